//! Asking memory for nodes and leaves before they are needed.

use crate::simd::Simd;
use crate::tree::{LeafBlock, Node, NodeRef, Tree};

/// Trees up to this size stay in the second-level caches of today's machines, and asking for what is
/// there only takes time.
const CACHED_BYTES: usize = 512 << 10;

/// Where nodes and leaves lie.
#[derive(Clone, Copy)]
pub struct Prefetcher {
    nodes: usize,
    /// False if all lies in the caches anyway.
    is_large: bool,
    /// From the first node to the first leaf.
    leaves_from_nodes: usize,
}

impl Prefetcher {
    /// That of a tree.
    pub fn of(tree: &Tree) -> Prefetcher {
        let nodes = tree.nodes.as_ptr().addr();
        let leaves = tree.leaves.blocks.as_ptr().addr();
        let is_large = tree.bytes() > CACHED_BYTES;
        Prefetcher { nodes, is_large, leaves_from_nodes: leaves.wrapping_sub(nodes) }
    }

    /// Asks for all cache lines of a node or leaf, without a branch on which it is.
    #[inline(always)]
    pub fn prefetch<S: Simd>(&self, simd: S, place: NodeRef) {
        if !self.is_large {
            return;
        }
        const LINES: usize = size_of::<Node>() / 64;
        let is_leaf = usize::from(place.is_leaf());
        let more = is_leaf * (size_of::<LeafBlock>() - size_of::<Node>());
        let base = self.nodes.wrapping_add(self.leaves_from_nodes & is_leaf.wrapping_neg());
        let address = base.wrapping_add(place.index() * (size_of::<Node>() + more));
        simd.prefetch(address, LINES);
        // The last line of a leaf; of a node one that was asked for already.
        simd.prefetch(address.wrapping_add((LINES - 1) * 64 + more), 1);
    }
}
