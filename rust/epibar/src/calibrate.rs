//! The whole job: two recordings in, one calibration out.
//!
//! The clocks are aligned; on one time line candidates are found, an `F` is searched with them, refined, and verified, once
//! more with other frames kept aside where they say too little. What it says of the clocks may call for another time line, and then all is
//! done once more.

use crate::calibration::{Calibration, CandidatePair, Counts, FrontierPoint, ShiftScore};
use crate::clock::{Aligned, Clocks, TimeOffset, Timing};
use crate::error::Result;
use crate::frontier::volume::disagreement;
use crate::frontier::{Views, busy_frames};
use crate::geometry::Fundamental;
use crate::geometry::median::median;
use crate::hypotheses::{Draws, LineModel};
use crate::matching::{Candidates, find_candidates};
use crate::offset_choice::outstanding_offset;
use crate::options::{CalibrateOptions, Method};
use crate::recording::{FramePair, RecordedFrame, Recording};
use crate::refine::{loss_scale, with_insets};
use crate::search::by_lines::{self, Filmed};
use crate::search::{Effort, Found, SearchOptions, Solution, TrainingSet, insets, search, settle};
use crate::verify::other_clocks::{OtherClock, other_clocks};
use crate::verify::second_look::Earlier;
use crate::verify::split::{Fold, Split, Stay};
use crate::verify::thresholds::{CLOCK_BETTER, MIN_Z_FOR_CLOCK, reaches, within};
use crate::verify::trials::falls_for;
use crate::verify::{Case, SplitViews, Verdict, Verified, are_masks, untestable, verify};
use crate::watch::{Stage, Unwatched, Watch, report};

/// Finds the fundamental matrix between two cameras.
///
/// Refusing is a result, not an error: see [`Calibration::verdict`]. The result depends on the recordings and the
/// options, not on the number of threads.
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) for options out of range.
pub fn calibrate(a: &Recording, b: &Recording, options: &CalibrateOptions) -> Result<Calibration> {
    calibrate_watched(a, b, options, &mut Unwatched)
}

/// [`calibrate`] with progress, and a way to stop: `watch` is asked between batches of work.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted) where `watch` says so, [`Error::Argument`](crate::Error::Argument)
/// for options out of range.
pub fn calibrate_watched(
    a: &Recording,
    b: &Recording,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    options.check()?;
    let found = at_better_clock(a, b, options.time_offset, options, watch)?;
    let next = options.time_offset.where_refused();
    let Some(next) = next.filter(|_| !found.accepted()) else { return Ok(found.with_outlines()) };
    let other = at_better_clock(a, b, next, options, watch)?;
    let other_is_better = other.accepted() || other.evidence.z > found.evidence.z;
    Ok(if other_is_better { other } else { found }.with_outlines())
}

