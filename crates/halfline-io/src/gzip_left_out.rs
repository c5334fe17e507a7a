//! What stands in `gzip.rs`'s place in a build without the feature `gzip`: refusals.

use std::path::Path;

use halfline::error::Result;
use halfline::progress::Observer;

use crate::left_out;

/// Nothing is inflated.
pub fn inflated_limit(_compressed: usize) -> usize {
    0
}

/// An error that says what is missing.
pub fn inflate_start(path: &Path, _compressed: &[u8], _count: usize) -> Result<Vec<u8>> {
    Err(left_out(path, "gzip"))
}

/// An error that says what is missing.
pub fn inflate(
    path: &Path,
    _compressed: &[u8],
    _observer: &dyn Observer,
    _enough: &dyn Fn(&[u8]) -> bool,
) -> Result<Vec<u8>> {
    Err(left_out(path, "gzip"))
}
