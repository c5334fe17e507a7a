//! The kd-tree that the engine walks: nodes, the leaves' triangles, statistics.

mod bounds;
pub mod file;
mod leaf_block;
mod node;
mod on_line;
mod parameters;
mod statistics;
mod wide_node;

pub use bounds::Bounds;
pub use file::{ContentHash, TreeFile, Verify, is_tree_file};
pub use leaf_block::{LeafBlock, LeafBlocks, LeafFaces};
pub use node::{Children, Node, NodeKind, Split};
pub use on_line::{CornerOnLine, FacesOnLine};
pub use parameters::{BuildParameters, Preset};
pub use statistics::TreeStatistics;
pub use wide_node::{WideNode, WideTree, Word};

use crate::map::Buffer;
use crate::numeric::Frame;

/// Gives up on a tree that no builder made. [`Scene::guarded`](crate::Scene::guarded) makes an error of
/// it.
#[cold]
pub(crate) fn give_up() -> ! {
    panic!("the tree is damaged: a walk goes in circles")
}

/// No leaf lies deeper than this below the root: the builder's promise, which sizes the stacks.
pub const MAX_DEPTH: usize = 128;

/// Leaves hold at most this many triangles: one block of the machine's vector unit.
pub const BLOCK_SIZE: usize = 8;

/// A kd-tree over the triangles of a mesh.
///
/// Near the root, nodes are kd cells: planes of the surface-area heuristic cut space, and
/// triangles that reach through a plane are referenced on both sides. Inside the last cells
/// triangles are grouped without cutting, into leaves of at most [`BLOCK_SIZE`]. Every node knows
/// the tight box of what its cell holds, so empty space needs no cells of its own.
#[derive(Clone, Debug)]
pub struct KdTree {
    /// Maps user coordinates to those of the nodes' boxes.
    pub frame: Frame,
    /// The root; a leaf of no triangles for an empty mesh.
    pub root: Node,
    /// All other nodes, as pairs of siblings, depth first.
    pub children: Buffer<Children>,
    /// The same, collapsed to nodes of up to eight children: what rays walk.
    pub wide: WideTree,
    /// No frame coordinate of a corner is larger.
    pub reach: f32,
    /// The triangles of the leaves.
    pub leaves: LeafBlocks,
    /// References to triangles, all leaves together.
    pub references: usize,
    /// Those of the faces left out that have edges.
    pub on_line: FacesOnLine,
    /// Faces left out since their three corners lie on one line.
    pub skipped_zero_area: usize,
    /// Faces left out since a coordinate is NaN or infinite.
    pub skipped_non_finite: usize,
}

impl KdTree {
    /// The faces of a leaf.
    #[inline]
    pub fn faces(&self, block: u32, count: u32) -> &[u32] {
        &self.leaves.blocks[block as usize].faces[..count as usize]
    }

    /// No walk goes through more binary nodes, leaves included: none comes to a node twice. A tree in a
    /// file that was damaged after it was opened may go in circles; what walks a tree gives up beyond
    /// this.
    pub fn most_steps(&self) -> usize {
        2 * self.children.len() + 1
    }

    /// The same for wide nodes and leaves.
    pub fn most_wide_steps(&self) -> usize {
        self.wide.nodes.len() + self.leaves.blocks.len()
    }

    /// Bytes of the nodes, the leaves, and the faces on a line.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.children[..])
            + size_of_val(&self.wide.nodes[..])
            + size_of_val(&self.leaves.blocks[..])
            + self.on_line.bytes()
    }
}
