//! All cameras at one moment: which sightings are of one walker.
//!
//! A group has at most one silhouette of each camera, and its sightings agree in space. The largest come first, and a silhouette
//! belongs to one. Two cameras alone are believed only where neither silhouette has another partner, and where no third camera looks at
//! the place and sees nothing there.

use nalgebra::{Matrix3, Vector3};

use super::points::TrackSighting;
use super::sightings::{DEVIATIONS, Eye, Sighting, stands};
use super::triangulate::{Ray, covariance, point};
use crate::image::ImageSize;

/// Standard deviation of tops of one walker in two pairs of cameras, over the median height: of places on a head.
const TOPS: f64 = 0.03;
/// Standard deviation of bottoms of one walker, over the median height: two pairs of cameras may touch different feet.
const FEET: f64 = 0.1;
/// Standard deviations by which two sightings of one walker may differ.
const APART: f64 = 3.5;
/// And median heights, however little cameras tell of a depth.
const MOST_APART: f64 = 0.5;
/// How far a top may be from where a camera has it, over the median height.
const TOP_OFF: f64 = 0.06;
/// How far a bottom may be from where a camera has it, over the median height.
const FOOT_OFF: f64 = 0.25;
/// Pixels of a 640×480 image by which a silhouette may fall short of a place that it covers.
const COVERED: f64 = 6.0;

/// A walker at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// For each camera which of its silhouettes it is, in the frame before.
    pub silhouettes: Vec<Option<u32>>,
    /// Its top.
    pub top: Vector3<f64>,
    /// Its bottom.
    pub foot: Vector3<f64>,
    /// Root mean square of what top and bottom are off, pixels.
    pub residual: f64,
    /// Largest standard deviation of the top by the scatter of tangents, where cameras tell least.
    pub deviation: f64,
    /// What each two cameras see of it.
    pub seen: Vec<TrackSighting>,
}

impl Group {
    /// Number of cameras that see it.
    pub fn cameras(&self) -> usize {
        self.silhouettes.iter().flatten().count()
    }
}

/// What decides whether sightings are one walker's.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// Median height of walkers.
    pub height: f64,
    /// Pixels within which tangents meet.
    pub radius: f64,
    /// That radius in pixels of the cameras, in the mean of them.
    pub pixels: f64,
}

/// The walkers at one moment.
pub fn groups(eyes: &[Eye], moment: usize, mut sightings: Vec<Sighting>, scale: Scale) -> Vec<Group> {
    let mut found = Vec::new();
    let mut used: Vec<Vec<bool>> = eyes.iter().map(|eye| vec![false; eye.moments[moment].len()]).collect();
    loop {
        let mut bundles: Vec<Bundle> =
            (0..sightings.len()).map(|seed| Bundle::about(&sightings, seed, eyes.len(), scale)).collect();
        bundles.sort_by(|p, q| q.cameras.cmp(&p.cameras).then(p.distance.total_cmp(&q.distance)));
        let mut taken = false;
        for bundle in bundles {
            if bundle.sightings.iter().any(|&s| is_used(&sightings[s], &used)) {
                continue;
            }
            taken = true;
            let sure = bundle.cameras > 2 || is_only(&sightings, bundle.sightings[0], &used);
            let of: Vec<&Sighting> = bundle.sightings.iter().map(|&s| &sightings[s]).collect();
            for s in &of {
                (0..2).for_each(|k| used[s.cameras[k]][s.silhouettes[k]] = true);
            }
            let Some(group) = sure.then(|| whole(eyes, moment, &of, scale)).flatten() else { continue };
            if group.cameras() > 2 || !is_denied(eyes, moment, &group) {
                found.push(group);
            }
        }
        sightings.retain(|s| !is_used(s, &used));
        if !taken || sightings.is_empty() {
            return found;
        }
    }
}

fn is_used(s: &Sighting, used: &[Vec<bool>]) -> bool {
    (0..2).any(|k| used[s.cameras[k]][s.silhouettes[k]])
}

/// Whether neither silhouette of a sighting has another partner left.
fn is_only(sightings: &[Sighting], of: usize, used: &[Vec<bool>]) -> bool {
    let one = &sightings[of];
    let shares = |s: &Sighting| {
        (0..2)
            .any(|k| (0..2).any(|l| s.cameras[k] == one.cameras[l] && s.silhouettes[k] == one.silhouettes[l]))
    };
    sightings.iter().enumerate().all(|(k, s)| k == of || is_used(s, used) || !shares(s))
}

/// Sightings that agree with one of them.
struct Bundle {
    sightings: Vec<usize>,
    cameras: usize,
    /// Mean distance of their ends.
    distance: f64,
}

