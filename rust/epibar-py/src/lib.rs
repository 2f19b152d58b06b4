//! `epibar._core`: validate, slice, release the GIL, call, convert. No algorithm lives here.
