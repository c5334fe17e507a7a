//! Places of which eight in a row are read or written at once, at whatever index: a ring, without a check.

#![allow(unsafe_code)]

use super::LANES;

/// A power of two of places, and room for eight behind the last. An index is taken modulo their number, so none
/// is out of range: a walk that was led astray, by a tree file that was damaged while it is in use, meets wrong
/// numbers, and never memory that is not its own.
pub(crate) struct Ring<T> {
    /// `mask + 1 + LANES` of them.
    places: Vec<T>,
    /// One less than a power of two.
    mask: usize,
}

impl<T: Copy> Ring<T> {
    /// At least so many places, all with the same in it.
    pub fn new(least: usize, item: T) -> Ring<T> {
        let count = least.next_power_of_two();
        Ring { places: vec![item; count + LANES], mask: count - 1 }
    }

    /// What is in a place.
    #[inline(always)]
    pub fn at(&self, index: usize) -> T {
        // SAFETY: `index & mask` is no larger than `mask`, and there are more places than that.
        unsafe { *self.places.get_unchecked(index & self.mask) }
    }

    /// Eight places in a row.
    #[inline(always)]
    pub fn eight(&mut self, index: usize) -> &mut [T; LANES] {
        let first = index & self.mask;
        // SAFETY: `first` is no larger than `mask`, and there are `LANES` places more than `mask + 1`.
        unsafe { &mut *self.places.as_mut_ptr().add(first).cast() }
    }

    /// All places.
    pub fn all_mut(&mut self) -> &mut [T] {
        &mut self.places
    }
}
