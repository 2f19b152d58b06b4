//! Which camera moved, by what each explains that would have moved by itself.
//!
//! A camera that moved spoils its pairs and no others. So for every camera it is asked how much better all pairs agree with the one place
//! of it that suits them best, the others being held. Where one moved, that one's place restores all that fell; another's restores
//! its pair with that camera at the most, and spoils pairs that stand. Three cameras of which one moved along the line to another
//! form a triangle of the same shape: then two explanations are equal, and either may be the true one.

use super::clocks::anchored;
use super::one_camera::{CLOSE, Move, Standing, StretchCase, deviates};
use super::stretch::{PARTS, Stretch};
use crate::error::Result;
use crate::network::model::beliefs::Beliefs;
use crate::network::model::camera::Camera;
use crate::network::observations::observed::Observed;
use crate::network::observations::survey::summed;
use crate::network::result::CheckStatus;
use crate::network::solve::relocate::Placed;
use crate::network::solve::settle::settle;
use crate::network::thresholds as limits;
use crate::watch::{Stage, Watch, report};

/// What was found of the cameras.
pub struct Judged {
    /// The cameras, those that moved where they stand now.
    pub now: Placed,
    /// Which moved.
    pub moved: Vec<bool>,
    /// For each camera the others that may have moved in place of it, so that it is not known which did.
    pub rivals: Vec<Vec<usize>>,
    /// What was found of each camera, beside those that moved.
    pub found: Vec<Option<Move>>,
}

impl Judged {
    /// What is said of a camera that has so much in common with the others, as a normal deviate.
    pub fn status(&self, camera: usize, deviate: f64) -> CheckStatus {
        let rivals = !self.rivals[camera].is_empty();
        let found = self.found[camera].as_ref().filter(|_| deviate >= limits::CAMERA_DEVIATES);
        match (found, rivals, self.moved[camera]) {
            (None, ..) => CheckStatus::Unsure,
            (Some(_), true, _) => CheckStatus::Suspect,
            (Some(_), false, true) => CheckStatus::Moved,
            (Some(found), false, false) if found.is_far() => CheckStatus::Unsure,
            (Some(_), false, false) => CheckStatus::Unmoved,
        }
    }
}

/// New footage of a network.
pub struct Footage<'a> {
    pub observed: &'a [Observed],
    pub beliefs: &'a [Beliefs],
}

/// What all pairs say if one camera moved.
struct Explanation {
    camera: usize,
    found: Move,
    /// The network before that camera is put elsewhere, with clocks and insets by the pairs that it has no part in.
    network: Placed,
    /// Evidence of every pair, part by part.
    parts: Vec<[f64; PARTS]>,
    /// In which parts the camera is compared with any other.
    seen: Vec<bool>,
}

/// What was found of the cameras that did not move yet, and what each explains, if any moved.
struct Round {
    pairs: Vec<(usize, usize)>,
    found: Vec<Option<Move>>,
    explained: Vec<Explanation>,
}

/// Which cameras moved.
///
/// # Errors
/// [`crate::Error::Interrupted`].
pub fn judged(footage: &Footage, stored: &Placed, watch: &mut dyn Watch) -> Result<Judged> {
    let n = footage.beliefs.len();
    let mut so_far = Judged {
        now: stored.clone(),
        moved: vec![false; n],
        rivals: vec![Vec::new(); n],
        found: vec![None; n],
    };
    let mut stretch = Stretch::whole(footage.observed, stored);
    let mut round = footage.asked(&stretch, &so_far, watch)?;
    let by_themselves = round.found.clone();
    loop {
        so_far.take(&round);
        let leading = round.leading();
        let suspects: Vec<usize> = leading.iter().map(|e| e.camera).collect();
        let mut next = None;
        for explained in leading {
            let (after, then) = explained.placed(&stretch, &so_far);
            let rest = footage.asked(&after, &then, watch)?;
            if suspects.len() > 1 && rest.leading().is_empty() {
                so_far.now = then.now;
                so_far.suspect(&suspects);
                return Ok(so_far);
            }
            next = next.or(Some((after, then, rest)));
        }
        let Some(after_best) = next else { break };
        (stretch, so_far, round) = after_best;
        so_far.rivals[suspects[0]] = suspects[1..].to_vec();
    }
    so_far.settle_rivals();
    so_far.doubt_without_two_that_stand(&by_themselves);
    Ok(so_far)
}

