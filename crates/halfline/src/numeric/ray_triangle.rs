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
//! 3. *Where?* t is the double nearest to the exact quotient (see `hit_point.rs`), so it depends on
//!    nothing but the ray and the triangle, and a point in front of another never gets the larger t.
//!    As long as it is not asked for, bounds of it will do.
//!
//! Closest and any hit use rule 1, all hits and counts rule 2 and, at borders, `border.rs`.

use super::double_double::UNIT_ROUNDOFF;
use super::edge_function::{Bounded, Orientation, edge_function, exact_edge_sign, perturbed_sign};
use super::exact::{BigFloat, DigitRange, ExactNumber, Expansion};
use super::power_of_two::{exponent_of, scale_vector};
use crate::geometry::{Hit, Ray, Vec3, vec3};

/// A ray, ready for the triangle test.
#[derive(Clone, Copy, Debug)]
pub struct PreparedRay {
    /// Where t is zero.
    pub origin: Vec3,
    /// The direction as given, for exact arithmetic.
    pub(super) given_direction: Vec3,
    /// The direction times a power of two, largest component in [2^500, 2^501), so that products
    /// with tiny coordinates keep all their bits. Where the smallest component would lose some all
    /// are NaN: then no filter is certain of anything, and everything is decided exactly.
    pub(super) direction: Vec3,
    /// The unit vector along the axis of its largest component: a product with it takes a component
    /// without a branch.
    longest: Vec3,
    /// The component of the given direction along the axis of its largest component.
    given_along: f64,
    /// The scaled direction is 2^t_exponent times the given one, and so is t for the given one.
    pub(super) t_exponent: i32,
    /// Smallest t that counts.
    pub t_min: f64,
    /// Largest t that counts.
    pub t_max: f64,
}

/// Exponent to which directions are scaled: midway between overflow in a product of a direction
/// with three coordinates of up to 2^100 each and underflow of the smallest denormal's products.
/// What overflows or underflows beyond that is not lost, but decided exactly, which takes longer.
const DIRECTION_EXPONENT: i32 = 500;

impl Default for PreparedRay {
    /// A ray that hits nothing.
    fn default() -> PreparedRay {
        PreparedRay {
            origin: Vec3::ZERO,
            given_direction: Vec3::ZERO,
            direction: Vec3::ZERO,
            longest: Vec3::ZERO,
            given_along: 0.0,
            t_exponent: 0,
            t_min: f64::INFINITY,
            t_max: f64::NEG_INFINITY,
        }
    }
}

impl PreparedRay {
    /// `None` if the ray hits nothing by definition; see [`Ray::is_valid`].
    #[inline]
    pub fn new(ray: &Ray) -> Option<PreparedRay> {
        let mut prepared = PreparedRay::default();
        ray.is_valid().then(|| prepared.set(ray))?;
        Some(prepared)
    }

    /// Prepares a valid ray in the place of another: in queues, where many wait in memory, a copy
    /// of what was just written would have to wait for the writes.
    #[inline(always)]
    pub fn set(&mut self, ray: &Ray) {
        let magnitude = ray.direction.abs();
        let exponent = DIRECTION_EXPONENT - exponent_of(magnitude.max_element());
        let scaled = scale_vector(ray.direction, exponent);
        let keeps_all_bits = scale_vector(scaled, -exponent) == ray.direction;
        self.direction = if keeps_all_bits { scaled } else { Vec3::splat(f64::NAN) };
        self.origin = ray.origin;
        self.given_direction = ray.direction;
        let Vec3 { x, y, z } = magnitude;
        let is_x = (x > y) & (x > z);
        let is_y = !is_x & (y > z);
        let one = |is: bool| f64::from(u8::from(is));
        self.longest = vec3(one(is_x), one(is_y), one(!is_x & !is_y));
        self.given_along = self.longest.dot(ray.direction);
        self.t_exponent = exponent;
        self.t_min = ray.t_min;
        self.t_max = ray.t_max;
    }
}

impl PreparedRay {
    /// The direction, or a positive multiple of it that is handier.
    pub(super) fn exact_direction(&self) -> Vec3 {
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
    /// From which side the line meets the triangle.
    pub orientation: Orientation,
}

/// A line that meets a closed triangle, at a t that is not known yet.
#[derive(Clone, Copy, Debug)]
pub struct LineIntersection {
    /// The triangle.
    pub corners: [Vec3; 3],
    /// The edge functions, each named by the corner opposite to the edge.
    edges: [Bounded; 3],
    /// The signs of the edge functions.
    signs: [i8; 3],
}

impl LineIntersection {
    /// Where in the triangle.
    pub fn touched(&self) -> Touched {
        Touched::of(self.signs)
    }

