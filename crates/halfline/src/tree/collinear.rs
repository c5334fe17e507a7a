//! The triangles without area that have edges nevertheless.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use twox_hash::XxHash3_64;

use crate::geometry::Vec3;
use crate::mesh::Mesh;
use crate::storage::Buffer;

/// A corner of a face whose corners are apart but on one line.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct CollinearCorner {
    /// The hash of where the corner lies.
    hash: u64,
    face: u32,
    /// Always zero: fills the struct up, so that no byte is undefined.
    unused: u32,
}

/// Faces whose three corners are apart but on one line, findable by their corners.
///
/// Nothing hits them, so no leaf holds them. But they may close the gap between a long edge and two
/// short ones, so that it is no border.
#[derive(Clone, Debug, Default)]
pub struct CollinearFaces {
    by_corner: Buffer<CollinearCorner>,
}

impl CollinearFaces {
    /// Sorts the corners of `faces`.
    pub fn new(mesh: &Mesh, faces: &[u32]) -> CollinearFaces {
        let mut by_corner: Vec<CollinearCorner> = faces
            .iter()
            .flat_map(|&face| {
                let entry = |corner| CollinearCorner { hash: hash(corner), face, unused: 0 };
                mesh.corners(face).map(entry)
            })
            .collect();
        by_corner.par_sort_unstable_by_key(|entry| (entry.hash, entry.face));
        CollinearFaces { by_corner: by_corner.into() }
    }

    /// The faces with a corner at `point`, each once; others too, whose corners have the same hash.
    pub fn with_corner(&self, point: Vec3) -> impl Iterator<Item = u32> + '_ {
        let hash = hash(point);
        let first = self.by_corner.partition_point(|entry| entry.hash < hash);
        self.by_corner[first..]
            .iter()
            .take_while(move |entry| entry.hash == hash)
            .map(|entry| entry.face)
    }

    /// What was sorted before.
    pub fn from_corners(by_corner: Buffer<CollinearCorner>) -> CollinearFaces {
        CollinearFaces { by_corner }
    }

    /// The corners of all faces, sorted by the hashes of their places and then by face.
    pub fn corners(&self) -> &[CollinearCorner] {
        &self.by_corner
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.by_corner[..])
    }
}

/// Equal for equal coordinates, both zeros being one: XXH3 of their bits, little endian. Files hold it.
fn hash(point: Vec3) -> u64 {
    XxHash3_64::oneshot(bytemuck::bytes_of(&point.place_key().map(u64::to_le)))
}
