//! The solid angle of the spherical triangle (-d, a - p, b - p) of an edge a, b seen from a point p, for one fixed
//! direction d: within a bound, and on the right side of its branch cut.
//!
//! Martens, Trettner, Bessmeltsev, "The Antipodal Method for the Generalized Winding Number" (SIGGRAPH
//! 2026) sum these angles over the edges of a boundary; A. van Oosterom, J. Strackee, "The Solid Angle of a
//! Plane Triangle" (1983) give the tangent of half of one. Different here:
//!
//! 1. In coordinates (x, y, z) with z along d, and with q = |a| - z, the half angle is minus the argument of
//!    `conj(x_a + i y_a) (x_b + i y_b) + q_a q_b`, whose bound is a few operations.
//! 2. The frame is a rotation whose entries are integers times a power of two: it is exact.
//! 3. Arguments are added by multiplying the numbers and counting how often the product goes around, so that
//!    one arc tangent is enough for all edges.
//! 4. Where the bound is too large, near the branch cut above all, the sum is computed exactly but for a square
//!    root to [`ROOT_STEPS`] times 50 digits. Where p, seen along d, lies on the edge, it is moved by the
//!    infinitesimal of [`perturbed_sign`], as lines are that cross triangles: so the angle takes that side of
//!    the cut which the crossings took.

use super::double_double::UNIT_ROUNDOFF;
use super::edge_function::{exact_edge_sign, perturbed_sign};
use super::exact::{BigFloat, ExactNumber};
use super::power_of_two::{exponent_of, two_powers};
use crate::geometry::{Vec3, vec3};

/// The rows of the frame, the last of them the direction d: the integer matrix of the rotation by the quaternion
/// (13499789, 629219, -7948565, -14629049), times 2^-46. So they are exactly at right angles and of the same
/// length, [`FRAME_LENGTH`]. The integers are large, and no axis, diagonal or small grid is along d.
pub const FRAME: [Vec3; 3] = [
    vec3(-94548540609144.0 * UNIT, 384975373299852.0 * UNIT, -233017651871032.0 * UNIT),
    vec3(-404980925782792.0 * UNIT, 31018997409384.0 * UNIT, 215571246259788.0 * UNIT),
    WINDING_DIRECTION,
];

/// The direction d, along which crossings are counted: 6.5 long, so that t does not overflow before coordinates do.
pub const WINDING_DIRECTION: Vec3 =
    vec3(196198149540108.0 * UNIT, 249548541198952.0 * UNIT, 332677775579736.0 * UNIT);

/// How long the rows of [`FRAME`] are.
pub const FRAME_LENGTH: f64 = 459828979798108.0 * UNIT;

const UNIT: f64 = 1.0 / (1_u64 << 46) as f64;

/// What is computed of a sum, in terms of `L_a s_b + L_b s_a`, where L is a length in the frame and s = |x| +
/// |y| + q: a coordinate is off by 4 u L (a difference, a product and two sums), L by 8 u L, and q by less than
/// 16 u L. A product of coordinates so is off by 6 u (L_a s_b + L_b s_a) at most, that of the q by 16 u, and
/// roundings of products and sums by 4 u: less than 26 u, and the rest for second-order terms.
const SUM_ERROR: f64 = 32.0 * UNIT_ROUNDOFF;

/// Solid angles that are computed more exactly than in doubles are off by less than this.
pub const TERM_ERROR: f64 = 1.0 / (1_u64 << 40) as f64;

/// The largest error of a solid angle in doubles with which [`edge_sum`] may be asked to put up.
pub const LARGEST_TERM_ERROR: f64 = 1.0 / (1_u64 << 30) as f64;

/// An angle is off by no more than the arc sine of the sum's relative error, and the solid angle by twice that; its
/// relative error is at most [`LARGEST_TERM_ERROR`], so this covers arc sine, arc tangent, and the six roundings of a product
/// of two sums, since the error is at least 32 u.
const ANGLE_PER_ERROR: f64 = 2.5;

