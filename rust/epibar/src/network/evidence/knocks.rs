//! Was a camera knocked far while it filmed?
//!
//! Then it sees what the others see only before or only after some moment, while pairs that it has no part in keep their evidence. The same of one
//! pair is asked in `verify::throughout`, which has no others to hold it against.

use rayon::prelude::*;

use crate::network::observations::survey::Survey;
use crate::network::observations::time_parts::TimeParts;
use crate::network::solve::relocate::Placed;
use crate::network::thresholds as limits;
use crate::verify::sides::{MOMENTS, PARTS, SHIFTS, beyond_chance, rate};

/// Evidence beyond chance, and what could meet.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    excess: f64,
    ends: f64,
}

impl Part {
    fn rate(self) -> f64 {
        rate(self.excess, self.ends)
    }
}

/// What some pairs keep on one side of a moment of what they have on the other.
struct Kept {
    worse: Part,
    better: Part,
}

impl Kept {
    fn of<'p>(pairs: impl Iterator<Item = &'p [Part; PARTS]>, moment: usize) -> Self {
        let mut sides = [Part::default(); 2];
        for parts in pairs {
            for (k, part) in parts.iter().enumerate() {
                let side = &mut sides[usize::from(k >= moment)];
                side.excess += part.excess;
                side.ends += part.ends;
            }
        }
        let [before, after] = sides;
        if before.rate() >= after.rate() {
            Self { worse: after, better: before }
        } else {
            Self { worse: before, better: after }
        }
    }

    fn share(&self) -> f64 {
        self.worse.rate() / self.better.rate().max(1e-12)
    }
}

/// Evidence at each moment, with the network's time, as camera A of the pair has it, pair by pair.
fn moments(survey: &Survey, network: &Placed, pairs: &[(usize, usize)]) -> Vec<Vec<(f64, Part)>> {
    let rays = survey.all_rays(&network.cameras);
    let of_pair = |&(a, b): &(usize, usize)| {
        let tangents = survey.tangents(&network.cameras, &rays, a, b);
        let scorer = tangents.scorer(limits::COMPARED * survey.scale(a, b));
        let time = |k: usize| (tangents.time(k), Part::default());
        let mut moments: Vec<(f64, Part)> = (0..tangents.moments()).map(time).collect();
        for shift in 0..=SHIFTS {
            let scores = scorer.by_moment(shift * tangents.moments() / (SHIFTS + 1));
            for (k, score) in scores.iter().enumerate() {
                let part = &mut moments[k].1;
                part.excess += beyond_chance(score.excess, shift);
                if shift == 0 {
                    part.ends += score.ends as f64;
                }
            }
        }
        moments
    };
    pairs.par_iter().map(of_pair).collect()
}

/// Of one pair in parts of some time.
fn parts(moments: &[(f64, Part)], time: &TimeParts) -> [Part; PARTS] {
    let mut parts = [Part::default(); PARTS];
    for (at, moment) in moments {
        let part = &mut parts[time.of(*at)];
        part.excess += moment.excess;
        part.ends += moment.ends;
    }
    parts
}

/// A camera that agrees with the others on one side of a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knock {
    /// The network's time of that moment, about.
    pub at: f64,
    /// What it keeps on the worse side, of its evidence on the better one.
    pub keeps: f64,
}

/// The knock of each camera that sees what the others see only before or only
/// after some moment: on one side of it less than the first share of its evidence on the other, and than the second share of what pairs keep
/// that it has no part in.
pub fn knocked(survey: &Survey, network: &Placed, [keeps, of_others]: [f64; 2]) -> Vec<Option<Knock>> {
    let pairs = network.pairs();
    let moments = moments(survey, network, &pairs);
    let of_camera = |c: usize| {
        // It may have filmed, or seen anything, for a part of the others' time alone.
        let own = |&&(a, b): &&(usize, usize)| a == c || b == c;
        let time = survey.time_parts(
            &network.cameras,
            &pairs.iter().filter(own).copied().collect::<Vec<_>>(),
            PARTS,
        );
        let parts: Vec<[Part; PARTS]> = moments.iter().map(|moments| parts(moments, &time)).collect();
        let kept = |own: bool, moment: usize| {
            let chosen = pairs.iter().zip(&parts).filter(|(p, _)| (p.0 == c || p.1 == c) == own);
            Kept::of(chosen.map(|(_, parts)| parts), moment)
        };
        let mut worst: Option<(f64, usize)> = None;
        for moment in MOMENTS {
            let (own, others) = (kept(true, moment), kept(false, moment).share());
            let found = own.share() < keeps
                && own.share() < of_others * others
                && others > limits::OTHERS_KEEP
                && own.better.excess > limits::KNOCKED_CLEAR
                && own.worse.ends > limits::KNOCKED_SHOWS * own.better.ends;
            if found && worst.is_none_or(|w| own.share() < w.0) {
                worst = Some((own.share(), moment));
            }
        }
        worst.map(|(keeps, moment)| Knock { at: time.start(moment), keeps })
    };
    (0..network.cameras.len()).map(of_camera).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_is_held_against_the_better_one() {
        let part = |excess| Part { excess, ends: 10.0 };
        let one: [Part; PARTS] = std::array::from_fn(|k| part(if k < 3 { 8.0 } else { 2.0 }));
        let other = [part(4.0); PARTS];
        assert!((Kept::of([&one].into_iter(), 3).share() - 0.25).abs() < 1e-12);
        assert!((Kept::of([&other].into_iter(), 3).share() - 1.0).abs() < 1e-12);
        let both = Kept::of([&one, &other].into_iter(), 3);
        assert_eq!((both.better.excess, both.worse.excess, both.worse.ends), (36.0, 30.0, 100.0));
        assert!((both.share() - 0.5).abs() < 1e-12);
        assert_eq!(Kept::of(std::iter::empty(), 3).share(), 0.0);
    }
}