impl Bundle {
    fn about(all: &[Sighting], seed: usize, cameras: usize, scale: Scale) -> Self {
        let one = &all[seed];
        let of_end = |s: &Sighting, end: usize, share: f64| {
            let off = s.segment[end] - one.segment[end];
            let of_end = Matrix3::identity() * (2.0 * (share * scale.height).powi(2));
            let by = (one.covariance[end] + s.covariance[end] + of_end).try_inverse();
            by.map_or(f64::INFINITY, |by| (off.dot(&(by * off))).sqrt() / APART)
        };
        let apart = |s: &Sighting| {
            let near = (s.segment[0] - one.segment[0]).norm() < MOST_APART * scale.height;
            if near { of_end(s, 0, TOPS).max(of_end(s, 1, FEET)) } else { f64::INFINITY }
        };
        let mut near: Vec<(f64, usize)> = all
            .iter()
            .enumerate()
            .filter(|(k, _)| *k != seed)
            .map(|(k, s)| (apart(s), k))
            .filter(|(d, _)| *d < 1.0)
            .collect();
        near.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let mut members: Vec<Option<usize>> = vec![None; cameras];
        let mut chosen = Vec::new();
        for k in std::iter::once(seed).chain(near.into_iter().map(|(_, k)| k)) {
            let s = &all[k];
            if (0..2).all(|e| members[s.cameras[e]].is_none_or(|m| m == s.silhouettes[e])) {
                (0..2).for_each(|e| members[s.cameras[e]] = Some(s.silhouettes[e]));
                chosen.push(k);
            }
        }
        let distance = chosen.iter().map(|&k| all[k].distance).sum::<f64>() / chosen.len() as f64;
        Self { sightings: chosen, cameras: members.iter().flatten().count(), distance }
    }
}

/// Top and bottom from all cameras that agree; `None` where fewer than two do, or nobody can stand so.
fn whole(eyes: &[Eye], moment: usize, sightings: &[&Sighting], scale: Scale) -> Option<Group> {
    let mut kept: Vec<&Sighting> = sightings.to_vec();
    loop {
        let start = kept.first()?.segment;
        let rays = |of: &dyn Fn(&Sighting) -> [[f64; 2]; 2]| -> Option<Vec<Ray>> {
            let of_end =
                |s: &&Sighting, k: usize| Ray::new(s.cameras[k], eyes[s.cameras[k]].camera, of(s)[k]);
            kept.iter().flat_map(|s| [of_end(s, 0), of_end(s, 1)]).collect()
        };
        let (tops, feet) = (rays(&|s| s.top)?, rays(&|s| s.foot)?);
        let (top, foot) = (point(&tops, start[0], scale.pixels)?, point(&feet, start[1], scale.pixels)?);
        let off = |rays: &[Ray], at: &Vector3<f64>, share: f64| {
            let over = |r: &Ray| {
                let (pixels, per_unit) = r.miss(at);
                pixels / (share * scale.height * per_unit).max(2.0 * scale.pixels)
            };
            rays.iter().map(|r| (over(r), r.camera)).collect::<Vec<_>>()
        };
        let all = [off(&tops, &top, TOP_OFF), off(&feet, &foot, FOOT_OFF)].concat();
        let worst = all.into_iter().max_by(|p, q| p.0.total_cmp(&q.0)).filter(|w| w.0 > 1.0);
        if let Some((_, camera)) = worst {
            kept.retain(|s| !s.cameras.contains(&camera));
            continue;
        }
        if !stands([&top, &foot], scale.height) {
            return None;
        }
        let mut silhouettes = vec![None; eyes.len()];
        for s in &kept {
            for k in 0..2 {
                let camera = s.cameras[k];
                silhouettes[camera] = Some(eyes[camera].moments[moment][s.silhouettes[k]].first);
            }
        }
        let squares: f64 = tops.iter().map(|r| r.miss(&top).0.powi(2)).sum::<f64>()
            + feet.iter().map(|r| r.miss(&foot).0.powi(2)).sum::<f64>();
        let residual = (squares / (tops.len() + feet.len()) as f64).sqrt();
        let mut single = tops.clone();
        single.sort_by_key(|ray| ray.camera);
        single.dedup_by_key(|ray| ray.camera);
        let covariance = covariance(&single, &top, scale.pixels / DEVIATIONS)?;
        let deviation = covariance.symmetric_eigenvalues().max().max(0.0).sqrt();
        let seen =
            kept.iter().map(|s| TrackSighting { cameras: s.cameras, top: s.top, foot: s.foot }).collect();
        return Some(Group { silhouettes, top, foot, residual, deviation, seen });
    }
}

/// Whether a camera that has no part in a group looks at its place and sees nothing there.
fn is_denied(eyes: &[Eye], moment: usize, group: &Group) -> bool {
    let middle = 0.5 * (group.top + group.foot);
    let others = eyes.iter().zip(&group.silhouettes).filter(|(_, own)| own.is_none());
    others.into_iter().any(|(eye, _)| {
        eye.looks_at(moment, &middle).is_some_and(|pixel| {
            let margin = COVERED * ImageSize::pixel_scale([eye.observed.size; 2]);
            !eye.covers(moment, pixel, margin)
        })
    })
}
