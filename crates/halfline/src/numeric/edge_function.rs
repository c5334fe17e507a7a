//! On which side of an edge a line passes: the sign of a determinant, exactly.
//!
//! The filter is that of Shewchuk's `orient3d` (1997, section 4.3): the determinant in doubles,
//! and an error bound from its permanent. Only where the bound leaves the sign open is it computed
//! exactly, from the coordinates as given. Different here: the bound covers underflow as well.

use super::double_double::UNIT_ROUNDOFF;
use super::exact::{BigFloat, DigitRange, ExactNumber, Expansion};
use crate::geometry::Vec3;

/// Bound on the relative error, in terms of the permanent, of a 3 x 3 determinant whose rows are
/// rounded differences: `errboundA` of `orient3d`. There all three rows are differences, here two.
const DETERMINANT_ERROR: f64 = (7.0 + 56.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

/// What underflow may do to an edge function, for directions whose components are below 2^501: a
/// product of coordinates loses up to 2^-1075, and the permanent may be too small by as much. Six of
/// them, times the direction, are off by less than 2^-571; the products with the direction lose no
/// more than 3 * 2^-1075.
const UNDERFLOW_ERROR: f64 = f64::from_bits((1023 - 570) << 52);

/// A value and how far it may be from the truth.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    /// The computed value.
    pub value: f64,
    /// The exact value differs from it by at most this. Where something overflowed, this or the
    /// value is infinite or NaN, and no sign is certain.
    pub error: f64,
}

impl Bounded {
    /// -1 or 1 where the sign is certain.
    #[inline(always)]
    pub fn certain_sign(&self) -> Option<i8> {
        if self.value > self.error {
            Some(1)
        } else if self.value < -self.error {
            Some(-1)
        } else {
            None
        }
    }
}

/// The edge function of the edge from p to q for the line through the origin along `direction`:
/// `direction . (p x q)`, for corners given relative to the line's origin, and a direction below
/// 2^501.
///
/// Swapping p and q changes the sign and nothing else, so two triangles that share an edge see
/// the same number.
#[inline(always)]
pub fn edge_function(direction: Vec3, p: Vec3, q: Vec3) -> Bounded {
    let (yz, zy) = (p.y * q.z, p.z * q.y);
    let (zx, xz) = (p.z * q.x, p.x * q.z);
    let (xy, yx) = (p.x * q.y, p.y * q.x);
    let value = direction.x * (yz - zy) + direction.y * (zx - xz) + direction.z * (xy - yx);
    let permanent = direction.x.abs() * (yz.abs() + zy.abs())
        + direction.y.abs() * (zx.abs() + xz.abs())
        + direction.z.abs() * (xy.abs() + yx.abs());
    Bounded { value, error: DETERMINANT_ERROR * permanent + UNDERFLOW_ERROR }
}

/// The exact edge function, as [`edge_function`] bounds it, from the corners and the origin as given.
pub fn exact_edge_function<N: ExactNumber>(origin: Vec3, direction: Vec3, p: Vec3, q: Vec3) -> N {
    let from_origin = |corner: Vec3, axis: usize| N::difference(corner[axis], origin[axis]);
    let mut sum = N::default();
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let minor = from_origin(p, next)
            .times(&from_origin(q, last))
            .minus(&from_origin(p, last).times(&from_origin(q, next)));
        sum = sum.plus(&minor.scaled(direction[axis]));
    }
    sum
}

/// The sign of the edge function, exactly.
#[cold]
pub fn exact_edge_sign(origin: Vec3, direction: Vec3, p: Vec3, q: Vec3) -> i8 {
    if is_plainly_zero(direction, p - origin, q - origin) {
        return 0;
    }
    let digits = DigitRange::of(&[origin, p, q]);
    if DigitRange::suits_expansions(digits, DigitRange::of(&[direction])) {
        exact_edge_function::<Expansion>(origin, direction, p, q).sign()
    } else {
        exact_edge_function::<BigFloat>(origin, direction, p, q).sign()
    }
}

/// True if each product in the edge function has a factor of zero, as is common where rays and edges
/// are parallel to axes. A difference is zero only if it is so exactly.
fn is_plainly_zero(direction: Vec3, p: Vec3, q: Vec3) -> bool {
    (0..3).all(|axis| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let is_zero = |i: usize, j: usize| p[i] == 0.0 || q[j] == 0.0;
        direction[axis] == 0.0 || (is_zero(next, last) && is_zero(last, next))
    })
}

/// To which side of an edge that meets the line exactly the line goes when its origin is moved by
/// the infinitesimal (e, e^2, e^3): the sign of the first component of `(p - q) x direction` that
/// is not zero; 0 only for an edge parallel to the line.
///
/// H. Edelsbrunner, E. P. Muecke, "Simulation of Simplicity", ACM TOG 9 (1990). For a camera it is
/// the rasteriser's top-left rule; but it holds for every direction and at vertices as well: the
/// moved line meets no edge, hence crosses each triangle in its inside or not at all.
#[cold]
pub fn perturbed_sign(direction: Vec3, p: Vec3, q: Vec3) -> i8 {
    let suits = DigitRange::suits_expansions(DigitRange::of(&[p, q]), DigitRange::of(&[direction]));
    (0..3)
        .map(|axis| {
            if suits {
                moved::<Expansion>(direction, p, q, axis)
            } else {
                moved::<BigFloat>(direction, p, q, axis)
            }
        })
        .find(|&sign| sign != 0)
        .unwrap_or(0)
}

/// The sign of one component of `(p - q) x direction`.
fn moved<N: ExactNumber>(direction: Vec3, p: Vec3, q: Vec3, axis: usize) -> i8 {
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    N::difference(p[next], q[next])
        .scaled(direction[last])
        .minus(&N::difference(p[last], q[last]).scaled(direction[next]))
        .sign()
}

/// From which side a line meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orientation {
    /// The corners run counter-clockwise for someone who looks along the direction.
    Front,
    /// The corners run clockwise for someone who looks along the direction.
    Back,
}
