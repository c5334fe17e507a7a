//! Corners to indexed vertices: equal points become one vertex.
//!
//! A hash table of all points misses the processor's caches with each look. So corners are first
//! sorted by a part of their hash into partitions, whose tables fit the caches, and which are
//! welded in parallel (the partitioned hash join of Shatdal, Kant and Naughton, 1994). Then
//! vertices are numbered by their first use, so that the result depends neither on the hash nor on
//! the threads. The hash is seeded at random, so that no file can be made to collide in it.

use std::ops::Range;

use foldhash::fast::RandomState;
use hashbrown::HashTable;
use hashbrown::hash_table::Entry;
use rayon::prelude::*;

use halfline::error::{Error, Result};
use halfline::progress::SharedProgress;
use halfline::storage::zeroed;

/// Triangles sorted as one parallel piece of work.
const CHUNK_TRIANGLES: usize = 1 << 15;
const CHUNK_CORNERS: usize = 3 * CHUNK_TRIANGLES;

/// Corners that a partition has on average, so that its table and points fit 1 MiB of cache.
const PARTITION_CORNERS: usize = 1 << 15;

/// With more partitions, each would be a cache line or less of each chunk.
const MOST_PARTITIONS: usize = 1 << 10;

/// A point whose equality is that of its bits, but for the sign of zero, which is dropped.
pub trait Point: Copy + Send + Sync {
    /// The origin.
    const ZERO: Self;
    /// The point with each -0 made 0.
    fn unsigned_zeros(self) -> Self;
    /// True if all bits are equal.
    fn same(self, other: Self) -> bool;
    /// A hash of the bits.
    fn hash(self, state: &RandomState) -> u64;
}

macro_rules! point {
    ($float:ty, |$bits:ident| $words:expr) => {
        impl Point for [$float; 3] {
            const ZERO: [$float; 3] = [0.0; 3];

            #[inline]
            fn unsigned_zeros(self) -> [$float; 3] {
                // Equal to both zeros, and false for NaN, which stays as it is.
                let unsigned = |c: $float| if c == 0.0 { 0.0 } else { c };
                [unsigned(self[0]), unsigned(self[1]), unsigned(self[2])]
            }

            #[inline]
            fn same(self, other: [$float; 3]) -> bool {
                let same = |i: usize| self[i].to_bits() == other[i].to_bits();
                same(0) & same(1) & same(2)
            }

            #[inline]
            fn hash(self, state: &RandomState) -> u64 {
                use std::hash::BuildHasher;
                let $bits = [self[0].to_bits(), self[1].to_bits(), self[2].to_bits()];
                state.hash_one($words)
            }
        }
    };
}
point!(f32, |b| (u64::from(b[0]) | u64::from(b[1]) << 32, b[2]));
point!(f64, |b| (b[0], b[1], b[2]));

/// The corners of a chunk of triangles, sorted by partition.
struct Chunk<P> {
    /// Where each partition begins, and the end.
    starts: Vec<u32>,
    points: Vec<P>,
    /// Where each point was among the chunk's corners; rising within a partition.
    slots: Vec<u32>,
}

impl<P> Chunk<P> {
    fn partition(&self, partition: usize) -> Range<usize> {
        self.starts[partition] as usize..self.starts[partition + 1] as usize
    }
}

/// The distinct points of a partition.
struct Partition<P> {
    points: Vec<P>,
    /// The corner that used each point first, counted through all chunks; rising.
    first_uses: Vec<usize>,
    /// For each corner, chunk by chunk, the index of its point.
    indices: Vec<u32>,
    /// Where each chunk begins in `indices`.
    offsets: Vec<usize>,
}

impl<P> Partition<P> {
    /// The points that a corner of the chunk used first.
    fn first_used_in(&self, chunk: usize) -> Range<usize> {
        let before = |corner: usize| self.first_uses.partition_point(|&first| first < corner);
        before(chunk * CHUNK_CORNERS)..before((chunk + 1) * CHUNK_CORNERS)
    }
}

/// Which corners of a chunk are first uses, and how many before each 64 of them.
struct FirstUses {
    bits: Vec<u64>,
    before: Vec<u32>,
    count: usize,
}

