//! Corners to indexed vertices: equal points become one vertex.
//!
//! Chunks of triangles are welded on their own, in parallel and within the processor's caches,
//! which leaves about one point in six; what is left of the chunks is then welded in order. Since
//! order is kept everywhere, vertices are numbered by their first use, whatever the chunks and
//! the threads. The hash is seeded at random, so that no file can be made to collide in it.

use std::hash::{BuildHasher, Hash};

use foldhash::fast::RandomState;
use hashbrown::HashTable;
use hashbrown::hash_table::Entry;
use rayon::prelude::*;

use super::progress::ByteProgress;
use crate::error::{Error, Result};

/// Triangles welded on their own.
const CHUNK_TRIANGLES: usize = 1 << 15;

/// A point whose equality is that of its bits, but for the sign of zero, which is dropped.
pub trait Point: Copy + Send + Sync {
    /// What is compared.
    type Bits: Copy + Eq + Hash;
    /// The point with each -0 made 0.
    fn unsigned_zeros(self) -> Self;
    /// The bits of the coordinates.
    fn bits(self) -> Self::Bits;
}

macro_rules! point {
    ($float:ty, $bits:ty) => {
        impl Point for [$float; 3] {
            type Bits = [$bits; 3];

            #[inline]
            fn unsigned_zeros(self) -> [$float; 3] {
                // Equal to both zeros, and false for NaN, which stays as it is.
                self.map(|c| if c == 0.0 { 0.0 } else { c })
            }

            #[inline]
            fn bits(self) -> [$bits; 3] {
                self.map(<$float>::to_bits)
            }
        }
    };
}
point!(f32, u32);
point!(f64, u64);

/// Distinct points, numbered in the order of their arrival.
struct Vertices<P> {
    points: Vec<P>,
    table: HashTable<u32>,
}

impl<P: Point> Vertices<P> {
    fn with_capacity(capacity: usize) -> Vertices<P> {
        Vertices { points: Vec::with_capacity(capacity), table: HashTable::with_capacity(capacity) }
    }

    /// The number of `point`. The caller sees to it that there are fewer than 2^32.
    #[inline]
    fn number(&mut self, point: P, hasher: &RandomState) -> u32 {
        let Vertices { points, table } = self;
        let bits = point.bits();
        let found = table.entry(
            hasher.hash_one(bits),
            |&other| points[other as usize].bits() == bits,
            |&other| hasher.hash_one(points[other as usize].bits()),
        );
        match found {
            Entry::Occupied(entry) => *entry.get(),
            Entry::Vacant(entry) => {
                let number = points.len() as u32;
                entry.insert(number);
                points.push(point);
                number
            }
        }
    }
}

/// The vertices of a mesh and its triangles.
pub type Welded<P> = (Vec<P>, Vec<[u32; 3]>);

/// Welds `count` triangles whose corners `corners` gives. `bytes` are what a triangle takes up in
/// the file, for `progress`.
pub fn weld<P: Point>(
    count: usize,
    corners: impl Fn(usize) -> [P; 3] + Sync,
    bytes: usize,
    progress: &ByteProgress,
) -> Result<Welded<P>> {
    let hasher = RandomState::default();
    let chunks = (0..count.div_ceil(CHUNK_TRIANGLES))
        .into_par_iter()
        .map(|chunk| {
            let range = chunk * CHUNK_TRIANGLES..((chunk + 1) * CHUNK_TRIANGLES).min(count);
            let mut vertices = Vertices::with_capacity(range.len());
            let mut triangles = Vec::with_capacity(range.len());
            progress.add(range.len() * bytes)?;
            for triangle in range {
                triangles.push(
                    corners(triangle)
                        .map(|corner| vertices.number(corner.unsigned_zeros(), &hasher)),
                );
            }
            Ok((vertices.points, triangles))
        })
        .collect::<Result<Vec<_>>>()?;

    // Number the points of all chunks.
    let mut vertices = Vertices::with_capacity(count / 2);
    let mut numbers = Vec::with_capacity(chunks.len());
    for (points, _) in &chunks {
        progress.check()?;
        if vertices.points.len() + points.len() >= u32::MAX as usize {
            return Err(Error::invalid("mesh", "more than 2^32 - 2 vertices"));
        }
        numbers.push(
            points.iter().map(|&point| vertices.number(point, &hasher)).collect::<Vec<u32>>(),
        );
    }

    // Put those numbers into the triangles.
    let mut triangles = vec![[0; 3]; count];
    triangles.par_chunks_mut(CHUNK_TRIANGLES).zip(&chunks).zip(&numbers).for_each(
        |((triangles, (_, local)), numbers)| {
            for (triangle, local) in triangles.iter_mut().zip(local) {
                *triangle = local.map(|corner| numbers[corner as usize]);
            }
        },
    );
    Ok((vertices.points, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::{Silent, Stage};

    fn weld_all<P: Point>(corners: &[[P; 3]]) -> Welded<P> {
        let progress = ByteProgress::new(&Silent, Stage::Load, 0);
        weld(corners.len(), |i| corners[i], 0, &progress).unwrap()
    }

    #[test]
    fn both_zeros_are_one_and_every_nan_is_itself() {
        let nan = f32::NAN;
        let (vertices, triangles) = weld_all(&[
            [[0.0_f32, -0.0, 1.0], [-0.0, 0.0, 1.0], [nan, 0.0, 0.0]],
            [[nan, -0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        ]);
        assert_eq!(triangles, [[0, 0, 1], [1, 2, 0]]);
        assert_eq!(vertices[0].map(f32::to_bits), [0.0_f32, 0.0, 1.0].map(f32::to_bits));
        assert_eq!(vertices.len(), 3);
    }

    #[test]
    fn vertices_are_numbered_by_first_use_across_chunks() {
        // A strip of triangles in which each point is used three times, in several chunks.
        let count = 3 * CHUNK_TRIANGLES + 17;
        let point = |i: usize| [(i % 100_003) as f64, 0.5, 0.0];
        let corners: Vec<_> = (0..count).map(|i| [point(i), point(i + 1), point(i + 2)]).collect();
        let (vertices, triangles) = weld_all(&corners);
        let mut used = 0;
        for (triangle, corners) in triangles.iter().zip(&corners) {
            for (&index, corner) in triangle.iter().zip(corners) {
                assert!(index <= used);
                used = used.max(index + 1);
                assert_eq!(vertices[index as usize], *corner);
            }
        }
        assert_eq!(used as usize, vertices.len());
        assert_eq!(vertices.len(), count.min(100_001) + 2);
    }
}
