//! Eight rays against a triangle each, in double precision, where single precision was not certain.
//!
//! The same steps as in `filter_f32.rs`, from the user's own coordinates, relative to the origin. With D
//! the largest coordinate of a corner, a projected corner is off by less than eight roundings of D: the
//! difference along each axis one, the slope two, its product one, the difference two. What is left after
//! this is decided exactly: rays through edges, that begin or end on a triangle, and ties.

use super::t_f32::plane_t;
use crate::numeric::UNIT_ROUNDOFF;
use crate::rays::{RayLanes, select_by_size};
use crate::simd::{F64x8, LANES, Simd, SimdF64};

/// What is certain about eight rays and triangles.
pub struct Refined {
    /// A bit for each ray that hits, in the inside and within its range.
    pub hit: u32,
    /// A bit for each that does not.
    pub missed: u32,
    /// For those that hit, a lower bound of t.
    pub low: [f64; LANES],
    /// For those that hit, an upper bound of t.
    pub high: [f64; LANES],
}

/// Error of a projected corner, and of a difference of two products of such, in terms of D; then as much
/// for the roundings of the bounds.
const CORNER_ERROR: f64 = 16.0 * UNIT_ROUNDOFF;

/// The bound on how far errors of the weights move a mean, as in `filter_f32.rs`.
const MEAN_ERROR: f64 = 2.5;

/// How many times its error the sum of the weights must be, as in `filter_f32.rs`.
const WELL_CONDITIONED: f64 = 8.0;

/// Roundings of the mean: corners 2, the weighted sum 5, the sum of the weights, its inverse and the
/// product 8, with weights of up to 1.5 times their sum; then as many for the errors' own.
const PLACE_ERROR: f64 = 32.0 * UNIT_ROUNDOFF;

/// Coordinates in this range, and directions, leave no product that overflows, or underflows by more than
/// a rounding of what it is added to.
const PLAIN_RANGE: std::ops::Range<f64> =
    f64::from_bits((1023 - 150) << 52)..f64::from_bits((1023 + 150) << 52);

