//! The one error type of the crate.
//!
//! Every message names the thing, the value and what to do about it, because it is what a user of
//! the command line reads.

/// What can go wrong, from a mask of the wrong size to a run that was interrupted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An image has no pixels or is too large to index.
    #[error("image size {width}x{height} is not usable: both sides must be between 2 and 16384 pixels")]
    ImageSize {
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
    },
    /// A mask does not have the size that its recorder was made for.
    #[error(
        "mask of frame {frame} has {actual} pixels, but the recording is {width}x{height}: every frame must have the same size"
    )]
    MaskSize {
        /// Frame index, from 0.
        frame: usize,
        /// Number of pixels given.
        actual: usize,
        /// Expected width in pixels.
        width: usize,
        /// Expected height in pixels.
        height: usize,
    },
    /// A frame time is not finite or does not increase.
    #[error(
        "time {time} s of frame {frame} is not after that of the frame before it: times must be finite and increase"
    )]
    FrameTime {
        /// Frame index, from 0.
        frame: usize,
        /// The offending time, seconds.
        time: f64,
    },
    /// A recording was finished without any frame.
    #[error("the recording has no frames")]
    NoFrames,
    /// An argument lies outside its range.
    #[error("{name} = {value}: {expected}")]
    Argument {
        /// Name of the argument.
        name: &'static str,
        /// Its value, printed.
        value: String,
        /// What it should be.
        expected: &'static str,
    },
    /// Two arrays that belong together have different lengths.
    #[error("{what}: {left} against {right}")]
    Length {
        /// Which two things were compared.
        what: &'static str,
        /// Length of the first.
        left: usize,
        /// Length of the second.
        right: usize,
    },
    /// Parts of a stored recording contradict each other.
    #[error("the stored recording is damaged: {0}")]
    Damaged(String),
    /// A file cannot be read or written.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: std::path::PathBuf,
        /// Why.
        reason: String,
    },
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;
