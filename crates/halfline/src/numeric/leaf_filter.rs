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

/// Corners of eight triangles, by corner, axis and triangle, in frame coordinates.
pub type CornerLanes = [[[f32; 8]; 3]; 3];

/// Half the distance from 1 to the next single-precision number.
pub const SINGLE_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

/// Room for what the bounds leave out: products of two errors, and the roundings in computing the
/// bounds themselves. Both are below 2^-20 of them.
pub const SLACK: f64 = 1.0 + 1.0 / 1024.0;

/// Error of the ray's point in the projection, in terms of the origin's largest coordinate: two
/// coordinates rounded by the frame, one of them times the slope, which is rounded, a product and
/// a difference: six roundings of doubles, each of less than twice that coordinate, and at least
/// a third more to spare.
pub const CENTER_ERROR: f64 = 8.0 * f64::EPSILON;

/// Beyond this a ray's point in the projection is so far from all corners, which are of size one,
/// that single precision could overflow.
pub const FARTHEST_CENTER: f64 = 1e9;

/// Each axis as the last of three, and once more, so that two bits have an entry.
const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

/// The axes of a projection along the axis in the lowest two bits, that one last.
#[inline(always)]
pub fn projection_axes(last: u32) -> [usize; 3] {
    AXES[(last & 3) as usize]
}

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
        (projection_axes(self.last), self.slope, self.center, error)
    }

    /// A bit for each triangle that the line may meet; all others it misses for certain.
    #[inline(always)]
    pub fn candidates(&self, corners: &CornerLanes) -> u32 {
        // Project the corners along the line, which goes to the origin.
        let axes = projection_axes(self.last);
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
