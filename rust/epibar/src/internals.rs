//! What the binding, the tests and the measurements of this repository reach into the crate for.
//!
//! No part of the public interface: it is there with the feature `internals` alone, and anything in here may change with every version.

pub use crate::calibrate::outstanding_offset;
pub use crate::clock::offset::FoundOffset;
pub use crate::clock::{Clock, Clocks, common_frames, find_offset};
#[cfg(feature = "files")]
pub use crate::files::saved;
pub use crate::foreground::{
    BANDS, Cleaning, LightChange, Mixture, MixtureOptions, Painting, SHRUNK, clean, compare_light,
    paint_over, shrunk_green, steady_background,
};
pub use crate::frontier::score::shifted_score;
pub use crate::frontier::volume::moving_correspondences;
pub use crate::frontier::{
    Class, CommonFrame, FrontierScore, Scorer, TangentMatch, Views, busy_frames, compare, frontier_score,
};
pub use crate::geometry::lens::Lens;
pub use crate::geometry::seven_parameters::Step;
pub use crate::geometry::{LinePair, PencilHomography, SevenParameters, area_between, epipolar_tangents};
pub use crate::hypotheses::floor::find_floors;
pub use crate::hypotheses::single_view::SingleView;
pub use crate::hypotheses::top_view::{TopView, different};
pub use crate::hypotheses::track_model::TrackModel;
pub use crate::hypotheses::tracks::tracks;
pub use crate::hypotheses::{Estimator, LineModel, ransac};
pub use crate::matching::{
    Candidate, CandidateOptions, Candidates, Match, MotionLineOptions, correlation, find_candidates,
    motion_lines, mutual_matches,
};
pub use crate::network::clocks::{GRID, MOST_DRIFT};
pub use crate::network::input::TANGENTIAL;
pub use crate::network::optics::Optics;
pub use crate::network::pair::{OFFERED_SHARE, RIVALS};
pub use crate::network::pair_choice::ALL_PAIRS;
pub use crate::network::stated_errors::{NINE_IN_TEN, NINE_IN_TEN_IN_SPACE};
pub use crate::network::support::{BASELINE, PAIR_DEVIATES};
pub use crate::options::{MAX_EXPECTED_ERROR, SEARCH_SECONDS};
pub use crate::random::generator;
pub use crate::recording::FramePair;
pub use crate::recording::barcode::barcodes_of_segments;
pub use crate::recording::barcode_words::{BLOCK_FRAMES, PixelBlock};
pub use crate::recording::components::Components;
pub use crate::recording::convex_hull::convex_hull;
pub use crate::recording::recorder::MAX_LINES;
pub use crate::recording::sampling::border_segments;
pub use crate::recording::traversal;
pub use crate::refine::{insets, refine};
pub use crate::search::resampled;
pub use crate::verify::error_map::{COLUMNS as MAP_COLUMNS, ROWS as MAP_ROWS};
pub use crate::verify::planarity::plane_residual;
pub use crate::verify::rivals::Winner;
pub use crate::verify::shift_curve::{HeldOut, normal_deviate, shift_curve};
pub use crate::verify::thresholds::SOME_Z;
pub use crate::verify::turning::may_turn;
