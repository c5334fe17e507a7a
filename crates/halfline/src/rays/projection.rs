//! The projection of triangles along a ray, for one ray and for eight.
//!
//! S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2 (2013): along the axis that the
//! ray follows most, everything is projected to a plane, and there the origin is on which side of each edge?
//!
//! Different here:
//! 1. The answer is not the verdict: each edge function comes with a bound on its error, and what that leaves
//!    open is decided exactly (see [`intersect`](crate::intersect)).
//! 2. The ray's point in the projection is computed once in double precision, not for each corner: four
//!    operations a corner instead of seven.
//!
//! `docs/numerics.md` derives the bounds.

use bytemuck::{Pod, Zeroable};

use crate::geometry::Ray;
use crate::numeric::{F32_ROUNDOFF, Frame};
use crate::simd::{F64x8, Simd, SimdF64};

/// Room for what the bounds leave out: products of two errors, and the roundings in computing the
/// bounds themselves. Both are below 2^-20 of them.
const SLACK: f64 = 1.0 + 1.0 / 1024.0;

/// Error of the ray's point in the projection, in terms of the origin's largest coordinate: two
/// coordinates rounded by the frame, one of them times the slope, which is rounded, a product and
/// a difference: six roundings of doubles, each of less than twice that coordinate, and at least
/// a third more to spare.
const CENTER_ERROR: f64 = 8.0 * f64::EPSILON;

/// Beyond this a ray's point in the projection is so far from all corners, which are of size one,
/// that single precision could overflow.
const FARTHEST_CENTER: f64 = 1e9;

/// Each axis as the last of three, and once more, so that two bits have an entry.
const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

/// The axes of a projection along the axis in the lowest two bits, that one last.
#[inline(always)]
pub fn projection_axes(last: u32) -> [usize; 3] {
    AXES[(last & 3) as usize]
}

/// How triangles are projected along one ray, with a bound on what rounding does there.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Projection {
    /// The axis of the direction's largest component, in the lowest two bits.
    last: u32,
    /// How far a step along the last axis goes along the other two.
    slope: [f32; 2],
    /// Where the line meets the plane through the frame's origin across the last axis.
    center: [f32; 2],
    /// Bound on the error of an edge function, for each unit of the corners' distances from the line
    /// (sums of two coordinates, all corners together).
    error_per_distance: f32,
    /// The rest of the bound.
    error_at_least: f32,
}

/// One instruction, other than `f64::max`, which has rules for NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl Projection {
    /// For a valid ray, and corners whose frame coordinates are at most `reach`.
    #[inline]
    pub fn new(ray: &Ray, frame: &Frame, reach: f32) -> Projection {
        let (origin, reach) = (frame.point(ray.origin), f64::from(reach).max(0.5));
        Projection::from_frame(origin.to_array(), ray.direction.to_array(), reach)
    }

    /// The projection for an origin in the frame, and a reach of at least one half.
    #[inline(always)]
    fn from_frame(origin: [f64; 3], direction: [f64; 3], reach: f64) -> Projection {
        // Choose the axis along which to project, and where the line is there.
        let [x, y, z] = direction;
        let [a, b, c] = origin;
        let is_x = (x.abs() > y.abs()) & (x.abs() > z.abs());
        let is_y = !is_x & (y.abs() > z.abs());
        let choose = |of_x: f64, of_y: f64, of_z: f64| {
            let other = if is_y { of_y } else { of_z };
            if is_x { of_x } else { other }
        };
        let across = [choose(y, z, x), choose(z, x, y)];
        let start = [choose(b, c, a), choose(c, a, b)];
        let inverse = 1.0 / choose(x, y, z);
        let depth = choose(a, b, c);
        let slope = [across[0] * inverse, across[1] * inverse];
        let center = [start[0] - slope[0] * depth, start[1] - slope[1] * depth];

        // Bound the error of a projected corner: a corner is rounded to single precision, and so
        // are the slope, its product with a coordinate, a difference of up to twice the reach,
        // the center, and a difference of all that.
        let farthest = larger(center[0].abs(), center[1].abs());
        let from_origin = larger(larger(a.abs(), b.abs()), c.abs());
        let center_error = CENTER_ERROR * from_origin;
        let corner_error = F32_ROUNDOFF * (8.0 * reach + 2.0 * farthest) + center_error;
        let largest = 2.0 * reach + farthest + corner_error;

        // Bound the error of a difference of two products of such coordinates.
        let per_distance = SLACK * (corner_error + F32_ROUNDOFF * largest);
        let at_least = SLACK * 2.0 * corner_error * corner_error;
        let is_usable = (farthest < FARTHEST_CENTER) & (center_error < FARTHEST_CENTER);
        Projection {
            last: if is_x { 0 } else { 2 - u32::from(is_y) },
            slope: [slope[0] as f32, slope[1] as f32],
            center: [center[0] as f32, center[1] as f32],
            // An infinite bound lets all triangles pass.
            error_per_distance: if is_usable { per_distance as f32 } else { f32::INFINITY },
            error_at_least: if is_usable { at_least as f32 } else { f32::INFINITY },
        }
    }

    /// The axes of the projection, that along which is projected last.
    #[inline(always)]
    pub fn axes(&self) -> [usize; 3] {
        projection_axes(self.last)
    }
}