impl FirstUses {
    fn rank(&self, corner: usize) -> u32 {
        let (word, bit) = (corner / 64, corner % 64);
        self.before[word] + (self.bits[word] & ((1 << bit) - 1)).count_ones()
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
    progress: &SharedProgress,
) -> Result<Welded<P>> {
    let state = RandomState::default();
    let partitions = (3 * count / PARTITION_CORNERS).next_power_of_two().clamp(1, MOST_PARTITIONS);

    // Sort the corners by partition, chunk by chunk.
    let chunks: Vec<Chunk<P>> = (0..count.div_ceil(CHUNK_TRIANGLES))
        .into_par_iter()
        .map(|chunk| {
            let range = chunk * CHUNK_TRIANGLES..((chunk + 1) * CHUNK_TRIANGLES).min(count);
            progress.advance(range.len() * bytes)?;
            Ok(sort_chunk(range, &corners, partitions, &state))
        })
        .collect::<Result<_>>()?;

    // Find the distinct points of each partition.
    let partitions: Vec<Partition<P>> = (0..partitions)
        .into_par_iter()
        .map(|partition| {
            progress.check()?;
            Ok(weld_partition(&chunks, partition, &state))
        })
        .collect::<Result<_>>()?;

    // Number the vertices by their first use.
    let first_uses: Vec<FirstUses> = (0..chunks.len())
        .into_par_iter()
        .map(|chunk| find_first_uses(&partitions, chunk))
        .collect();
    let mut vertex_count = 0;
    let mut bases = Vec::with_capacity(chunks.len());
    for uses in &first_uses {
        bases.push(vertex_count as u32);
        vertex_count += uses.count;
        if vertex_count >= u32::MAX as usize {
            return Err(Error::invalid("mesh", "more than 2^32 - 2 vertices"));
        }
    }
    let number = |corner: usize| {
        let chunk = corner / CHUNK_CORNERS;
        bases[chunk] + first_uses[chunk].rank(corner % CHUNK_CORNERS)
    };
    let numbers: Vec<Vec<u32>> = partitions
        .par_iter()
        .map(|partition| partition.first_uses.iter().map(|&first| number(first)).collect())
        .collect();
    progress.check()?;

    // Put the vertices in their order, by the chunks that use them first.
    let mut vertices = zeroed(P::ZERO, vertex_count);
    let mut rest = &mut vertices[..];
    let mut pieces = Vec::with_capacity(chunks.len());
    for uses in &first_uses {
        let (piece, after) = rest.split_at_mut(uses.count);
        pieces.push(piece);
        rest = after;
    }
    pieces.into_par_iter().enumerate().for_each(|(chunk, piece)| {
        for (partition, numbers) in partitions.iter().zip(&numbers) {
            for vertex in partition.first_used_in(chunk) {
                piece[(numbers[vertex] - bases[chunk]) as usize] = partition.points[vertex];
            }
        }
    });

    // Put the numbers in the triangles.
    let mut triangles = zeroed([0; 3], count);
    triangles.par_chunks_mut(CHUNK_TRIANGLES).enumerate().try_for_each(|(c, triangles)| {
        progress.check()?;
        let chunk = &chunks[c];
        for (p, (partition, numbers)) in partitions.iter().zip(&numbers).enumerate() {
            let slots = &chunk.slots[chunk.partition(p)];
            let indices = &partition.indices[partition.offsets[c]..][..slots.len()];
            for (&slot, &index) in slots.iter().zip(indices) {
                triangles[slot as usize / 3][slot as usize % 3] = numbers[index as usize];
            }
        }
        Ok(())
    })?;
    Ok((vertices, triangles))
}

/// Sorts the corners of the triangles of `range` by partition, by counting.
fn sort_chunk<P: Point>(
    range: Range<usize>,
    corners: impl Fn(usize) -> [P; 3],
    partitions: usize,
    state: &RandomState,
) -> Chunk<P> {
    let count = 3 * range.len();
    let (mut unsorted, mut keys) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut ends = vec![0_u32; partitions + 1];
    for triangle in range {
        for corner in corners(triangle) {
            let point = corner.unsigned_zeros();
            // Tables find their places by the lowest and the highest bits.
            let key = (point.hash(state) >> 32) as usize & (partitions - 1);
            ends[key + 1] += 1;
            unsorted.push(point);
            keys.push(key as u16);
        }
    }
    for i in 0..partitions {
        ends[i + 1] += ends[i];
    }
    let starts = ends.clone();
    let (mut points, mut slots) = (vec![P::ZERO; count], vec![0; count]);
    for (slot, (&key, &point)) in keys.iter().zip(&unsorted).enumerate() {
        let place = &mut ends[usize::from(key)];
        points[*place as usize] = point;
        slots[*place as usize] = slot as u32;
        *place += 1;
    }
    Chunk { starts, points, slots }
}

fn weld_partition<P: Point>(
    chunks: &[Chunk<P>],
    partition: usize,
    state: &RandomState,
) -> Partition<P> {
    let count = chunks.iter().map(|chunk| chunk.partition(partition).len()).sum::<usize>();
    let mut welded: Partition<P> = Partition {
        // In a closed mesh six triangles meet at a vertex on average.
        points: Vec::with_capacity(count / 5),
        first_uses: Vec::with_capacity(count / 5),
        indices: Vec::with_capacity(count),
        offsets: Vec::with_capacity(chunks.len()),
    };
    let mut table: HashTable<u32> = HashTable::with_capacity(count / 5);
    for (c, chunk) in chunks.iter().enumerate() {
        welded.offsets.push(welded.indices.len());
        for i in chunk.partition(partition) {
            let (point, points) = (chunk.points[i], &mut welded.points);
            let found = table.entry(
                point.hash(state),
                |&other| points[other as usize].same(point),
                |&other| points[other as usize].hash(state),
            );
            welded.indices.push(match found {
                Entry::Occupied(entry) => *entry.get(),
                Entry::Vacant(entry) => {
                    // Numbers past 32 bits belong to a mesh that is refused before they are used.
                    let index = points.len() as u32;
                    entry.insert(index);
                    points.push(point);
                    welded.first_uses.push(c * CHUNK_CORNERS + chunk.slots[i] as usize);
                    index
                }
            });
        }
    }
    welded
}

fn find_first_uses<P>(partitions: &[Partition<P>], chunk: usize) -> FirstUses {
    let mut bits = vec![0_u64; CHUNK_CORNERS / 64];
    for partition in partitions {
        for &first in &partition.first_uses[partition.first_used_in(chunk)] {
            let corner = first - chunk * CHUNK_CORNERS;
            bits[corner / 64] |= 1 << (corner % 64);
        }
    }
    let mut count = 0;
    let before = bits
        .iter()
        .map(|word| {
            let before = count;
            count += word.count_ones();
            before
        })
        .collect();
    FirstUses { bits, before, count: count as usize }
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::progress::{NoProgress, Stage};

    fn weld_all<P: Point>(corners: &[[P; 3]]) -> Welded<P> {
        let progress = SharedProgress::new(&NoProgress, Stage::Load, 0);
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
