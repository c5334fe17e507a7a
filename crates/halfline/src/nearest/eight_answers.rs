//! Eight answers at once: the doubles nearest to distances, points and weights.
//!
//! The second rung of the rule ([`numeric`](crate::numeric)) in vectors: the same double-doubles with the same bounds
//! (docs/numerics.md, "Closest points"), for eight points whose closest points lie on the same kind of part. What
//! rounding leaves open goes the rule's own way, one by one; both are the nearest doubles, so nothing tells them apart.

use super::questions::Answers;
use crate::geometry::{ClosestPoint, Feature, Vec3};
use crate::numeric::{MeasureErrors, NearestPart, Region};
use crate::simd::{F64x8, Job, LANES, Simd, SimdF64};

/// A point whose nearest part is known.
#[derive(Clone, Copy)]
pub struct Found {
    /// Where its answer belongs.
    pub number: usize,
    /// The point.
    pub point: Vec3,
    /// The largest distance that counts.
    pub max_distance: f64,
    /// The part.
    pub part: NearestPart,
}

impl Found {
    /// The answer, unless it is too far away.
    fn put(&self, answer: ClosestPoint, answers: &mut Answers) {
        let is_near = answer.distance <= self.max_distance;
        answers.put(self.number, if is_near { &answer } else { &ClosestPoint::NONE });
    }
}

/// Those that wait for others of their kind: corners, edges, insides.
#[derive(Default)]
pub struct Waiting([Vec<Found>; 3]);

impl Waiting {
    /// Takes one more, and answers about eight of its kind if there are so many.
    #[inline(always)]
    pub fn push<S: Simd>(&mut self, simd: S, found: Found, answers: &mut Answers) {
        let kind = match found.part.region {
            Region::Corner(_) => 0,
            Region::Edge(_) => 1,
            Region::Inside => 2,
        };
        let queue = &mut self.0[kind];
        queue.push(found);
        if queue.len() == LANES {
            simd.outlined(EightAnswers { found: queue, answers });
        }
    }

    /// Answers about the rest.
    pub fn flush(&mut self, answers: &mut Answers) {
        for found in self.0.iter_mut().flat_map(|queue| queue.drain(..)) {
            found.put(found.part.closest_point(found.point), answers);
        }
    }
}

/// Up to eight of one kind, which are drained.
struct EightAnswers<'a, 'b> {
    found: &'a mut Vec<Found>,
    answers: &'a mut Answers<'b>,
}

impl Job for EightAnswers<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let EightAnswers { found, answers } = self;
        let Some(eight) = found.first_chunk::<LANES>() else { return };
        let lanes = match eight[0].part.region {
            Region::Corner(_) => of_corners(simd, eight),
            Region::Edge(_) => of_edges(simd, eight),
            Region::Inside => of_insides(simd, eight),
        };
        for (lane, found) in eight.iter().enumerate() {
            let answer = if lanes.certain >> lane & 1 == 1 {
                lanes.answer(lane, &found.part)
            } else {
                found.part.closest_point(found.point)
            };
            found.put(answer, answers);
        }
        found.clear();
    }
}

/// What is told of eight points, and a bit for each of which it is certain.
struct Rounded {
    certain: u32,
    distance: [f64; LANES],
    point: [[f64; LANES]; 3],
    /// Of the second and third corner; on an edge of its second end and its first.
    weights: [[f64; LANES]; 2],
}

impl Rounded {
    const NONE: Rounded = Rounded {
        certain: 0,
        distance: [0.0; LANES],
        point: [[0.0; LANES]; 3],
        weights: [[0.0; LANES]; 2],
    };

    #[inline(always)]
    fn answer(&self, lane: usize, part: &NearestPart) -> ClosestPoint {
        let NearestPart { face, corners, region, .. } = *part;
        let weights = [self.weights[0][lane], self.weights[1][lane]];
        let [x, y, z] = &self.point;
        let point = Vec3 { x: x[lane], y: y[lane], z: z[lane] };
        let ([u, v], point, feature) = match region {
            Region::Corner(0) => ([0.0, 0.0], corners[0], Feature::Vertex),
            Region::Corner(1) => ([1.0, 0.0], corners[1], Feature::Vertex),
            Region::Corner(_) => ([0.0, 1.0], corners[2], Feature::Vertex),
            Region::Edge(0) => ([weights[0], 0.0], point, Feature::Edge),
            Region::Edge(1) => ([weights[1], weights[0]], point, Feature::Edge),
            Region::Edge(_) => ([0.0, weights[1]], point, Feature::Edge),
            Region::Inside => (weights, point, Feature::Face),
        };
        ClosestPoint { distance: self.distance[lane], point, face, u, v, feature }
    }
}

