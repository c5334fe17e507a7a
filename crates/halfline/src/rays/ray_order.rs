//! In which order the rays of a batch are cast.
//!
//! Rays of an image lie in memory row by row, and 64 in a row are a strip that is far wider than high. In a tile
//! of 8 by 8 pixels they are nearer to each other, and go as a packet where a strip does not. So an image is cast
//! by bands of eight rows, and each band tile by tile; a row of a tile is an octet, and in a row in memory too.

use crate::simd::LANES;

/// Pixels along a side of a tile.
const TILE: usize = LANES;

/// Wider images are cast in the order of memory: a band of theirs would keep one thread busy for too long.
const WIDEST: usize = 1 << 13;

/// The order of a batch, or of a band of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayOrder {
    /// Rays of a row of the image, or 0 for the order of memory.
    width: usize,
    /// Rays in all.
    len: usize,
}

/// Rays of an image of this width in one band, or `None` if it is not cast by bands.
pub fn rays_per_band(width: usize) -> Option<usize> {
    // The last tile of a row overlaps the one before, and casts some rays again: not where these are many.
    let is_tiled = (width.is_multiple_of(TILE) || width >= 8 * TILE) && width <= WIDEST;
    (is_tiled && width > 0).then_some(TILE * width)
}

impl RayOrder {
    /// The order of so many rays of an image of this width; 0 for none.
    pub fn new(width: usize, len: usize) -> RayOrder {
        let is_band =
            rays_per_band(width).is_some_and(|band| len <= band) && len.is_multiple_of(width);
        RayOrder { width: if is_band { width } else { 0 }, len }
    }

    /// How many rays are cast: some may be cast twice.
    pub fn count(&self) -> usize {
        if self.width == 0 {
            return self.len;
        }
        self.len / self.width * self.width.next_multiple_of(TILE)
    }

    /// Where eight rays that are cast in a row begin in memory, given how many are cast before.
    #[inline(always)]
    pub fn octet(&self, number: usize) -> usize {
        if self.width == 0 {
            return number;
        }
        let height = self.len / self.width;
        let (tile, row) = (number / (TILE * height), number / TILE % height);
        row * self.width + (tile * TILE).min(self.width - TILE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ray_of_a_band_is_cast() {
        for (width, height) in [(8, 8), (64, 8), (65, 8), (71, 3), (100, 1), (8192, 8)] {
            let order = RayOrder::new(width, width * height);
            let mut casts = vec![0; width * height];
            for number in (0..order.count()).step_by(TILE) {
                let begin = order.octet(number);
                casts[begin..begin + TILE].iter_mut().for_each(|count| *count += 1);
            }
            assert!(casts.iter().all(|&count| count == 1 || count == 2), "{width} x {height}");
            let again = casts.iter().filter(|&&count| count == 2).count();
            assert_eq!(again, width.next_multiple_of(TILE) * height - width * height);
        }
    }

    #[test]
    fn a_tile_is_eight_octets_below_each_other() {
        let order = RayOrder::new(640, 640 * 8);
        let begins: Vec<usize> =
            (64..128).step_by(TILE).map(|number| order.octet(number)).collect();
        assert_eq!(begins, (0..8).map(|row| row * 640 + 8).collect::<Vec<_>>());
    }

    #[test]
    fn other_batches_are_cast_in_the_order_of_memory() {
        for (width, len) in
            [(0, 100), (7, 56), (63, 63 * 8), (64, 100), (64, 64 * 9), (8193, 8193 * 8)]
        {
            let order = RayOrder::new(width, len);
            assert_eq!((order.count(), order.octet(24)), (len, 24), "{width}, {len}");
        }
    }
}
