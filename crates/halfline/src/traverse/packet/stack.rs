//! The stack of a packet's walk.

use super::Mask;
use super::bounds::ChildBounds;
use crate::simd::{LANES, Simd};
use crate::tree::Node;

/// Beside the number of a lane: all rays that met its node meet its box.
const MET_BY_ALL: u32 = 8;

/// What a packet comes to next.
pub struct PacketStack {
    entries: Vec<f32>,
    refs: Vec<u32>,
    /// The lane of the box in its parent, and whether all rays meet it.
    lanes: Vec<u32>,
    /// The parent.
    parents: Vec<u32>,
    /// The rays that came to the parent.
    masks: Vec<Mask>,
    size: usize,
}

/// What lay on top of the stack.
pub struct Popped {
    /// Bits of a [`NodeRef`](crate::tree::NodeRef).
    pub place: u32,
    /// The lane of its box in its parent.
    pub lane: usize,
    /// True if all rays that came to its parent meet its box.
    pub is_met_by_all: bool,
    /// Its parent.
    pub parent: usize,
    /// The rays that came to its parent, as far as anything still matters to them.
    pub mask: Mask,
}

impl PacketStack {
    /// A stack for a tree whose walks need so much.
    pub fn new(max_stack_size: usize) -> PacketStack {
        let room = max_stack_size + 1 + LANES;
        PacketStack {
            entries: vec![0.0; room],
            refs: vec![0; room],
            lanes: vec![0; room],
            parents: vec![0; room],
            masks: vec![0; room],
            size: 0,
        }
    }

    /// Drops everything.
    pub fn clear(&mut self) {
        self.size = 0;
    }

    /// True if nothing is left.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.size == 0
    }

    /// The reference so far below the top, if there is one: 0 for the top itself.
    #[inline(always)]
    pub fn below_top(&self, depth: usize) -> Option<u32> {
        (self.size > depth).then(|| self.refs[self.size - 1 - depth])
    }

    /// Pops what is nearest; `None` if none of the rays that are `alive` came to its parent, or it is entered
    /// beyond `limit`.
    #[inline(always)]
    pub fn pop(&mut self, alive: Mask, limit: f32) -> Option<Popped> {
        self.size -= 1;
        let top = self.size;
        let mask = self.masks[top] & alive;
        if mask == 0 || self.entries[top] > limit {
            return None;
        }
        let lane = self.lanes[top];
        Some(Popped {
            place: self.refs[top],
            lane: lane as usize % LANES,
            is_met_by_all: lane & MET_BY_ALL != 0,
            parent: self.parents[top] as usize,
            mask,
        })
    }

    /// Pushes the children of a node that some ray may meet, the nearest last.
    #[inline(always)]
    pub fn push<S: Simd>(
        &mut self,
        simd: S,
        (node, index): (&Node, usize),
        octant: u32,
        children: &ChildBounds<S::F32x8>,
        mask: Mask,
    ) {
        let mut numbers = [0; LANES];
        for lane in 0..LANES {
            numbers[lane] = lane as u32 + (children.met_by_all >> lane & 1) * MET_BY_ALL;
        }
        let first = self.size;
        let order = node.orders[octant as usize & 7];
        let (entries, refs) =
            (self.entries[first..].first_chunk_mut(), self.refs[first..].first_chunk_mut());
        let (lanes, parents) = (
            self.lanes[first..].first_chunk_mut(),
            self.parents[first..].first_chunk_mut::<LANES>(),
        );
        let masks = self.masks[first..].first_chunk_mut::<LANES>();
        let (Some(entries), Some(refs), Some(lanes), Some(parents), Some(masks)) =
            (entries, refs, lanes, parents, masks)
        else {
            unreachable!("the builder bounds the stack")
        };
        let ChildBounds { entry, exit, .. } = *children;
        simd.compress(entry, exit, &numbers, order, entries, lanes);
        self.size += simd.compress(entry, exit, &node.refs, order, entries, refs);
        *parents = [index as u32; LANES];
        *masks = [mask; LANES];
    }

    /// Copies what is left, the top last, for a ray that goes on by itself; returns how much.
    pub fn copy_to(&self, entries: &mut [f32], refs: &mut [u32]) -> usize {
        entries[..self.size].copy_from_slice(&self.entries[..self.size]);
        refs[..self.size].copy_from_slice(&self.refs[..self.size]);
        self.size
    }
}
