//! A node of the tree: the boxes of up to eight children.

use bytemuck::{Pod, Zeroable};

use super::{Bounds, NodeRef};
use crate::simd::LANES;

/// Four cache lines: the boxes of up to eight children, what they are, and in which order a ray
/// passes through them.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Node {
    /// For each axis the lower sides of the children's boxes, then the upper sides.
    pub sides: [[[f32; LANES]; 2]; 3],
    /// The children. Those that there are come first.
    pub refs: [u32; LANES],
    /// For each octant of directions (bit `axis` is set where the direction is negative) the lanes
    /// from the last that a ray passes to the first, three bits for each. Along a ray the order of
    /// splits depends on nothing else.
    pub orders: [u32; 8],
}

impl Node {
    /// A node without children.
    pub const EMPTY: Node = Node {
        sides: [[[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]]; 3],
        refs: [NodeRef::END.0; LANES],
        orders: [0; 8],
    };

    /// Puts a child into a lane.
    pub fn set(&mut self, lane: usize, child: NodeRef, bounds: &Bounds) {
        for axis in 0..3 {
            self.sides[axis][0][lane] = bounds.min[axis];
            self.sides[axis][1][lane] = bounds.max[axis];
        }
        self.refs[lane] = child.0;
    }

    /// The box in a lane.
    pub fn bounds(&self, lane: usize) -> Bounds {
        let side = |side: usize| [0, 1, 2].map(|axis| self.sides[axis][side][lane]);
        Bounds { min: side(0), max: side(1) }
    }

    /// The children.
    pub fn children(&self) -> impl Iterator<Item = NodeRef> {
        self.refs.iter().map(|&bits| NodeRef(bits)).take_while(|&child| child != NodeRef::END)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_four_cache_lines_and_begins_without_children() {
        assert_eq!(size_of::<Node>(), 256);
        assert_eq!(Node::EMPTY.children().count(), 0);
    }
}
