//! The triangles without area that have edges nevertheless.

use std::hash::BuildHasher;

use foldhash::fast::FixedState;
use rayon::prelude::*;

use crate::geometry::Vec3;
use crate::mesh::Mesh;

/// Faces whose three corners are apart but on one line, findable by their corners.
///
/// Nothing hits them, so no leaf holds them. But they may close the gap between a long edge and two
/// short ones, so that it is no border.
#[derive(Clone, Debug, Default)]
pub struct FacesOnLine {
    /// For each corner the hash of its place and the face, sorted.
    by_corner: Vec<(u64, u32)>,
}

impl FacesOnLine {
    /// Sorts the corners of `faces`.
    pub fn new(mesh: &Mesh, faces: &[u32]) -> FacesOnLine {
        let mut by_corner: Vec<(u64, u32)> = faces
            .iter()
            .flat_map(|&face| mesh.corners(face).map(|corner| (hash(corner), face)))
            .collect();
        by_corner.par_sort_unstable();
        FacesOnLine { by_corner }
    }

    /// The faces with a corner at `point`, each once; others too, whose corners have the same hash.
    pub fn with_corner(&self, point: Vec3) -> impl Iterator<Item = u32> + '_ {
        let hash = hash(point);
        let first = self.by_corner.partition_point(|entry| entry.0 < hash);
        self.by_corner[first..]
            .iter()
            .take_while(move |entry| entry.0 == hash)
            .map(|&(_, face)| face)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.by_corner[..])
    }
}

/// Equal for equal coordinates, both zeros being one.
fn hash(point: Vec3) -> u64 {
    FixedState::default().hash_one(point.to_array().map(|x| if x == 0.0 { 0 } else { x.to_bits() }))
}
