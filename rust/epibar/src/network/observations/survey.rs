//! All cameras of a network before the same moments: which tangents meet under given cameras.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::ends::CameraView;
use super::evenly::evenly;
use super::figures::{PairFigures, figures};
use super::observed::Observed;
use super::tangents::{PairTangents, Score, common_times};
use super::time_parts::TimeParts;
use crate::image::ImageSize;
use crate::network::model::camera::Camera;
use crate::network::model::joint::PairMeetings;
use crate::recording::RecordedFrame;

/// With more partners than the first a camera has fewer frames compared with each; from the second on a pair would tell nothing.
const PARTNERS: [usize; 2] = [9, 36];

/// So many frames of each of some cameras that what is measured of a camera over all its partners does not grow with their number:
/// time grows with the cameras and not with their pairs.
pub fn shared(frames: usize, cameras: usize) -> usize {
    let [few, many] = PARTNERS;
    frames * few / cameras.saturating_sub(1).clamp(few, many)
}

/// What all cameras saw at some of their frames.
#[derive(Debug, Clone)]
pub struct Survey<'a> {
    /// Silhouettes, camera by camera.
    pub observed: &'a [Observed],
    /// Frames of each camera that are looked at.
    frames: Vec<Vec<RecordedFrame>>,
}

/// The sum over some pairs, part by part.
pub fn summed<'p, const PARTS: usize>(pairs: impl IntoIterator<Item = &'p [f64; PARTS]>) -> [f64; PARTS] {
    let mut sums = [0.0; PARTS];
    for parts in pairs {
        sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
    }
    sums
}

/// Rays of one camera's silhouettes.
pub type Rays = Vec<Vector3<f64>>;

impl<'a> Survey<'a> {
    /// At most `limit` frames of each camera, evenly spread over those in which something moves.
    pub fn new(observed: &'a [Observed], limit: usize) -> Self {
        Self::among(observed, limit, |_, _| true)
    }

    /// At most `limit` frames of each camera, evenly spread over those in which something moves and that are kept: asked by the camera's index and its clock's seconds.
    pub fn among(observed: &'a [Observed], limit: usize, keep: impl Fn(usize, f64) -> bool) -> Self {
        let frames = observed
            .iter()
            .enumerate()
            .map(|(camera, o)| {
                let kept: Vec<RecordedFrame> = (0..o.frames() as u32)
                    .map(RecordedFrame)
                    .filter(|&i| keep(camera, o.times[i.index()]) && !o.of_frame(i).is_empty())
                    .collect();
                evenly(kept.len(), limit).map(|k| kept[k]).collect()
            })
            .collect();
        Self { observed, frames }
    }

    /// Rays of the silhouettes of a camera that are looked at, or that another camera may ask for.
    pub fn rays(&self, cameras: &[Camera], camera: usize) -> Rays {
        let own = self.frames[camera].iter().copied();
        let mut wanted = self.observed[camera].wanted(own);
        for (other, frames) in self.frames.iter().enumerate().filter(|(other, _)| *other != camera) {
            let times = frames.iter().map(|&f| {
                let time = cameras[other].time_of(self.observed[other].times[f.index()]);
                cameras[camera].clock_at(time)
            });
            let asked = times.filter_map(|t| self.observed[camera].moment(t)).map(|m| m.frame);
            let of_other = self.observed[camera].wanted(asked);
            wanted.iter_mut().zip(of_other).for_each(|(w, o)| *w |= o);
        }
        self.observed[camera].rays(&cameras[camera], &wanted)
    }

    /// Rays of all cameras.
    pub fn all_rays(&self, cameras: &[Camera]) -> Vec<Rays> {
        (0..cameras.len()).map(|camera| self.rays(cameras, camera)).collect()
    }

