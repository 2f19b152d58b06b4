//! What coverage-guided fuzzing runs, and the tests replay: one function for each entry, which takes any bytes.
//!
//! A function panics where the crate does, or where what came back is not what was promised. The targets of `cargo fuzz`
//! in `fuzz/` call these functions; `fuzz_corpus.rs` gives them the files of `corpus/`.

mod entries;
pub mod files;
mod scenes;

/// What takes any bytes.
type Target = fn(&[u8]);

/// Every function, by the name of its target and of its folder of inputs.
pub const ALL: [(&str, Target); 9] = [
    ("archive", files::archive),
    ("recording", files::recording),
    ("calibration", files::calibration),
    ("recorder", entries::recorder),
    ("matching", entries::matching),
    ("calibrate", entries::calibrate),
    ("network", entries::network),
    ("network_add", entries::network_add),
    ("network_check", entries::network_check),
];

/// The function of a target.
pub fn target(name: &str) -> Target {
    ALL.iter().find(|(known, _)| *known == name).expect("a target that is listed").1
}
