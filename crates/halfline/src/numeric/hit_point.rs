//! Where in space a line meets a triangle that it is known to meet: t, and the barycentrics.
//!
//! t is correctly rounded: an approximation with a bound of its error is rounded if the bound leaves
//! no doubt (A. Ziv, "Fast Evaluation of Elementary Mathematical Functions with Correctly Rounded Last
//! Bit", ACM TOMS 17 (1991)), and else a better one is taken; the last one is exact.

use super::double_double::{DoubleDouble, UNIT_ROUNDOFF, two_product, two_sum};
use super::edge_function::exact_edge_function;
use super::exact::{BigFloat, ExactNumber};
use super::power_of_two::scale_by_power_of_two;
use super::ray_triangle::PreparedRay;
use crate::geometry::{Hit, Vec3, vec3};

impl PreparedRay {
    /// The hit of `face`, whose corners these are and which the line is known to meet: t, whether it
    /// is in the ray's range or not, and the weights of the second and third corner, to within
    /// 2^-40.
    ///
    /// From far away nearly all bits of the edge functions cancel. So the line is first followed to
    /// t as plain doubles give it, in twice the precision. Whether that point lies in the plane
    /// exactly does not matter for the weights, since it lies on the line. How far it is from the
    /// plane is what t is wrong by, and is small, so plain doubles do for that too. From the point
    /// plain doubles also do for the weights of all but slivers and triangles seen edge-on.
    #[inline]
    pub fn hit(&self, face: u32, corners: [Vec3; 3]) -> Hit {
        // Take the normal, and the approximate t of the scaled direction.
        let [a, b, c] = corners;
        let (ab, ac) = (b - a, c - a);
        let direction = self.direction;
        let (normal, normal_permanent) = (ab.cross(ac), permanent(ab.abs(), ac.abs()));
        let determinant = normal.dot(direction);
        let inverse = 1.0 / determinant;
        let determinant_permanent = normal_permanent.dot(direction.abs());
        let scaled_t = normal.dot(a - self.origin) * inverse;

        // Take the point there relative to the first corner, and what of it may be wrong.
        let mut at = Vec3::ZERO;
        let mut reach = Vec3::ZERO;
        for axis in 0..3 {
            let start = DoubleDouble::difference(self.origin[axis], a[axis]);
            let (step, step_error) = two_product(scaled_t, direction[axis]);
            let (sum, sum_error) = two_sum(start.high, step);
            at[axis] = sum + (sum_error + (start.low + step_error));
            reach[axis] =
                at[axis].abs() + POINT_ERROR * (start.high.abs() + step.abs()) + POINT_UNDERFLOW;
        }

        // Correct t by the distance to the plane, and round it if its error allows.
        let determinant_error = WEIGHT_ERROR * determinant_permanent + WEIGHT_UNDERFLOW;
        let correction = -(normal.dot(at) * inverse);
        let error = (CORRECTION_ERROR * normal_permanent.dot(reach)
            + PRODUCT_UNDERFLOW * (reach.dot(Vec3::splat(1.0)) + 1.0)
            + 2.0 * correction.abs() * determinant_error)
            * inverse.abs();
        let lowest = scaled_t + (correction - error);
        let highest = scaled_t + (correction + error);
        let t = scale_by_power_of_two(lowest, self.t_exponent);
        let is_certain = lowest == highest
            && determinant_error < MAX_DETERMINANT_ERROR * determinant.abs()
            && QUOTIENT_RANGE.contains(&lowest.abs())
            && determinant.abs() < QUOTIENT_RANGE.end
            && t.is_normal();
        let t = if is_certain { t } else { self.parameter(&corners) };

        // Solve for the weights, with the permanents of both determinants.
        let (p, p_permanent) = (direction.cross(ac), permanent(direction.abs(), ac.abs()));
        let (q, q_permanent) = (at.cross(ab), permanent(reach, ab.abs()));
        let (u, v) = (-at.dot(p) * inverse, -direction.dot(q) * inverse);
        let error = WEIGHT_ERROR
            * (reach.dot(p_permanent)
                + direction.abs().dot(q_permanent)
                + 2.0 * determinant_permanent)
            + PRODUCT_UNDERFLOW * (reach + ab.abs()).dot(Vec3::splat(1.0))
            + WEIGHT_UNDERFLOW;
        let is_accurate =
            error < BARYCENTRIC_ERROR * determinant.abs() && determinant.abs() < QUOTIENT_RANGE.end;
        // A weight of zero may have come out below zero by the error, or as negative zero.
        let (u, v) = if is_accurate {
            (u.clamp(0.0, 1.0) + 0.0, v.clamp(0.0, 1.0) + 0.0)
        } else {
            self.exact_barycentrics(&corners)
        };
        Hit { t, face, u, v }
    }