/// Lengths in the frame of which no product of four underflows or overflows.
const SAFE_LENGTH: std::ops::Range<f64> =
    f64::from_bits((1023 - 200) << 52)..f64::from_bits((1023 + 200) << 52);

/// A vertex as it is seen from a point, in the frame.
#[derive(Clone, Copy, Debug)]
pub struct SeenVertex {
    x: f64,
    y: f64,
    /// |a| - z, never negative.
    q: f64,
    length: f64,
    size: f64,
}

impl SeenVertex {
    /// `from_point` is the vertex less the point, rounded once, and maybe times a power of two.
    #[inline(always)]
    pub fn new(from_point: Vec3) -> SeenVertex {
        let [x, y, z] = FRAME.map(|row| row.dot(from_point));
        let length = (x * x + y * y + z * z).sqrt();
        let q = length - z;
        SeenVertex { x, y, q, length, size: x.abs() + y.abs() + q }
    }
}

/// Of an edge the number whose argument, times two, is the solid angle, and how far that may be off; `None` if it may
/// be off by more than `limit`, which is at most [`LARGEST_TERM_ERROR`], or is too near to the branch cut.
#[inline(always)]
pub fn edge_sum(a: &SeenVertex, b: &SeenVertex, limit: f64) -> Option<([f64; 2], f64)> {
    let re = a.x * b.x + a.y * b.y + a.q * b.q;
    let im = a.y * b.x - a.x * b.y;
    let error = SUM_ERROR * (a.length * b.size + b.length * a.size);
    let is_safe = SAFE_LENGTH.contains(&a.length) & SAFE_LENGTH.contains(&b.length);
    // NaN is certain of nothing.
    let angle_error = ANGLE_PER_ERROR * error / re.abs().max(im.abs());
    let is_off_cut = (re > 0.0) | (im.abs() > error);
    (is_safe & (angle_error <= limit) & is_off_cut).then_some(([re, im], angle_error))
}

/// The sum of the arguments of numbers, as their product and a count of turns.
#[derive(Clone, Copy, Debug)]
pub struct AngleProduct {
    re: f64,
    im: f64,
    turns: i32,
}

impl AngleProduct {
    /// Of no numbers.
    pub const ONE: AngleProduct = AngleProduct { re: 1.0, im: 0.0, turns: 0 };

    /// Takes a number off the negative axis, of which no square overflows or underflows.
    #[inline(always)]
    pub fn multiply(&mut self, [re, im]: [f64; 2]) {
        let AngleProduct { re: p, im: q, turns } = *self;
        let (new_re, new_im) = (p * re - q * im, p * im + q * re);

        // Arguments lie in (-pi, pi]. Where both numbers lie above the axis, theirs sum to more than pi if the
        // product lies below, or if both lie to the left and the product to the right: then the sum is near to
        // two pi, and the product on either side of the axis by a rounding. Below it is the same; but there the
        // product of two numbers to the right is never above. Where one lies above and one below, nothing
        // cancels near to the negative axis.
        let (is_above, is_below) = ((q >= 0.0) & (im >= 0.0), (q < 0.0) & (im < 0.0));
        let is_around = (p < 0.0) & (re < 0.0) & (new_re > 0.0);
        let is_right = (p > 0.0) & (re > 0.0);
        let up = is_above & ((new_im < 0.0) | is_around);
        let down = is_below & !is_right & ((new_im >= 0.0) | is_around);

        // Bring the product back to a size of about one; no bit of it changes.
        let largest = new_re.abs().max(new_im.abs());
        let exponent = (largest.to_bits() >> 52).clamp(100, 1946);
        let factor = f64::from_bits((2046 - exponent) << 52);
        *self = AngleProduct {
            re: new_re * factor,
            im: new_im * factor,
            turns: turns + i32::from(up) - i32::from(down),
        };
    }

    /// Twice the sum of the arguments.
    pub fn solid_angle(&self) -> f64 {
        // A negative zero would be on the other side of the negative axis.
        let angle = solid_angle_of([self.re, self.im + 0.0]);
        angle + f64::from(self.turns) * (4.0 * std::f64::consts::PI)
    }
}

