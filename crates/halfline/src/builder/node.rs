//! The builder's binary tree: what splits make, before it is collapsed to nodes of eight children. Nothing of
//! it is kept.

use bytemuck::{Pod, Zeroable};

use crate::tree::Bounds;

/// How an inner node divides what it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Split {
    /// By a plane across `axis` at `position`, in frame coordinates.
    Spatial {
        /// 0, 1 or 2.
        axis: usize,
        /// Where the plane cuts the axis.
        position: f32,
    },
    /// Into two groups of whole triangles whose centres are ordered along `axis`; their boxes may overlap.
    Object {
        /// 0, 1 or 2.
        axis: usize,
    },
}

impl Split {
    /// The axis along which the first child comes before the second.
    pub fn axis(&self) -> usize {
        match *self {
            Split::Spatial { axis, .. } | Split::Object { axis } => axis,
        }
    }
}

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BinaryNodeKind {
    /// A leaf, which holds some triangles.
    Leaf {
        /// Index of the leaf's block.
        first: u32,
        /// Number of triangles.
        count: u32,
    },
    /// An inner node, which has two children.
    Inner {
        /// Index of the pair of children.
        children: u32,
        /// How they divide the node.
        split: Split,
    },
}

/// A node of the tree. The kind is packed: `word` holds three bits of kind (0 leaf, 1 to 3 a plane
/// across x, y, z, 4 to 6 an object split along x, y, z) and 29 bits of index; `payload` the count of a leaf
/// or the bits of a plane's position.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct BinaryNode {
    /// The tight box of what the node holds.
    pub bounds: Bounds,
    word: u32,
    payload: u32,
}

const KIND_BITS: u32 = 3;

impl BinaryNode {
    /// Indices of references and of children must be below this.
    pub const INDEX_LIMIT: usize = 1 << (u32::BITS - KIND_BITS);

    /// A leaf.
    ///
    /// # Panics
    /// If `first` is not below [`BinaryNode::INDEX_LIMIT`]; the builder refuses such meshes.
    pub fn leaf(bounds: Bounds, first: u32, count: u32) -> BinaryNode {
        assert!((first as usize) < BinaryNode::INDEX_LIMIT);
        BinaryNode { bounds, word: first << KIND_BITS, payload: count }
    }

    /// An inner node.
    ///
    /// # Panics
    /// If `children` is not below [`BinaryNode::INDEX_LIMIT`]; the builder refuses such meshes.
    pub fn inner(bounds: Bounds, children: u32, split: Split) -> BinaryNode {
        assert!((children as usize) < BinaryNode::INDEX_LIMIT);
        let (kind, payload) = match split {
            Split::Spatial { axis, position } => (1 + axis as u32, position.to_bits()),
            Split::Object { axis } => (4 + axis as u32, 0),
        };
        BinaryNode { bounds, word: children << KIND_BITS | kind, payload }
    }

    /// What this node is.
    #[inline]
    pub fn kind(&self) -> BinaryNodeKind {
        let index = self.word >> KIND_BITS;
        match self.word & 7 {
            0 => BinaryNodeKind::Leaf { first: index, count: self.payload },
            kind @ 1..=3 => {
                let position = f32::from_bits(self.payload);
                let split = Split::Spatial { axis: kind as usize - 1, position };
                BinaryNodeKind::Inner { children: index, split }
            }
            kind => {
                let split = Split::Object { axis: (kind as usize - 4).min(2) };
                BinaryNodeKind::Inner { children: index, split }
            }
        }
    }

    /// This node with its index moved, for a subtree that is appended to others.
    pub fn moved(self, children_before: u32, leaves_before: u32) -> BinaryNode {
        match self.kind() {
            BinaryNodeKind::Leaf { first, count } => {
                BinaryNode::leaf(self.bounds, first + leaves_before, count)
            }
            BinaryNodeKind::Inner { children, split } => {
                BinaryNode::inner(self.bounds, children + children_before, split)
            }
        }
    }
}

/// Two siblings.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Children(pub [BinaryNode; 2]);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_half_a_cache_line_and_keeps_what_it_is_given() {
        assert_eq!((size_of::<BinaryNode>(), size_of::<Children>()), (32, 64));
        let last = BinaryNode::INDEX_LIMIT as u32 - 1;
        let kinds = [
            BinaryNodeKind::Leaf { first: last, count: 7 },
            BinaryNodeKind::Inner {
                children: last,
                split: Split::Spatial { axis: 2, position: -0.5 },
            },
            BinaryNodeKind::Inner {
                children: 0,
                split: Split::Spatial { axis: 0, position: 0.25 },
            },
            BinaryNodeKind::Inner { children: 3, split: Split::Object { axis: 1 } },
            BinaryNodeKind::Inner { children: 3, split: Split::Object { axis: 2 } },
        ];
        for kind in kinds {
            let node = match kind {
                BinaryNodeKind::Leaf { first, count } => {
                    BinaryNode::leaf(Bounds::EMPTY, first, count)
                }
                BinaryNodeKind::Inner { children, split } => {
                    BinaryNode::inner(Bounds::EMPTY, children, split)
                }
            };
            assert_eq!(node.kind(), kind);
        }
    }
}