    /// The barycentrics by exact arithmetic: shares of the edge functions in their sum.
    #[cold]
    fn exact_barycentrics(&self, corners: &[Vec3; 3]) -> (f64, f64) {
        let exact = [0, 1, 2].map(|i| {
            let (p, q) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
            exact_edge_function::<BigFloat>(self.origin, self.given_direction, p, q)
        });
        let sum = exact[0].plus(&exact[1]).plus(&exact[2]);
        (exact[1].quotient(&sum), exact[2].quotient(&sum))
    }

    /// The parameter of the point where the line meets the triangle's plane, correctly rounded:
    /// `n . (a - origin) / (n . direction)` with the normal `n = (b - a) x (c - a)`.
    pub fn parameter(&self, [a, b, c]: &[Vec3; 3]) -> f64 {
        // Compute numerator and denominator in double-double, and their permanents.
        let (ab, ac, oa) = (difference(b, a), difference(c, a), difference(a, &self.origin));
        let is_short = are_short(&ab) && are_short(&ac);
        let mut numerator = DoubleDouble { high: 0.0, low: 0.0 };
        let mut denominator = DoubleDouble { high: 0.0, low: 0.0 };
        let mut numerator_permanent = 0.0;
        let mut denominator_permanent = 0.0;
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let (normal, normal_permanent);
            if is_short {
                let left = ab[next].high * ac[last].high;
                let right = ab[last].high * ac[next].high;
                normal = DoubleDouble::difference(left, right);
                normal_permanent = left.abs() + right.abs();
            } else {
                let left = ab[next].times(ac[last]);
                let right = ab[last].times(ac[next]);
                normal = left.minus_loosely(right);
                normal_permanent = left.high.abs() + right.high.abs();
            }
            numerator = numerator.plus_loosely(normal.times(oa[axis]));
            denominator = denominator.plus_loosely(normal.times_double(self.direction[axis]));
            numerator_permanent += normal_permanent * oa[axis].high.abs();
            denominator_permanent += normal_permanent * self.direction[axis].abs();
        }

        // Round the quotient if its error leaves no doubt to which double (Ziv's test), and neither
        // it nor t is so small or so large that a rounding would be coarser than that. After an
        // overflow all comparisons fail, with infinities or NaN.
        let quotient = numerator.divided_by(denominator);
        let reach = oa[0].high.abs().max(oa[1].high.abs()).max(oa[2].high.abs()).max(1.0);
        let numerator_error = PLANE_ERROR * numerator_permanent + NUMERATOR_UNDERFLOW * reach;
        let denominator_error = PLANE_ERROR * denominator_permanent + PLANE_UNDERFLOW;
        let relative_error = numerator_error / numerator.high.abs()
            + denominator_error / denominator.high.abs()
            + QUOTIENT_ERROR;
        let error = relative_error * quotient.high.abs();
        let lowest = quotient.high + (quotient.low - error);
        let highest = quotient.high + (quotient.low + error);
        let t = scale_by_power_of_two(lowest, self.t_exponent);
        if lowest == highest
            && relative_error < MAX_RELATIVE_ERROR
            && QUOTIENT_RANGE.contains(&lowest.abs())
            && t.is_normal()
        {
            t
        } else {
            self.exact_parameter([a, b, c])
        }
    }

    /// [`PreparedRay::parameter`] by exact arithmetic; +0 for either zero.
    #[cold]
    fn exact_parameter(&self, [a, b, c]: [&Vec3; 3]) -> f64 {
        let mut numerator = BigFloat::default();
        let mut denominator = BigFloat::default();
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let ab = |i: usize| BigFloat::difference(b[i], a[i]);
            let ac = |i: usize| BigFloat::difference(c[i], a[i]);
            let normal = ab(next).times(&ac(last)).minus(&ab(last).times(&ac(next)));
            let oa = BigFloat::difference(a[axis], self.origin[axis]);
            numerator = numerator.plus(&normal.times(&oa));
            denominator = denominator.plus(&normal.scaled(self.given_direction[axis]));
        }
        numerator.quotient(&denominator)
    }
}

/// `p - q`, exactly. Written out, since the compiler leaves `array::map` a call, which costs more
/// than the subtractions.
#[inline(always)]
fn difference(p: &Vec3, q: &Vec3) -> [DoubleDouble; 3] {
    [
        DoubleDouble::difference(p.x, q.x),
        DoubleDouble::difference(p.y, q.y),
        DoubleDouble::difference(p.z, q.z),
    ]
}