/// From what is known of the offset, and once more from another one near it where that is clearly better.
fn at_better_clock(
    a: &Recording,
    b: &Recording,
    offset: TimeOffset,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<Calibration> {
    let (found, better) = calibrate_from(a, b, offset, options, watch)?;
    let Some(better) = better else { return Ok(found) };
    let (other, _) = calibrate_from(a, b, TimeOffset::About(better), options, watch)?;
    // It is still the best of as many as were tried before.
    let Timing { runner_up, trials, .. } = found.timing;
    let timing = Timing { runner_up, trials, ..other.timing };
    let other = other.with_timing(timing, trials);
    Ok(if other.evidence.z > found.evidence.z { other } else { found })
}

/// From what is known of the offset, which is learned with the geometry; and another offset that is clearly better, if there is one.
fn calibrate_from(
    a: &Recording,
    b: &Recording,
    offset: TimeOffset,
    options: &CalibrateOptions,
    watch: &mut dyn Watch,
) -> Result<(Calibration, Option<f64>)> {
    let mut clocks = Clocks::new(a, b, offset, options.upright, watch)?;
    if options.method == Method::Frontier
        && let Some(outstanding) = outstanding_offset(&clocks, options, &mut after_barcodes(watch))?
    {
        clocks.take(outstanding.offset);
    }
    loop {
        let found = calibrate_at(&clocks.aligned(), options, watch)?;
        let credible = found.fundamental.filter(|_| found.evidence.z >= MIN_Z_FOR_CLOCK);
        if let Some(timing) = clocks.learn(credible) {
            // Only where their number decides is it asked more closely.
            let decides = found.accepted() && falls_for(timing.trials, &found.evidence);
            let trials = if decides { clocks.trials_by_parts(watch)? } else { timing.trials };
            let found = found.with_timing(timing, trials);
            return Ok(if offset.is_given() {
                (borne_out_by_motion(found, &clocks, options), None)
            } else {
                told_by_motion(found, &clocks, options)
            });
        }
    }
}

/// The last tenth of the work on the offset.
fn after_barcodes(watch: &mut dyn Watch) -> impl Watch {
    |stage, done| watch.keep_going(stage, 0.9 + 0.1 * done)
}

/// An accepted geometry, unless what moves does not tell the clock that it was found with; and an offset that is clearly better.
fn told_by_motion(
    found: Calibration,
    clocks: &Clocks,
    options: &CalibrateOptions,
) -> (Calibration, Option<f64>) {
    let others = clocks_beside(&found, clocks, options);
    let best = others.iter().max_by(|p, q| p.share.total_cmp(&q.share));
    let better =
        best.filter(|o| reaches(o.share, CLOCK_BETTER)).map(|o| clocks.later(o.later).clock().offset);
    let open = others.iter().filter(|o| o.is_open(options.max_expected_error));
    match open.max_by(|p, q| p.distance.total_cmp(&q.distance)) {
        Some(other) => (Calibration { verdict: other.verdict(clocks.frame_interval()), ..found }, better),
        None => (found, better),
    }
}

/// An accepted geometry, unless another clock than the one that was given explains clearly more; where one explains as much it is said.
fn borne_out_by_motion(found: Calibration, clocks: &Clocks, options: &CalibrateOptions) -> Calibration {
    let (limit, frame_interval) = (options.max_expected_error, clocks.frame_interval());
    let others = clocks_beside(&found, clocks, options);
    let better = others.iter().filter(|o| o.is_better(limit)).max_by(|p, q| p.gain.total_cmp(&q.gain));
    if let Some(other) = better {
        return Calibration { verdict: other.verdict_of_given(frame_interval), ..found };
    }
    let open = others.iter().filter(|o| o.is_open(limit));
    match open.max_by(|p, q| p.distance.total_cmp(&q.distance)) {
        Some(other) => {
            let verdict = found.verdict.with_remark(&other.remark_on_given(frame_interval));
            Calibration { verdict, ..found }
        }
        None => found,
    }
}

/// Other clocks under which a geometry of its own explains most of what an accepted one does.
fn clocks_beside(found: &Calibration, clocks: &Clocks, options: &CalibrateOptions) -> Vec<OtherClock> {
    let Some(f) = found.fundamental.filter(|_| found.accepted()) else { return Vec::new() };
    other_clocks(|frames| clocks.later(frames), &f, options.cameras_used(), options.seed)
}

/// By a known clock.
fn calibrate_at(aligned: &Aligned, options: &CalibrateOptions, watch: &mut dyn Watch) -> Result<Calibration> {
    let common = aligned.frame_pairs();
    if let Some(verdict) = untestable::too_few_frames(common.len()) {
        return Ok(refused(verdict, aligned, &Candidates::default(), &common, options));
    }
    let pair = Pair::new(aligned, common, options);
    let (first, earlier) = pair.look(Fold::First, None, watch)?;
    let Some(earlier) = earlier.filter(|_| options.method == Method::Frontier) else { return Ok(first) };
    let (second, _) = pair.look(Fold::Second, Some(&earlier), watch)?;
    Ok(if second.evidence.z > first.evidence.z { second } else { first })
}

/// A refusal before there is anything to verify.
fn refused(
    verdict: Verdict,
    aligned: &Aligned,
    candidates: &Candidates,
    common: &[FramePair],
    options: &CalibrateOptions,
) -> Calibration {
    let timing = Timing::of(aligned.clock(), aligned.a(), aligned.b());
    let candidate_pairs = with_inliers(candidates, std::iter::repeat(false));
    let counts = counts(candidates, &candidate_pairs, common.len(), 0);
    let nothing = Calibration::refused(verdict, timing, options.method, options.seed);
    Calibration { candidates: candidate_pairs, counts, ..nothing }
}

/// Two recordings on one time line, and which of their frames are for what.
struct Pair<'a> {
    aligned: &'a Aligned<'a>,
    options: &'a CalibrateOptions,
    /// All common frames, and those in which both cameras see something.
    common: Vec<FramePair>,
    busy: Vec<FramePair>,
    /// For how many frames motion stays where it is.
    stay: Stay,
    /// Silhouettes were cut out, and stand in for nothing else.
    masks: bool,
}