/// The solid angle whose half is the argument of a sum. The same on every machine: operations of the library, and not
/// of the platform's.
#[inline]
fn solid_angle_of([re, im]: [f64; 2]) -> f64 {
    2.0 * libm::atan2(im, re)
}

/// The solid angle of the edge from `a` to `b` seen from `point`, all finite, within [`TERM_ERROR`]; 0 where
/// the point lies on the edge.
#[cold]
#[inline(never)]
pub fn exact_solid_angle(point: Vec3, a: Vec3, b: Vec3) -> f64 {
    let (first, second) = (ExactVertex::new(a, point), ExactVertex::new(b, point));
    if first.is_at_point || second.is_at_point {
        return 0.0;
    }

    // On the ray itself only the infinitesimal tells where the vertex is seen.
    let moved = FRAME.map(|row| BigFloat::from_double(-row.x));
    let (p, q, is_moved) = match (first.is_on_ray(), second.is_on_ray()) {
        (true, true) => return 0.0,
        (true, false) => (&moved, &second.frame, true),
        (false, true) => (&first.frame, &moved, true),
        (false, false) => (&first.frame, &second.frame, false),
    };
    let mut re = p[0].times(&q[0]).plus(&p[1].times(&q[1]));
    if !is_moved {
        re = re.plus(&first.q().times(&second.q()));
    }
    let im = p[1].times(&q[0]).minus(&p[0].times(&q[1]));

    let one = BigFloat::from_double(1.0);
    let (mut re, mut im, sign) = (re.quotient(&one), im.quotient(&one), im.sign());
    if !is_moved && sign == 0 && re.abs() < ROOT_ERROR {
        return 0.0;
    }
    if sign == 0 && re < 0.0 {
        // The crossing rule's edge function has the other sign.
        let edge_sign = match exact_edge_sign(point, WINDING_DIRECTION, a, b) {
            0 => perturbed_sign(WINDING_DIRECTION, a, b),
            sign => sign,
        };
        im = if edge_sign > 0 { -0.0 } else { 0.0 };
    } else if sign != 0 && im == 0.0 {
        im = f64::from(sign) * f64::MIN_POSITIVE;
    }
    // No zero of the other sign.
    re += 0.0;
    solid_angle_of([re, im])
}

/// How often a root is improved by 50 digits.
const ROOT_STEPS: usize = 5;

/// Sums of vertices at a distance of about one that are smaller are those of a point on the edge.
const ROOT_ERROR: f64 = f64::from_bits((1023 - 240) << 52);

/// A vertex as it is seen from a point, in the frame, times a power of two so that it is at a distance of 4 to 30.
struct ExactVertex {
    frame: [BigFloat; 3],
    is_at_point: bool,
}

impl ExactVertex {
    fn new(vertex: Vec3, point: Vec3) -> ExactVertex {
        let difference = [0, 1, 2].map(|axis| BigFloat::difference(vertex[axis], point[axis]));
        let one = BigFloat::from_double(1.0);
        let rounded = difference.each_ref().map(|component| component.quotient(&one).abs());
        let largest = rounded.into_iter().fold(0.0, f64::max);
        let is_at_point = largest == 0.0;
        let exponent = if is_at_point { 0 } else { exponent_of(largest.min(f64::MAX)) };
        let [first, second] = two_powers(-exponent);
        let scaled = difference.map(|component| component.scaled(first).scaled(second));
        let frame = FRAME.map(|row| {
            let sum = scaled[0].scaled(row.x).plus(&scaled[1].scaled(row.y));
            sum.plus(&scaled[2].scaled(row.z))
        });
        ExactVertex { frame, is_at_point }
    }

    /// True if the ray along the direction passes through it.
    fn is_on_ray(&self) -> bool {
        let [x, y, z] = &self.frame;
        x.sign() == 0 && y.sign() == 0 && z.sign() > 0
    }