/// True if products of two such numbers are exact, since each has at most 26 binary digits, as
/// differences of single-precision numbers of similar size have. Underflow is bounded as always.
#[inline(always)]
fn are_short(numbers: &[DoubleDouble; 3]) -> bool {
    const SURPLUS_DIGITS: u64 = (1 << 27) - 1;
    let bits = numbers.iter().fold(0, |bits, x| bits | x.high.to_bits());
    bits & SURPLUS_DIGITS == 0 && numbers.iter().all(|x| x.low == 0.0)
}

/// Relative error, in terms of its permanent, of a sum of three products of a 2 x 2 minor and one
/// more factor in double-double: a product (8 u^2), a difference (4), a product (8), two sums (8),
/// and the rounding of the permanent itself, generously rounded up to 64 u^2.
const PLANE_ERROR: f64 = 64.0 * UNIT_ROUNDOFF * UNIT_ROUNDOFF;

/// What underflow may add to the error of such a sum with a direction below 2^501. Each exact
/// product of [`two_product`](super::double_double::two_product) may be off by four roundings to
/// denormals, 2^-1073, and a product of two double-doubles by twice that; so a minor is off by less
/// than 2^-1070, and times the direction by 2^-569. Three of them and their own products stay below
/// 2^-567.
const PLANE_UNDERFLOW: f64 = f64::from_bits((1023 - 567) << 52);

/// What underflow may add to the error of a sum of three products as in [`PLANE_ERROR`] whose last factors
/// are at most 1; larger ones scale it.
const NUMERATOR_UNDERFLOW: f64 = f64::from_bits(1 << (1074 - 1066));

/// Double-double quotients within this range have both parts clear of underflow and overflow.
const QUOTIENT_RANGE: std::ops::Range<f64> =
    f64::from_bits((1023 - 900) << 52)..f64::from_bits((1023 + 900) << 52);

/// Absolute error of barycentric weights: 8192 roundings of 1, which is 2^-40.
pub const BARYCENTRIC_ERROR: f64 = 8192.0 * UNIT_ROUNDOFF;

/// Error of a coordinate of the point on the line, beyond one rounding of itself, in terms of the
/// two numbers of which it is the sum: their low parts are at most u of them, and are added with
/// three roundings. (In units of 1/8 u, since the permanent that it goes into is multiplied by
/// [`WEIGHT_ERROR`].)
pub const POINT_ERROR: f64 = 4.0 * UNIT_ROUNDOFF;

/// Error of the determinants for the weights in terms of their permanents: two factors rounded, two
/// products, a difference and two sums, seven roundings; one more for second-order terms.
pub const WEIGHT_ERROR: f64 = 8.0 * UNIT_ROUNDOFF;

/// Underflow in the step along the line may move its point by 2^-1072: this, times [`WEIGHT_ERROR`].
const POINT_UNDERFLOW: f64 = 2.0 * f64::MIN_POSITIVE;

/// Underflow in the products of the first cross product, 2^-1074 for each component, which are then
/// multiplied by the point and, for the determinant, which counts twice, by an edge.
const PRODUCT_UNDERFLOW: f64 = f64::from_bits(16);

/// Underflow in the products of the second cross product, which is multiplied by a direction below 2^501,
/// and in what follows: 3 * 2^-573 and a little.
const WEIGHT_UNDERFLOW: f64 = f64::from_bits((1023 - 569) << 52);

/// Error of the distance from the plane, in terms of its permanent: as [`WEIGHT_ERROR`], but both
/// edges are rounded, and the point, and one more for the quotient.
pub const CORRECTION_ERROR: f64 = 10.0 * UNIT_ROUNDOFF;

/// Relative error of a determinant up to which twice that bounds the error of its inverse.
pub const MAX_DETERMINANT_ERROR: f64 = 1.0 / 1024.0;

/// What a cross product would be if nothing cancelled, for vectors without negative components.
#[inline(always)]
fn permanent(a: Vec3, b: Vec3) -> Vec3 {
    vec3(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)
}

/// Relative error of a double-double quotient, 16 u^2, doubled for the products of small errors.
const QUOTIENT_ERROR: f64 = 32.0 * UNIT_ROUNDOFF * UNIT_ROUNDOFF;

/// Up to here the errors of numerator and denominator may be added to give that of the quotient:
/// what is left out is their product, far below the doubling in [`QUOTIENT_ERROR`].
const MAX_RELATIVE_ERROR: f64 = UNIT_ROUNDOFF;
