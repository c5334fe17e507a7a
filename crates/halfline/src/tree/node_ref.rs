//! What nodes and stacks refer to nodes and leaves by.

use bytemuck::{Pod, Zeroable};

/// A reference to a node or a leaf, as it stands in a node and on a ray's stack: two bits of kind, thirty of
/// index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct NodeRef(pub u32);

const KIND_SHIFT: u32 = 30;

impl NodeRef {
    /// No child: its box is empty, so it is never met. On a stack it is the end of the walk.
    pub const END: NodeRef = NodeRef((NodeRef::ENDED as u32) << KIND_SHIFT);

    /// The reference of a stream's slot without a ray.
    pub const IDLE: NodeRef = NodeRef(3 << KIND_SHIFT);

    /// The reference of a stream's slot whose ray waits for a look in double precision.
    pub const WAITING: NodeRef = NodeRef(NodeRef::IDLE.0 + 1);

    /// References below this are nodes; leaves are those from it to [`NodeRef::END`].
    pub const FIRST_LEAF: u32 = (NodeRef::LEAF as u32) << KIND_SHIFT;

    const NODE: usize = 0;
    const LEAF: usize = 1;
    const ENDED: usize = 2;

    #[inline(always)]
    fn kind(self) -> usize {
        (self.0 >> KIND_SHIFT) as usize
    }

    /// A reference to the node of this index.
    pub fn node(index: usize) -> NodeRef {
        assert!(index >> KIND_SHIFT == 0, "the builder refuses meshes of more than 2^29 triangles");
        NodeRef(index as u32)
    }

    /// A reference to the leaf whose block has this index.
    pub fn leaf(index: usize) -> NodeRef {
        assert!(index >> KIND_SHIFT == 0, "the builder refuses meshes of more than 2^29 triangles");
        NodeRef((NodeRef::LEAF as u32) << KIND_SHIFT | index as u32)
    }

    /// True for a node.
    #[inline(always)]
    pub fn is_node(self) -> bool {
        self.kind() == NodeRef::NODE
    }

    /// True for a leaf.
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.kind() == NodeRef::LEAF
    }

    /// The index of the node, or of the leaf's block.
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & ((1 << KIND_SHIFT) - 1)) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_keep_what_they_are_given() {
        let last = (1 << KIND_SHIFT) - 1;
        let (node, leaf) = (NodeRef::node(last), NodeRef::leaf(last));
        assert_eq!([node.is_node(), node.is_leaf()], [true, false]);
        assert_eq!([leaf.is_node(), leaf.is_leaf()], [false, true]);
        assert_eq!([NodeRef::END.is_node(), NodeRef::END.is_leaf()], [false, false]);
        assert_eq!([node.index(), leaf.index()], [last, last]);
    }
}