    /// From which side.
    pub fn orientation(&self) -> Orientation {
        if self.signs.contains(&1) { Orientation::Back } else { Orientation::Front }
    }

    /// True if the line, moved by an infinitesimal, crosses the triangle.
    pub fn is_crossing(&self, ray: &PreparedRay) -> bool {
        let side = if self.signs.contains(&1) { 1 } else { -1 };
        (0..3).all(|i| {
            let sign = match self.signs[i] {
                0 => perturbed_sign(
                    ray.exact_direction(),
                    self.corners[(i + 1) % 3],
                    self.corners[(i + 2) % 3],
                ),
                sign => sign,
            };
            sign == side
        })
    }

    /// Two numbers between which t is, by the edge functions as weights of the corners; nearly for
    /// nothing, and good enough to tell most triangles apart.
    #[inline(always)]
    pub fn bounds(&self, ray: &PreparedRay) -> Interval {
        // Take the mean of the corners along the axis that the ray follows most.
        let [a, b, c] = &self.corners;
        let along = [
            (*a - ray.origin).dot(ray.longest),
            (*b - ray.origin).dot(ray.longest),
            (*c - ray.origin).dot(ray.longest),
        ];
        let [u, v, w] = &self.edges;
        let [p, q, r] = [u.value * along[0], v.value * along[1], w.value * along[2]];
        let weights = u.value + v.value + w.value;
        let inverse = 1.0 / (weights * ray.given_along);
        let t = (p + q + r) * inverse;

        // An error of a weight moves the mean by no more than the corners are apart.
        let nearest = along[0].min(along[1]).min(along[2]);
        let farthest = along[0].max(along[1]).max(along[2]);
        let extent = farthest - nearest + MEAN_ERROR * (nearest.abs() + farthest.abs());
        let error = ((u.error + v.error + w.error) * extent * (1.0 + MEAN_ERROR)
            + MEAN_ERROR * (p.abs() + q.abs() + r.abs())
            + f64::MIN_POSITIVE)
            * inverse.abs();
        let is_bounded = u.value.abs() + v.value.abs() + w.value.abs() <= 2.0 * weights.abs()
            && SAFE_T.contains(&t.abs())
            && error < SAFE_T.end
            && inverse.abs() < LARGEST_INVERSE;
        if is_bounded { Interval { low: t - error, high: t + error } } else { Interval::UNKNOWN }
    }
}

/// What goes on with meetings.
pub trait TakeIntersection {
    /// Takes the meeting of the line of `ray` with `face`, whose t may be out of range.
    fn take(&mut self, ray: &PreparedRay, meeting: &LineIntersection, face: u32);
}

/// What is certain about the signs of three edge functions.
enum Sign {
    /// Two of them differ: nearly every candidate that is missed ends here.
    Both,
    /// All are this.
    One(i8),
    /// Some are open.
    Open,
}

#[inline(always)]
fn certain_sign_of(edges: &[Bounded; 3]) -> Sign {
    let positive = edges.iter().fold(0, |n, e| n + i32::from(e.value > e.error));
    let negative = edges.iter().fold(0, |n, e| n + i32::from(e.value < -e.error));
    if positive > 0 && negative > 0 {
        Sign::Both
    } else if positive == 3 {
        Sign::One(1)
    } else if negative == 3 {
        Sign::One(-1)
    } else {
        Sign::Open
    }
}

/// Relative error of a mean whose weights sum to at least half of their permanent, in terms of the
/// sum's permanent: coordinates rounded, products, two sums, at most four for the two sums of the
/// weights, three for their product with the direction, its inverse, and the product with that;
/// twelve roundings, and as many for the error's own and second-order terms.
const MEAN_ERROR: f64 = 24.0 * UNIT_ROUNDOFF;

/// Values of t whose error is not worsened by underflow, and that are far from overflow.
const SAFE_T: std::ops::Range<f64> =
    f64::from_bits((1023 - 400) << 52)..f64::from_bits((1023 + 400) << 52);

/// Inverses of numbers that did not underflow.
const LARGEST_INVERSE: f64 = f64::from_bits((1023 + 900) << 52);

/// Doubles between which the exact t lies, and so the double nearest to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// A lower bound: t is no smaller.
    pub low: f64,
    /// An upper bound: t is no larger.
    pub high: f64,
}

impl Interval {
    /// Of a t that may be anything.
    pub const UNKNOWN: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// Of a t that is known.
    pub fn exactly(t: f64) -> Interval {
        Interval { low: t, high: t }
    }
}

