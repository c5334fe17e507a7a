//! The triangles that may be the nearest to the points that are under way.

use crate::simd::{LANES, Ring, Simd};
use crate::traverse::SLOTS;

/// Places for each slot.
const ROOM: usize = 64;

/// More than this are decided at once.
const MOST: usize = ROOM - LANES;

/// For each slot the triangles, as eight times the block and the lane, with lower bounds of their distances.
pub struct Candidates {
    places: Ring<u32>,
    lows: Ring<f32>,
    counts: [usize; SLOTS],
}

impl Candidates {
    /// None for any slot.
    pub fn new() -> Candidates {
        Candidates {
            places: Ring::new(ROOM * SLOTS, 0),
            lows: Ring::new(ROOM * SLOTS, 0.0),
            counts: [0; SLOTS],
        }
    }

    /// Forgets those of a slot.
    #[inline(always)]
    pub fn clear(&mut self, slot: usize) {
        self.counts[slot] = 0;
    }

    /// Takes the lanes of a block that may be no farther than `bound`.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, slot: usize, block: usize, low: S::F32x8, bound: f32) {
        let mut words = [0; LANES];
        for lane in 0..LANES {
            words[lane] = (block * LANES + lane) as u32;
        }
        let end = slot * ROOM + self.counts[slot] % ROOM;
        let (lows, places) = (self.lows.eight(end), self.places.eight(end));
        self.counts[slot] += simd.compress(low, simd.splat(bound), &words, IN_ORDER, lows, places);
    }

    /// True if there is no room for eight more.
    #[inline(always)]
    pub fn are_many(&self, slot: usize) -> bool {
        self.counts[slot] > MOST
    }

    /// How many there are.
    #[inline(always)]
    pub fn count(&self, slot: usize) -> usize {
        self.counts[slot]
    }

    /// Block and lane of one, and its lower bound.
    #[inline(always)]
    pub fn at(&self, slot: usize, number: usize) -> (usize, usize, f32) {
        let place = self.places.at(slot * ROOM + number) as usize;
        (place / LANES, place % LANES, self.lows.at(slot * ROOM + number))
    }

    /// Drops those beyond `bound`.
    #[inline(always)]
    pub fn drop_beyond<S: Simd>(&mut self, simd: S, slot: usize, bound: f32) {
        let (begin, count) = (slot * ROOM, self.counts[slot]);
        let mut kept = 0;
        // Beyond the last is what does not count.
        self.lows.eight(begin + count).fill(f32::INFINITY);
        let mut first = 0;
        while first < count {
            let low = simd.load(self.lows.eight(begin + first));
            let places = *self.places.eight(begin + first);
            let end = begin + kept;
            let (lows, free) = (self.lows.eight(end), self.places.eight(end));
            kept += simd.compress(low, simd.splat(bound), &places, IN_ORDER, lows, free);
            first += LANES;
        }
        self.counts[slot] = kept;
    }
}

/// The lanes of a vector from the first to the last, as [`Simd::compress`] takes them.
const IN_ORDER: u32 = 0o76_543_210;
