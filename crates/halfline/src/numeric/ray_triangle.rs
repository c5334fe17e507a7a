//! The rule that says what "hits" means: one ray against one triangle.
//!
//! T. Moller, B. Trumbore 1997 and S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle
//! Intersection", JCGT 2 (2013) decide by the signs of three edge functions. So does this test,
//! but on the coordinates as given and with exact signs:
//!
//! 1. *Does it meet?* The line meets the closed triangle if the three edge functions have no two
//!    opposite signs. All three zero: the line lies in the triangle's plane, and there is no hit.
//! 2. *Does it cross?* Where an edge function is zero, the line is moved by an infinitesimal
//!    (see [`perturbed_sign`]). Of the triangles around a shared edge or vertex this picks each
//!    crossing once.
//! 3. *Where?* t is the double nearest to the exact quotient, so it depends on nothing but the
//!    ray and the triangle, and a point in front of another never gets the larger t.
//!
//! Closest and any hit use rule 1, all hits and counts rule 2 and, at borders, `border.rs`.

use super::double_double::{DoubleDouble, UNIT_ROUNDOFF, two_product, two_sum};
use super::edge_function::{
    Bounded, Orientation, edge_function, exact_edge_function, exact_edge_sign, perturbed_sign,
};
use super::exact::{BigFloat, DigitRange, ExactNumber, Expansion};
use super::power_of_two::{exponent_of, scale_by_power_of_two, scale_vector};
use crate::geometry::{Hit, Ray, Vec3, vec3};

/// A ray, ready for the triangle test.
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    /// Where t is zero.
    pub origin: Vec3,
    /// The direction as given, for exact arithmetic.
    given_direction: Vec3,
    /// The direction times a power of two, largest component in [2^500, 2^501), so that products
    /// with tiny coordinates keep all their bits. Where the smallest component would lose some all
    /// are NaN: then no filter is certain of anything, and everything is decided exactly.
    direction: Vec3,
    /// The scaled direction is 2^t_exponent times the given one, and so is t for the given one.
    t_exponent: i32,
    /// Smallest t that counts.
    pub t_min: f64,
    /// Largest t that counts.
    pub t_max: f64,
}

/// Exponent to which directions are scaled: midway between overflow in a product of a direction
/// with three coordinates of up to 2^100 each and underflow of the smallest denormal's products.
/// What overflows or underflows beyond that is not lost, but decided exactly, which takes longer.
const DIRECTION_EXPONENT: i32 = 500;

impl PreparedRay {
    /// `None` if the ray hits nothing by definition; see [`Ray::is_valid`].
    #[inline]
    pub fn new(ray: &Ray) -> Option<PreparedRay> {
        if !ray.is_valid() {
            return None;
        }
        let exponent = DIRECTION_EXPONENT - exponent_of(ray.direction.abs().max_element());
        let scaled = scale_vector(ray.direction, exponent);
        let keeps_all_bits = scale_vector(scaled, -exponent) == ray.direction;
        let direction = if keeps_all_bits { scaled } else { Vec3::splat(f64::NAN) };
        Some(PreparedRay {
            origin: ray.origin,
            given_direction: ray.direction,
            direction,
            t_exponent: exponent,
            t_min: ray.t_min,
            t_max: ray.t_max,
        })
    }
}

impl PreparedRay {
    /// The direction, or a positive multiple of it that is handier.
    fn exact_direction(&self) -> Vec3 {
        if self.direction.x.is_nan() { self.given_direction } else { self.direction }
    }
}

/// In which part of a triangle a line meets it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Touched {
    /// Neither on an edge nor at a corner.
    Inside,
    /// Inside the edge opposite to this corner.
    Edge(usize),
    /// At this corner.
    Corner(usize),
}

impl Touched {
    /// By the signs of the edge functions, each named by the corner opposite to the edge; not all of
    /// them are zero.
    fn of(signs: [i8; 3]) -> Touched {
        match signs.map(|sign| sign == 0) {
            [false, false, false] => Touched::Inside,
            [true, false, false] => Touched::Edge(0),
            [false, true, false] => Touched::Edge(1),
            [false, false, true] => Touched::Edge(2),
            [false, true, true] => Touched::Corner(0),
            [true, false, true] => Touched::Corner(1),
            [true, true, _] => Touched::Corner(2),
        }
    }
}