/// Eight double-doubles.
#[derive(Clone, Copy)]
struct Wide<S: Simd> {
    high: F64x8<S>,
    low: F64x8<S>,
}

type Vector<S> = [Wide<S>; 3];

#[inline(always)]
fn two_sum<S: Simd>(simd: S, a: F64x8<S>, b: F64x8<S>) -> Wide<S> {
    let d = simd.doubles();
    let high = d.add(a, b);
    let b_virtual = d.sub(high, a);
    let a_virtual = d.sub(high, b_virtual);
    Wide { high, low: d.add(d.sub(a, a_virtual), d.sub(b, b_virtual)) }
}

#[inline(always)]
fn two_difference<S: Simd>(simd: S, a: F64x8<S>, b: F64x8<S>) -> Wide<S> {
    two_sum(simd, a, simd.doubles().sub(simd.doubles().splat(0.0), b))
}

#[inline(always)]
fn fast_two_sum<S: Simd>(simd: S, a: F64x8<S>, b: F64x8<S>) -> Wide<S> {
    let d = simd.doubles();
    let high = d.add(a, b);
    Wide { high, low: d.sub(b, d.sub(high, a)) }
}

#[inline(always)]
fn two_product<S: Simd>(simd: S, a: F64x8<S>, b: F64x8<S>) -> Wide<S> {
    let high = simd.doubles().mul(a, b);
    Wide { high, low: simd.doubles().product_error(a, b, high) }
}

/// Error at most 4 u² of the summands.
#[inline(always)]
fn plus<S: Simd>(simd: S, a: Wide<S>, b: Wide<S>) -> Wide<S> {
    let d = simd.doubles();
    let sum = two_sum(simd, a.high, b.high);
    fast_two_sum(simd, sum.high, d.add(sum.low, d.add(a.low, b.low)))
}

#[inline(always)]
fn minus<S: Simd>(simd: S, a: Wide<S>, b: Wide<S>) -> Wide<S> {
    let (d, zero) = (simd.doubles(), simd.doubles().splat(0.0));
    plus(simd, a, Wide { high: d.sub(zero, b.high), low: d.sub(zero, b.low) })
}

/// Relative error below 8 u².
#[inline(always)]
fn times<S: Simd>(simd: S, a: Wide<S>, b: Wide<S>) -> Wide<S> {
    let d = simd.doubles();
    let product = two_product(simd, a.high, b.high);
    let cross = d.add(d.mul(a.high, b.low), d.mul(a.low, b.high));
    fast_two_sum(simd, product.high, d.add(product.low, cross))
}

/// Relative error below 24 u²: a rounded quotient, and what it leaves, divided.
#[inline(always)]
fn divided_by<S: Simd>(simd: S, a: Wide<S>, b: Wide<S>) -> Wide<S> {
    let d = simd.doubles();
    let quotient = d.div(a.high, b.high);
    let product = two_product(simd, b.high, quotient);
    // The first difference is exact.
    let rest = d.sub(d.sub(a.high, product.high), product.low);
    let rest = d.add(rest, d.sub(a.low, d.mul(b.low, quotient)));
    fast_two_sum(simd, quotient, d.div(rest, b.high))
}

/// Relative error below 8 u².
#[inline(always)]
fn root<S: Simd>(simd: S, a: Wide<S>) -> Wide<S> {
    let d = simd.doubles();
    let high = d.sqrt(a.high);
    let square = two_product(simd, high, high);
    let rest = d.add(d.sub(d.sub(a.high, square.high), square.low), a.low);
    fast_two_sum(simd, high, d.div(rest, d.add(high, high)))
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: &Vector<S>, b: &Vector<S>) -> Wide<S> {
    let sum = plus(simd, times(simd, a[0], b[0]), times(simd, a[1], b[1]));
    plus(simd, sum, times(simd, a[2], b[2]))
}

