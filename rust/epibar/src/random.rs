//! Random numbers: generators that depend on a seed and an index, and on nothing else.
//!
//! Whatever is random has an index (of a hypothesis, of a line, of a sample) and draws from a generator of its own,
//! so that no result depends on the number of threads. A seed serves for much that is random, so what must not draw alike gets a
//! [stream](Stream) or a seed of its own from it.

use rand::{Rng, SeedableRng};

/// The generator of everything random in this crate: small, and the same on every machine.
pub type Generator = rand_pcg::Pcg64Mcg;

/// 2⁶⁴ over the golden ratio: its multiples are far apart.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// The finaliser of `SplitMix64` (Steele, Lea and Flood 2014): a bijection that scatters neighbours.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A generator that depends only on the seed and the index; neighbouring indices give unrelated states.
pub fn generator(seed: u64, index: u64) -> Generator {
    let low = mix(seed.wrapping_add(GOLDEN).wrapping_add(mix(index)));
    let high = mix(low ^ index.wrapping_mul(GOLDEN));
    Generator::new((u128::from(high) << 64) | u128::from(low) | 1)
}

/// What draws beside a search, each apart from the others: by the seed of a calibration and its name in ASCII, or by a number of its own where there is no seed.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
pub enum Stream {
    /// Places of pencils.
    Pencils = 0x0070_656E_6369_6C73,
    /// Points of the volume where things moved.
    Points = 0x0070_6F69_6E74,
    /// Points of silhouettes that met.
    Met = 0x006D_6574,
    /// Homographies between the views.
    Planes = 0x0070_6C61_6E65,
    /// Planes about which a geometry may turn.
    Turns = 0x7475_726E,
    /// Planes through what meets in a pair of a network. They draw by seed 0 alone.
    PlanesOfPairs = 11,
}

impl Stream {
    /// Its generator of a seed and an index.
    pub fn generator(self, seed: u64, index: u64) -> Generator {
        generator(seed.wrapping_add(self as u64), index)
    }
}

/// The seed of a pass of the search: far apart, so that no pass repeats the draws of another.
pub fn seed_of_pass(seed: u64, pass: u64) -> u64 {
    seed.wrapping_add(pass.wrapping_mul(GOLDEN))
}

/// The seed of a source of hypotheses beside others of its kind.
pub fn seed_of_source(seed: u64, source: u64) -> u64 {
    seed.wrapping_add((source + 1) << 56)
}

/// The seed by which a solution of a round is resampled; of a hundred solutions at most.
pub fn seed_of_resampled(seed: u64, round: u64, solution: u64) -> u64 {
    seed.wrapping_add(round * 100 + solution)
}

/// The seed of further lines of a recording, the first or the second of a pair, by the recording's seed and the calibration's.
pub fn seed_of_lines(recording: u64, which: u64, seed: u64) -> u64 {
    (recording ^ which).wrapping_add(seed)
}

/// The generator of line `index` of a recording.
///
/// A seed must give the same lines for ever, in files that are kept, so this does not follow [`generator`] where that
/// changes.
pub fn line_generator(seed: u64, index: u64) -> Generator {
    let stream = mix(seed.wrapping_add(GOLDEN));
    Generator::seed_from_u64(mix((stream ^ index).wrapping_add(GOLDEN)))
}

/// Uniform below `n`. Written out because the crates of random numbers may change how they do it; the bias of
/// `n / 2⁶⁴` is immaterial.
pub fn below(random: &mut Generator, n: usize) -> usize {
    ((u128::from(random.next_u64()) * n as u128) >> 64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_called_by_their_names() {
        let names = [
            (Stream::Pencils, "pencils"),
            (Stream::Points, "point"),
            (Stream::Met, "met"),
            (Stream::Planes, "plane"),
            (Stream::Turns, "turn"),
        ];
        for (stream, name) in names {
            let number = name.bytes().fold(0, |number, letter| number << 8 | u64::from(letter));
            assert_eq!(stream as u64, number, "{name}");
            assert_eq!(stream.generator(3, 5), generator(3 + number, 5));
        }
        assert_eq!(Stream::PlanesOfPairs.generator(0, 5), generator(11, 5));
    }

    #[test]
    fn seeds_from_one_seed_are_those_that_they_always_were() {
        assert_eq!(seed_of_pass(7, 2), 7_u64.wrapping_add(GOLDEN.wrapping_mul(2)));
        assert_eq!(seed_of_source(7, 1), 7 + (2 << 56));
        assert_eq!(seed_of_resampled(u64::MAX, 1, 3), 102);
        assert_eq!(seed_of_lines(6, 2, 10), 14);
    }
}
