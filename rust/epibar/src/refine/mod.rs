//! Refinement of `F` on tangents that meet.
//!
//! [`sampson`] is the cost of tangents that meet and [`essential`] the prior of known camera matrices; [`least_squares`]
//! minimises over the seven parameters, [`mod@polish`] does so while the radius shrinks, and [`valley`] walks on along what the
//! tangents leave open. [`mod@insets`] solves for what outlines are off by as well.

pub mod essential;
pub mod insets;
pub mod least_squares;
pub mod polish;
pub mod sampson;
pub mod valley;

pub use insets::{insets, with_insets};
pub use polish::{loss_scale, polish, refine, touch_up};
pub use sampson::residual_rows;