/// How a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Ray parameter: the double nearest to the exact one.
    pub t: f64,
    /// True if the line, moved by an infinitesimal, crosses the triangle. A contact that is no
    /// crossing is at an edge or a corner; it counts for closest and any hit, and for all hits only
    /// on the border of the surface.
    pub is_crossing: bool,
    /// Where in the triangle.
    pub touched: Touched,
    /// From which side.
    pub orientation: Orientation,
}

impl PreparedRay {
    /// The contact with the closed triangle, if there is one with t in the ray's range.
    ///
    /// NaN or infinite corners never hit: no sign of their edge functions is certain, and the exact
    /// path refuses them.
    #[inline]
    pub fn meet(&self, corners: [Vec3; 3]) -> Option<Contact> {
        // Take the corners relative to the origin and compute the three edge functions.
        let [a, b, c] = corners;
        let (a, b, c) = (a - self.origin, b - self.origin, c - self.origin);
        let edges = [
            edge_function(self.direction, b, c),
            edge_function(self.direction, c, a),
            edge_function(self.direction, a, b),
        ];

        // Leave if two certain signs differ: nearly every candidate ends here.
        let positive = edges.iter().any(|e| e.value > e.error);
        let negative = edges.iter().any(|e| e.value < -e.error);
        if positive && negative {
            return None;
        }
        self.meet_likely(corners, edges)
    }

    /// The rest of [`PreparedRay::meet`], for candidates that no certain pair of signs rules out.
    fn meet_likely(&self, corners: [Vec3; 3], edges: [Bounded; 3]) -> Option<Contact> {
        if !corners.into_iter().all(Vec3::is_finite) {
            return None;
        }

        // Decide the open signs exactly.
        let mut signs = [0i8; 3];
        for i in 0..3 {
            let (p, q) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
            signs[i] = edges[i]
                .certain_sign()
                .unwrap_or_else(|| exact_edge_sign(self.origin, self.exact_direction(), p, q));
        }
        let positive = signs.contains(&1);
        let negative = signs.contains(&-1);
        if positive == negative {
            return None;
        }

        // Compute where, and leave if it is out of range.
        let t = self.parameter(&corners);
        if !(self.t_min <= t && t <= self.t_max && t.is_finite()) {
            return None;
        }

        let is_crossing = (0..3).all(|i| {
            let sign = match signs[i] {
                0 => perturbed_sign(
                    self.exact_direction(),
                    corners[(i + 1) % 3],
                    corners[(i + 2) % 3],
                ),
                sign => sign,
            };
            sign == if positive { 1 } else { -1 }
        });
        let orientation = if positive { Orientation::Back } else { Orientation::Front };
        Some(Contact { t, is_crossing, touched: Touched::of(signs), orientation })
    }

    /// The hit for a contact at `t` with `face`, whose corners these are.
    pub fn hit(&self, t: f64, face: u32, corners: [Vec3; 3]) -> Hit {
        let (u, v) = self.barycentrics(t, &corners);
        Hit { t, face, u, v }
    }

    /// Weights of the second and third corner in the point where the line meets the triangle, to
    /// within [`BARYCENTRIC_ERROR`], given t.
    ///
    /// From far away nearly all bits of the edge functions cancel. So the line is first followed to
    /// the point at t, in twice the precision; whether that lies in the plane exactly does not
    /// matter, for it lies on the line. From there plain doubles do for all but slivers and
    /// triangles seen edge-on.
    fn barycentrics(&self, t: f64, corners: &[Vec3; 3]) -> (f64, f64) {
        // Take a point of the line relative to the first corner, and what of it may be wrong.
        let [a, b, c] = *corners;
        let (ab, ac) = (b - a, c - a);
        let direction = self.direction;
        let scaled_t = scale_by_power_of_two(t, -self.t_exponent);
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

        // Solve for the weights, with the permanents of all three determinants.
        let (p, p_permanent) = (direction.cross(ac), permanent(direction.abs(), ac.abs()));
        let (q, q_permanent) = (at.cross(ab), permanent(reach, ab.abs()));
        let determinant = ab.dot(p);
        let (u, v) = (at.dot(p) / determinant, direction.dot(q) / determinant);
        let error = WEIGHT_ERROR
            * (reach.dot(p_permanent)
                + direction.abs().dot(q_permanent)
                + 2.0 * ab.abs().dot(p_permanent))
            + PRODUCT_UNDERFLOW * (reach + ab.abs()).dot(Vec3::splat(1.0))
            + WEIGHT_UNDERFLOW;
        let is_accurate =
            error < BARYCENTRIC_ERROR * determinant.abs() && determinant.abs() < QUOTIENT_RANGE.end;
        // A weight of zero may have come out below zero by the error, or as negative zero.
        if is_accurate {
            (u.clamp(0.0, 1.0) + 0.0, v.clamp(0.0, 1.0) + 0.0)
        } else {
            self.exact_barycentrics(corners)
        }
    }

