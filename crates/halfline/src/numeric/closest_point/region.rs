//! The first rung: doubles, and what is certain in spite of their rounding.
//!
//! Lengths |x| are the largest component. Bounds are derived in docs/numerics.md, "Closest points".

use super::Region;
use crate::geometry::Vec3;
use crate::numeric::UNIT_ROUNDOFF;

/// Error of a product of two rounded differences a and b, in terms of |a| |b|: three terms, each with two
/// differences, a product and two sums, and the rounding of the bound.
const DOT_ERROR: f64 = 32.0 * UNIT_ROUNDOFF;

/// Error of n·(s × r), in terms of |ab| |ac| |s| |r|: 11 roundings of three terms of four at most, and the
/// rounding of the bound.
const TRIPLE_ERROR: f64 = 256.0 * UNIT_ROUNDOFF;

/// Error of a distance from a corner, in terms of itself.
const CORNER_ERROR: f64 = 8.0 * UNIT_ROUNDOFF;

/// Error of a distance from an edge, in terms of |ap| + |ab|.
const EDGE_ERROR: f64 = 64.0 * UNIT_ROUNDOFF;

/// Error of a distance from a plane, in terms of |ap| |ab| |ac| / |n|.
const PLANE_ERROR: f64 = 128.0 * UNIT_ROUNDOFF;

/// Where |ab| |ac| / |n| is larger than this, the direction of the normal is not known well enough for the bounds.
const MOST_SLENDER: f64 = 1e12;

/// Between these lengths no product or sum of the bounds loses digits to underflow or is infinite.
pub const SHORTEST: f64 = 1e-60;
pub const LONGEST: f64 = 1e60;

/// The largest magnitude of a component.
#[inline(always)]
fn length(v: Vec3) -> f64 {
    v.abs().max_element()
}

/// True if a length allows bounds.
pub fn is_in_range(length: f64) -> bool {
    (SHORTEST..=LONGEST).contains(&length)
}

/// The sign of a product of two vectors, or 0 if rounding leaves it open. Not a number is open, too.
#[inline(always)]
fn certain_sign((a, a_length): (Vec3, f64), (b, b_length): (Vec3, f64)) -> i8 {
    sign_beyond(a.dot(b), DOT_ERROR * (a_length * b_length) + f64::MIN_POSITIVE)
}

#[inline(always)]
fn sign_beyond(value: f64, bound: f64) -> i8 {
    i8::from(value > bound) - i8::from(value < -bound)
}

/// The part of a triangle that holds the point nearest to `p`, if doubles are certain of it.
pub fn certain_region(p: Vec3, [a, b, c]: [Vec3; 3]) -> Option<Region> {
    let sized = |v: Vec3| (v, length(v));
    let (ab, bc, ca) = (sized(b - a), sized(c - b), sized(a - c));
    let (ap, bp, cp) = (sized(p - a), sized(p - b), sized(p - c));
    let along = [certain_sign(ap, ab), certain_sign(bp, bc), certain_sign(cp, ca)];
    let against = [-certain_sign(bp, ab), -certain_sign(cp, bc), -certain_sign(ap, ca)];
    // At corner i the edge i begins and the edge before it ends.
    let is_corner = |corner: usize, (arm, _): (Vec3, f64)| {
        (along[corner] < 0 && against[(corner + 2) % 3] < 0) || arm == Vec3::ZERO
    };
    for (corner, arm) in [ap, bp, cp].into_iter().enumerate() {
        if is_corner(corner, arm) {
            return Some(Region::Corner(corner));
        }
    }
    let normal = ca.0.cross(ab.0);
    let size = ab.1 * ca.1;
    let inwards = |side: (Vec3, f64), arm: (Vec3, f64)| {
        let bound = TRIPLE_ERROR * size * (side.1 * arm.1);
        sign_beyond(normal.dot(side.0.cross(arm.0)), bound + f64::MIN_POSITIVE)
    };
    let inwards = [inwards(ab, ap), inwards(bc, bp), inwards(ca, cp)];
    for edge in 0..3 {
        if along[edge] > 0 && against[edge] > 0 && inwards[edge] < 0 {
            return Some(Region::Edge(edge));
        }
    }
    (inwards == [1; 3]).then_some(Region::Inside)
}

/// Bounds of the distance of `p` from a part that holds the nearest point.
pub fn distance_bounds(p: Vec3, corners: [Vec3; 3], region: Region) -> (f64, f64) {
    const UNKNOWN: (f64, f64) = (0.0, f64::INFINITY);
    let around = |distance: f64, error: f64| ((distance - error).max(0.0), distance + error);
    match region {
        Region::Corner(corner) => {
            let arm = p - corners[corner];
            if arm == Vec3::ZERO {
                return (0.0, 0.0);
            }
            if !is_in_range(length(arm)) {
                return UNKNOWN;
            }
            let distance = arm.length();
            around(distance, CORNER_ERROR * distance)
        }
        Region::Edge(edge) => {
            let (side, arm) = (corners[(edge + 1) % 3] - corners[edge], p - corners[edge]);
            if !(is_in_range(length(side)) && is_in_range(length(arm))) {
                return UNKNOWN;
            }
            let t = arm.dot(side) / side.dot(side);
            around((arm - side * t).length(), EDGE_ERROR * (length(arm) + length(side)))
        }
        Region::Inside => {
            let [a, b, c] = corners;
            let (ab, ac, arm) = (b - a, c - a, p - a);
            if ![ab, ac, arm].into_iter().all(|vector| is_in_range(length(vector))) {
                return UNKNOWN;
            }
            let normal = ab.cross(ac);
            let size = normal.length();
            let slenderness = length(ab) * length(ac) / size;
            // Not a number neither.
            if slenderness < MOST_SLENDER {
                let distance = normal.dot(arm).abs() / size;
                around(distance, PLANE_ERROR * slenderness * length(arm))
            } else {
                UNKNOWN
            }
        }
    }
}