impl Judged {
    /// Keeps what was found of the cameras that did not move.
    fn take(&mut self, round: &Round) {
        for (c, found) in round.found.iter().enumerate().filter(|(c, _)| !self.moved[*c]) {
            self.found[c] = *found;
        }
    }

    /// One of these moved.
    fn suspect(&mut self, cameras: &[usize]) {
        for &c in cameras {
            self.moved[c] = false;
            self.rivals[c] = cameras.iter().copied().filter(|other| *other != c).collect();
        }
        self.settle_rivals();
    }

    /// Cameras move against others, and where fewer than two of several are left that stand nothing says against which: two that
    /// moved spoil all pairs of four but one. Then any may have moved, by what it was found to have done by itself.
    fn doubt_without_two_that_stand(&mut self, by_themselves: &[Option<Move>]) {
        let all: Vec<usize> = (0..self.moved.len()).collect();
        let stand = all.iter().filter(|&&c| !self.moved[c] && self.rivals[c].is_empty()).count();
        if all.len() > 2 && stand < 2 && self.moved.contains(&true) {
            self.found = by_themselves.to_vec();
            self.suspect(&all);
        }
    }

    /// A camera that moved itself did not move in place of another.
    fn settle_rivals(&mut self) {
        for c in (0..self.moved.len()).filter(|&c| self.moved[c]).collect::<Vec<_>>() {
            let rivals: Vec<usize> = self.rivals[c].iter().copied().filter(|&o| !self.moved[o]).collect();
            self.rivals[c].clear();
            if !rivals.is_empty() {
                self.suspect(&[&[c], &rivals[..]].concat());
            }
        }
    }
}

impl Footage<'_> {
    /// What is found of each camera that did not move.
    fn asked(&self, stretch: &Stretch, so_far: &Judged, watch: &mut dyn Watch) -> Result<Round> {
        let n = self.beliefs.len();
        let end = stretch.end();
        let standing = Standing::of(stretch, &so_far.now);
        let whole = StretchCase { stretch, fitted: stretch, beliefs: self.beliefs, network: &so_far.now };
        let at_end = StretchCase { fitted: &end, ..whole };
        let rounds = so_far.moved.iter().filter(|m| **m).count();
        let mut found = Vec::new();
        for c in 0..n {
            report(watch, Stage::Network, (rounds * n + c) as f64 / (n * (n + 1)) as f64)?;
            found.push(if so_far.moved[c] { None } else { moved(&whole, &at_end, c) });
        }
        let mut explained = Vec::new();
        if found.iter().flatten().any(Move::is_clear) {
            for (c, found) in found.iter_mut().enumerate() {
                let Some(found) = found else { continue };
                let explanation = self.explanation(stretch, so_far, c, found);
                *found = explanation.found;
                explained.push(explanation);
            }
        }
        Ok(Round { pairs: standing.pairs, found, explained })
    }

    /// What all pairs say if a camera moved, of which a move was found beside clocks and insets that it may have spoiled.
    fn explanation(&self, stretch: &Stretch, so_far: &Judged, camera: usize, found: &Move) -> Explanation {
        let network = self.without(stretch, &so_far.now, camera);
        let standing = Standing::of(stretch, &network);
        let fitted = since(found, stretch);
        let case = StretchCase { stretch, fitted: &fitted, beliefs: self.beliefs, network: &network };
        let start = Camera { log_focal: network.cameras[camera].log_focal, ..found.camera };
        let posed = case.measured(camera, start, &case.beliefs_free(camera));
        let found = posed.map_or(*found, |posed| case.zoomed(camera, &posed));
        let there = case.with(camera, found.camera);
        let new =
            stretch.all.excess_of_pairs::<PARTS>(&there, &standing.pairs, limits::COMPARED, &stretch.parts);
        let part = |p: usize, k: usize| if k >= found.from_of_all { new[p][k] } else { standing.parts[p][k] };
        let parts = (0..new.len()).map(|p| std::array::from_fn(|k| part(p, k))).collect();
        let times = stretch.all.times(&network.cameras, &case.pairs_of(camera));
        let seen = stretch.parts.occupied(&times);
        Explanation { camera, found, network, parts, seen }
    }

    /// A network with clocks and insets by the pairs that a camera has no part in.
    fn without(&self, stretch: &Stretch, network: &Placed, camera: usize) -> Placed {
        let pairs: Vec<(usize, usize)> =
            network.pairs().into_iter().filter(|&(a, b)| a != camera && b != camera).collect();
        let others: Vec<bool> = (0..self.beliefs.len()).map(|c| c != camera).collect();
        let beliefs = anchored(self.beliefs, &network.cameras, camera);
        let settled = settle(&stretch.all, &network.cameras, &beliefs, &pairs, &others, Some(CLOSE));
        Placed { cameras: settled.cameras, placed: network.placed.clone() }
    }
}

