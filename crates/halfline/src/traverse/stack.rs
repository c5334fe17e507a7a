//! The stacks of the rays that are under way.
//!
//! V. Havran, "Heuristic Ray Shooting Algorithms", 2000, appendix C keeps where each entry is reached, so that
//! what lies beyond a hit is passed over when it is popped. Different here: it is dropped at the hit, eight at a
//! time, so that what is popped needs no test.

use crate::simd::{LANES, Ring, Simd};
use crate::tree::NodeRef;

use super::stream::SLOTS;

/// The lanes of a vector from the first to the last, as [`Simd::compress`] takes them.
const IN_ORDER: u32 = 0o76_543_210;

/// The stacks of all slots, each in a part of its own. Writes are eight wide, so there is that much room at the
/// end of each.
pub struct Stacks {
    refs: Ring<u32>,
    /// Lower bounds of where the ray enters what the references stand for.
    entries: Ring<f32>,
    /// For each slot the place after the top.
    ends: [usize; SLOTS],
    /// Places for each slot.
    room: usize,
}

impl Stacks {
    /// Empty stacks for a tree whose walks need so much.
    pub fn new(max_stack_size: usize) -> Stacks {
        // The end of the walk lies below everything else.
        let room = max_stack_size + 1 + LANES;
        let refs = Ring::new(room * SLOTS, NodeRef::END.0);
        let entries = Ring::new(room * SLOTS, f32::NEG_INFINITY);
        Stacks { refs, entries, ends: std::array::from_fn(|slot| slot * room + 1), room }
    }

    /// The eight places above the top: for entries and for references.
    #[inline(always)]
    pub fn free(&mut self, slot: usize) -> (&mut [f32; LANES], &mut [u32; LANES]) {
        let end = self.ends[slot];
        (self.entries.eight(end), self.refs.eight(end))
    }

    /// The top.
    #[inline(always)]
    pub fn top(&self, slot: usize) -> u32 {
        self.refs.at(self.ends[slot].wrapping_sub(1))
    }

    /// Drops the top if `is_dropped`, without a branch.
    #[inline(always)]
    pub fn drop_top_if(&mut self, slot: usize, is_dropped: bool) {
        self.ends[slot] = self.ends[slot].wrapping_sub(usize::from(is_dropped));
    }

    /// Pops the top, after so many more have been put into the free places.
    #[inline(always)]
    pub fn pop_after(&mut self, slot: usize, pushed: usize) -> u32 {
        let last = self.ends[slot].wrapping_add(pushed).wrapping_sub(1);
        self.ends[slot] = last;
        self.refs.at(last)
    }

    /// Begins a walk with so many references on the stack.
    #[inline(always)]
    pub fn restart(&mut self, slot: usize, size: usize) {
        self.ends[slot] = slot * self.room + 1 + size;
    }

    /// The places above the end of the walk: for entries and for references.
    pub fn places(&mut self, slot: usize) -> (&mut [f32], &mut [u32]) {
        let places = slot * self.room + 1..(slot + 1) * self.room;
        (&mut self.entries.all_mut()[places.clone()], &mut self.refs.all_mut()[places])
    }

    /// Drops what is entered beyond `limit`, eight at a time.
    #[inline(always)]
    pub fn drop_beyond<S: Simd>(&mut self, simd: S, slot: usize, limit: f32) {
        // What lies above the top is dropped too.
        self.free(slot).0.fill(f32::INFINITY);
        let limit = simd.splat(limit.min(f32::MAX));
        let begin = slot * self.room + 1;
        let (mut kept, mut first) = (begin, begin);
        while first < self.ends[slot] {
            let entry = simd.load(self.entries.eight(first));
            let refs = *self.refs.eight(first);
            let (free_entries, free_refs) = (self.entries.eight(kept), self.refs.eight(kept));
            kept += simd.compress(entry, limit, &refs, IN_ORDER, free_entries, free_refs);
            first += LANES;
        }
        self.ends[slot] = kept;
    }
}
