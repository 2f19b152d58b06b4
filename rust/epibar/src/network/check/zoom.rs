//! A camera whose focal length was changed: told from one that was turned, or that stands elsewhere.
//!
//! A pose can stand for some of what a zoom does, and a zoom for some of a pose: a camera that went closer shows all larger. So a
//! zoom is stated only where no pose alone explains the footage nearly as well, as it does over parts of it.

use super::one_camera::{Move, ROUGH, StretchCase, deviates, freed};
use super::stretch::PARTS;
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::Camera;
use crate::network::thresholds as limits;

/// Focal lengths that are tried, as shares of the stored one: beyond what a few per cent at once would find.
const ZOOMS: [f64; 8] = [0.75, 0.8, 0.86, 0.93, 1.07, 1.15, 1.25, 1.33];

impl StretchCase<'_> {
    /// A camera by the new footage; `None` where it shows too little.
    pub fn found(&self, camera: usize) -> Option<Move> {
        self.elsewhere(camera).map(|posed| self.zoomed(camera, &posed))
    }

    /// A camera by the end of the footage alone; `None` where nothing speaks for a move in the midst of it.
    pub fn found_at_end(&self, camera: usize) -> Option<Move> {
        let posed = if self.fades(camera) { self.elsewhere(camera) } else { self.nearby(camera) };
        let posed = posed.filter(|m| m.gain > limits::MOVED_DEVIATES && m.is_within())?;
        Some(self.zoomed(camera, &posed)).filter(Move::is_clear_within)
    }

    /// The move of a camera with what its focal length did; `posed` is the best that its pose alone explains.
    pub fn zoomed(&self, camera: usize, posed: &Move) -> Move {
        let mut beliefs = self.beliefs_free(camera);
        let of_pose = beliefs.clone();
        beliefs[camera] = freed(&beliefs[camera]);
        let start = self.other_focal(camera, &posed.camera);
        let Some(both) = self.measured(camera, start, &beliefs) else { return *posed };
        let measured = |posed: &Move| Move { focal: both.focal, focal_error: both.focal_error, ..*posed };
        if !both.is_zoomed() {
            return measured(posed);
        }
        let stored = self.network.cameras[camera];
        // A pose that was not found by itself may be beside the one with another focal length.
        let beside = Camera { log_focal: stored.log_focal, ..both.camera };
        let again = self.measured(camera, beside, &of_pose).filter(|m| m.better > posed.better);
        let posed = again.unwrap_or(*posed);
        beliefs[camera] = Beliefs { posed: true, ..beliefs[camera] };
        let start = Camera { log_focal: both.camera.log_focal, ..stored };
        let Some(only) = self.measured(camera, start, &beliefs) else { return measured(&posed) };
        self.simplest(camera, &posed, &Move { zoomed: true, ..only }, &Move { zoomed: true, ..both })
    }

    /// Which of a pose, a focal length, and both explains the footage and is no more than what it takes.
    fn simplest(&self, camera: usize, posed: &Move, only: &Move, both: &Move) -> Move {
        let measured = Move { focal: both.focal, focal_error: both.focal_error, ..*posed };
        let time = self.own_time(camera);
        let of = |found: &Move| self.parts(camera, found.camera, &time);
        let (by_both, by_pose, by_focal) = (of(both), of(posed), of(only));
        let more = |one: &[f64; PARTS], than: &[f64; PARTS]| -> Vec<f64> {
            one.iter().zip(than).skip(both.from).map(|(p, q)| p - q).collect()
        };
        let better = |more: &[f64]| deviates(more) > limits::ZOOMED_DEVIATES;
        let clearly = |one, than| {
            let more = more(one, than);
            better(&more) && more.iter().sum::<f64>() > limits::ZOOMED_SHARE * both.better
        };
        // One number that explains more than six needs no share of it.
        if !clearly(&by_both, &by_pose) && !better(&more(&by_focal, &by_pose)) {
            return Move { or_zoomed: !clearly(&by_pose, &by_focal), ..measured };
        }
        if both.is_reposed() && clearly(&by_both, &by_focal) {
            return *both;
        }
        // That the pose is as stored is known no better than its errors.
        Move { focal_error: both.focal_error, ..only.with_pose_of(both) }
    }

    /// The camera, or the stored one with the best of other focal lengths where that agrees better.
    fn other_focal(&self, camera: usize, posed: &Camera) -> Camera {
        let stored = self.network.cameras[camera];
        let zoomed = ZOOMS.map(|by| Camera { log_focal: stored.log_focal + by.ln(), ..stored });
        let tried = zoomed.into_iter().chain([*posed]);
        let scored = tried.map(|at| (self.excess(&self.fitted.few, camera, at, ROUGH), at));
        scored.max_by(|p, q| p.0.total_cmp(&q.0)).map_or(*posed, |best| best.1)
    }
}
