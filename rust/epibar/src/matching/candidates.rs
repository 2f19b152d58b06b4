//! Candidate pairs of corresponding epipolar lines (paper §2 and §4.2).
//!
//! Informative lines of both recordings → mutual top 3 by correlation → pairs on motion lines in both views
//! removed → the best 1,000. The pairs beyond the best are kept in reserve, because where people walk on a
//! floor the most alike pairs are those of the floor and the epipolar ones come later.

use super::densify::more_lines;
use super::motion_lines::{MotionLineOptions, motion_lines, overlaps};
use super::mutual::mutual_matches;
use crate::error::Result;
use crate::geometry::LinePair;
use crate::image::{Line, Segment};
use crate::random::seed_of_lines;
use crate::recording::{Barcodes, FramePair, Informative, RecordedFrame, Recording};

/// How candidates are chosen; the defaults are the paper's numbers.
#[derive(Debug, Clone)]
pub struct CandidateOptions {
    /// A pair must be in the mutual top `mutual` of each other (paper §2: 3).
    pub mutual: usize,
    /// How many of the best pairs are candidates (paper §2: 1,000).
    pub limit: usize,
    /// How many pairs are kept in all, candidates first.
    pub reserve: usize,
    /// The pairs in reserve are in the mutual top `mutual_reserve` of each other.
    pub mutual_reserve: usize,
    /// Where fewer lines than this are informative, more are drawn near those that are; 0 keeps to the recording's.
    pub densify: usize,
    /// Seed of the lines that are drawn.
    pub seed: u64,
    /// What makes a line informative.
    pub informative: Informative,
    /// How motion lines are found; `None` keeps every pair.
    pub motion_lines: Option<MotionLineOptions>,
}

impl Default for CandidateOptions {
    fn default() -> Self {
        Self {
            mutual: 3,
            limit: 1000,
            reserve: 4000,
            mutual_reserve: 10,
            densify: 0,
            seed: 0,
            informative: Informative::default(),
            motion_lines: Some(MotionLineOptions::default()),
        }
    }
}

/// A line of A and a line of B with similar motion barcodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The two lines.
    pub lines: LinePair,
    /// Line of A inside image A.
    pub segment_a: Segment,
    /// Line of B inside image B.
    pub segment_b: Segment,
    /// Normalised correlation of the two barcodes.
    pub correlation: f64,
}

/// Candidates of a pair of recordings and what was left after each filter.
#[derive(Debug, Clone, Default)]
pub struct Candidates {
    /// Pairs, best correlation first: the first [`Candidates::limit`] are the candidates of the paper.
    pub pairs: Vec<Candidate>,
    /// How many of `pairs` are candidates; the rest is reserve.
    pub limit: usize,
    /// Informative lines of A.
    pub informative_a: usize,
    /// Informative lines of B.
    pub informative_b: usize,
    /// Pairs removed because both lines overlap motion lines.
    pub on_motion_lines: usize,
}

impl Candidates {
    /// The best pairs, at most the limit of the paper.
    pub fn best(&self) -> &[Candidate] {
        &self.pairs[..self.limit.min(self.pairs.len())]
    }

    /// These candidates with B for A.
    #[must_use]
    pub fn swapped(&self) -> Self {
        let swapped = |candidate: &Candidate| Candidate {
            lines: LinePair { a: candidate.lines.b, b: candidate.lines.a },
            segment_a: candidate.segment_b,
            segment_b: candidate.segment_a,
            ..*candidate
        };
        Self {
            pairs: self.pairs.iter().map(swapped).collect(),
            informative_a: self.informative_b,
            informative_b: self.informative_a,
            ..*self
        }
    }
}

/// Informative lines of one camera over the common frames.
struct InformativeLines {
    segments: Vec<Segment>,
    barcodes: Barcodes,
}

