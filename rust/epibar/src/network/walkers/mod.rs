//! Walkers as tracks over all cameras of a network that stands.
//!
//! At every frame of the first camera silhouettes of any two cameras whose tops and bottoms both meet, and which stand on the floor,
//! are candidates; those that agree in space are one walker, whose top and bottom are where the rays of all of them meet; and walkers
//! of one moment go on at the next. What could be two walkers is left out.
//!
//! * `sightings`: the candidates.
//! * `over_cameras`, `triangulate`: which of them are one walker; where rays meet.
//! * `over_time`: from moment to moment.
//! * `points`: what comes out.

mod over_cameras;
mod over_time;
mod points;
mod sightings;
mod triangulate;

pub use points::{TrackPoint, TrackSighting};

use rayon::prelude::*;

use over_cameras::{Group, Scale, groups};
use over_time::Crowd;
use sightings::{Eye, Sighting, sightings};

use super::given::clocks::MOST_DRIFT;
use super::given::input::INSET;
use super::given::posed::{EXPECTED, PosedCamera};
use super::model::beliefs::{Belief, Beliefs, InsetBeliefs};
use super::model::camera::Camera;
use super::model::insets::Insets;
use super::observations::observed::Observed;
use super::observations::survey::Survey;
use super::solve::relocate::Placed;
use super::solve::settle::settle;
use crate::error::{Error, Result};
use crate::image::ImageSize;
use crate::recording::Recording;
use crate::watch::{Stage, Watch, report};

/// A camera of a network, its clock, and what it recorded.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct TrackingCamera<'r> {
    /// What it saw, in raw pixels of the lens.
    pub recording: &'r Recording,
    /// Where it stands, in a world with z up, and 0 on the floor.
    pub camera: PosedCamera,
    /// Offset, seconds, and drift, ppm: t seconds of the network are `t + offset + 1e-6 drift t` here.
    pub clock: (f64, f64),
}

impl<'r> TrackingCamera<'r> {
    /// A camera with the clock of the network.
    pub fn new(recording: &'r Recording, camera: PosedCamera) -> Self {
        Self { recording, camera, clock: (0.0, 0.0) }
    }

    /// With a clock of its own: offset, seconds, and drift, ppm.
    #[must_use]
    pub fn clock(self, offset: f64, drift: f64) -> Self {
        Self { clock: (offset, drift), ..self }
    }
}

/// Frames of each camera by which insets are found.
const FRAMES: usize = 250;
/// Moments at most whose sightings are kept: of twenty cameras there are 190 of a walker.
const WITH_SIGHTINGS: usize = 1000;
/// Moments of which everything is held in memory at once.
const AT_ONCE: usize = 1500;
/// Radius to begin with, pixels of a 640×480 image.
const WIDEST: f64 = 6.0;

/// Follows walkers over all cameras of a network.
///
/// `height` is the median height of walkers, in the unit of the network. Returned in the order of tracks, and of time.
///
/// # Errors
/// [`Error::Argument`] for fewer than two cameras and for numbers that no camera has, [`Error::Interrupted`].
pub fn walker_tracks(
    cameras: &[TrackingCamera],
    height: f64,
    watch: &mut dyn Watch,
) -> Result<Vec<TrackPoint>> {
    refuse(cameras, height)?;
    report(watch, Stage::Network, 0.0)?;
    let observed: Vec<Observed> = cameras.iter().map(|c| Observed::new(c.recording)).collect();
    let (placed, radius) = with_insets(cameras, &observed);
    let scales = observed.iter().map(|o| ImageSize::pixel_scale([o.size; 2]));
    let pixels = radius * scales.sum::<f64>() / observed.len() as f64;
    let scale = Scale { height, radius, pixels };
    let times = moments(&placed.cameras, &observed);
    let all = times.len();
    let parts = times.chunks(AT_ONCE).count() as f64;
    let mut walkers = Vec::with_capacity(times.len());
    for (part, times) in times.chunks(AT_ONCE).enumerate() {
        report(watch, Stage::Network, (part as f64 + 0.5) / (parts + 0.5))?;
        for mut groups in walkers_at(cameras, &placed, &observed, times, scale) {
            if !is_chosen(walkers.len(), all) {
                for group in &mut groups {
                    group.seen = Vec::new();
                }
            }
            walkers.push(groups);
        }
    }
    let tracks = Crowd { observed: &observed, times: &times, height }.tracks(walkers);
    let row = |number: usize, moment: usize, group: &Group| TrackPoint {
        time: times[moment],
        track: number as u32,
        foot: group.foot.into(),
        top: group.top.into(),
        cameras: group.silhouettes.iter().map(Option::is_some).collect(),
        residual: group.residual,
        sightings: group.seen.clone(),
    };
    Ok(tracks
        .iter()
        .enumerate()
        .flat_map(|(number, track)| track.points.iter().map(move |(moment, group)| (number, *moment, group)))
        .map(|(number, moment, group)| row(number, moment, group))
        .collect())
}

/// Whether a moment is one of [`WITH_SIGHTINGS`] that are spread evenly over `all`.
fn is_chosen(moment: usize, all: usize) -> bool {
    let before = |moment: usize| moment * WITH_SIGHTINGS.min(all) / all;
    before(moment) < before(moment + 1)
}