impl Explanation {
    /// The network with the camera where it would stand now, and the footage since.
    fn placed<'f>(&self, stretch: &Stretch<'f>, so_far: &Judged) -> (Stretch<'f>, Judged) {
        let mut then = Judged {
            now: self.network.clone(),
            moved: so_far.moved.clone(),
            rivals: so_far.rivals.clone(),
            found: so_far.found.clone(),
        };
        then.now.cameras[self.camera] = self.found.camera;
        then.moved[self.camera] = true;
        (since(&self.found, stretch), then)
    }
}

/// The footage since a move; all of a stretch where it was not filmed.
fn since<'f>(found: &Move, stretch: &Stretch<'f>) -> Stretch<'f> {
    stretch.since(found.is_within().then_some((found.since, found.before)))
}

/// The move of a camera before the footage or in the midst of it.
fn moved(whole: &StretchCase, at_end: &StretchCase, camera: usize) -> Option<Move> {
    let of_all = whole.found(camera);
    let enough = |m: &Move| m.is_clear() && !m.is_within();
    let within = if of_all.as_ref().is_some_and(enough) { None } else { at_end.found_at_end(camera) };
    match (of_all, within) {
        (Some(all), Some(end)) => Some(if all.better >= end.better { all } else { end }),
        (all, end) => end.or(all),
    }
}

impl Round {
    /// Where a camera clearly moved the one that explains most, and then those that explain about as much.
    fn leading(&self) -> Vec<&Explanation> {
        if !self.explained.iter().any(|e| e.found.is_clear()) {
            return Vec::new();
        }
        let mut all: Vec<(f64, &Explanation)> =
            self.explained.iter().map(|e| (e.parts.iter().flatten().sum::<f64>(), e)).collect();
        all.sort_by(|p, q| q.0.total_cmp(&p.0));
        let likely = |e: &Explanation| e.found.gain > limits::MOVED_DEVIATES;
        let Some(best) = all.iter().map(|(_, e)| *e).find(|e| likely(e)) else { return Vec::new() };
        let others = all.into_iter().map(|(_, e)| e).filter(|e| e.camera != best.camera);
        // Of two cameras either explains the same.
        let rivals = others.filter(|e| self.pairs.len() == 1 || !self.rules_out(best, e));
        [best].into_iter().chain(rivals).collect()
    }

