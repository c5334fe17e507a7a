//! A node with up to eight children: what the engine walks.

use bytemuck::{Pod, Zeroable};

use super::Bounds;
use crate::map::Buffer;
use crate::simd::LANES;

/// What a word of a node, or of a ray's stack, stands for: two bits of kind, thirty of index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Word(pub u32);

const KIND_SHIFT: u32 = 30;

impl Word {
    /// No child: its box is empty, so it is never met; on a stack the end of the walk.
    pub const END: Word = Word((Word::ENDED as u32) << KIND_SHIFT);

    /// In a slot without a ray.
    pub const IDLE: Word = Word(3 << KIND_SHIFT);

    /// Words below this are inner nodes; leaves are those from it to [`Word::END`].
    pub const FIRST_LEAF: u32 = (Word::LEAF as u32) << KIND_SHIFT;

    const INNER: usize = 0;
    const LEAF: usize = 1;
    const ENDED: usize = 2;

    #[inline(always)]
    fn kind(self) -> usize {
        (self.0 >> KIND_SHIFT) as usize
    }

    /// The wide node of this index.
    pub fn inner(index: usize) -> Word {
        assert!(index >> KIND_SHIFT == 0, "the builder refuses meshes of more than 2^29 triangles");
        Word(index as u32)
    }

    /// The leaf whose block has this index.
    pub fn leaf(index: u32) -> Word {
        assert!(index >> KIND_SHIFT == 0, "the builder refuses meshes of more than 2^29 triangles");
        Word((Word::LEAF as u32) << KIND_SHIFT | index)
    }

    /// True for an inner node.
    #[inline(always)]
    pub fn is_inner(self) -> bool {
        self.kind() == Word::INNER
    }

    /// True for a leaf.
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.kind() == Word::LEAF
    }

    /// The index of a node or block.
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.0 & ((1 << KIND_SHIFT) - 1)) as usize
    }
}

/// Four cache lines: the boxes of up to eight children, what they are, and in which order a ray
/// passes through them.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct WideNode {
    /// For each axis the lower sides of the children's boxes, then the upper sides.
    pub planes: [[[f32; LANES]; 2]; 3],
    /// The children. Those that there are come first.
    pub words: [u32; LANES],
    /// For each octant of directions (bit `axis` is set where the direction is negative) the lanes
    /// from the last that a ray passes to the first, three bits for each. Along a ray the order of
    /// kd cells depends on nothing else.
    pub orders: [u32; 8],
}

impl WideNode {
    /// A node without children.
    pub const EMPTY: WideNode = WideNode {
        planes: [[[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]]; 3],
        words: [Word::END.0; LANES],
        orders: [0; 8],
    };

    /// Puts a child into a lane.
    pub fn set(&mut self, lane: usize, word: Word, bounds: &Bounds) {
        for axis in 0..3 {
            self.planes[axis][0][lane] = bounds.min[axis];
            self.planes[axis][1][lane] = bounds.max[axis];
        }
        self.words[lane] = word.0;
    }

    /// The children.
    pub fn children(&self) -> impl Iterator<Item = Word> {
        self.words.iter().map(|&word| Word(word)).take_while(|&word| word != Word::END)
    }
}

/// The engine's tree: the binary one, collapsed.
#[derive(Clone, Debug)]
pub struct WideTree {
    /// Where a walk begins; [`Word::END`] for an empty mesh.
    pub root: Word,
    /// All inner nodes, depth first.
    pub nodes: Buffer<WideNode>,
    /// How many children a walk may leave waiting at one time.
    pub most_waiting: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_four_cache_lines_and_words_keep_what_they_are_given() {
        assert_eq!(size_of::<WideNode>(), 256);
        let last = (1 << KIND_SHIFT) - 1;
        let (inner, leaf) = (Word::inner(last), Word::leaf(last as u32));
        assert_eq!([inner.is_inner(), inner.is_leaf()], [true, false]);
        assert_eq!([leaf.is_inner(), leaf.is_leaf()], [false, true]);
        assert_eq!([Word::END.is_inner(), Word::END.is_leaf()], [false, false]);
        assert_eq!([inner.index(), leaf.index()], [last, last]);
        assert_eq!(WideNode::EMPTY.children().count(), 0);
    }
}
