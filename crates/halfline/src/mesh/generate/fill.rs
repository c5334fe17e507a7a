//! Large arrays, computed element by element on all threads.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::progress::{Observer, Stage};

/// How many elements are computed between two looks at the observer: some ten milliseconds of the
/// dearest kind.
const CHUNK: usize = 8192;

/// The array of `value(0), ..., value(count - 1)`, reporting elements as [`Stage::Load`].
pub fn fill<T: Copy + Default + Send + Sync>(
    count: usize,
    observer: &dyn Observer,
    value: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>> {
    let mut items: Vec<T> = reserved(count)?;
    items.resize(count, T::default());
    let done = AtomicU64::new(0);
    items.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, part)| {
        observer.check()?;
        for (i, item) in part.iter_mut().enumerate() {
            *item = value(chunk * CHUNK + i);
        }
        let before = done.fetch_add(part.len() as u64, Ordering::Relaxed);
        observer.report(Stage::Load, before + part.len() as u64, count as u64);
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
