//! How a ray is held against the triangles of a leaf.

use super::query::Query;
use crate::geometry::Ray;
use crate::mesh::Mesh;
use crate::numeric::{LeafFilter, PreparedRay};
use crate::tree::{KdTree, LeafBlock};

/// A test of one ray against the blocks of leaves.
pub trait LeafTest<Q> {
    /// Prepares a valid ray.
    fn new(ray: &Ray, tree: &KdTree) -> Self;

    /// Shows `query` the contacts of the ray, which was also `prepared`, with the first `count`
    /// triangles of `block`.
    fn test(
        &self,
        tree: &KdTree,
        mesh: &Mesh,
        prepared: &PreparedRay,
        block: &LeafBlock,
        count: u32,
        query: &mut Q,
    );
}

/// The engine's: a filter of all eight in single precision, then the exact test of what is left.
pub struct Watertight(LeafFilter);

impl<Q: Query> LeafTest<Q> for Watertight {
    #[inline]
    fn new(ray: &Ray, tree: &KdTree) -> Watertight {
        Watertight(LeafFilter::new(ray, &tree.frame, tree.reach))
    }

    #[inline]
    fn test(
        &self,
        tree: &KdTree,
        mesh: &Mesh,
        prepared: &PreparedRay,
        block: &LeafBlock,
        count: u32,
        query: &mut Q,
    ) {
        let mut candidates = self.0.candidates(&block.corners) & ((1 << count) - 1);
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            let corners = tree.leaves.corners(mesh, &tree.frame, block, lane);
            prepared.meet_line_then(corners, block.faces[lane], query);
        }
    }
}