impl<'a> Pair<'a> {
    fn new(aligned: &'a Aligned<'a>, common: Vec<FramePair>, options: &'a CalibrateOptions) -> Self {
        let (a, b) = (aligned.a(), aligned.b());
        let busy = busy_frames(a, b, &common, None);
        let stay = Stay::new(a, b, &common, &busy);
        Self { aligned, options, common, busy, stay, masks: are_masks([a, b]) }
    }

    /// Common frames a second: where A films faster than B not all of its frames are. NaN where unknown.
    fn frame_rate(&self) -> f64 {
        // The median, as frames may lack for a while.
        let step = median(self.common.windows(2).map(|p| f64::from(p[1].a - p[0].a)));
        self.aligned.a().frame_rate() / step.map_or(f64::NAN, |step| step.max(1.0))
    }

    /// Found by some frames and tested on others, and what is worth a second look at it, if anything is.
    fn look(
        &self,
        fold: Fold,
        earlier: Option<&Earlier>,
        watch: &mut dyn Watch,
    ) -> Result<(Calibration, Option<Earlier>)> {
        report(watch, Stage::Candidates, 0.0)?;
        let refused = |verdict, candidates: &Candidates| {
            Ok((refused(verdict, self.aligned, candidates, &self.common, self.options), None))
        };
        let split = Split::new(&self.common, &self.busy, self.stay, fold);
        let candidates = self.candidates(&split)?;
        if let Some(verdict) = untestable::too_little_motion(&candidates, self.busy.len()) {
            return refused(verdict, &candidates);
        }
        let seen = SplitViews::new(split, &self.common, &self.busy, |frames| self.views(frames));
        let (seen, found) = match self.options.method {
            Method::Frontier => self.by_tangents(seen, &candidates, watch)?,
            Method::Lines => {
                let found = self.by_lines(&seen, &candidates, watch)?;
                (seen, found)
            }
        };
        let Some(winner) = found.solutions.first() else {
            return refused(untestable::no_hypothesis(), &candidates);
        };
        let case = Case { earlier, ..self.case(&seen, &found) };
        let verified = verify(&case, &winner.fundamental, watch)?;
        let again = Earlier::new(&verified, found.fitted);
        Ok((self.calibration(&seen, &candidates, &found, winner, verified), again))
    }

    /// Candidates of the answer: tangents are searched on the fitted frames alone, lines on all.
    fn candidates(&self, split: &Split) -> Result<Candidates> {
        match self.options.method {
            Method::Frontier => self.candidates_of(&split.fitted),
            Method::Lines => self.candidates_of(&self.common),
        }
    }

    fn candidates_of(&self, compared: &[FramePair]) -> Result<Candidates> {
        let (a, b) = (self.aligned.a(), self.aligned.b());
        find_candidates(a, b, &self.common, compared, &self.options.candidate_options())
    }

    /// Silhouettes of both at some of the frames.
    fn views(&self, frames: &[FramePair]) -> Views {
        self.aligned.views(frames).with_cameras(self.options.cameras_used())
    }

    /// The method of frontier points: search on the fitted frames, then refine on all, with silhouettes moved onto their outlines, which the fitted frames
    /// tell; what was moved is what the answer is tested on.
    fn by_tangents(
        &self,
        seen: SplitViews,
        candidates: &Candidates,
        watch: &mut dyn Watch,
    ) -> Result<(SplitViews, Found)> {
        let defaults = Effort::default();
        let draws = Draws { lines: self.options.draws, ..defaults.draws };
        let effort = Effort { draws, ..defaults };
        let some = |limit| {
            let busy = busy_frames(self.aligned.a(), self.aligned.b(), &seen.split.fitted_busy, Some(limit));
            self.views(&busy)
        };
        let training = TrainingSet::new(
            &seen.fitted,
            some,
            SearchOptions { seed: self.options.seed, effort, ..SearchOptions::default() },
        );
        let searched = search(&training, candidates, watch)?;
        // Shapes that stand for others are off by a share of their width, and not all alike.
        let insets = if self.masks { insets(&training, &searched) } else { None };
        let Some(insets) = insets else {
            let found = settle(&training, &seen.all, searched, watch)?;
            return Ok((seen, found));
        };
        let moved = seen.moved_outward(insets);
        let training = training.moved_outward(&moved.fitted, insets);
        let found = settle(&training, &moved.all, searched, watch)?;
        Ok((moved, found))
    }

