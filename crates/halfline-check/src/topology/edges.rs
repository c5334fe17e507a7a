//! The edges: how many faces each has, and which way they run along it.
//!
//! All half-edges are put into one array in compressed sparse rows, those with the same lower
//! place beside each other (a counting sort); each row is then sorted by the other place. A
//! half-edge is one number of 64 bits: the higher place, the half-edge's own number, and whether
//! it runs upward.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use rayon::prelude::*;

use super::CHUNK;
use super::faces::FaceKind;
use super::{Corner, Found, for_each_surface_face};
use halfline::error::Result;
use halfline::mesh::Mesh;
use halfline::progress::SharedProgress;

/// What the edges are like.
#[derive(Default)]
pub struct Edges {
    /// For each edge the lowest of its half-edges.
    pub corners: Vec<Corner>,
    pub open: Found,
    pub non_manifold: Found,
    pub inconsistent: Found,
    pub odd: usize,
    pub unbalanced: usize,
}

/// Follows the edges of all faces that take part.
pub fn examine(
    mesh: &Mesh,
    place_of_vertex: &[u32],
    kinds: &[FaceKind],
    progress: &SharedProgress,
) -> Result<Edges> {
    let places = place_of_vertex.len();
    let for_each_half_edge = |use_half_edge: &(dyn Fn(u32, u64) + Sync)| {
        mesh.triangles().par_chunks(CHUNK).enumerate().try_for_each(|(chunk, triangles)| {
            let first = chunk * CHUNK;
            for_each_surface_face(first, triangles, kinds, place_of_vertex, |face, places| {
                for slot in 0..3 {
                    let (from, to) = (places[slot], places[(slot + 1) % 3]);
                    let (low, high) = (from.min(to), from.max(to));
                    let corner = u64::from(face) * 3 + slot as u64;
                    let upward = u64::from(from < to);
                    use_half_edge(low, u64::from(high) << 32 | corner << 1 | upward);
                }
            });
            progress.advance(triangles.len())
        })
    };

    // Count the half-edges of each lower place, and let its row begin after those before it.
    let rows: Vec<AtomicU32> = (0..places).into_par_iter().map(|_| AtomicU32::new(0)).collect();
    for_each_half_edge(&|low, _| {
        rows[low as usize].fetch_add(1, Ordering::Relaxed);
    })?;
    let mut half_edges = 0;
    for row in &rows {
        half_edges += row.swap(half_edges, Ordering::Relaxed);
    }

    // Put each half-edge into its row, in whatever order the threads come; afterwards a row's
    // number is its end.
    let mut entries: Vec<AtomicU64> =
        (0..half_edges).into_par_iter().map(|_| AtomicU64::new(0)).collect();
    for_each_half_edge(&|low, entry| {
        let slot = rows[low as usize].fetch_add(1, Ordering::Relaxed);
        entries[slot as usize].store(entry, Ordering::Relaxed);
    })?;

    // Sort each row, many rows at a time, and look at the edges that come to lie together.
    let mut pieces = Vec::with_capacity(places.div_ceil(CHUNK));
    let (mut rest, mut begin) = (&mut entries[..], 0);
    for rows in rows.chunks(CHUNK) {
        let end = rows[rows.len() - 1].load(Ordering::Relaxed);
        let (piece, after) = rest.split_at_mut((end - begin) as usize);
        pieces.push((begin, rows, piece));
        (rest, begin) = (after, end);
    }
    let parts: Vec<Edges> = pieces
        .into_par_iter()
        .map(|(begin, rows, piece)| {
            let mut edges = Edges::default();
            let mut row_begin = 0;
            for row in rows {
                let row_end = (row.load(Ordering::Relaxed) - begin) as usize;
                let entries = &mut piece[row_begin..row_end];
                entries.sort_unstable_by_key(|entry| entry.load(Ordering::Relaxed));
                edges.add_row(entries);
                row_begin = row_end;
            }
            progress.advance(rows.len())?;
            Ok(edges)
        })
        .collect::<Result<_>>()?;
    drop(entries);

    let mut edges = Edges::default();
    edges.corners.reserve_exact(parts.iter().map(|part| part.corners.len()).sum());
    for part in parts {
        edges.corners.extend_from_slice(&part.corners);
        edges.open = edges.open.and(part.open);
        edges.non_manifold = edges.non_manifold.and(part.non_manifold);
        edges.inconsistent = edges.inconsistent.and(part.inconsistent);
        edges.odd += part.odd;
        edges.unbalanced += part.unbalanced;
    }
    Ok(edges)
}

impl Edges {
    /// Looks at the edges from one place to higher ones.
    fn add_row(&mut self, row: &[AtomicU64]) {
        let high = |entry: &AtomicU64| entry.load(Ordering::Relaxed) >> 32;
        for edge in row.chunk_by(|a, b| high(a) == high(b)) {
            let corner = edge[0].load(Ordering::Relaxed) as u32 >> 1;
            let upward = edge.iter().filter(|e| e.load(Ordering::Relaxed) & 1 == 1).count();
            let balanced = 2 * upward == edge.len();
            self.corners.push(corner);
            match edge.len() {
                1 => self.open.add(corner / 3),
                2 if !balanced => self.inconsistent.add(corner / 3),
                2 => (),
                _ => self.non_manifold.add(corner / 3),
            }
            self.odd += edge.len() % 2;
            self.unbalanced += usize::from(!balanced);
        }
    }
}
