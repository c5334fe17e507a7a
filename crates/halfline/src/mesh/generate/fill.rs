//! Large arrays, computed element by element on all threads.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::progress::{Observer, Stage};

/// How many elements are computed between two looks at the observer: some ten milliseconds of the
/// dearest kind.
const CHUNK: usize = 8192;

/// How far the generation of one mesh has come, in triangles.
pub struct Progress<'a> {
    observer: &'a dyn Observer,
    done: AtomicU64,
    total: u64,
}

impl Progress<'_> {
    /// Nothing of `total` triangles yet.
    pub fn new(observer: &dyn Observer, total: usize) -> Progress<'_> {
        Progress { observer, done: AtomicU64::new(0), total: total as u64 }
    }

    /// `Err(Error::Interrupted)` once the work should end.
    pub fn check(&self) -> Result<()> {
        self.observer.check()
    }

    /// Reports that all is done.
    pub fn finish(&self) {
        self.observer.report(Stage::Load, self.total, self.total);
    }

    /// Reports that so many more are done.
    pub fn advance(&self, triangles: u64) {
        let done = self.done.fetch_add(triangles, Ordering::Relaxed) + triangles;
        self.observer.report(Stage::Load, done.min(self.total), self.total);
    }
}

/// The array of `value(0), ..., value(count - 1)`. To the progress of the whole mesh it counts as
/// much as `share` triangles.
pub fn fill<T: Copy + Default + Send + Sync>(
    count: usize,
    share: usize,
    progress: &Progress,
    value: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>> {
    let mut items: Vec<T> = reserved(count)?;
    items.resize(count, T::default());
    items.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, part)| {
        progress.check()?;
        let start = chunk * CHUNK;
        for (i, item) in part.iter_mut().enumerate() {
            *item = value(start + i);
        }
        let shares = |elements: usize| (elements as u128 * share as u128 / count as u128) as u64;
        progress.advance(shares(start + part.len()) - shares(start));
        Ok::<(), Error>(())
    })?;
    Ok(items)
}

/// An empty vector with room for `count` elements, or an error that says there is none.
pub fn reserved<T>(count: usize) -> Result<Vec<T>> {
    let mut items = Vec::new();
    items.try_reserve_exact(count).map_err(|_| {
        let gigabytes = (count as f64) * size_of::<T>() as f64 / 1e9;
        Error::invalid("number of triangles", format!("no memory for {gigabytes:.1} GB"))
    })?;
    Ok(items)
}

/// Single precision, rounded to nearest.
pub fn single(p: crate::geometry::Vec3) -> [f32; 3] {
    [p.x as f32, p.y as f32, p.z as f32]
}
