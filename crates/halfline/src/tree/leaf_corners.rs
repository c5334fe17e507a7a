//! The triangles of a leaf, side by side in memory.

use crate::geometry::Vec3;
use crate::mesh::{Mesh, Positions};

/// The corners of the referenced triangles, in the order of the references.
///
/// A leaf's triangles have their vertices anywhere in the mesh: reading them there costs a cache
/// miss for nearly every corner, which rules the time of incoherent rays. So the tree holds copies
/// of single-precision corners, bit by bit the user's. Copies of double-precision ones would double
/// the tree, so those are read from the mesh.
#[derive(Clone, Debug)]
pub enum LeafCorners {
    /// The corners of each reference.
    Copied(Vec<[[f32; 3]; 3]>),
    /// To be read from the mesh.
    InMesh,
}

impl LeafCorners {
    /// The corners of the triangle with number `reference` in the tree's references, which is
    /// `face` in the mesh.
    #[inline(always)]
    pub fn get(&self, mesh: &Mesh, reference: usize, face: u32) -> [Vec3; 3] {
        match self {
            LeafCorners::Copied(corners) => {
                let [a, b, c] = corners[reference];
                [a.into(), b.into(), c.into()]
            }
            LeafCorners::InMesh => mesh.corners(face),
        }
    }

    /// Fills the array for a mesh and the tree's references.
    pub fn of(mesh: &Mesh, references: &[u32]) -> LeafCorners {
        use rayon::prelude::*;
        let Positions::F32(positions) = mesh.positions() else { return LeafCorners::InMesh };
        let mut corners = Vec::with_capacity(references.len());
        crate::io::advise_huge_pages(corners.spare_capacity_mut());
        references
            .par_iter()
            .map(|&face| mesh.triangles()[face as usize].map(|vertex| positions[vertex as usize]))
            .collect_into_vec(&mut corners);
        LeafCorners::Copied(corners)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        match self {
            LeafCorners::Copied(corners) => size_of_val(&corners[..]),
            LeafCorners::InMesh => 0,
        }
    }
}
