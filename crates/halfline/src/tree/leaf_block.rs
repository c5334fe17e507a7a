//! The triangles of a leaf, side by side in memory.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::{BLOCK_SIZE, Children, Node, NodeKind};
use crate::geometry::{NO_FACE, Vec3, vec3};
use crate::mesh::Mesh;
use crate::numeric::{CornerLanes, Frame};

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
    /// By corner, axis, and triangle.
    pub corners: CornerLanes,
    /// The faces.
    pub faces: [u32; BLOCK_SIZE],
}

impl LeafBlock {
    fn of(mesh: &Mesh, frame: &Frame, faces: &[u32]) -> LeafBlock {
        let mut block = LeafBlock { faces: [NO_FACE; BLOCK_SIZE], ..LeafBlock::zeroed() };
        block.faces[..faces.len()].copy_from_slice(faces);
        for lane in 0..BLOCK_SIZE {
            let Some(&face) = faces.get(lane).or(faces.first()) else { break };
            for (number, corner) in mesh.corners(face).into_iter().enumerate() {
                let corner = frame.point(corner);
                for axis in 0..3 {
                    block.corners[number][axis][lane] = corner[axis] as f32;
                }
            }
        }
        block
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

    fn is_exact(&self, mesh: &Mesh, frame: &Frame, count: usize) -> bool {
        (0..count).all(|lane| self.user_corners(frame, lane) == mesh.corners(self.faces[lane]))
    }
}

/// The blocks of all leaves.
#[derive(Clone, Debug)]
pub struct LeafBlocks {
    /// One for each leaf, in the order of the nodes.
    pub blocks: Vec<LeafBlock>,
    /// True if every block gives the user's corners exactly, as it does for single-precision meshes
    /// whose coordinates are of similar size. Then the mesh, where they lie anywhere, need not be
    /// read, which would cost a cache miss for nearly every corner.
    pub are_exact: bool,
}

impl LeafBlocks {
    /// Makes the blocks, and lets each leaf, which names a range of `references`, name its block.
    pub fn pack(
        mesh: &Mesh,
        frame: &Frame,
        root: &mut Node,
        children: &mut [Children],
        references: &[u32],
    ) -> LeafBlocks {
        // Number the leaves in the order of the nodes.
        let mut ranges = Vec::new();
        let nodes = children.iter_mut().flat_map(|pair| pair.0.iter_mut());
        for node in std::iter::once(root).chain(nodes) {
            if let NodeKind::Leaf { first, count } = node.kind() {
                *node = Node::leaf(node.bounds, ranges.len() as u32, count);
                ranges.push(first as usize..first as usize + count as usize);
            }
        }

        // Fill the blocks, and see whether anything was lost.
        let mut blocks = Vec::with_capacity(ranges.len());
        crate::io::advise_huge_pages(blocks.spare_capacity_mut());
        ranges
            .par_iter()
            .map(|range| LeafBlock::of(mesh, frame, &references[range.clone()]))
            .collect_into_vec(&mut blocks);
        let are_exact = blocks
            .par_iter()
            .zip(&ranges)
            .all(|(block, range)| block.is_exact(mesh, frame, range.len()));
        LeafBlocks { blocks, are_exact }
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
