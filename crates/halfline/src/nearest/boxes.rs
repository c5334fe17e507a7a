//! Eight boxes at once: how far away is each, at least?
//!
//! The distance along an axis is `max(low - p, p - high, 0)`. With p rounded up for the first and down for the second,
//! what is left is rounding in terms of the square of the distance itself: a difference, a square and two sums, 5 of
//! them with those of the difference counted twice. [`BOX_ERROR`] takes more, on the side of the limit.

use super::point_in_frame::{PointInFrame, SMALLEST};
use crate::simd::{LANES, Simd};
use crate::tree::Node;

/// What is added to the square of a limit, in terms of itself: 16 roundings.
const BOX_ERROR: f32 = 8.0 * f32::EPSILON;

/// For each lane an order of all lanes in which it is the last.
const LAST: [u32; LANES] = orders();

const fn orders() -> [u32; LANES] {
    let mut orders = [0; LANES];
    let mut last = 0;
    while last < LANES {
        let (mut step, mut lane) = (0, 0);
        while lane < LANES {
            if lane != last {
                orders[last] |= (lane as u32) << (3 * step);
                step += 1;
            }
            lane += 1;
        }
        orders[last] |= (last as u32) << (3 * step);
        last += 1;
    }
    orders
}

/// The largest square of a distance to a box that may hold something nearer than `bound`.
#[inline(always)]
pub fn square_of_limit(bound: f32) -> f32 {
    bound * bound * (1.0 + BOX_ERROR) + SMALLEST * SMALLEST
}

/// Writes the children that are not beyond the limit, and the squares of their distances, the nearest last. Returns how
/// many.
#[inline(always)]
pub fn push_children<S: Simd>(
    simd: S,
    point: &PointInFrame,
    limit: f32,
    node: &Node,
    squares: &mut [f32; LANES],
    refs: &mut [u32; LANES],
) -> usize {
    let zero = simd.splat(0.0);
    let mut square = zero;
    for axis in 0..3 {
        let [low, high] = &node.sides[axis];
        let before = simd.sub(simd.load(low), simd.splat(point.high[axis]));
        let behind = simd.sub(simd.splat(point.low[axis]), simd.load(high));
        let apart = simd.max(simd.max(before, behind), zero);
        square = simd.mul_add(apart, apart, square);
    }

    // Find the nearest: numbers that are not negative are ordered as their bits, whose last three give way to the
    // lane's number.
    let mut keys = [0.0; LANES];
    simd.store(square, &mut keys);
    let mut nearest = u32::MAX;
    for lane in 0..LANES {
        nearest = nearest.min(keys[lane].to_bits() & !7 | lane as u32);
    }
    let order = LAST[nearest as usize % LANES];
    simd.compress(square, simd.splat(limit), &node.refs, order, squares, refs)
}