/// The informative ones among the recording's lines, and as many more near them as `densify` asks for, with their
/// barcodes at the `compared` places of `frames`. Lines must be informative at those at which the camera sees anything: a long time in
/// which nobody is there says nothing of what a line sees.
fn informative_lines(
    recording: &Recording,
    frames: &[u32],
    compared: &[u32],
    options: &CandidateOptions,
    which: u64,
) -> InformativeLines {
    let selected = recording.barcodes.select_frames(frames);
    let busy: Vec<u32> = (0..frames.len() as u32)
        .filter(|&place| recording.shows(RecordedFrame(frames[place as usize])))
        .collect();
    let informative = |barcodes: &Barcodes| {
        // Where nothing is large enough to be a silhouette lines are all there is.
        if busy.is_empty() || busy.len() == frames.len() {
            return barcodes.informative(&options.informative);
        }
        barcodes.select_frames(&busy).informative(&options.informative)
    };
    let rows = informative(&selected);
    let mut segments: Vec<Segment> = rows.iter().map(|&i| recording.segments[i as usize]).collect();
    let mut barcodes = selected.select_rows(&rows);
    let missing = options.densify.saturating_sub(rows.len());
    if missing > 0 {
        let (more, bits) =
            more_lines(recording, &rows, frames, missing, seed_of_lines(recording.seed, which, options.seed));
        let kept = informative(&bits);
        segments.extend(kept.iter().map(|&i| more[i as usize]));
        barcodes.count += kept.len();
        barcodes.bits.extend(bits.select_rows(&kept).bits);
    }
    InformativeLines { segments, barcodes: barcodes.select_frames(compared) }
}

/// Finds candidates between two recordings whose frames correspond by `common`.
///
/// Lines are informative over those of `common` in which their camera sees something, and compared at some of `common`, `compared`, in the
/// same order: frames that are not compared have a say in what each camera is taken to see, but none in what the two see together.
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) where `mutual` and `mutual_reserve` are 0.
pub fn find_candidates(
    a: &Recording,
    b: &Recording,
    common: &[FramePair],
    compared: &[FramePair],
    options: &CandidateOptions,
) -> Result<Candidates> {
    let compared: Vec<u32> = compared.iter().map(|c| common.partition_point(|p| p < c) as u32).collect();
    let [frames_a, frames_b] = FramePair::indices(common);
    let lines_a = informative_lines(a, &frames_a, &compared, options, 1);
    let lines_b = informative_lines(b, &frames_b, &compared, options, 2);
    let deep = options.mutual.max(options.mutual_reserve);
    let mut matches = mutual_matches(&lines_a.barcodes, &lines_b.barcodes, deep)?;
    // The paper's candidates first, each part best correlation first (the sort is stable).
    matches.sort_by_key(|m| m.rank as usize >= options.mutual);
    let paths =
        options.motion_lines.as_ref().map(|options| (motion_lines(a, options), motion_lines(b, options)));

    let mut found = Candidates {
        limit: 0,
        informative_a: lines_a.segments.len(),
        informative_b: lines_b.segments.len(),
        ..Candidates::default()
    };
    for pair in matches {
        if found.pairs.len() >= options.reserve.max(options.limit) {
            break;
        }
        let (segment_a, segment_b) = (lines_a.segments[pair.a as usize], lines_b.segments[pair.b as usize]);
        let (Some(line_a), Some(line_b)) = (segment_a.line(), segment_b.line()) else {
            continue;
        };
        if let Some((paths_a, paths_b)) = &paths {
            let on = |line: &Line, paths: &[Line], size| paths.iter().any(|p| overlaps(line, p, size));
            if on(&line_a, paths_a, a.size) && on(&line_b, paths_b, b.size) {
                found.on_motion_lines += 1;
                continue;
            }
        }
        if (pair.rank as usize) < options.mutual {
            found.limit = options.limit.min(found.pairs.len() + 1);
        }
        found.pairs.push(Candidate {
            lines: LinePair { a: line_a, b: line_b },
            segment_a,
            segment_b,
            correlation: f64::from(pair.correlation),
        });
    }
    Ok(found)
}