    /// |a| - z, within [`ROOT_ERROR`].
    fn q(&self) -> BigFloat {
        let [x, y, z] = &self.frame;
        let square = x.times(x).plus(&y.times(y)).plus(&z.times(z));
        root(&square).minus(z)
    }
}

/// The square root of a number between one and a thousand.
fn root(square: &BigFloat) -> BigFloat {
    let one = BigFloat::from_double(1.0);
    let rounded = square.quotient(&one).sqrt();
    let slope = BigFloat::from_double(2.0 * rounded);
    let mut root = BigFloat::from_double(rounded);
    for _ in 0..ROOT_STEPS {
        let correction = square.minus(&root.times(&root)).quotient(&slope);
        root = root.plus(&BigFloat::from_double(correction));
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_is_exactly_a_rotation() {
        let integers = FRAME.map(|row| row.to_array().map(|x| (x / UNIT) as i128));
        let length = (FRAME_LENGTH / UNIT) as i128;
        for i in 0..3 {
            for j in 0..3 {
                let product: i128 = (0..3).map(|k| integers[i][k] * integers[j][k]).sum();
                assert_eq!(product, if i == j { length * length } else { 0 });
            }
            let (next, last) = ((i + 1) % 3, (i + 2) % 3);
            let cross =
                integers[0][next] * integers[1][last] - integers[0][last] * integers[1][next];
            assert_eq!(cross, length * integers[2][i]);
        }
        assert_eq!(FRAME[2], WINDING_DIRECTION);
    }

    #[test]
    fn products_count_their_turns() {
        // All pairs of directions on the axes, the diagonals, and next to them by a rounding; and long rows of them.
        let mut numbers = Vec::new();
        for (re, im) in [(1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]
        {
            for tilt in [0.0, 1e-16, -1e-16, 1e-3, -1e-3] {
                numbers.push([re - tilt * im, im + tilt * re]);
            }
        }
        numbers.extend([[-1.0, 1e-16], [-1.0, -1e-16], [-1e100, 1e80], [-1e-100, -1e-120]]);
        let mut product = AngleProduct::ONE;
        let mut sum = 0.0;
        for (i, a) in numbers.iter().enumerate() {
            for b in &numbers {
                let mut pair = AngleProduct::ONE;
                pair.multiply(*a);
                pair.multiply(*b);
                let expected = solid_angle_of(*a) + solid_angle_of(*b);
                assert!((pair.solid_angle() - expected).abs() < 1e-14, "{a:?} {b:?}");
                let number = if i % 3 == 0 { a } else { b };
                product.multiply(*number);
                sum += solid_angle_of(*number);
                assert!((product.solid_angle() - sum).abs() < 1e-11, "{sum} {product:?}");
            }
        }
    }

    #[test]
    fn both_ways_to_the_angle_agree() {
        let mut state = 1_u64;
        let mut number = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut certain = 0;
        for turn in 0..20_000 {
            let mut point = || vec3(number(), number(), number());
            let (p, mut a, mut b) = (point(), point(), point());
            let offset = point() * 0.1_f64.powi(turn % 12);
            match turn % 5 {
                0 => a = p + WINDING_DIRECTION * 0.3 + offset,
                1 => b = p + WINDING_DIRECTION * 0.7 + offset,
                2 => b = p + (p - a) + offset,
                3 => b = a + offset,
                _ => {}
            }
            let exact = exact_solid_angle(p, a, b);
            assert!((exact + exact_solid_angle(p, b, a)).abs() <= TERM_ERROR);
            let (a_seen, b_seen) = (SeenVertex::new(a - p), SeenVertex::new(b - p));
            if let Some((sum, error)) = edge_sum(&a_seen, &b_seen, LARGEST_TERM_ERROR) {
                certain += 1;
                let quick = solid_angle_of(sum);
                assert!((quick - exact).abs() <= error, "{quick} {exact} {p:?} {a:?} {b:?}");
            }
        }
        // Four of five are aimed at where doubles are not.
        assert!(certain > 8_000, "{certain}");
    }
}
