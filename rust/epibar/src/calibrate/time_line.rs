//! Two recordings on one time line: what is found on it, by some frames, and tested on others.

use crate::clock::Aligned;
use crate::error::Result;
use crate::frontier::{Views, busy_frames};
use crate::geometry::median::median;
use crate::hypotheses::Draws;
use crate::matching::{Candidates, find_candidates};
use crate::options::{CalibrateOptions, Method};
use crate::recording::FramePair;
use crate::search::by_lines::{self, Filmed};
use crate::search::{Effort, Found, SearchOptions, Searched, Solution, TrainingSet, insets, search, settle};
use crate::verify::split::{Fold, Split, Stay};
use crate::verify::{Case, SplitViews, are_masks};
use crate::watch::Watch;

/// Two recordings on one time line, and which of their frames are for what.
pub struct TimeLine<'a> {
    pub(super) aligned: &'a Aligned<'a>,
    pub(super) options: &'a CalibrateOptions,
    /// All common frames, and those in which both cameras see something.
    pub(super) common: Vec<FramePair>,
    pub(super) busy: Vec<FramePair>,
    /// For how many frames motion stays where it is.
    stay: Stay,
    /// Silhouettes were cut out, and stand in for nothing else.
    masks: bool,
}

/// What a search gives by either method.
pub enum SearchedBy<'s> {
    /// Geometries by tangents of the fitted frames, which are to be refined on all.
    Tangents {
        /// The frames that were looked at.
        training: Box<TrainingSet<'s>>,
        /// What was found on them.
        searched: Searched,
    },
    /// Geometries by lines of all frames, each fitted to its inliers: lines leave nothing to refine.
    Lines(Found),
}

impl SearchedBy<'_> {
    /// Geometries that the search with tangents found on the fitted frames alone, best first.
    pub fn solutions(&self) -> &[Solution] {
        match self {
            Self::Tangents { searched, .. } => &searched.solutions,
            Self::Lines(_) => &[],
        }
    }
}

impl<'a> TimeLine<'a> {
    pub fn new(aligned: &'a Aligned<'a>, options: &'a CalibrateOptions) -> Self {
        let (a, b, common) = (aligned.a(), aligned.b(), aligned.frame_pairs());
        let busy = busy_frames(a, b, &common, None);
        let stay = Stay::new(a, b, &common, &busy);
        Self { aligned, options, common, busy, stay, masks: are_masks([a, b]) }
    }

    /// Common frames a second: where A films faster than B not all of its frames are. NaN where unknown.
    fn frame_rate(&self) -> f64 {
        // The median, as frames may lack for a while.
        let step = median(self.common.windows(2).map(|p| (p[1].a.index() - p[0].a.index()) as f64));
        self.aligned.a().frame_rate() / step.map_or(f64::NAN, |step| step.max(1.0))
    }

    /// Which frames are for the search, and which for the test.
    pub fn split(&self, fold: Fold) -> Split {
        Split::new(&self.common, &self.busy, self.stay, fold)
    }

    /// Candidates of the answer: tangents are searched on the fitted frames alone, lines on all.
    pub fn candidates(&self, split: &Split) -> Result<Candidates> {
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

    /// Silhouettes of both at the frames of either kind.
    pub fn split_views(&self, split: Split) -> SplitViews {
        SplitViews::new(split, &self.common, &self.busy, |frames| self.views(frames))
    }

    /// What candidates lead to, by either method; `known` is where the method of frontier points ended by a clock nearly as good.
    pub fn searched<'s>(
        &self,
        seen: &'s SplitViews,
        candidates: &Candidates,
        known: &[Solution],
        watch: &mut dyn Watch,
    ) -> Result<SearchedBy<'s>> {
        match self.options.method {
            Method::Frontier => {
                let training = Box::new(self.training_set(seen));
                let searched = search(&training, candidates, known, watch)?;
                Ok(SearchedBy::Tangents { training, searched })
            }
            Method::Lines => self.by_lines(seen, candidates, watch).map(SearchedBy::Lines),
        }
    }

    /// What was searched on the fitted frames, refined on all, with silhouettes moved onto their outlines, which the fitted frames tell; and those silhouettes where
    /// they were moved, for they are what the answer is tested on.
    pub fn refined(
        &self,
        seen: &SplitViews,
        searched: SearchedBy,
        watch: &mut dyn Watch,
    ) -> Result<(Option<SplitViews>, Found)> {
        let (training, searched) = match searched {
            SearchedBy::Tangents { training, searched } => (training, searched),
            SearchedBy::Lines(found) => return Ok((None, found)),
        };
        // Shapes that stand for others are off by a share of their width, and not all alike.
        let insets = if self.masks { insets(&training, &searched) } else { None };
        let moved = insets.map(|insets| (insets, seen.moved_outward(insets)));
        let (training, all) = match &moved {
            Some((insets, moved)) => (training.moved_outward(&moved.fitted, *insets), &moved.all),
            None => (*training, &seen.all),
        };
        let found = settle(&training, all, searched, watch)?;
        Ok((moved.map(|(_, moved)| moved), found))
    }

    fn training_set<'s>(&self, seen: &'s SplitViews) -> TrainingSet<'s> {
        let defaults = Effort::default();
        let draws = Draws { lines: self.options.draws, ..defaults.draws };
        let effort = Effort { draws, ..defaults };
        let some = |limit| {
            let busy = busy_frames(self.aligned.a(), self.aligned.b(), &seen.split.fitted_busy, Some(limit));
            self.views(&busy)
        };
        let options = SearchOptions { seed: self.options.seed, effort, ..SearchOptions::default() };
        TrainingSet::new(&seen.fitted, some, options)
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

    /// What is to be verified.
    pub fn case<'s>(&'s self, seen: &'s SplitViews, found: &'s Found) -> Case<'s> {
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
}
