//! Eight rays against a triangle each, in double precision: the leaf's kernel once more, where single
//! precision was not certain.
//!
//! The same steps as in `leaf_kernel.rs`, from the user's own coordinates, relative to the origin. With D
//! the largest coordinate of a corner, a projected corner is off by less than eight roundings of D: the
//! difference along each axis one, the slope two, its product one, the difference two. What is left after
//! this is decided exactly: rays through edges, that begin or end on a triangle, and ties.

use super::filter_lanes::choose_by_size;
use super::ray_group::RayLanes;
use crate::numeric::UNIT_ROUNDOFF;
use crate::simd::{Doubles, LANES, Numbers, Simd};

/// What is certain about eight rays and triangles.
pub struct SecondLook {
    /// A bit for each ray that hits, in the inside and within its range.
    pub hit: u32,
    /// A bit for each that does not.
    pub missed: u32,
    /// For those that hit, two numbers between which t is.
    pub low: [f64; LANES],
    /// The second.
    pub high: [f64; LANES],
}

/// Error of a projected corner, and of a difference of two products of such, in terms of D; then as much
/// for the roundings of the bounds.
const CORNER_ERROR: f64 = 16.0 * UNIT_ROUNDOFF;

/// As in `leaf_kernel.rs`.
const MEAN_ERROR: f64 = 2.5;

/// As there.
const STABLE: f64 = 8.0;

/// Roundings of the mean: corners 2, the weighted sum 5, the sum of the weights, its inverse and the
/// product 8, with weights of up to 1.5 times their sum; then as many for the errors' own.
const PLACE_ERROR: f64 = 32.0 * UNIT_ROUNDOFF;

/// Coordinates in this range, and directions, leave no product that overflows, or underflows by more than
/// a rounding of what it is added to.
const PLAIN_RANGE: std::ops::Range<f64> =
    f64::from_bits((1023 - 150) << 52)..f64::from_bits((1023 + 150) << 52);

/// Looks at rays and the corners of their triangles.
#[inline(always)]
pub fn second_look<S: Simd>(
    simd: S,
    rays: &RayLanes<S>,
    corners: &[[Numbers<S>; 3]; 3],
) -> SecondLook {
    let wide = simd.doubles();
    let zero = wide.splat(0.0);

    // Move the origin to zero, and turn the axes so that the direction goes most along the last.
    let [x, y, z] = rays.direction;
    let size = [wide.magnitude(x), wide.magnitude(y), wide.magnitude(z)];
    let course = turned(simd, &size, rays.direction);
    let inverse = wide.divided(wide.splat(1.0), course[2]);
    let slope = [wide.times(course[0], inverse), wide.times(course[1], inverse)];
    let (mut depths, mut largest) = ([zero; 3], zero);
    let mut across = [[zero; 2]; 3];
    for corner in 0..3 {
        let mut relative = [zero; 3];
        for axis in 0..3 {
            relative[axis] = wide.minus(corners[corner][axis], rays.origin[axis]);
            largest = wide.largest(wide.magnitude(relative[axis]), largest);
        }
        let [p, q, depth] = turned(simd, &size, relative);
        depths[corner] = depth;
        across[corner] = [
            wide.minus(p, wide.times(slope[0], depth)),
            wide.minus(q, wide.times(slope[1], depth)),
        ];
    }

    // Take the edge functions, their least and largest, and the bound on their error.
    let [a, b, c] = across;
    let (u, v, w) = (edge(simd, c, b), edge(simd, a, c), edge(simd, b, a));
    let distance = wide.plus(wide.plus(length(simd, a), length(simd, b)), length(simd, c));
    let corner_error = wide.times(largest, wide.splat(CORNER_ERROR));
    let error =
        wide.times(corner_error, wide.plus(wide.plus(corner_error, corner_error), distance));
    let minus_error = wide.minus(zero, error);
    let least = wide.least(wide.least(u, v), w);
    let most = wide.largest(wide.largest(u, v), w);
    let is_missed = wide.are_below(least, minus_error) & wide.are_below(error, most);
    let is_crossed = wide.are_below(error, least) | wide.are_below(most, minus_error);

    // Take the mean of the corners' depths, and t there.
    let sum = wide.plus(wide.plus(u, v), w);
    let share = wide.divided(wide.splat(1.0), sum);
    let mean = wide.plus(wide.times(u, depths[0]), wide.times(v, depths[1]));
    let mean = wide.times(wide.plus(mean, wide.times(w, depths[2])), share);
    let nearest = wide.least(wide.least(depths[0], depths[1]), depths[2]);
    let farthest = wide.largest(wide.largest(depths[0], depths[1]), depths[2]);
    let extent = wide.times(wide.minus(farthest, nearest), wide.splat(MEAN_ERROR));
    let room = wide.times(extent, wide.magnitude(wide.times(error, share)));
    let room = wide.multiply_add(largest, wide.splat(PLACE_ERROR), room);
    let room = wide.times(room, wide.magnitude(inverse));
    let at = wide.times(mean, inverse);
    let (low, high) = (wide.minus(at, room), wide.plus(at, room));

    // Which are out of range for certain, and which within it?
    let is_stable = wide.are_below(wide.times(error, wide.splat(STABLE)), wide.magnitude(sum));
    let is_outside = wide.are_below(rays.t_max, low) | wide.are_below(high, rays.t_min);
    let is_within = wide.are_below(rays.t_min, low) & wide.are_below(high, rays.t_max);
    let (first, last) = (wide.splat(PLAIN_RANGE.start), wide.splat(PLAIN_RANGE.end));
    let steepness = wide.magnitude(inverse);
    let is_plain = wide.are_below(first, wide.least(largest, steepness))
        & wide.are_below(wide.largest(largest, steepness), last);
    let mut look = SecondLook {
        hit: is_plain & is_stable & is_crossed & is_within,
        missed: is_plain & (is_missed | is_stable & is_outside),
        low: [0.0; LANES],
        high: [0.0; LANES],
    };
    wide.store(low, &mut look.low);
    wide.store(high, &mut look.high);
    look
}

/// A vector with its axes turned so that the largest of `size` comes last.
#[inline(always)]
fn turned<S: Simd>(simd: S, size: &[Numbers<S>; 3], [x, y, z]: [Numbers<S>; 3]) -> [Numbers<S>; 3] {
    [
        choose_by_size(simd, size, [y, z, x]),
        choose_by_size(simd, size, [z, x, y]),
        choose_by_size(simd, size, [x, y, z]),
    ]
}

#[inline(always)]
fn edge<S: Simd>(simd: S, p: [Numbers<S>; 2], q: [Numbers<S>; 2]) -> Numbers<S> {
    let wide = simd.doubles();
    wide.minus(wide.times(p[0], q[1]), wide.times(p[1], q[0]))
}

#[inline(always)]
fn length<S: Simd>(simd: S, p: [Numbers<S>; 2]) -> Numbers<S> {
    let wide = simd.doubles();
    wide.plus(wide.magnitude(p[0]), wide.magnitude(p[1]))
}

#[cfg(test)]
mod tests;
