//! Eight triangles at once in single precision: which of them a ray may meet.
//!
//! S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2 (2013): along the
//! ray everything is projected to a plane, and there the origin is on which side of each edge?
//! Different here:
//!
//! 1. The answer is not the verdict. A triangle is passed over only if two of its edge functions
//!    have opposite signs beyond doubt; what remains goes to the exact test. So the result depends
//!    neither on the rounding here nor on whether products are fused, on which instruction sets
//!    differ: every one of them gives the same bits in the end.
//! 2. The ray's point in the projection is computed once in double precision, not for each corner:
//!    four operations a corner instead of seven.
//!
//! `docs/numerics.md` derives the bounds.

use bytemuck::{Pod, Zeroable};

use super::frame::Frame;
use crate::geometry::Ray;
use crate::simd::{Doubles, Simd};

/// Corners of eight triangles, by corner, axis and triangle, in frame coordinates.
pub type CornerLanes = [[[f32; 8]; 3]; 3];

/// Half the distance from 1 to the next single-precision number.
const SINGLE_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

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

/// A ray, ready to be held against blocks of triangles.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct LeafFilter {
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

/// Eight rays, by lane, or a ray, by what is needed of it: the fields of [`LeafFilter`].
pub(crate) type FilterLanes<S> = [<S as Simd>::Floats; 7];

/// Prepares eight rays, with origins in the frame, by axis, for corners whose frame coordinates are at
/// most `reach`, which is at least one half. The same as [`LeafFilter::new`] does for one.
#[inline(always)]
pub(crate) fn leaf_filters<S: Simd>(
    simd: S,
    origin: &[Numbers<S>; 3],
    direction: &[Numbers<S>; 3],
    reach: f64,
) -> FilterLanes<S> {
    // Choose the axis along which to project, and where the line is there.
    let wide = simd.doubles();
    let [a, b, c] = *origin;
    let longest = Longest::of(simd, direction);
    let [x, y, z] = *direction;
    let across = [longest.choose(simd, y, z, x), longest.choose(simd, z, x, y)];
    let start = [longest.choose(simd, b, c, a), longest.choose(simd, c, a, b)];
    let inverse = wide.divided(wide.splat(1.0), longest.choose(simd, x, y, z));
    let depth = longest.choose(simd, a, b, c);
    let slope = [wide.times(across[0], inverse), wide.times(across[1], inverse)];
    let center = [
        wide.minus(start[0], wide.times(slope[0], depth)),
        wide.minus(start[1], wide.times(slope[1], depth)),
    ];

    // Bound the errors of a projected corner, and of a difference of two products.
    let farthest = wide.largest(wide.magnitude(center[0]), wide.magnitude(center[1]));
    let from_origin = wide.largest(wide.magnitude(a), wide.magnitude(b));
    let from_origin = wide.largest(from_origin, wide.magnitude(c));
    let center_error = wide.times(from_origin, wide.splat(CENTER_ERROR));
    let corner_error = wide.multiply_add(
        farthest,
        wide.splat(SINGLE_ROUNDOFF * 2.0),
        wide.plus(center_error, wide.splat(SINGLE_ROUNDOFF * 8.0 * reach)),
    );
    let largest = wide.plus(wide.plus(farthest, corner_error), wide.splat(2.0 * reach));
    let per_distance = wide.multiply_add(largest, wide.splat(SINGLE_ROUNDOFF), corner_error);
    let per_distance = wide.times(per_distance, wide.splat(SLACK));
    let at_least = wide.times(wide.times(corner_error, corner_error), wide.splat(2.0 * SLACK));

    // An infinite bound lets all triangles pass, also where something is NaN.
    let limit = wide.splat(FARTHEST_CENTER);
    let infinite = wide.splat(f64::INFINITY);
    let unbounded = wide.if_below(center_error, limit, wide.splat(0.0), infinite);
    let unbounded = wide.if_below(farthest, limit, unbounded, infinite);
    let (per_distance, at_least) =
        (wide.largest(per_distance, unbounded), wide.largest(at_least, unbounded));
    [
        simd.narrow(longest.axis(simd)),
        simd.narrow(slope[0]),
        simd.narrow(slope[1]),
        simd.narrow(center[0]),
        simd.narrow(center[1]),
        simd.narrow(per_distance),
        simd.narrow(at_least),
    ]
}

/// Eight doubles.
pub(crate) type Numbers<S> = <<S as Simd>::Wide as Doubles>::Numbers;

/// The axes along which eight vectors are longest, as [`LeafFilter`] chooses them.
pub(crate) struct Longest<S: Simd> {
    size: [Numbers<S>; 3],
    larger: [Numbers<S>; 2],
}

impl<S: Simd> Longest<S> {
    /// Of vectors by axis.
    #[inline(always)]
    pub(crate) fn of(simd: S, direction: &[Numbers<S>; 3]) -> Longest<S> {
        let wide = simd.doubles();
        let [x, y, z] = *direction;
        let size = [wide.magnitude(x), wide.magnitude(y), wide.magnitude(z)];
        Longest { size, larger: [wide.largest(size[1], size[2]), size[2]] }
    }