#[inline(always)]
fn minor<S: Simd>(simd: S, a: &Vector<S>, b: &Vector<S>, i: usize, j: usize) -> Wide<S> {
    minus(simd, times(simd, a[i], b[j]), times(simd, a[j], b[i]))
}

#[inline(always)]
fn cross<S: Simd>(simd: S, a: &Vector<S>, b: &Vector<S>) -> Vector<S> {
    [minor(simd, a, b, 1, 2), minor(simd, a, b, 2, 0), minor(simd, a, b, 0, 1)]
}

/// The largest magnitude of a component.
#[inline(always)]
fn length<S: Simd>(simd: S, a: &Vector<S>) -> F64x8<S> {
    let d = simd.doubles();
    d.max(d.max(d.abs(a[0].high), d.abs(a[1].high)), d.abs(a[2].high))
}

/// A bit for each lane where a length allows bounds.
#[inline(always)]
fn in_range<S: Simd>(simd: S, length: F64x8<S>) -> u32 {
    let (d, errors) = (simd.doubles(), MeasureErrors::ALL);
    d.le(d.splat(errors.shortest), length) & d.le(length, d.splat(errors.longest))
}

/// Writes the nearest doubles to what may be off by `error`. Returns a bit for each of which that is certain.
#[inline(always)]
fn round<S: Simd>(simd: S, a: Wide<S>, error: F64x8<S>, rounded: &mut [f64; LANES]) -> u32 {
    let d = simd.doubles();
    let error = d.add(error, d.mul(d.splat(MeasureErrors::ALL.rounding), d.abs(a.high)));
    let least = d.add(a.high, d.sub(a.low, error));
    let most = d.add(a.high, d.add(a.low, error));
    d.store(least, rounded);
    d.le(most, least)
}

/// Eight points, by axis.
#[inline(always)]
fn gather<S: Simd>(simd: S, points: &[Vec3; LANES]) -> [F64x8<S>; 3] {
    let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        (x[lane], y[lane], z[lane]) = (points[lane].x, points[lane].y, points[lane].z);
    }
    [simd.doubles().set(x), simd.doubles().set(y), simd.doubles().set(z)]
}

#[inline(always)]
fn difference<S: Simd>(simd: S, a: &[F64x8<S>; 3], b: &[F64x8<S>; 3]) -> Vector<S> {
    [
        two_difference(simd, a[0], b[0]),
        two_difference(simd, a[1], b[1]),
        two_difference(simd, a[2], b[2]),
    ]
}

/// The points of eight, and some corner of each part.
#[inline(always)]
fn points_of<S: Simd>(simd: S, found: &[Found; LANES]) -> [F64x8<S>; 3] {
    let mut points = [Vec3::ZERO; LANES];
    for lane in 0..LANES {
        points[lane] = found[lane].point;
    }
    gather(simd, &points)
}

#[inline(always)]
fn corners_of<S: Simd>(simd: S, found: &[Found; LANES], from: usize) -> [F64x8<S>; 3] {
    let mut points = [Vec3::ZERO; LANES];
    for lane in 0..LANES {
        let first = match found[lane].part.region {
            Region::Corner(first) | Region::Edge(first) => first,
            Region::Inside => 0,
        };
        points[lane] = found[lane].part.corners[(first + from) % 3];
    }
    gather(simd, &points)
}

#[inline(always)]
fn of_corners<S: Simd>(simd: S, found: &[Found; LANES]) -> Rounded {
    let (d, errors) = (simd.doubles(), MeasureErrors::ALL);
    let mut rounded = Rounded::NONE;
    let (p, at) = (points_of(simd, found), corners_of(simd, found, 0));
    let arm = difference(simd, &p, &at);
    let distance = root(simd, dot(simd, &arm, &arm));
    let error = d.mul(d.splat(errors.corner), distance.high);
    rounded.certain =
        in_range(simd, length(simd, &arm)) & round(simd, distance, error, &mut rounded.distance);
    rounded
}

