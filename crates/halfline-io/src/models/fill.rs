//! Large arrays, computed element by element on all threads.

use rayon::prelude::*;

use halfline::error::{Error, Result};
use halfline::geometry::Vec3;
use halfline::mesh::{Mesh, Positions};
use halfline::progress::SharedProgress;

/// How many elements are computed between two looks at the observer: some ten milliseconds of the
/// dearest kind.
const CHUNK: usize = 8192;

/// The array of `value(0), ..., value(count - 1)`. To the progress of the whole mesh it counts as
/// much as `share` triangles.
pub fn fill<T: Copy + Default + Send + Sync>(
    count: usize,
    share: usize,
    progress: &SharedProgress,
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
        let shares = |elements: usize| (elements as u128 * share as u128 / count as u128) as usize;
        progress.advance(shares(start + part.len()) - shares(start))
    })?;
    Ok(items)
}

/// The mesh of `count` triangles that share no vertex; `triangle` gives the corners of each.
pub fn separate_triangles(
    count: usize,
    progress: &SharedProgress,
    triangle: impl Fn(usize) -> [Vec3; 3] + Sync,
) -> Result<Mesh> {
    let positions = fill(3 * count, 3 * count / 4, progress, |i| single(triangle(i / 3)[i % 3]))?;
    let indices = fill(count, count / 4, progress, |i| {
        let first = 3 * i as u32;
        [first, first + 1, first + 2]
    })?;
    Mesh::new(Positions::F32(positions.into()), indices)
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
pub fn single(p: Vec3) -> [f32; 3] {
    [p.x as f32, p.y as f32, p.z as f32]
}