    /// Whether so much more speaks for one explanation that the other is not the true one.
    fn rules_out(&self, best: &Explanation, other: &Explanation) -> bool {
        let from = best.found.from_of_all.min(other.found.from_of_all);
        let more = |of: &dyn Fn(&(usize, usize)) -> bool| -> Vec<(usize, f64)> {
            let chosen = |e: &Explanation| -> [f64; PARTS] {
                summed(self.pairs.iter().zip(&e.parts).filter(|(pair, _)| of(pair)).map(|(_, parts)| parts))
            };
            let (one, two) = (chosen(best), chosen(other));
            (from..PARTS).map(|k| (k, one[k] - two[k])).collect()
        };
        // Pairs that stand whatever happened to the best: another that had moved would have spoiled its own.
        let (all, stand) = (more(&|_| true), more(&|&(a, b)| a != best.camera && b != best.camera));
        let clearly = |parts: &[(usize, f64)], least: f64| {
            let sum: f64 = parts.iter().map(|(_, more)| more).sum();
            // Where the best is not seen it explains nothing more, though it may be seen for a small part of the time.
            let seen = parts.iter().filter(|(k, _)| best.seen[*k]).map(|(_, more)| *more).collect::<Vec<_>>();
            let all = parts.iter().map(|(_, more)| *more).collect::<Vec<_>>();
            deviates(&seen).max(deviates(&all)) > limits::RULED_OUT && sum / best.found.better > least
        };
        clearly(&stand, limits::SPOILED_SHARE) || clearly(&all, limits::RULED_OUT_SHARE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ImageSize;

    #[test]
    fn what_is_said_needs_enough_in_common_and_one_explanation() {
        let cameras = [500.0, 600.0].map(|focal| Camera::new(ImageSize::new(640, 480).unwrap(), focal));
        let mut judged = Judged {
            now: Placed { cameras: cameras.to_vec(), placed: vec![true; 2] },
            moved: vec![true, false],
            rivals: vec![Vec::new(); 2],
            found: cameras.map(|camera| Some(Move::none(camera))).to_vec(),
        };
        let enough = limits::CAMERA_DEVIATES;
        assert_eq!([0, 1].map(|c| judged.status(c, enough)), [CheckStatus::Moved, CheckStatus::Unmoved]);
        for deviate in [enough - 0.1, f64::NAN] {
            assert_eq!([0, 1].map(|c| judged.status(c, deviate)), [CheckStatus::Unsure; 2]);
        }
        judged.rivals = vec![vec![1], vec![0]];
        assert_eq!([0, 1].map(|c| judged.status(c, enough)), [CheckStatus::Suspect; 2]);
        judged.found[1] = None;
        assert_eq!(judged.status(1, enough), CheckStatus::Unsure);
    }

    #[test]
    fn where_fewer_than_two_stand_nobody_knows_which_moved() {
        let camera = Camera::new(ImageSize::new(640, 480).unwrap(), 500.0);
        let judged = |moved: &[bool]| {
            let n = moved.len();
            let now = Placed { cameras: vec![camera; n], placed: vec![true; n] };
            let found = vec![Some(Move { turned: 1.0, ..Move::none(camera) }); n];
            let mut judged = Judged { now, moved: moved.to_vec(), rivals: vec![Vec::new(); n], found };
            judged.doubt_without_two_that_stand(&vec![Some(Move { turned: 0.5, ..Move::none(camera) }); n]);
            let status = (0..n).map(|c| judged.status(c, limits::CAMERA_DEVIATES)).collect::<Vec<_>>();
            (status, judged.found[0].unwrap().turned)
        };
        let suspects = |n: usize| (vec![CheckStatus::Suspect; n], 0.5);
        assert_eq!(judged(&[true; 4]), suspects(4));
        assert_eq!(judged(&[true, true, false]), suspects(3));
        let named = [CheckStatus::Moved, CheckStatus::Moved, CheckStatus::Unmoved, CheckStatus::Unmoved];
        assert_eq!(judged(&[true, true, false, false]), (named.to_vec(), 1.0));
        assert_eq!(judged(&[false; 4]), (vec![CheckStatus::Unmoved; 4], 1.0));
    }

    #[test]
    fn one_that_agrees_best_far_away_is_not_said_to_stand() {
        let camera = Camera::new(ImageSize::new(640, 480).unwrap(), 500.0);
        let (error, far) = (0.01, limits::SEEMS_MOVED * 0.01);
        let at = |turned: f64, shifted: f64, better: f64| Move {
            better,
            turned,
            shifted,
            turned_error: error,
            shifted_error: error,
            focal: 0.0,
            focal_error: error,
            ..Move::none(camera)
        };
        let status = |found: Move, moved: bool| {
            let now = Placed { cameras: vec![camera], placed: vec![true] };
            let rivals = vec![Vec::new()];
            let judged = Judged { now, moved: vec![moved], rivals, found: vec![Some(found)] };
            judged.status(0, limits::CAMERA_DEVIATES)
        };
        for found in [at(1.01 * far, 0.0, 1.0), at(0.0, 1.01 * far, 1.0)] {
            assert_eq!(status(found, false), CheckStatus::Unsure);
            assert_eq!(status(found, true), CheckStatus::Moved);
            assert_eq!(status(Move { better: 0.0, ..found }, false), CheckStatus::Unmoved);
        }
        let zoomed = Move { focal: -1.01 * far, ..at(0.0, 0.0, 1.0) };
        assert_eq!(status(zoomed, false), CheckStatus::Unsure);
        assert_eq!(status(at(0.99 * far, 0.99 * far, 1.0), false), CheckStatus::Unmoved);
        // That nothing tells of a shift is no move.
        let untold = Move { shifted_error: f64::INFINITY, ..at(0.0, 1e3, 1.0) };
        assert_eq!(status(untold, false), CheckStatus::Unmoved);
    }
}
