//! The tree that rays walk: nodes of eight children over leaves of eight triangles, and its file.
//!
//! In the terms of today's literature it is a spatial-split BVH (M. Stich, H. Friedrich, A. Dietrich,
//! "Spatial Splits in Bounding Volume Hierarchies", HPG 2009), collapsed to eight children (BVH8); with the
//! preset `fast` it has no spatial splits. The lecture's kd-tree is [`textbook`](crate::textbook).

mod bounds;
mod collinear;
pub mod file;
mod leaf_block;
mod node;
mod node_ref;
mod parameters;
mod statistics;

pub use bounds::Bounds;
pub use collinear::{CollinearCorner, CollinearFaces};
pub use file::{ContentHash, TreeFile, Verify, is_tree_file};
pub use leaf_block::{CornerLanes, LeafBlock, LeafBlocks, LeafFaces};
pub use node::Node;
pub use node_ref::NodeRef;
pub use parameters::{BuildParameters, Preset};
pub use statistics::TreeStatistics;

use crate::geometry::NO_FACE;
use crate::numeric::Frame;
use crate::storage::Buffer;

/// Panics about a tree that no builder made. [`Scene::guarded`](crate::Scene::guarded) makes an error of it.
#[cold]
pub(crate) fn panic_corrupt_tree() -> ! {
    panic!("the tree is damaged: a walk goes in circles")
}

/// Leaves hold at most this many triangles: one block of the machine's vector unit.
pub const BLOCK_SIZE: usize = 8;

/// No walk has more references on its stack than this: the builder's promise, which bounds what a file
/// may ask for.
pub const MAX_STACK_SIZE: usize = 1024;

/// The tree over the triangles of a mesh.
///
/// Every node knows the tight boxes of its up to eight children. A triangle that a spatial split cut is
/// referenced by leaves on both sides; triangles that object splits divided are referenced once. Leaves
/// hold at most [`BLOCK_SIZE`] triangles.
#[derive(Clone, Debug)]
pub struct Tree {
    /// Maps user coordinates to those of the boxes.
    pub frame: Frame,
    /// The tight box of all that can be hit.
    pub bounds: Bounds,
    /// Where a walk begins: a node, a leaf, or [`NodeRef::END`] for a mesh in which nothing can be hit.
    pub root: NodeRef,
    /// All nodes, depth first.
    pub nodes: Buffer<Node>,
    /// How many references a walk may have on its stack at one time.
    pub max_stack_size: usize,
    /// No frame coordinate of a corner is larger.
    pub reach: f32,
    /// The triangles of the leaves.
    pub leaves: LeafBlocks,
    /// References to triangles, all leaves together.
    pub references: usize,
    /// How many spatial splits the builder made.
    pub spatial_splits: usize,
    /// How many object splits the builder made.
    pub object_splits: usize,
    /// The faces of no area that have edges nevertheless.
    pub collinear: CollinearFaces,
    /// Faces left out since their three corners lie on one line.
    pub skipped_zero_area: usize,
    /// Faces left out since a coordinate is NaN or infinite.
    pub skipped_non_finite: usize,
}

impl Tree {
    /// The faces of the leaf whose block has this index.
    #[inline]
    pub fn faces(&self, block: usize) -> impl Iterator<Item = u32> + '_ {
        self.leaves.blocks[block].faces.iter().copied().take_while(|&face| face != NO_FACE)
    }

    /// No walk comes to more nodes and leaves, since none comes to one twice. A tree in a file that was
    /// damaged after it was opened may go in circles; what walks a tree panics beyond this.
    pub fn max_steps(&self) -> usize {
        self.nodes.len() + self.leaves.blocks.len()
    }

    /// Bytes of the nodes, the leaves, and the collinear faces.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.leaves.blocks[..]) + self.collinear.bytes()
    }
}
