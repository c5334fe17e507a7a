//! Pairs of rays and triangles that single precision leaves open, collected over rays.
//!
//! A look in double precision takes eight pairs at once, and by itself as long as a walk of six steps: so a ray with
//! such a pair waits until there are eight, or until it has waited long enough. Most of these rays have just
//! left a surface, and their pair is the triangle that they start on.

use super::Pairs;
use crate::simd::LANES;
use crate::tree::LeafBlock;

/// Room for pairs: those of a turn, one for each ray, and those that are left of earlier ones, and one leaf more.
const ROOM: usize = 64;

/// Pairs that wait, in the order in which they came; those of a ray in a row.
pub struct OpenPairs {
    /// Of each pair the slot, or the number in the packet, of its ray.
    owners: [u8; ROOM],
    /// The lane of each triangle in its block.
    lanes: [u8; ROOM],
    /// The index of each triangle's block.
    blocks: [u32; ROOM],
    len: usize,
}

impl OpenPairs {
    /// None yet.
    pub fn none() -> OpenPairs {
        OpenPairs { owners: [0; ROOM], lanes: [0; ROOM], blocks: [0; ROOM], len: 0 }
    }

    /// How many there are.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// True if there may be no room for those of another leaf.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.len > ROOM - LANES
    }

    /// Takes a pair if `is_open`, without a branch: whose it is, the index of the block, and the lane of the
    /// triangle.
    #[inline(always)]
    pub fn push_if(&mut self, is_open: bool, owner: usize, block: u32, lane: u32) {
        let end = self.len % ROOM;
        (self.owners[end], self.lanes[end]) = (owner as u8, lane as u8);
        self.blocks[end] = block;
        self.len += usize::from(is_open);
    }

    /// Takes the triangles in some lanes of a leaf.
    #[inline(always)]
    pub fn push_all(&mut self, owner: usize, block: u32, mut open: u32) {
        while open != 0 {
            self.push_if(true, owner, block, open.trailing_zeros());
            open &= open - 1;
        }
    }

    /// Whose a pair is.
    #[inline(always)]
    pub fn owner(&self, pair: usize) -> usize {
        self.owners[pair % ROOM].into()
    }

    /// True if the pair is the last of its ray.
    #[inline(always)]
    pub fn is_last_of_owner(&self, pair: usize) -> bool {
        let next = (pair + 1) % ROOM;
        pair + 1 == self.len || self.owners[next] != self.owners[pair % ROOM]
    }

    /// The first eight pairs, of which the number of the ray follows from whose they are.
    #[inline(always)]
    pub fn first(&self, blocks: &[LeafBlock], number_of: impl Fn(usize) -> usize) -> Pairs {
        let mut pairs = Pairs::none();
        pairs.lanes = (1 << self.len.min(LANES)) - 1;
        let last = self.len.saturating_sub(1);
        for lane in 0..LANES {
            // Lanes beyond the last repeat it: what is left there of others may be of no ray of this batch.
            let pair = lane.min(last);
            let (block, triangle) = (self.blocks[pair], usize::from(self.lanes[pair]) % LANES);
            pairs.numbers[lane] = number_of(self.owner(pair));
            pairs.faces[lane] = blocks[block as usize].faces[triangle];
            (pairs.blocks[lane], pairs.triangles[lane]) = (block, triangle as u32);
        }
        pairs
    }

    /// Drops the first eight.
    #[inline(always)]
    pub fn drop_first(&mut self) {
        if self.len > LANES {
            self.owners.copy_within(LANES.., 0);
            self.lanes.copy_within(LANES.., 0);
            self.blocks.copy_within(LANES.., 0);
        }
        self.len = self.len.saturating_sub(LANES);
    }
}