impl PreparedRay {
    /// The contact with the closed triangle, if there is one with t in the ray's range.
    pub fn meet(&self, corners: [Vec3; 3]) -> Option<Contact> {
        let meeting = self.meet_line(corners)?;
        let t = self.parameter(&corners);
        self.is_in_range(t).then(|| Contact {
            t,
            is_crossing: meeting.is_crossing(self),
            touched: meeting.touched(),
            orientation: meeting.orientation(),
        })
    }

    /// True if a hit at `t` counts; one beyond the largest double does not.
    #[inline]
    pub fn is_in_range(&self, t: f64) -> bool {
        self.t_min <= t && t <= self.t_max && t.is_finite()
    }

    /// Whether a hit at a t within `bounds` counts, or `None` if it depends.
    #[inline]
    pub fn are_in_range(&self, bounds: Interval) -> Option<bool> {
        if bounds.high < self.t_min || bounds.low > self.t_max {
            Some(false)
        } else if self.t_min <= bounds.low && bounds.high <= self.t_max && bounds.high.is_finite() {
            Some(true)
        } else {
            None
        }
    }

    /// The meeting of the ray's line with the closed triangle, wherever on the line.
    ///
    /// NaN or infinite corners are never met: no sign of their edge functions is certain, and the
    /// exact path refuses them.
    #[inline]
    pub fn meet_line(&self, corners: [Vec3; 3]) -> Option<LineIntersection> {
        let edges = self.edges_of(&corners);
        match certain_sign_of(&edges) {
            Sign::Both => None,
            Sign::One(sign) => Some(LineIntersection { corners, edges, signs: [sign; 3] }),
            Sign::Open => self.meet_closely(corners, edges),
        }
    }

    /// [`PreparedRay::meet_line`] that goes on with what it finds instead of returning it: an answer
    /// from either path would go through memory, and reading at once what was just written stalls.
    #[inline(always)]
    pub fn intersect_line_then<T: TakeIntersection>(
        &self,
        corners: [Vec3; 3],
        face: u32,
        taker: &mut T,
    ) {
        let edges = self.edges_of(&corners);
        match certain_sign_of(&edges) {
            Sign::Both => {}
            Sign::One(sign) => {
                taker.take(self, &LineIntersection { corners, edges, signs: [sign; 3] }, face);
            }
            Sign::Open => self.meet_closely_then(corners, edges, face, taker),
        }
    }

    #[cold]
    #[inline(never)]
    fn meet_closely_then<T: TakeIntersection>(
        &self,
        corners: [Vec3; 3],
        edges: [Bounded; 3],
        face: u32,
        taker: &mut T,
    ) {
        if let Some(meeting) = self.meet_closely(corners, edges) {
            taker.take(self, &meeting, face);
        }
    }

    /// The three edge functions, each named by the corner opposite to the edge.
    #[inline(always)]
    fn edges_of(&self, [a, b, c]: &[Vec3; 3]) -> [Bounded; 3] {
        let (a, b, c) = (*a - self.origin, *b - self.origin, *c - self.origin);
        [
            edge_function(self.direction, b, c),
            edge_function(self.direction, c, a),
            edge_function(self.direction, a, b),
        ]
    }

    /// What [`PreparedRay::meet_line`] does where signs are open.
    #[cold]
    fn meet_closely(&self, corners: [Vec3; 3], edges: [Bounded; 3]) -> Option<LineIntersection> {
        let signs = self.exact_signs(&corners, &edges)?;
        let is_met = signs.contains(&1) != signs.contains(&-1);
        is_met.then_some(LineIntersection { corners, edges, signs })
    }

    /// The signs of edge functions; `None` for corners that are not finite.
    fn exact_signs(&self, corners: &[Vec3; 3], edges: &[Bounded; 3]) -> Option<[i8; 3]> {
        corners.iter().all(|corner| corner.is_finite()).then(|| {
            std::array::from_fn(|i| {
                let (p, q) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
                let exactly = || exact_edge_sign(self.origin, self.exact_direction(), p, q);
                edges[i].certain_sign().unwrap_or_else(exactly)
            })
        })
    }

    /// On which side of each edge the line passes, exactly: -1, 0 or 1 for the edges b-c, c-a and a-b.
    /// The line meets the triangle if no two of them are opposite, and not all are 0. `None` for
    /// corners that are not finite.
    pub fn edge_signs(&self, corners: &[Vec3; 3]) -> Option<[i8; 3]> {
        self.exact_signs(corners, &self.edges_of(corners))
    }
}

/// The order of hits along a ray: by t, and at equal t by face index.
#[inline]
pub fn is_nearer(hit: &Hit, than: &Hit) -> bool {
    hit.t < than.t || (hit.t == than.t && hit.face < than.face)
}

/// True if the triangle's corners, which are finite, lie on one line, exactly.
#[inline]
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