fn refuse(cameras: &[TrackingCamera], height: f64) -> Result<()> {
    let wrong = |name, value: String, expected| Err(Error::Argument { name, value, expected });
    if cameras.len() < 2 {
        return wrong("cameras", cameras.len().to_string(), "at least two cameras that stand");
    }
    if !(height > 0.0 && height.is_finite()) {
        return wrong("height", height.to_string(), "a positive height of walkers");
    }
    for (i, c) in cameras.iter().enumerate() {
        if c.clock.1.abs() > MOST_DRIFT {
            return wrong("clock", c.clock.1.to_string(), "a drift in ppm that a clock has");
        }
        if !(c.camera.is_camera() && c.clock.0.is_finite() && c.clock.1.is_finite()) {
            return wrong("camera", i.to_string(), EXPECTED);
        }
    }
    Ok(())
}

/// The cameras with the insets of their silhouettes, which no file keeps, and the radius within which tangents meet.
fn with_insets(cameras: &[TrackingCamera], observed: &[Observed]) -> (Placed, f64) {
    let at: Vec<Camera> = cameras
        .iter()
        .map(|c| Camera {
            offset: c.clock.0,
            drift: c.clock.1,
            insets: Insets::all_around(INSET.mean),
            ..c.camera.solvable(c.recording.size())
        })
        .collect();
    let known = Beliefs {
        intrinsic: [Belief::fixed(0.0); 7],
        clock: [Belief::fixed(0.0); 2],
        insets: InsetBeliefs::all_around(INSET),
        centred: false,
        posed: true,
    };
    let placed = vec![true; at.len()];
    let pairs = Placed { cameras: at.clone(), placed: placed.clone() }.pairs();
    let survey = Survey::new(observed, FRAMES);
    let settled = settle(&survey, &at, &vec![known; at.len()], &pairs, &placed, Some(WIDEST));
    (Placed { cameras: settled.cameras, placed }, settled.radius)
}

/// The frames of the first camera, and where only others film together, moments as far apart; seconds of the network.
fn moments(cameras: &[Camera], observed: &[Observed]) -> Vec<f64> {
    let films: Vec<[f64; 2]> = cameras
        .iter()
        .zip(observed)
        .filter_map(|(c, o)| Some([c.time_of(*o.times.first()?), c.time_of(*o.times.last()?)]))
        .collect();
    let own: Vec<f64> = observed[0].times.iter().map(|&t| cameras[0].time_of(t)).collect();
    let (Some(&begins), Some(&stops)) = (own.first(), own.last()) else { return Vec::new() };
    let apart = observed[0].interval;
    let mut all = own;
    for [from, to] in together(&films) {
        let parts = [[from, to.min(begins - apart)], [from.max(stops + apart), to]];
        for [from, to] in parts.into_iter().filter(|[from, to]| from <= to) {
            let count = ((to - from) / apart) as usize;
            all.extend((0..=count).map(|k| from + k as f64 * apart));
        }
    }
    all.sort_by(f64::total_cmp);
    all
}

/// Where two intervals or more overlap, in order.
fn together(films: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut common: Vec<[f64; 2]> = Vec::new();
    for (i, p) in films.iter().enumerate() {
        let both = films[i + 1..].iter().map(|q| [p[0].max(q[0]), p[1].min(q[1])]);
        common.extend(both.filter(|[from, to]| from < to));
    }
    common.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let mut merged: Vec<[f64; 2]> = Vec::new();
    for [from, to] in common {
        match merged.last_mut() {
            Some(last) if from <= last[1] => last[1] = last[1].max(to),
            _ => merged.push([from, to]),
        }
    }
    merged
}

/// Who is seen at each of some moments.
fn walkers_at(
    cameras: &[TrackingCamera],
    placed: &Placed,
    observed: &[Observed],
    times: &[f64],
    scale: Scale,
) -> Vec<Vec<Group>> {
    let eye =
        |k: usize| Eye::new(&placed.cameras[k], &observed[k], cameras[k].recording.visible.as_deref(), times);
    let eyes: Vec<Eye> = (0..cameras.len()).map(eye).collect();
    let mut candidates: Vec<Vec<Sighting>> = vec![Vec::new(); times.len()];
    for (a, b) in placed.pairs() {
        let pixels = scale.radius * ImageSize::pixel_scale([a, b].map(|c| observed[c].size));
        let found = sightings(&eyes, [a, b], pixels, scale.height);
        candidates.iter_mut().zip(found).for_each(|(all, found)| all.extend(found));
    }
    candidates
        .into_par_iter()
        .enumerate()
        .with_min_len(16)
        .map(|(moment, sightings)| groups(&eyes, moment, sightings, scale))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_moments_are_spread_evenly() {
        for all in [1, 7, WITH_SIGHTINGS, WITH_SIGHTINGS + 1, 90_000] {
            let chosen: Vec<usize> = (0..all).filter(|&moment| is_chosen(moment, all)).collect();
            assert_eq!(chosen.len(), all.min(WITH_SIGHTINGS));
            let widest = chosen.windows(2).map(|w| w[1] - w[0]).max().unwrap_or(1);
            assert!(widest <= all.div_ceil(WITH_SIGHTINGS), "{widest} of {all}");
        }
    }

    #[test]
    fn films_overlap_where_two_do() {
        let films = [[0.0, 10.0], [8.0, 12.0], [11.0, 20.0], [30.0, 40.0], [9.0, 9.5]];
        assert_eq!(together(&films), vec![[8.0, 10.0], [11.0, 12.0]]);
        assert!(together(&[[0.0, 1.0], [1e300, 2e300]]).is_empty());
    }
}
