//! `epibar._core`: validate, slice, release the GIL, call, convert. No algorithm lives here.

#![allow(clippy::needless_pass_by_value, reason = "PyO3 hands arrays and objects over by value")]

mod added;
mod calibration;
mod clocks;
mod convert;
mod examine;
mod foreground;
mod lines;
mod network;
mod recording;
mod scores;
mod tracks;
mod watch;

use epibar::internals;
use pyo3::prelude::*;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<recording::Recorder>()?;
    module.add_class::<recording::Recording>()?;
    module.add_function(wrap_pyfunction!(added::add_cameras, module)?)?;
    module.add_function(wrap_pyfunction!(added::pairs_to_add, module)?)?;
    module.add_class::<calibration::Calibration>()?;
    module.add_function(wrap_pyfunction!(calibration::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(clocks::clock_rate, module)?)?;
    module.add_function(wrap_pyfunction!(clocks::common_frames, module)?)?;
    module.add_function(wrap_pyfunction!(clocks::frame_interval, module)?)?;
    module.add_function(wrap_pyfunction!(clocks::positions, module)?)?;
    module.add_function(wrap_pyfunction!(examine::examine, module)?)?;
    module.add_class::<foreground::Mixture>()?;
    module.add_function(wrap_pyfunction!(foreground::clean_mask, module)?)?;
    module.add_function(wrap_pyfunction!(foreground::steady_background, module)?)?;
    module.add_function(wrap_pyfunction!(foreground::paint_over, module)?)?;
    module.add_function(wrap_pyfunction!(foreground::shrunk_green, module)?)?;
    module.add_function(wrap_pyfunction!(foreground::compare_light, module)?)?;
    module.add_function(wrap_pyfunction!(lines::barcodes, module)?)?;
    module.add_function(wrap_pyfunction!(lines::match_barcodes, module)?)?;
    module.add_function(wrap_pyfunction!(lines::motion_lines, module)?)?;
    module.add_function(wrap_pyfunction!(network::check_network, module)?)?;
    module.add_function(wrap_pyfunction!(network::clock_offsets, module)?)?;
    module.add_function(wrap_pyfunction!(network::join_network, module)?)?;
    module.add_function(wrap_pyfunction!(network::lens_directions, module)?)?;
    module.add_function(wrap_pyfunction!(network::lens_reach, module)?)?;
    module.add_function(wrap_pyfunction!(network::pairs_to_search, module)?)?;
    module.add_function(wrap_pyfunction!(scores::score_lines, module)?)?;
    module.add_function(wrap_pyfunction!(scores::score_tangents, module)?)?;
    module.add_function(wrap_pyfunction!(tracks::walker_tracks, module)?)?;
    module.add("GRID", internals::GRID)?;
    module.add("MAP_SHAPE", (internals::MAP_ROWS, internals::MAP_COLUMNS))?;
    module.add("ALL_PAIRS", internals::ALL_PAIRS)?;
    module.add("BASELINE", internals::BASELINE)?;
    module.add("MAX_EXPECTED_ERROR", internals::MAX_EXPECTED_ERROR)?;
    module.add("MAX_LINES", internals::MAX_LINES)?;
    module.add("MOST_DRIFT", internals::MOST_DRIFT)?;
    module.add("NINE_IN_TEN", internals::NINE_IN_TEN)?;
    module.add("NINE_IN_TEN_IN_SPACE", internals::NINE_IN_TEN_IN_SPACE)?;
    module.add("PAIR_DEVIATES", internals::PAIR_DEVIATES)?;
    module.add("RIVALS", internals::RIVALS)?;
    module.add("RIVAL_SHARE", internals::OFFERED_SHARE)?;
    module.add("SEARCH_SECONDS", internals::SEARCH_SECONDS)?;
    module.add("SOME_Z", internals::SOME_Z)?;
    module.add("TANGENTIAL", internals::TANGENTIAL)?;
    Ok(())
}
