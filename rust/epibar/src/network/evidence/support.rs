//! What speaks for each camera of a network on moments in which the fit had no part.
//!
//! The network is fitted once more without some stretches of time. On these its pairs are compared as they are and with
//! B's moments moved on: people who walk about in both views at other times are what chance has to offer. A camera's score
//! is the sum over its pairs, and its normal deviate that of Student's t over the shifts, so that what is alike in
//! neighbouring frames counts for no more than it is worth.

use rayon::prelude::*;

use crate::network::model::camera::Camera;
use crate::network::observations::observed::Observed;
use crate::network::observations::survey::{Survey, shared};
use crate::network::observations::tangents::Score;
use crate::network::observations::time_parts::TimeParts;
use crate::network::solve::networks::{Solved, settled};
use crate::network::solve::relocate::Placed;
use crate::network::solve::settle::Again;
use crate::network::thresholds as limits;
pub use crate::network::thresholds::{BASELINE, PAIR_DEVIATES};
use crate::verify::shift_curve::normal_deviate;

/// Frames of each camera that are looked at; those that the network is fitted to are fewer of many cameras.
const FRAMES: usize = 300;

/// Normal deviates of what was seen on moments kept aside.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Deviates {
    /// Of the tangents.
    pub tangents: f64,
    /// Of whole silhouettes: those of which both ends meet those of one other.
    pub whole: f64,
}

/// What speaks for a network.
#[derive(Debug, Clone)]
pub struct Support {
    /// Camera by camera.
    pub cameras: Vec<Deviates>,
    /// Pairs of cameras that stand.
    pub pairs: Vec<((usize, usize), Deviates)>,
    /// Camera by camera, of all that could meet in its pairs.
    pub shares: Vec<Share>,
}

/// What meets beyond chance, of what could.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Share {
    /// Excess over chance of a tangent.
    pub excess: f64,
    /// Of whole silhouettes.
    pub whole: f64,
}

impl Share {
    /// From scores, each that by the true clocks and then those by shifted ones.
    fn of<'s>(scores: impl Iterator<Item = &'s Vec<Score>>) -> Self {
        let (mut ends, mut sum) = (0.0, Self::default());
        for score in scores {
            let Some((first, rest)) = score.split_first() else { continue };
            let by_chance =
                |value: fn(&Score) -> f64| rest.iter().map(value).sum::<f64>() / rest.len() as f64;
            ends += first.ends as f64;
            sum.excess += first.excess - by_chance(|s| s.excess);
            sum.whole += first.whole as f64 - by_chance(|s| s.whole as f64);
        }
        let ends = f64::max(ends, 1.0);
        Self { excess: sum.excess / ends, whole: 2.0 * sum.whole / ends }
    }
}

impl Support {
    /// Pairs of which so much confirms the network that chance does not.
    pub fn confirmed(&self) -> Vec<(usize, usize)> {
        self.pairs.iter().filter(|(_, d)| d.tangents >= PAIR_DEVIATES).map(|(pair, _)| *pair).collect()
    }

    /// Of a network that was solved on all moments.
    pub fn of(observed: &[Observed], solved: &Solved) -> Self {
        let aside = Aside::of(observed, &solved.network);
        let frames = shared(FRAMES, observed.len());
        let fitted = Survey::among(observed, frames, |camera, seconds| !aside.has(camera, seconds));
        let radius = Some(Again::FEWER_MOMENTS.after(&solved.settled));
        let pairs = solved.network.pairs();
        let network = settled(&fitted, solved.network.clone(), &solved.beliefs, &pairs, radius).network;
        let kept = Survey::among(observed, FRAMES, |camera, seconds| aside.has(camera, seconds));
        Self::on(&kept, &network)
    }

    /// Of a network on the moments of a survey.
    pub fn on(survey: &Survey, network: &Placed) -> Self {
        let pairs = network.pairs();
        let rays = survey.all_rays(&network.cameras);
        let scores: Vec<Vec<Score>> = pairs
            .par_iter()
            .map(|&(a, b)| {
                let tangents = survey.tangents(&network.cameras, &rays, a, b);
                let n = tangents.moments();
                if n <= limits::SHIFTS {
                    return vec![Score::default(); limits::SHIFTS + 1];
                }
                let scorer = tangents.scorer(limits::COMPARED * survey.scale(a, b));
                (0..=limits::SHIFTS).map(|k| scorer.score(k * n / (limits::SHIFTS + 1))).collect()
            })
            .collect();
        let deviates = |of: &dyn Fn(&(usize, usize)) -> bool| {
            let sum = |value: &dyn Fn(&Score) -> f64| -> Vec<f64> {
                let chosen = || pairs.iter().zip(&scores).filter(|(pair, _)| of(pair));
                (0..=limits::SHIFTS).map(|k| chosen().map(|(_, s)| value(&s[k])).sum()).collect()
            };
            Deviates { tangents: deviate(&sum(&|s| s.excess)), whole: deviate(&sum(&|s| s.whole as f64)) }
        };
        Self {
            cameras: (0..network.cameras.len()).map(|c| deviates(&|p| p.0 == c || p.1 == c)).collect(),
            pairs: pairs.iter().map(|&pair| (pair, deviates(&|p| *p == pair))).collect(),
            shares: (0..network.cameras.len())
                .map(|c| {
                    let own = pairs.iter().zip(&scores).filter(|(p, _)| p.0 == c || p.1 == c);
                    Share::of(own.map(|(_, scores)| scores))
                })
                .collect(),
        }
    }
}

