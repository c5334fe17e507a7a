//! Eight triangles at once: how far away is each, at least and at most?
//!
//! ```text
//! q := the nearest to p of: the feet on three edges, clamped to them; the foot on the plane, by weights that are
//!      clamped to what is not negative
//! at most   |q - p|                                    since q lies in the triangle
//! at least  min over the corners c of (c - p)·(q - p) / |q - p|
//! ```
//!
//! No region is asked for, and no branch depends on one. The lower bound is the distance to the plane through the
//! nearest corner across q - p, beyond which the whole triangle lies: the duality gap of M. Frank, P. Wolfe, "An
//! Algorithm for Quadratic Programming", 1956. So it holds whatever q is, also where weights are ill-conditioned, and
//! both bounds are close together where q is near the nearest point.
//!
//! Rounding: with X no longer than R, for all that is computed of corners X - p, each coordinate is off by 2 u R and the
//! slack (`point_in_frame.rs`), q by 8 u R more, products by 4 u R, quotient and root by 6 u R; vectors are twice that
//! at most. R is no larger than |q - p| and the longest edge together; [`LEAF_ERROR`] is 64 u.

use super::point_in_frame::{PointInFrame, SMALLEST};
use crate::simd::Simd;
use crate::tree::LeafBlock;

/// Error of the bounds, in terms of the distance and the longest edge.
const LEAF_ERROR: f32 = 32.0 * f32::EPSILON;

/// Where the weights of the foot on the plane sum to less, digits of them may be lost.
const SMALLEST_SUM: f32 = 1e-30;

type Vector<S> = [<S as Simd>::F32x8; 3];

#[inline(always)]
fn minus<S: Simd>(simd: S, a: &Vector<S>, b: &Vector<S>) -> Vector<S> {
    [simd.sub(a[0], b[0]), simd.sub(a[1], b[1]), simd.sub(a[2], b[2])]
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: &Vector<S>, b: &Vector<S>) -> S::F32x8 {
    simd.mul_add(a[0], b[0], simd.mul_add(a[1], b[1], simd.mul(a[2], b[2])))
}

#[inline(always)]
fn cross<S: Simd>(simd: S, a: &Vector<S>, b: &Vector<S>) -> Vector<S> {
    [
        simd.neg_mul_add(a[2], b[1], simd.mul(a[1], b[2])),
        simd.neg_mul_add(a[0], b[2], simd.mul(a[2], b[0])),
        simd.neg_mul_add(a[1], b[0], simd.mul(a[0], b[1])),
    ]
}

/// A point of a triangle, and the square of its distance.
#[derive(Clone, Copy)]
struct Foot<S: Simd> {
    at: Vector<S>,
    square: S::F32x8,
}

impl<S: Simd> Foot<S> {
    #[inline(always)]
    fn new(simd: S, at: Vector<S>) -> Foot<S> {
        Foot { at, square: dot(simd, &at, &at) }
    }

    /// That on an edge from `a`, and the square of the edge's length.
    #[inline(always)]
    fn on_edge(simd: S, a: &Vector<S>, ab: &Vector<S>) -> (Foot<S>, S::F32x8) {
        let length = dot(simd, ab, ab);
        // Not a number becomes an end.
        let back = simd.min(simd.div(dot(simd, a, ab), length), simd.splat(0.0));
        let back = simd.max(back, simd.splat(-1.0));
        let at = [
            simd.neg_mul_add(back, ab[0], a[0]),
            simd.neg_mul_add(back, ab[1], a[1]),
            simd.neg_mul_add(back, ab[2], a[2]),
        ];
        (Foot::new(simd, at), length)
    }

    /// The nearer; the other if this is not a number.
    #[inline(always)]
    fn or_nearer(self, simd: S, other: Foot<S>) -> Foot<S> {
        let choose = |x: S::F32x8, y: S::F32x8| simd.select_lt(self.square, other.square, x, y);
        Foot {
            at: [
                choose(self.at[0], other.at[0]),
                choose(self.at[1], other.at[1]),
                choose(self.at[2], other.at[2]),
            ],
            square: choose(self.square, other.square),
        }
    }
}

/// Bounds of the distance of each triangle, in the frame.
#[inline(always)]
pub fn distance_bounds<S: Simd>(simd: S, point: &PointInFrame, block: &LeafBlock) -> [S::F32x8; 2] {
    // Take all relative to the point.
    let mut corners = [[simd.splat(0.0); 3]; 3];
    for corner in 0..3 {
        for axis in 0..3 {
            let x = simd.load(&block.corners[corner][axis]);
            let apart = simd.sub(x, simd.splat(point.near[axis]));
            corners[corner][axis] = simd.sub(apart, simd.splat(point.rest[axis]));
        }
    }
    let [a, b, c] = &corners;
    let (ab, bc, ca) = (minus(simd, b, a), minus(simd, c, b), minus(simd, a, c));

    // Find the feet on the edges.
    let (on_ab, ab_square) = Foot::on_edge(simd, a, &ab);
    let (on_bc, bc_square) = Foot::on_edge(simd, b, &bc);
    let (on_ca, ca_square) = Foot::on_edge(simd, c, &ca);
    let on_edges = on_ab.or_nearer(simd, on_bc).or_nearer(simd, on_ca);

    // Find the foot on the plane.
    let zero = simd.splat(0.0);
    let normal = cross(simd, &ca, &ab);
    let weigh = |of: &Vector<S>, along: &Vector<S>| {
        simd.max(dot(simd, &normal, &cross(simd, of, along)), zero)
    };
    let (of_a, of_b, of_c) = (weigh(b, &bc), weigh(c, &ca), weigh(a, &ab));
    let sum = simd.add(simd.add(of_a, of_b), of_c);
    let inverse = simd.div(simd.splat(1.0), sum);
    let mut at = [zero; 3];
    for axis in 0..3 {
        let weighted =
            simd.mul_add(of_a, a[axis], simd.mul_add(of_b, b[axis], simd.mul(of_c, c[axis])));
        at[axis] = simd.mul(weighted, inverse);
    }
    let mut on_plane = Foot::new(simd, at);
    let (smallest, infinite) = (simd.splat(SMALLEST_SUM), simd.splat(f32::INFINITY));
    on_plane.square = simd.select_lt(smallest, sum, on_plane.square, infinite);
    let foot = on_plane.or_nearer(simd, on_edges);

    // Bound the distance.
    let along = |corner: &Vector<S>| dot(simd, &foot.at, corner);
    let nearest = simd.min(simd.min(along(a), along(b)), along(c));
    let distance = simd.sqrt(foot.square);
    let longest = simd.sqrt(simd.max(simd.max(ab_square, bc_square), ca_square));
    let error =
        simd.mul_add(simd.splat(LEAF_ERROR), simd.add(distance, longest), simd.splat(point.slack));
    let least = simd.div(nearest, simd.max(distance, simd.splat(SMALLEST)));
    [simd.max(simd.sub(least, error), zero), simd.add(distance, error)]
}
