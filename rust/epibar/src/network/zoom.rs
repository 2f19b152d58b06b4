//! A camera whose focal length was changed: told from one that was turned, or that stands elsewhere.
//!
//! A pose can stand for some of what a zoom does, and a zoom for some of a pose: a camera that went closer shows all larger. So the
//! simplest that explains the footage is taken, as it does over parts of it: the pose alone, the focal length alone, or both.

use super::camera::Camera;
use super::covariance::covariance;
use super::joint::{Beliefs, Problem};
use super::moves::{Case, Move, PARTS, ROUGH, deviates, focal_error, freed};
use super::relocate::Placed;
use super::settle::settle;
use super::thresholds as limits;

/// Focal lengths that are tried, as shares of the stored one: beyond what a few per cent at once would find.
const ZOOMS: [f64; 8] = [0.75, 0.8, 0.86, 0.93, 1.07, 1.15, 1.25, 1.33];

impl Case<'_> {
    /// A camera by the new footage; `None` where it shows too little.
    pub fn found(&self, network: &Placed, camera: usize) -> Option<Move> {
        self.elsewhere(network, camera).map(|posed| self.zoomed(network, camera, &posed))
    }

    /// The move of a camera with what its focal length did; `posed` is the best that its pose alone explains.
    fn zoomed(&self, network: &Placed, camera: usize, posed: &Move) -> Move {
        let with = |at: Camera| {
            let mut cameras = network.cameras.clone();
            cameras[camera] = at;
            cameras
        };
        let pairs = self.pairs_of(camera);
        let start = self.other_focal(network, camera, &posed.camera);
        let mut beliefs = self.beliefs.to_vec();
        beliefs[camera] = Beliefs { posed: false, ..freed(&beliefs[camera]) };
        let Some(both) = self.measured(network, camera, start, &beliefs) else { return *posed };
        let measured = Move { focal: both.focal, focal_error: both.focal_error, ..*posed };
        if !both.is_zoomed() {
            return measured;
        }
        let stored = network.cameras[camera];
        let start = Camera { log_focal: both.camera.log_focal, ..stored };
        beliefs[camera].posed = true;
        let Some(only) = self.focal_alone(camera, &with(start), &beliefs, stored.log_focal) else {
            return measured;
        };
        let from = (both.since * PARTS as f64) as usize;
        let of = |at: Camera| self.parts(&with(at), &pairs)[from..].to_vec();
        let (by_both, by_pose, by_focal) = (of(both.camera), of(posed.camera), of(only.camera));
        let better = |one: &[f64], than: &[f64]| {
            let parts: Vec<f64> = one.iter().zip(than).map(|(p, q)| p - q).collect();
            deviates(&parts) > limits::MOVED_DEVIATES
        };
        let sum = |parts: &[f64]| parts.iter().sum::<f64>();
        // One number that explains as much as six is the simpler answer.
        if !better(&by_both, &by_pose) && sum(&by_focal) < sum(&by_pose) {
            return measured;
        }
        if both.is_reposed() && better(&by_both, &by_focal) {
            return Move { zoomed: true, ..both };
        }
        let (gain, since) = self.gain(network, &with(only.camera), camera, &pairs);
        Move { turned: both.turned, shifted: both.shifted, gain, since, ..only }.with_errors_of(&both)
    }

    /// The camera, or the stored one with the best of other focal lengths where that agrees better.
    fn other_focal(&self, network: &Placed, camera: usize, posed: &Camera) -> Camera {
        let pairs = self.pairs_of(camera);
        let stored = network.cameras[camera];
        let zoomed = ZOOMS.map(|by| Camera { log_focal: stored.log_focal + by.ln(), ..stored });
        let evidence = |at: &Camera| -> f64 {
            let mut cameras = network.cameras.clone();
            cameras[camera] = *at;
            self.few.scores(&cameras, &pairs, ROUGH, 0).iter().map(|s| s.excess).sum()
        };
        let tried = zoomed.into_iter().chain([*posed]).map(|at| (evidence(&at), at));
        tried.max_by(|p, q| p.0.total_cmp(&q.0)).map_or(*posed, |best| best.1)
    }

    /// The focal length by the new footage, the camera standing and looking as stored.
    fn focal_alone(&self, camera: usize, start: &[Camera], beliefs: &[Beliefs], stored: f64) -> Option<Move> {
        let mut moving = vec![false; start.len()];
        moving[camera] = true;
        let settled = settle(self.survey, start, beliefs, &self.pairs_of(camera), &moving, None);
        let problem = Problem {
            pairs: &settled.pairs,
            beliefs,
            scale: settled.scale,
            prior_weight: settled.prior_weight,
            moving,
        };
        let found = covariance(&problem, &settled.cameras, 0.0)?;
        let at = settled.cameras[camera];
        Some(Move {
            focal: at.log_focal - stored,
            focal_error: focal_error(&found, camera)?,
            zoomed: true,
            ..Move::none(at)
        })
    }
}