/// Looks at the rays in some lanes and the corners of their triangles.
#[inline(always)]
pub fn refine<S: Simd>(
    simd: S,
    rays: &RayLanes<S>,
    corners: &[[F64x8<S>; 3]; 3],
    lanes: u32,
) -> Refined {
    let wide = simd.doubles();
    let zero = wide.splat(0.0);

    // The planes alone tell that rays start beyond their triangles, as those do that leave a surface.
    let [a, b, c] = *corners;
    let plane = plane_t(simd, &[rays.origin, rays.direction, a, b, c]);
    let (low, high) = (wide.sub(plane.t, plane.error), wide.add(plane.t, plane.error));
    let is_outside = wide.lt(rays.t_max, low) | wide.lt(high, rays.t_min);
    if lanes & !is_outside == 0 {
        return Refined { hit: 0, missed: is_outside, low: [0.0; LANES], high: [0.0; LANES] };
    }

    // Move the origin to zero, and turn the axes so that the direction goes most along the last.
    let [x, y, z] = rays.direction;
    let size = [wide.abs(x), wide.abs(y), wide.abs(z)];
    let course = turned(simd, &size, rays.direction);
    let inverse = wide.div(wide.splat(1.0), course[2]);
    let slope = [wide.mul(course[0], inverse), wide.mul(course[1], inverse)];
    let (mut depths, mut largest) = ([zero; 3], zero);
    let mut across = [[zero; 2]; 3];
    for corner in 0..3 {
        let mut relative = [zero; 3];
        for axis in 0..3 {
            relative[axis] = wide.sub(corners[corner][axis], rays.origin[axis]);
            largest = wide.max(wide.abs(relative[axis]), largest);
        }
        let [p, q, depth] = turned(simd, &size, relative);
        depths[corner] = depth;
        across[corner] =
            [wide.sub(p, wide.mul(slope[0], depth)), wide.sub(q, wide.mul(slope[1], depth))];
    }

    // Take the edge functions, their least and largest, and the bound on their error.
    let [a, b, c] = across;
    let (u, v, w) = (edge(simd, c, b), edge(simd, a, c), edge(simd, b, a));
    let distance = wide.add(wide.add(length(simd, a), length(simd, b)), length(simd, c));
    let corner_error = wide.mul(largest, wide.splat(CORNER_ERROR));
    let error = wide.mul(corner_error, wide.add(wide.add(corner_error, corner_error), distance));
    let minus_error = wide.sub(zero, error);
    let least = wide.min(wide.min(u, v), w);
    let most = wide.max(wide.max(u, v), w);
    let is_missed = wide.lt(least, minus_error) & wide.lt(error, most);
    let is_crossed = wide.lt(error, least) | wide.lt(most, minus_error);

    // Take the mean of the corners' depths, and t there.
    let sum = wide.add(wide.add(u, v), w);
    let share = wide.div(wide.splat(1.0), sum);
    let mean = wide.add(wide.mul(u, depths[0]), wide.mul(v, depths[1]));
    let mean = wide.mul(wide.add(mean, wide.mul(w, depths[2])), share);
    let nearest = wide.min(wide.min(depths[0], depths[1]), depths[2]);
    let farthest = wide.max(wide.max(depths[0], depths[1]), depths[2]);
    let extent = wide.mul(wide.sub(farthest, nearest), wide.splat(MEAN_ERROR));
    let room = wide.mul(extent, wide.abs(wide.mul(error, share)));
    let room = wide.mul_add(largest, wide.splat(PLACE_ERROR), room);
    let room = wide.mul(room, wide.abs(inverse));
    let at = wide.mul(mean, inverse);
    let unknown = wide.splat(f64::INFINITY);
    let conditioned = wide.mul(error, wide.splat(WELL_CONDITIONED));
    let room = wide.select_lt(conditioned, wide.abs(sum), room, unknown);
    let at = wide.select_lt(room, unknown, at, zero);

    // Where the plane is NaN, the mean is taken.
    let low = wide.max(low, wide.sub(at, room));
    let high = wide.min(high, wide.add(at, room));

    // Which are out of range for certain, and which within it?
    let is_outside = wide.lt(rays.t_max, low) | wide.lt(high, rays.t_min);
    let is_within = wide.lt(rays.t_min, low) & wide.lt(high, rays.t_max);
    let (first, last) = (wide.splat(PLAIN_RANGE.start), wide.splat(PLAIN_RANGE.end));
    let steepness = wide.abs(inverse);
    let is_plain =
        wide.lt(first, wide.min(largest, steepness)) & wide.lt(wide.max(largest, steepness), last);
    let mut look = Refined {
        hit: is_plain & is_crossed & is_within,
        missed: is_plain & (is_missed | is_outside),
        low: [0.0; LANES],
        high: [0.0; LANES],
    };
    wide.store(low, &mut look.low);
    wide.store(high, &mut look.high);
    look
}

/// A vector with its axes turned so that the largest of `size` comes last.
#[inline(always)]
fn turned<S: Simd>(simd: S, size: &[F64x8<S>; 3], [x, y, z]: [F64x8<S>; 3]) -> [F64x8<S>; 3] {
    [
        select_by_size(simd, size, [y, z, x]),
        select_by_size(simd, size, [z, x, y]),
        select_by_size(simd, size, [x, y, z]),
    ]
}

#[inline(always)]
fn edge<S: Simd>(simd: S, p: [F64x8<S>; 2], q: [F64x8<S>; 2]) -> F64x8<S> {
    let wide = simd.doubles();
    wide.sub(wide.mul(p[0], q[1]), wide.mul(p[1], q[0]))
}

#[inline(always)]
fn length<S: Simd>(simd: S, p: [F64x8<S>; 2]) -> F64x8<S> {
    let wide = simd.doubles();
    wide.add(wide.abs(p[0]), wide.abs(p[1]))
}

#[cfg(test)]
mod tests;