/// The projections of eight rays: the fields of [`Projection`], each for all of them.
pub type Projections<S> = [<S as Simd>::F32x8; 7];

/// Prepares eight rays, with origins in the frame, of which `from_origin` is the largest coordinate, for
/// corners whose frame coordinates are at most `reach`. As [`Projection::new`] does for one, but that
/// bounds are in single precision.
#[inline(always)]
pub fn project_octet<S: Simd>(
    simd: S,
    longest: &Longest<S>,
    origin: &[F64x8<S>; 3],
    direction: &[F64x8<S>; 3],
    from_origin: S::F32x8,
    reach: f32,
) -> Projections<S> {
    // Choose the axis along which to project, and where the line is there.
    let wide = simd.doubles();
    let ([a, b, c], [x, y, z]) = (*origin, *direction);
    let across = [longest.select_f64(simd, y, z, x), longest.select_f64(simd, z, x, y)];
    let start = [longest.select_f64(simd, b, c, a), longest.select_f64(simd, c, a, b)];
    let inverse = wide.div(wide.splat(1.0), longest.select_f64(simd, x, y, z));
    let depth = longest.select_f64(simd, a, b, c);
    let slope = [wide.mul(across[0], inverse), wide.mul(across[1], inverse)];
    let center = [
        simd.narrow(wide.sub(start[0], wide.mul(slope[0], depth))),
        simd.narrow(wide.sub(start[1], wide.mul(slope[1], depth))),
    ];

    // Bound the errors of a projected corner, and of a difference of two products.
    let (u, reach) = (F32_ROUNDOFF as f32, reach.max(0.5));
    let farthest = simd.max(simd.abs(center[0]), simd.abs(center[1]));
    let center_error = simd.mul(from_origin, simd.splat(CENTER_ERROR as f32));
    let fixed_error = simd.add(center_error, simd.splat(8.0 * u * reach));
    let corner_error = simd.mul_add(farthest, simd.splat(2.0 * u), fixed_error);
    let largest = simd.add(simd.add(farthest, corner_error), simd.splat(2.0 * reach));
    let per_distance = simd.mul_add(largest, simd.splat(u), corner_error);
    let per_distance = simd.mul(per_distance, simd.splat(SLACK as f32));
    let twice = simd.mul(corner_error, simd.splat(2.0 * SLACK as f32));
    let at_least = simd.mul(corner_error, twice);

    // An infinite bound lets all triangles pass, also where something is NaN.
    let limit = simd.splat(FARTHEST_CENTER as f32);
    let infinite = simd.splat(f32::INFINITY);
    let unbounded = simd.select_lt(center_error, limit, simd.splat(0.0), infinite);
    let unbounded = simd.select_lt(farthest, limit, unbounded, infinite);
    [
        longest.axis(simd),
        simd.narrow(slope[0]),
        simd.narrow(slope[1]),
        center[0],
        center[1],
        simd.max(per_distance, unbounded),
        simd.max(at_least, unbounded),
    ]
}

/// The axes along which eight vectors are longest.
pub struct Longest<S: Simd> {
    size: [S::F32x8; 3],
    larger: [S::F32x8; 2],
    wide_size: [F64x8<S>; 3],
}

impl<S: Simd> Longest<S> {
    /// Of vectors, given by the magnitudes of their components.
    #[inline(always)]
    pub fn of(simd: S, size: [S::F32x8; 3]) -> Longest<S> {
        let larger = [simd.max(size[1], size[2]), size[2]];
        let wide_size = [simd.widen(size[0]), simd.widen(size[1]), simd.widen(size[2])];
        Longest { size, larger, wide_size }
    }

    /// What belongs to the axis of each.
    #[inline(always)]
    pub fn select(&self, simd: S, of_x: S::F32x8, of_y: S::F32x8, of_z: S::F32x8) -> S::F32x8 {
        let other = simd.select_lt(self.larger[1], self.size[1], of_y, of_z);
        simd.select_lt(self.larger[0], self.size[0], of_x, other)
    }

    /// The same in double precision.
    #[inline(always)]
    fn select_f64(&self, simd: S, of_x: F64x8<S>, of_y: F64x8<S>, of_z: F64x8<S>) -> F64x8<S> {
        select_by_size(simd, &self.wide_size, [of_x, of_y, of_z])
    }

    /// The axis in the lowest bits of a single-precision number.
    #[inline(always)]
    fn axis(&self, simd: S) -> S::F32x8 {
        let [x, y, z] = [simd.splat(UNITS), simd.splat(UNITS + 1.0), simd.splat(UNITS + 2.0)];
        self.select(simd, x, y, z)
    }
}

/// What belongs to the axis along which each of eight vectors is longest, by the magnitudes of their
/// components.
#[inline(always)]
pub fn select_by_size<S: Simd>(
    simd: S,
    size: &[F64x8<S>; 3],
    [of_x, of_y, of_z]: [F64x8<S>; 3],
) -> F64x8<S> {
    let wide = simd.doubles();
    let other = wide.select_lt(size[2], size[1], of_y, of_z);
    wide.select_lt(wide.max(size[1], size[2]), size[0], of_x, other)
}

/// From here on single-precision numbers have their units in the lowest bit.
pub const UNITS: f32 = 8_388_608.0;
