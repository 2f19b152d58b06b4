//! All pairs of two sets of barcodes, compared by AND and popcount, of which the best few of each side are kept.
//!
//! [`popcount`] compares one row with 64 columns; [`rows`] meet [`columns`], and each keeps its [`best`].

pub(super) mod best;
pub(super) mod columns;
pub(super) mod popcount;
pub(super) mod rows;
