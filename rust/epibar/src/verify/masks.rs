//! Were silhouettes cut out, or do they stand in for something else?

use super::thresholds::{STAND_INS, within};
use crate::recording::Recording;
use crate::recording::stand_ins::stand_ins;

/// Whether silhouettes of both are those of masks that were cut out, and not boxes or ellipses that a detector gave. Of silhouettes too small to tell it is not known.
pub fn are_masks(recordings: [&Recording; 2]) -> bool {
    recordings.into_iter().all(|recording| within(stand_ins(&recording.silhouettes), STAND_INS))
}