    /// The number of each axis.
    #[inline(always)]
    pub(crate) fn choose(
        &self,
        simd: S,
        of_x: Numbers<S>,
        of_y: Numbers<S>,
        of_z: Numbers<S>,
    ) -> Numbers<S> {
        let wide = simd.doubles();
        let other = wide.if_below(self.larger[1], self.size[1], of_y, of_z);
        wide.if_below(self.larger[0], self.size[0], of_x, other)
    }

    /// The axis in the lowest bits of a single-precision number.
    #[inline(always)]
    fn axis(&self, simd: S) -> Numbers<S> {
        let wide = simd.doubles();
        let [x, y, z] = [wide.splat(UNITS), wide.splat(UNITS + 1.0), wide.splat(UNITS + 2.0)];
        self.choose(simd, x, y, z)
    }
}

/// From here on single-precision numbers have their units in the lowest bit.
pub(crate) const UNITS: f64 = 8_388_608.0;

/// One instruction, other than `f64::max`, which has rules for NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl LeafFilter {
    /// For a valid ray, and corners whose frame coordinates are at most `reach`.
    #[inline]
    pub fn new(ray: &Ray, frame: &Frame, reach: f32) -> LeafFilter {
        let (origin, reach) = (frame.point(ray.origin), f64::from(reach).max(0.5));
        LeafFilter::from_frame(origin.to_array(), ray.direction.to_array(), reach)
    }

    /// The same for an origin in the frame, and a reach of at least one half.
    #[inline(always)]
    fn from_frame(origin: [f64; 3], direction: [f64; 3], reach: f64) -> LeafFilter {
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
        let corner_error = SINGLE_ROUNDOFF * (8.0 * reach + 2.0 * farthest) + center_error;
        let largest = 2.0 * reach + farthest + corner_error;

        // Bound the error of a difference of two products of such coordinates.
        let per_distance = SLACK * (corner_error + SINGLE_ROUNDOFF * largest);
        let at_least = SLACK * 2.0 * corner_error * corner_error;
        let is_usable = (farthest < FARTHEST_CENTER) & (center_error < FARTHEST_CENTER);
        LeafFilter {
            last: if is_x { 0 } else { 2 - u32::from(is_y) },
            slope: [slope[0] as f32, slope[1] as f32],
            center: [center[0] as f32, center[1] as f32],
            // An infinite bound lets all triangles pass.
            error_per_distance: if is_usable { per_distance as f32 } else { f32::INFINITY },
            error_at_least: if is_usable { at_least as f32 } else { f32::INFINITY },
        }
    }

    /// The axes of the projection, that along which is projected last; the slope and the center; the
    /// error for each unit of distance, and the rest of the error.
    #[inline(always)]
    pub fn parts(&self) -> ([usize; 3], [f32; 2], [f32; 2], [f32; 2]) {
        let error = [self.error_per_distance, self.error_at_least];
        (AXES[(self.last & 3) as usize], self.slope, self.center, error)
    }

    /// A bit for each triangle that the line may meet; all others it misses for certain.
    #[inline(always)]
    pub fn candidates(&self, corners: &CornerLanes) -> u32 {
        // Project the corners along the line, which goes to the origin.
        let axes = AXES[(self.last & 3) as usize];
        let mut projected = [[[0.0f32; 8]; 2]; 3];
        for (corner, projected) in corners.iter().zip(&mut projected) {
            let depth = &corner[axes[2]];
            for i in 0..2 {
                let across = &corner[axes[i]];
                for lane in 0..8 {
                    projected[i][lane] =
                        (across[lane] - self.slope[i] * depth[lane]) - self.center[i];
                }
            }
        }

        // Take the edge functions, their least and largest, and the bound on their error.
        let [[ax, ay], [bx, by], [cx, cy]] = &projected;
        let mut missed = [0u32; 8];
        for lane in 0..8 {
            let u = cx[lane] * by[lane] - cy[lane] * bx[lane];
            let v = ax[lane] * cy[lane] - ay[lane] * cx[lane];
            let w = bx[lane] * ay[lane] - by[lane] * ax[lane];
            let distance = (ax[lane].abs() + ay[lane].abs())
                + (bx[lane].abs() + by[lane].abs())
                + (cx[lane].abs() + cy[lane].abs());
            let error = self.error_per_distance * distance + self.error_at_least;
            let least = least(least(u, v), w);
            let largest = largest(largest(u, v), w);
            // False where the bound is infinite or NaN: such triangles stay candidates.
            let is_certain = (least < -error) & (largest > error);
            missed[lane] = if is_certain { 1 << lane } else { 0 };
        }
        !missed.into_iter().fold(0, |bits, bit| bits | bit) & 0xff
    }
}

/// One instruction, other than `f32::min`, which has rules for NaN.
#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn largest(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
