//! The pieces of a surface, by disjoint sets of places.
//!
//! S. Jayanti and R. Tarjan, "A Randomized Concurrent Algorithm for Disjoint Set Union" (PODC 2016),
//! with path halving. Sets are linked by index instead of a random order: vertices of a file are
//! shuffled enough, and the number of sets is the same for every order.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::CHUNK;
use super::faces::FaceKind;
use super::{Corner, NO_CORNER, for_each_surface_face};
use halfline::error::Result;
use halfline::mesh::Mesh;
use halfline::progress::SharedProgress;

/// The pieces.
pub struct Pieces {
    pub count: usize,
    /// For each place on the surface the lowest corner that lies there.
    pub place_corners: Vec<Corner>,
}

/// Counts the pieces of the surface.
pub fn find(
    mesh: &Mesh,
    place_of_vertex: &[u32],
    kinds: &[FaceKind],
    progress: &SharedProgress,
) -> Result<Pieces> {
    let places = place_of_vertex.len() as u32;
    let parents: Vec<AtomicU32> = (0..places).into_par_iter().map(AtomicU32::new).collect();
    let corners: Vec<AtomicU32> =
        (0..places).into_par_iter().map(|_| AtomicU32::new(NO_CORNER)).collect();
    mesh.triangles().par_chunks(CHUNK).enumerate().try_for_each(|(chunk, triangles)| {
        for_each_surface_face(chunk * CHUNK, triangles, kinds, place_of_vertex, |face, places| {
            unite(&parents, places[0], places[1]);
            unite(&parents, places[0], places[2]);
            for (slot, place) in (0..).zip(places) {
                corners[place as usize].fetch_min(face * 3 + slot, Ordering::Relaxed);
            }
        });
        progress.advance(triangles.len())
    })?;

    let place_corners: Vec<Corner> = corners
        .par_iter()
        .map(|corner| corner.load(Ordering::Relaxed))
        .filter(|&corner| corner != NO_CORNER)
        .collect();
    let is_root = |place: u32| {
        corners[place as usize].load(Ordering::Relaxed) != NO_CORNER
            && parents[place as usize].load(Ordering::Relaxed) == place
    };
    let count = (0..places).into_par_iter().filter(|&place| is_root(place)).count();
    Ok(Pieces { count, place_corners })
}

/// The place that stands for the set of `place`.
fn root(parents: &[AtomicU32], mut place: u32) -> u32 {
    loop {
        let parent = parents[place as usize].load(Ordering::Relaxed);
        if parent == place {
            return place;
        }
        // Halve the path: point past the parent, unless another thread has changed it already.
        let grandparent = parents[parent as usize].load(Ordering::Relaxed);
        let link = &parents[place as usize];
        let _ = link.compare_exchange(parent, grandparent, Ordering::Relaxed, Ordering::Relaxed);
        place = grandparent;
    }
}

/// Makes the sets of two places one.
fn unite(parents: &[AtomicU32], a: u32, b: u32) {
    loop {
        let (a, b) = (root(parents, a), root(parents, b));
        let (low, high) = (a.min(b), a.max(b));
        // Parents are lower than their children, so that no circle can come about.
        let link = &parents[high as usize];
        if low == high
            || link.compare_exchange(high, low, Ordering::Relaxed, Ordering::Relaxed).is_ok()
        {
            return;
        }
    }
}