/// How unlikely the first of some scores is among the others, as a normal deviate; 0 where they do not differ.
fn deviate(scores: &[f64]) -> f64 {
    let Some((first, rest)) = scores.split_first() else { return 0.0 };
    let n = rest.len() as f64;
    let mean = rest.iter().sum::<f64>() / n;
    let variance = rest.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0);
    if variance > 0.0 {
        normal_deviate((first - mean) / (variance * (1.0 + 1.0 / n)).sqrt(), n - 1.0)
    } else if *first > mean {
        // Never by chance, and seen.
        normal_deviate(first - mean, n - 1.0)
    } else {
        0.0
    }
}

/// Stretches of the time in which cameras that stand are compared that are kept aside: one that films on alone is in none.
struct Aside<'c> {
    cameras: &'c [Camera],
    stretches: TimeParts,
}

impl<'c> Aside<'c> {
    fn of(observed: &[Observed], network: &'c Placed) -> Self {
        let cameras = &network.cameras;
        let all = Survey::new(observed, FRAMES);
        Self { cameras, stretches: all.time_parts(cameras, &network.pairs(), limits::STRETCHES) }
    }

    fn has(&self, camera: usize, seconds: f64) -> bool {
        self.stretches.of(self.cameras[camera].time_of(seconds)) % 3 == 1
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::network::given::input::INSET;
    use crate::network::model::beliefs::{Belief, Beliefs, InsetBeliefs};
    use crate::network::solve::settle::tests::around;
    use crate::recording::{Recorder, RecorderOptions, Recording};

    /// Balls that wander about before a camera for 200 frames, of so many.
    fn filmed(camera: &Camera, frames: usize) -> Recording {
        let size = camera.size;
        let mut recorder = Recorder::new(size, RecorderOptions::new().lines(50)).unwrap();
        for frame in 0..frames {
            let mut mask = vec![0u8; size.pixels()];
            for k in (0..5).map(f64::from).filter(|_| frame < 200) {
                let t = frame as f64;
                let [x, y] =
                    [(0.031 * t * (1.0 + 0.3 * k) + k).sin(), (0.043 * t * (1.0 + 0.2 * k) + 2.0 * k).cos()];
                let ball = 1.3 * Vector3::new(x, y, 0.5 * (0.05 * t + 3.0 * k).sin());
                let Some([u, v]) = camera.project(&ball) else { continue };
                let radius = 0.25 * camera.focal()[0] / (camera.rotation * (ball - camera.position)).z;
                for (i, pixel) in mask.iter_mut().enumerate() {
                    let (x, y) = ((i % size.width()) as f64, (i / size.width()) as f64);
                    *pixel |= u8::from((x - u).abs() < radius && (x - u).hypot(y - v) <= radius);
                }
            }
            recorder.push(&mask, frame as f64 / 25.0).unwrap();
        }
        recorder.finish().unwrap()
    }

    #[test]
    fn that_one_camera_films_on_is_no_time_to_keep_aside() {
        let angles = [(0.3, 500.0), (1.6, 480.0), (2.9, 450.0), (4.4, 520.0)];
        let cameras: Vec<Camera> = angles.map(|(at, focal)| around(at, focal)).into();
        let recordings: Vec<Recording> =
            cameras.iter().zip([3000, 200, 200, 200]).map(|(c, frames)| filmed(c, frames)).collect();
        let observed: Vec<Observed> = recordings.iter().map(Observed::new).collect();
        let known = |c: &Camera| Beliefs {
            intrinsic: c.intrinsic().map(Belief::fixed),
            clock: [Belief::fixed(0.0); 2],
            centred: false,
            insets: InsetBeliefs::all_around(INSET),
            posed: false,
        };
        let beliefs: Vec<Beliefs> = cameras.iter().map(known).collect();
        let network = Placed { cameras, placed: vec![true; 4] };
        let pairs = network.pairs();
        let solved = settled(&Survey::new(&observed, 240), network, &beliefs, &pairs, None);
        let support = Support::of(&observed, &solved);
        assert!(support.cameras.iter().all(|d| d.tangents > 6.0 && d.whole > 6.0), "{:?}", support.cameras);
    }

    #[test]
    fn a_share_is_beyond_chance_and_of_what_could_meet() {
        let score = |ends, whole, excess| Score { ends, whole, excess };
        let one = vec![score(100, 22, 90.0), score(100, 2, 15.0), score(100, 2, 5.0)];
        let other = vec![score(300, 0, 0.0), score(300, 0, 0.0), score(300, 0, 0.0)];
        assert_eq!(Share::of([&one].into_iter()), Share { excess: 0.8, whole: 0.4 });
        assert_eq!(Share::of([&one, &other].into_iter()), Share { excess: 0.2, whole: 0.1 });
        assert_eq!(Share::of([].into_iter()), Share::default());
    }

    #[test]
    fn a_score_like_the_others_has_no_deviate() {
        assert_eq!(deviate(&[0.0; 9]), 0.0);
        assert!(deviate(&[3.0, 1.0, 2.0, 3.0, 4.0, 5.0, 2.0, 3.0, 4.0]).abs() < 1.0);
        assert!(deviate(&[90.0, 1.0, 2.0, 3.0, 4.0, 5.0, 2.0, 3.0, 4.0]) > 4.0);
        assert!(deviate(&[]) == 0.0);
    }
}