    /// The method of the paper.
    fn by_lines(&self, seen: &SplitViews, candidates: &Candidates, watch: &mut dyn Watch) -> Result<Found> {
        let fitted = self.candidates_of(&seen.split.fitted)?;
        let recordings = [self.aligned.a(), self.aligned.b()];
        let all = Filmed { recordings, frames: &self.common, candidates };
        let fitted = Filmed { recordings, frames: &seen.split.fitted, candidates: &fitted };
        let CalibrateOptions { draws, seed, .. } = *self.options;
        by_lines::search(&all, &fitted, &seen.all, draws, seed, watch)
    }

    fn case<'s>(&'s self, seen: &'s SplitViews, found: &'s Found) -> Case<'s> {
        Case {
            views: &seen.all,
            busy_views: &seen.busy,
            fitted_views: &seen.fitted,
            split: &seen.split,
            recordings: [self.aligned.a(), self.aligned.b()],
            masks: self.masks,
            common: &self.common,
            found,
            earlier: None,
            max_expected_error: self.options.max_expected_error,
            frame_rate: self.frame_rate(),
            seed: self.options.seed,
        }
    }

    fn calibration(
        &self,
        seen: &SplitViews,
        candidates: &Candidates,
        found: &Found,
        winner: &Solution,
        verified: Verified,
    ) -> Calibration {
        let (a, b) = (self.aligned.a(), self.aligned.b());
        let timing = Timing::of(self.aligned.clock(), a, b);
        let outlined = self.outlined(seen, &winner.fundamental, &verified);
        let empty = Calibration::refused(verified.verdict, timing, self.options.method, self.options.seed);
        let f = &winner.fundamental;
        let inliers = LineModel::new(candidates.best(), seen.all.sizes()).inliers(f);
        let candidate_pairs = with_inliers(candidates, inliers.into_iter());
        let of_a = |p: &crate::frontier::TangentMatch| RecordedFrame(self.common[p.frame.index()].a);
        // Points stay on the silhouettes, by which pairs of one camera share them.
        let on_silhouettes = |p: &crate::frontier::TangentMatch| {
            let frame = p.frame.index();
            FrontierPoint::new(of_a(p), seen.all.a.unmoved(frame, p.a), seen.all.b.unmoved(frame, p.b), f)
        };
        let frontier_points: Vec<FrontierPoint> = verified.matches.iter().map(on_silhouettes).collect();
        let floor = found.floor.as_ref().filter(|floor| floor.is_supported(candidates.best().len()));
        Calibration {
            fundamental: Some(*f),
            expected_error: Some(verified.expected_error).filter(|e| e.is_finite()),
            error_maps: verified.uncertainty.map(|u| u.maps()),
            counts: counts(candidates, &candidate_pairs, self.common.len(), frontier_points.len()),
            candidates: candidate_pairs,
            frontier_points,
            floor: floor.map(|floor| floor.homography),
            rivals: verified.rivals,
            evidence: verified.evidence,
            shift_curve: verified.curve.totals().map(|(shift, score)| ShiftScore { shift, score }).collect(),
            tested: found.fitted,
            source: Some(winner.source),
            outlined,
            ..empty
        }
    }

    /// The geometry with both insets solved for once more, on all frames, where that is no farther from the one that was tested than it may be wrong.
    fn outlined(&self, seen: &SplitViews, f: &Fundamental, verified: &Verified) -> Option<Fundamental> {
        if self.options.method != Method::Frontier {
            return None;
        }
        let outlined = with_insets(&seen.all, f, &verified.matches, loss_scale(verified.radius))?;
        within(disagreement(&verified.volume, &outlined), verified.expected_error).then_some(outlined)
    }
}

fn with_inliers(candidates: &Candidates, inliers: impl Iterator<Item = bool>) -> Vec<CandidatePair> {
    let pair = |(c, inlier): (&crate::matching::Candidate, bool)| CandidatePair {
        a: c.lines.a,
        b: c.lines.b,
        correlation: c.correlation,
        inlier,
    };
    candidates.best().iter().zip(inliers).map(pair).collect()
}

fn counts(candidates: &Candidates, pairs: &[CandidatePair], frames: usize, frontier_points: usize) -> Counts {
    Counts {
        frames,
        informative_a: candidates.informative_a,
        informative_b: candidates.informative_b,
        on_motion_lines: candidates.on_motion_lines,
        mutual_pairs: candidates.pairs.len(),
        candidates: pairs.len(),
        line_inliers: pairs.iter().filter(|pair| pair.inlier).count(),
        frontier_points,
    }
}
