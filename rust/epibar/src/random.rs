//! Random numbers: generators that depend on a seed and an index, and on nothing else.
//!
//! Whatever is random has an index (of a hypothesis, of a line, of a sample) and draws from a generator of its own,
//! so that no result depends on the number of threads.

use rand::{Rng, SeedableRng};

/// The generator of everything random in this crate: small, and the same on every machine.
pub type Generator = rand_pcg::Pcg64Mcg;

/// 2⁶⁴ over the golden ratio: its multiples are far apart.
pub const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

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
