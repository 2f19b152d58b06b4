//! What was found on one time line, as a calibration.

use super::time_line::TimeLine;
use crate::calibration::{Calibration, CandidatePair, Counts, FrontierPoint, ShiftScore};
use crate::clock::Timing;
use crate::frontier::TangentMatch;
use crate::frontier::volume::disagreement;
use crate::geometry::Fundamental;
use crate::hypotheses::LineModel;
use crate::matching::{Candidate, Candidates};
use crate::options::Method;
use crate::refine::{loss_scale, with_insets};
use crate::search::{Found, Solution};
use crate::verify::thresholds::within;
use crate::verify::{SplitViews, Verdict, Verified};

impl TimeLine<'_> {
    /// A refusal before there is anything to verify.
    pub fn refused(&self, verdict: Verdict, candidates: &Candidates) -> Calibration {
        let candidate_pairs = with_inliers(candidates, std::iter::repeat(false));
        let counts = self.counts(candidates, &candidate_pairs, 0);
        Calibration { candidates: candidate_pairs, counts, ..self.without_geometry(verdict) }
    }

    fn without_geometry(&self, verdict: Verdict) -> Calibration {
        let timing = Timing::of(self.aligned.clock(), self.aligned.a(), self.aligned.b());
        Calibration::refused(verdict, timing, self.options.method, self.options.seed)
    }

    /// What was found, and what was verified of the winner.
    pub fn calibration(
        &self,
        seen: &SplitViews,
        candidates: &Candidates,
        found: &Found,
        winner: &Solution,
        verified: Verified,
    ) -> Calibration {
        let outlined = self.outlined(seen, &winner.fundamental, &verified);
        let empty = self.without_geometry(verified.verdict);
        let f = &winner.fundamental;
        let inliers = LineModel::new(candidates.best(), seen.all.sizes()).inliers(f);
        let candidate_pairs = with_inliers(candidates, inliers.into_iter());
        let of_a = |p: &TangentMatch| self.common[p.frame.index()].a;
        // Points stay on the silhouettes, by which pairs of one camera share them.
        let on_silhouettes = |p: &TangentMatch| {
            let frame = p.frame.index();
            FrontierPoint::new(of_a(p), seen.all.a.unmoved(frame, p.a), seen.all.b.unmoved(frame, p.b), f)
        };
        let frontier_points: Vec<FrontierPoint> = verified.matches.iter().map(on_silhouettes).collect();
        let floor = found.floor.as_ref().filter(|floor| floor.is_supported(candidates.best().len()));
        Calibration {
            fundamental: Some(*f),
            expected_error: Some(verified.expected_error).filter(|e| e.is_finite()),
            error_maps: verified.uncertainty.map(|u| u.maps()),
            counts: self.counts(candidates, &candidate_pairs, frontier_points.len()),
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

    fn counts(&self, candidates: &Candidates, pairs: &[CandidatePair], frontier_points: usize) -> Counts {
        Counts {
            frames: self.common.len(),
            informative_a: candidates.informative_a,
            informative_b: candidates.informative_b,
            on_motion_lines: candidates.on_motion_lines,
            mutual_pairs: candidates.pairs.len(),
            candidates: pairs.len(),
            line_inliers: pairs.iter().filter(|pair| pair.inlier).count(),
            frontier_points,
        }
    }
}

fn with_inliers(candidates: &Candidates, inliers: impl Iterator<Item = bool>) -> Vec<CandidatePair> {
    let pair = |(c, inlier): (&Candidate, bool)| CandidatePair {
        a: c.lines.a,
        b: c.lines.b,
        correlation: c.correlation,
        inlier,
    };
    candidates.best().iter().zip(inliers).map(pair).collect()
}