#[inline(always)]
fn of_edges<S: Simd>(simd: S, found: &[Found; LANES]) -> Rounded {
    let (d, errors) = (simd.doubles(), MeasureErrors::ALL);
    let mut rounded = Rounded::NONE;
    let (p, start) = (points_of(simd, found), corners_of(simd, found, 0));
    let side = difference(simd, &corners_of(simd, found, 1), &start);
    let arm = difference(simd, &p, &start);
    let (side_length, arm_length) = (length(simd, &side), length(simd, &arm));
    let t = divided_by(simd, dot(simd, &arm, &side), dot(simd, &side, &side));
    let step = [times(simd, side[0], t), times(simd, side[1], t), times(simd, side[2], t)];
    let apart =
        [minus(simd, arm[0], step[0]), minus(simd, arm[1], step[1]), minus(simd, arm[2], step[2])];
    let error = d.mul(d.splat(errors.edge), d.add(side_length, arm_length));
    let mut certain = in_range(simd, side_length) & in_range(simd, arm_length);
    certain &= in_range(simd, length(simd, &apart));
    let distance = root(simd, dot(simd, &apart, &apart));
    certain &= round(simd, distance, error, &mut rounded.distance);
    for axis in 0..3 {
        let zero = d.splat(0.0);
        let at = plus(simd, Wide { high: start[axis], low: zero }, step[axis]);
        let error = d.add(error, d.mul(d.splat(errors.sum), d.abs(start[axis])));
        certain &= round(simd, at, error, &mut rounded.point[axis]);
    }
    let error = d.div(error, side_length);
    certain &= round(simd, t, error, &mut rounded.weights[0]);
    let one = Wide { high: d.splat(1.0), low: d.splat(0.0) };
    let error = d.add(error, d.splat(errors.sum));
    certain &= round(simd, minus(simd, one, t), error, &mut rounded.weights[1]);
    rounded.certain = certain;
    rounded
}

#[inline(always)]
fn of_insides<S: Simd>(simd: S, found: &[Found; LANES]) -> Rounded {
    let (d, errors) = (simd.doubles(), MeasureErrors::ALL);
    let mut rounded = Rounded::NONE;
    let (p, a) = (points_of(simd, found), corners_of(simd, found, 0));
    let ab = difference(simd, &corners_of(simd, found, 1), &a);
    let ac = difference(simd, &corners_of(simd, found, 2), &a);
    let arm = difference(simd, &p, &a);
    let [ab_length, ac_length, arm_length] =
        [length(simd, &ab), length(simd, &ac), length(simd, &arm)];
    let mut certain = in_range(simd, ab_length) & in_range(simd, ac_length);
    certain &= in_range(simd, arm_length);

    let normal = cross(simd, &ab, &ac);
    let square = dot(simd, &normal, &normal);
    let normal_length = root(simd, square);
    let size = normal_length.high;
    let slenderness = d.div(d.mul(ab_length, ac_length), size);
    certain &= d.le(slenderness, d.splat(errors.most_slender));

    let height = dot(simd, &normal, &arm);
    let error = d.mul(d.mul(d.splat(errors.plane), slenderness), arm_length);
    let distance = divided_by(simd, height, normal_length);
    let is_below = d.lt(distance.high, d.splat(0.0));
    certain &= round(simd, distance, error, &mut rounded.distance);
    for lane in 0..LANES {
        if is_below >> lane & 1 == 1 {
            rounded.distance[lane] = -rounded.distance[lane];
        }
    }
    let share = divided_by(simd, height, square);
    for axis in 0..3 {
        let at = Wide { high: p[axis], low: d.splat(0.0) };
        let at = minus(simd, at, times(simd, normal[axis], share));
        let error = d.add(error, d.mul(d.splat(errors.sum), d.abs(p[axis])));
        certain &= round(simd, at, error, &mut rounded.point[axis]);
    }
    let across = [(cross(simd, &arm, &ac), ac_length), (cross(simd, &ab, &arm), ab_length)];
    let one = d.splat(1.0);
    let worst = d.mul(d.splat(errors.weight), d.max(slenderness, one));
    for (i, (across, other)) in across.iter().enumerate() {
        let weight = divided_by(simd, dot(simd, &normal, across), square);
        let error = d.mul(worst, d.add(d.div(d.mul(arm_length, *other), size), one));
        certain &= round(simd, weight, error, &mut rounded.weights[i]);
    }
    rounded.certain = certain;
    rounded
}
