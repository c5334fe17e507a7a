//! One node: 32 bytes, siblings together in one cache line.

use bytemuck::{Pod, Zeroable};

use super::Bounds;

/// How an inner node divides what it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Split {
    /// By a plane across `axis` at `position`, in frame coordinates.
    Plane {
        /// 0, 1 or 2.
        axis: usize,
        /// Where the plane cuts the axis.
        position: f32,
    },
    /// Into two groups whose centres are ordered along `axis`; their boxes may overlap.
    Groups {
        /// 0, 1 or 2.
        axis: usize,
    },
}

impl Split {
    /// The axis along which the first child comes before the second.
    pub fn axis(&self) -> usize {
        match *self {
            Split::Plane { axis, .. } | Split::Groups { axis } => axis,
        }
    }
}

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeKind {
    /// Some triangles.
    Leaf {
        /// Index of the leaf's block.
        first: u32,
        /// Number of triangles.
        count: u32,
    },
    /// Two children.
    Inner {
        /// Index of the pair of children.
        children: u32,
        /// How they divide the node.
        split: Split,
    },
}

/// A node of the tree. The kind is packed: `word` holds three bits of kind (0 leaf, 1 to 3 a plane
/// across x, y, z, 4 to 6 groups along x, y, z) and 29 bits of index; `payload` the count of a leaf
/// or the bits of a plane's position.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Node {
    /// The tight box of what the node holds.
    pub bounds: Bounds,
    word: u32,
    payload: u32,
}

const KIND_BITS: u32 = 3;

impl Node {
    /// Indices of references and of children must be below this.
    pub const INDEX_LIMIT: usize = 1 << (u32::BITS - KIND_BITS);

    /// A leaf.
    ///
    /// # Panics
    /// If `first` is not below [`Node::INDEX_LIMIT`]; the builder refuses such meshes.
    pub fn leaf(bounds: Bounds, first: u32, count: u32) -> Node {
        assert!((first as usize) < Node::INDEX_LIMIT);
        Node { bounds, word: first << KIND_BITS, payload: count }
    }

    /// An inner node.
    ///
    /// # Panics
    /// If `children` is not below [`Node::INDEX_LIMIT`]; the builder refuses such meshes.
    pub fn inner(bounds: Bounds, children: u32, split: Split) -> Node {
        assert!((children as usize) < Node::INDEX_LIMIT);
        let (kind, payload) = match split {
            Split::Plane { axis, position } => (1 + axis as u32, position.to_bits()),
            Split::Groups { axis } => (4 + axis as u32, 0),
        };
        Node { bounds, word: children << KIND_BITS | kind, payload }
    }

    /// What this node is.
    #[inline]
    pub fn kind(&self) -> NodeKind {
        let index = self.word >> KIND_BITS;
        match self.word & 7 {
            0 => NodeKind::Leaf { first: index, count: self.payload },
            kind @ 1..=3 => {
                let position = f32::from_bits(self.payload);
                let split = Split::Plane { axis: kind as usize - 1, position };
                NodeKind::Inner { children: index, split }
            }
            kind => {
                let split = Split::Groups { axis: (kind as usize - 4).min(2) };
                NodeKind::Inner { children: index, split }
            }
        }
    }

    /// The same node with its index moved, for a subtree that is appended to others.
    pub fn moved(self, children_before: u32, leaves_before: u32) -> Node {
        match self.kind() {
            NodeKind::Leaf { first, count } => {
                Node::leaf(self.bounds, first + leaves_before, count)
            }
            NodeKind::Inner { children, split } => {
                Node::inner(self.bounds, children + children_before, split)
            }
        }
    }
}

/// Two siblings.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Children(pub [Node; 2]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_half_a_cache_line_and_keeps_what_it_is_given() {
        assert_eq!((size_of::<Node>(), size_of::<Children>()), (32, 64));
        let last = Node::INDEX_LIMIT as u32 - 1;
        let kinds = [
            NodeKind::Leaf { first: last, count: 7 },
            NodeKind::Inner { children: last, split: Split::Plane { axis: 2, position: -0.5 } },
            NodeKind::Inner { children: 0, split: Split::Plane { axis: 0, position: 0.25 } },
            NodeKind::Inner { children: 3, split: Split::Groups { axis: 1 } },
            NodeKind::Inner { children: 3, split: Split::Groups { axis: 2 } },
        ];
        for kind in kinds {
            let node = match kind {
                NodeKind::Leaf { first, count } => Node::leaf(Bounds::EMPTY, first, count),
                NodeKind::Inner { children, split } => Node::inner(Bounds::EMPTY, children, split),
            };
            assert_eq!(node.kind(), kind);
        }
    }
}
