//! On which side of a triangle's plane a point lies, to which side a direction goes, and whether a triangle
//! holds a point: exactly.
//!
//! Signs of determinants as in `edge_function.rs`; rounded values answer nearly always.

use super::double_double::UNIT_ROUNDOFF;
use super::edge_function::{edge_function, exact_edge_sign};
use super::exact::{BigFloat, ExactNumber};
use super::ray_triangle::PreparedRay;
use crate::geometry::{Ray, Vec3};

/// The sign of `direction . normal`, where the normal is `(b - a) x (c - a)`: 1 if a line along `direction`
/// leaves a solid through the triangle that is its surface. 0 if it is parallel to the triangle. The corners
/// are finite, and the direction below 2^501.
#[inline]
pub fn facing_sign(direction: Vec3, [a, b, c]: [Vec3; 3]) -> i8 {
    let product = edge_function(direction, b - a, c - a);
    product.certain_sign().unwrap_or_else(|| exact_edge_sign(a, direction, b, c))
}

/// The sign of `(point - a) . normal`: 1 above the triangle, where its corners are seen to run counter-clockwise;
/// 0 in its plane. All coordinates are finite.
pub fn plane_side(point: Vec3, [a, b, c]: [Vec3; 3]) -> i8 {
    // The bound is that of `orient3d`, with room for underflow of moderate coordinates; overflow is certain of
    // nothing.
    let (p, q, r) = (b - a, c - a, point - a);
    let minor =
        |i: usize, j: usize| (p[i] * q[j] - p[j] * q[i], (p[i] * q[j]).abs() + (p[j] * q[i]).abs());
    let (mut value, mut permanent) = (0.0, 0.0);
    for (axis, (product, magnitude)) in
        [minor(1, 2), minor(2, 0), minor(0, 1)].into_iter().enumerate()
    {
        value += r[axis] * product;
        permanent += r[axis].abs() * magnitude;
    }
    if permanent > SAFE_PERMANENT && value.abs() > PLANE_ERROR * permanent {
        return if value > 0.0 { 1 } else { -1 };
    }
    exact_plane_side(point, [a, b, c])
}

/// Relative error of a 3 x 3 determinant of rounded differences, in terms of its permanent: `errboundA` of
/// Shewchuk's `orient3d`, (7 + 56 u) u, rounded up.
const PLANE_ERROR: f64 = 8.0 * UNIT_ROUNDOFF;

/// Permanents of which an underflow, of less than 2^-1070 times a coordinate below 2^400, is no part worth a
/// roundoff.
const SAFE_PERMANENT: f64 = f64::from_bits((1023 - 600) << 52);

#[cold]
fn exact_plane_side(point: Vec3, [a, b, c]: [Vec3; 3]) -> i8 {
    let from_a = |corner: Vec3, axis: usize| BigFloat::difference(corner[axis], a[axis]);
    let mut sum = BigFloat::default();
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let minor =
            from_a(b, next).times(&from_a(c, last)).minus(&from_a(b, last).times(&from_a(c, next)));
        sum = sum.plus(&minor.times(&from_a(point, axis)));
    }
    sum.sign()
}

/// True if the closed triangle holds the point. One whose corners lie on one line, or are not finite, holds none.
pub fn holds_point(corners: [Vec3; 3], point: Vec3) -> bool {
    let is_finite = corners.iter().all(|corner| corner.is_finite()) && point.is_finite();
    if !is_finite || plane_side(point, corners) != 0 {
        return false;
    }
    // A line through the point across the plane meets the plane nowhere else.
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vec3::from);
    let across = axes.into_iter().find(|axis| facing_sign(*axis, corners) != 0);
    across
        .and_then(|axis| PreparedRay::new(&Ray::new(point, axis)))
        .is_some_and(|line| line.meet_line(corners).is_some())
}
