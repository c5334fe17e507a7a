//! The triangles of a leaf, side by side in memory.

use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::BLOCK_SIZE;
use crate::geometry::{NO_FACE, Vec3, vec3};
use crate::mesh::Mesh;
use crate::numeric::Frame;
use crate::storage::Buffer;

/// Corners of eight triangles, by corner, axis and triangle, in frame coordinates.
pub type CornerLanes = [[[f32; BLOCK_SIZE]; 3]; 3];

/// A leaf's triangles as a vector unit wants them: the corners as structure of arrays, then the
/// face indices. Five cache lines.
///
/// Corners and not edges, so that the same arithmetic on a shared vertex gives the same result for
/// every triangle that uses it. They are frame coordinates, rounded to the nearest single-precision
/// number: good enough to pass over most triangles. Lanes beyond the leaf's count repeat the first
/// triangle, as [`NO_FACE`].
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct LeafBlock {
    /// The coordinates of the corners, by corner, axis, and triangle.
    pub corners: CornerLanes,
    /// The faces of the triangles.
    pub faces: [u32; BLOCK_SIZE],
}

/// The faces of a leaf, then [`NO_FACE`].
pub type LeafFaces = [u32; BLOCK_SIZE];

impl LeafBlock {
    /// The block of a leaf, and whether it gives the user's corners exactly.
    fn of(mesh: &Mesh, frame: &Frame, faces: &LeafFaces) -> (LeafBlock, bool) {
        let mut block = LeafBlock { faces: *faces, ..LeafBlock::zeroed() };
        let mut is_exact = true;
        if faces[0] == NO_FACE {
            return (block, is_exact);
        }
        for lane in 0..BLOCK_SIZE {
            let face = if faces[lane] == NO_FACE { faces[0] } else { faces[lane] };
            let corners = mesh.corners(face);
            for (number, &corner) in corners.iter().enumerate() {
                let Vec3 { x, y, z } = frame.point(corner);
                block.corners[number][0][lane] = x as f32;
                block.corners[number][1][lane] = y as f32;
                block.corners[number][2][lane] = z as f32;
            }
            is_exact &= block.user_corners(frame, lane) == corners;
        }
        (block, is_exact)
    }

    /// The corners of a triangle in user coordinates, as near as the block knows them.
    #[inline(always)]
    pub fn user_corners(&self, frame: &Frame, lane: usize) -> [Vec3; 3] {
        let [a, b, c] = &self.corners;
        // Written out, since the compiler leaves array::map a call.
        let corner = |[x, y, z]: &[[f32; BLOCK_SIZE]; 3]| {
            vec3(frame.to_user(x[lane], 0), frame.to_user(y[lane], 1), frame.to_user(z[lane], 2))
        };
        [corner(a), corner(b), corner(c)]
    }
}

/// The blocks of all leaves.
#[derive(Clone, Debug)]
pub struct LeafBlocks {
    /// One for each leaf, in the order of the nodes.
    pub blocks: Buffer<LeafBlock>,
    /// True if every block gives the user's corners exactly, as it does for single-precision meshes
    /// whose coordinates are of similar size. Then the mesh, where they lie anywhere, need not be
    /// read, which would cost a cache miss for nearly every corner.
    pub are_exact: bool,
}

impl LeafBlocks {
    /// Makes the blocks of leaves.
    pub fn pack(mesh: &Mesh, frame: &Frame, leaves: &[LeafFaces]) -> LeafBlocks {
        let mut blocks = Vec::with_capacity(leaves.len());
        crate::storage::advise_huge_pages(blocks.spare_capacity_mut());
        let are_exact = AtomicBool::new(true);
        let pack = |faces: &LeafFaces| {
            let (block, is_exact) = LeafBlock::of(mesh, frame, faces);
            if !is_exact {
                are_exact.store(false, Ordering::Relaxed);
            }
            block
        };
        leaves.par_iter().with_min_len(64).map(pack).collect_into_vec(&mut blocks);
        LeafBlocks { blocks: blocks.into(), are_exact: are_exact.into_inner() }
    }

    /// The corners of the triangle in a lane of `block`, as the user gave them.
    #[inline(always)]
    pub fn corners(&self, mesh: &Mesh, frame: &Frame, block: &LeafBlock, lane: usize) -> [Vec3; 3] {
        if self.are_exact {
            block.user_corners(frame, lane)
        } else {
            mesh.corners(block.faces[lane])
        }
    }
}