    /// The tangents of a pair.
    pub fn tangents<'s>(
        &'s self,
        cameras: &'s [Camera],
        rays: &'s [Rays],
        a: usize,
        b: usize,
    ) -> PairTangents<'s> {
        self.tangents_of(cameras, &rays[a], &rays[b], a, b)
    }

    /// The tangents of a pair by the rays of both.
    pub fn tangents_of<'s>(
        &'s self,
        cameras: &'s [Camera],
        rays_a: &'s Rays,
        rays_b: &'s Rays,
        a: usize,
        b: usize,
    ) -> PairTangents<'s> {
        let seen =
            |i: usize, rays: &'s Rays| CameraView { observed: &self.observed[i], camera: &cameras[i], rays };
        PairTangents::new(seen(a, rays_a), seen(b, rays_b), &self.frames[a])
    }

    /// What meets in some pairs within a radius, pixels of a 640×480 image, times the coarseness of each; those without `least`
    /// meetings are left out.
    pub fn meetings(
        &self,
        cameras: &[Camera],
        pairs: &[(usize, usize)],
        coarseness: &[f64],
        radius: f64,
        least: usize,
    ) -> Vec<PairMeetings> {
        let rays = self.all_rays(cameras);
        let found: Vec<PairMeetings> = pairs
            .par_iter()
            .zip(coarseness)
            .map(|(&(a, b), &coarseness)| {
                let tangents = self.tangents(cameras, &rays, a, b);
                let met = tangents.meet(radius * coarseness * self.scale(a, b), 0);
                PairMeetings { a, b, meetings: tangents.measurements(&met), coarseness }
            })
            .collect();
        found.into_iter().filter(|p| p.meetings.len() >= least).collect()
    }

    /// Figures of some pairs at a radius, pixels of a 640×480 image.
    pub fn figures(&self, cameras: &[Camera], pairs: &[(usize, usize)], radius: f64) -> Vec<PairFigures> {
        let rays = self.all_rays(cameras);
        pairs
            .par_iter()
            .map(|&(a, b)| {
                let tangents = self.tangents(cameras, &rays, a, b);
                let met = tangents.meet(radius * self.scale(a, b), 0);
                PairFigures { a, b, figures: figures(&tangents, &met) }
            })
            .collect()
    }

    /// Evidence of some pairs at a radius, pixels of a 640×480 image, less that of clocks shifted by even parts of the
    /// recording.
    pub fn scores(
        &self,
        cameras: &[Camera],
        pairs: &[(usize, usize)],
        radius: f64,
        shifts: usize,
    ) -> Vec<Score> {
        let rays = self.all_rays(cameras);
        pairs
            .par_iter()
            .map(|&(a, b)| {
                let tangents = self.tangents(cameras, &rays, a, b);
                let scorer = tangents.scorer(radius * self.scale(a, b));
                let mut score = scorer.score(0);
                for k in 1..=shifts {
                    let by_chance = scorer.score(k * tangents.moments() / (shifts + 1));
                    score.excess -= by_chance.excess.max(0.0) / shifts as f64;
                }
                score
            })
            .collect()
    }

    /// The network's times at which some pairs are compared, pair by pair.
    pub fn times(&self, cameras: &[Camera], pairs: &[(usize, usize)]) -> Vec<f64> {
        let of = |c: usize| (&self.observed[c], &cameras[c]);
        pairs.iter().flat_map(|&(a, b)| common_times(of(a), of(b), &self.frames[a])).collect()
    }

    /// So many parts of the time in which some pairs are compared.
    pub fn time_parts(&self, cameras: &[Camera], pairs: &[(usize, usize)], parts: usize) -> TimeParts {
        TimeParts::new(self.times(cameras, pairs), parts)
    }

    /// Evidence of some pairs at a radius, pixels of a 640×480 image, in each part of the time.
    pub fn excess_by_part<const PARTS: usize>(
        &self,
        cameras: &[Camera],
        pairs: &[(usize, usize)],
        radius: f64,
        parts: &TimeParts,
    ) -> [f64; PARTS] {
        summed(&self.excess_of_pairs(cameras, pairs, radius, parts))
    }

    /// Excess over chance of each pair, part by part.
    pub fn excess_of_pairs<const PARTS: usize>(
        &self,
        cameras: &[Camera],
        pairs: &[(usize, usize)],
        radius: f64,
        parts: &TimeParts,
    ) -> Vec<[f64; PARTS]> {
        let rays = self.all_rays(cameras);
        let of_pair = |&(a, b): &(usize, usize)| {
            let tangents = self.tangents(cameras, &rays, a, b);
            let scores = tangents.scorer(radius * self.scale(a, b)).by_moment(0);
            let mut sums = [0.0; PARTS];
            for (k, score) in scores.iter().enumerate() {
                sums[parts.of(tangents.time(k))] += score.excess;
            }
            sums
        };
        pairs.par_iter().map(of_pair).collect()
    }

    /// [`ImageSize::pixel_scale`] of a pair.
    pub fn scale(&self, a: usize, b: usize) -> f64 {
        ImageSize::pixel_scale([a, b].map(|c| self.observed[c].size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_measured_of_a_camera_does_not_grow_with_its_partners() {
        for cameras in [0, 1, 3, 10] {
            assert_eq!(shared(240, cameras), 240);
        }
        for cameras in [11, 20, 37] {
            let of_camera = shared(240, cameras) * (cameras - 1);
            assert!((2100..=2160).contains(&of_camera), "{cameras}: {of_camera}");
        }
        assert_eq!(shared(240, 100), 60);
    }
}