    /// [`PreparedRay::barycentrics`] by exact arithmetic: shares of the edge functions in their sum.
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
    fn parameter(&self, [a, b, c]: &[Vec3; 3]) -> f64 {
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

/// The same for a sum whose last factors are at most 1; larger ones scale it.
const NUMERATOR_UNDERFLOW: f64 = f64::from_bits(1 << (1074 - 1066));

/// Double-double quotients within this range have both parts clear of underflow and overflow.
const QUOTIENT_RANGE: std::ops::Range<f64> =
    f64::from_bits((1023 - 900) << 52)..f64::from_bits((1023 + 900) << 52);

/// Absolute error of barycentric weights: 256 roundings of 1.
const BARYCENTRIC_ERROR: f64 = 256.0 * UNIT_ROUNDOFF;

/// Error of a coordinate of the point on the line, beyond one rounding of itself, in terms of the
/// two numbers of which it is the sum: their low parts are at most u of them, and are added with
/// three roundings. (In units of 1/8 u, since the permanent that it goes into is multiplied by
/// [`WEIGHT_ERROR`].)
const POINT_ERROR: f64 = 4.0 * UNIT_ROUNDOFF;

/// Error of the determinants for the weights in terms of their permanents: two factors rounded, two
/// products, a difference and two sums, seven roundings; one more for second-order terms.
const WEIGHT_ERROR: f64 = 8.0 * UNIT_ROUNDOFF;

/// Underflow in the step along the line may move its point by 2^-1072: this, times [`WEIGHT_ERROR`].
const POINT_UNDERFLOW: f64 = 2.0 * f64::MIN_POSITIVE;

/// Underflow in the products of the first cross product, 2^-1074 for each component, which are then
/// multiplied by the point and, for the determinant, which counts twice, by an edge.
const PRODUCT_UNDERFLOW: f64 = f64::from_bits(16);

/// The same for the second one, which is multiplied by a direction below 2^501, and for what follows:
/// 3 * 2^-573 and a little.
const WEIGHT_UNDERFLOW: f64 = f64::from_bits((1023 - 569) << 52);

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

/// The order of hits along a ray: by t, and at equal t by face index.
#[inline]
pub fn is_nearer(hit: &Hit, than: &Hit) -> bool {
    hit.t < than.t || (hit.t == than.t && hit.face < than.face)
}

/// True if the triangle's corners, which are finite, lie on one line, exactly.
pub fn is_zero_area([a, b, c]: [Vec3; 3]) -> bool {
    // A certain component of the normal in doubles settles nearly every triangle.
    let (ab, ac) = (b - a, c - a);
    let settled = (0..3).any(|axis| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let (left, right) = (ab[next] * ac[last], ab[last] * ac[next]);
        (left - right).abs() > MINOR_ERROR * (left.abs() + right.abs()) + MINOR_UNDERFLOW
    });
    if settled {
        return false;
    }
    let digits = DigitRange::of(&[a, b, c]);
    if DigitRange::suits_expansions(digits, DigitRange::OF_ONE) {
        is_normal_zero::<Expansion>([a, b, c])
    } else {
        is_normal_zero::<BigFloat>([a, b, c])
    }
}

fn is_normal_zero<N: ExactNumber>([a, b, c]: [Vec3; 3]) -> bool {
    (0..3).all(|axis| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let ab = |i: usize| N::difference(b[i], a[i]);
        let ac = |i: usize| N::difference(c[i], a[i]);
        ab(next).times(&ac(last)).minus(&ab(last).times(&ac(next))).sign() == 0
    })
}

/// Relative error, in terms of the permanent, of a 2 x 2 determinant of rounded differences:
/// `ccwerrboundA` of Shewchuk's `orient2d`.
const MINOR_ERROR: f64 = (3.0 + 16.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

/// Two products that underflow are off by 2^-1075 each, and so may be their permanent; the rest is
/// for the product with [`MINOR_ERROR`], which may underflow too.
const MINOR_UNDERFLOW: f64 = f64::from_bits(4);
