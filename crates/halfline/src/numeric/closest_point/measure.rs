//! The second rung: double-doubles with a bound on their error.
//!
//! Differences of coordinates are exact. Lengths |x| are the largest component; bounds are derived in
//! docs/numerics.md, "Closest points".

use std::cmp::Ordering;

use super::region::{LONGEST, SHORTEST, is_in_range};
use super::{Region, Rounded};
use crate::geometry::Vec3;
use crate::numeric::UNIT_ROUNDOFF;
use crate::numeric::double_double::{DoubleDouble, two_product};
use crate::numeric::exact::BigFloat;

/// One rounding of a double-double.
const UNIT: f64 = UNIT_ROUNDOFF * UNIT_ROUNDOFF;

/// Error of a distance from a corner, in terms of itself.
const CORNER_ERROR: f64 = 64.0 * UNIT;

/// Error of a point of an edge and of the distance from it, in terms of |ap| + |ab|, and of where on the edge it is,
/// in terms of that by |ab|.
const EDGE_ERROR: f64 = 256.0 * UNIT;

/// Error of a point in a plane and of the distance from it, in terms of |ap| |ab| |ac| / |n|.
const PLANE_ERROR: f64 = 2048.0 * UNIT;

/// Error of the length of the normal, in terms of itself and of |ab| |ac| / |n| and one.
const NORMAL_ERROR: f64 = 128.0 * UNIT;

/// Error of a weight, in terms of |ap| |s| / |n| times the larger of one and |ab| |ac| / |n|, s being the other edge.
const WEIGHT_ERROR: f64 = 1024.0 * UNIT;

/// Error of a coordinate of the point that comes of its last sum, in terms of the summands.
const SUM_ERROR: f64 = 16.0 * UNIT;

/// Where |ab| |ac| / |n| is larger than this, the direction of the normal is not known well enough for the bounds.
const MOST_SLENDER: f64 = 1e12;

/// How far off a number may seem beyond its bound once that is added to it, in terms of itself.
const ROUNDING_ERROR: f64 = 4.0 * UNIT;

/// The bounds, for whoever computes the same in vectors.
pub struct MeasureErrors {
    /// [`CORNER_ERROR`].
    pub corner: f64,
    /// [`EDGE_ERROR`].
    pub edge: f64,
    /// [`PLANE_ERROR`].
    pub plane: f64,
    /// [`WEIGHT_ERROR`].
    pub weight: f64,
    /// [`SUM_ERROR`].
    pub sum: f64,
    /// [`ROUNDING_ERROR`].
    pub rounding: f64,
    /// [`MOST_SLENDER`].
    pub most_slender: f64,
    /// The shortest length that allows bounds.
    pub shortest: f64,
    /// The longest.
    pub longest: f64,
}

impl MeasureErrors {
    /// All of them.
    pub const ALL: MeasureErrors = MeasureErrors {
        corner: CORNER_ERROR,
        edge: EDGE_ERROR,
        plane: PLANE_ERROR,
        weight: WEIGHT_ERROR,
        sum: SUM_ERROR,
        rounding: ROUNDING_ERROR,
        most_slender: MOST_SLENDER,
        shortest: SHORTEST,
        longest: LONGEST,
    };
}

/// A number and how far off it may be.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    value: DoubleDouble,
    error: f64,
}

impl Bounded {
    const ZERO: Bounded = Bounded { value: double(0.0), error: 0.0 };

    /// Which is larger, if that is certain.
    pub fn compare(&self, other: &Bounded) -> Option<Ordering> {
        let difference = self.value.minus(other.value);
        let bound = 2.0 * (self.error + other.error)
            + SUM_ERROR * (self.value.high.abs() + other.value.high.abs());
        match difference.high {
            d if d > bound => Some(Ordering::Greater),
            d if d < -bound => Some(Ordering::Less),
            _ => None,
        }
    }

    /// The nearest double to whatever this may be, if that is one.
    fn rounded(&self) -> Option<f64> {
        let DoubleDouble { high, low } = self.value;
        let error = self.error + ROUNDING_ERROR * high.abs();
        let least = high + (low - error);
        (least == high + (low + error)).then_some(least)
    }
}

/// All that is told of a nearest point, nearly.
pub struct Measure {
    /// How far away.
    pub distance: Bounded,
    /// The length of the edge or of the normal, or one, with an error in terms of itself.
    divisor: Bounded,
    point: [Bounded; 3],
    weights: [Bounded; 2],
}

type Vector = [DoubleDouble; 3];

const fn double(x: f64) -> DoubleDouble {
    DoubleDouble { high: x, low: 0.0 }
}

#[inline(always)]
fn difference(a: Vec3, b: Vec3) -> Vector {
    [
        DoubleDouble::difference(a.x, b.x),
        DoubleDouble::difference(a.y, b.y),
        DoubleDouble::difference(a.z, b.z),
    ]
}

#[inline(always)]
fn dot(a: &Vector, b: &Vector) -> DoubleDouble {
    a[0].times(b[0]).plus_loosely(a[1].times(b[1])).plus_loosely(a[2].times(b[2]))
}

#[inline(always)]
fn minor(a: &Vector, b: &Vector, i: usize, j: usize) -> DoubleDouble {
    a[i].times(b[j]).minus_loosely(a[j].times(b[i]))
}

#[inline(always)]
fn cross(a: &Vector, b: &Vector) -> Vector {
    [minor(a, b, 1, 2), minor(a, b, 2, 0), minor(a, b, 0, 1)]
}

/// The root of a positive number, with a relative error below 8 u^2: one step of Newton's.
fn root(x: DoubleDouble) -> DoubleDouble {
    let high = x.high.sqrt();
    let (square, error) = two_product(high, high);
    let low = (((x.high - square) - error) + x.low) / (2.0 * high);
    double(high).plus(double(low))
}

fn length(v: &Vector) -> f64 {
    v[0].high.abs().max(v[1].high.abs()).max(v[2].high.abs())
}

fn minus(x: DoubleDouble) -> DoubleDouble {
    DoubleDouble { high: -x.high, low: -x.low }
}

impl Measure {
    /// What is told of the point of a part that holds the one nearest to `p`; `None` where no bound holds.
    pub fn new(p: Vec3, corners: [Vec3; 3], region: Region) -> Option<Measure> {
        match region {
            Region::Corner(corner) => Measure::of_corner(p, corners, corner),
            Region::Edge(edge) => Measure::of_edge(p, corners, edge),
            Region::Inside => Measure::of_inside(p, corners),
        }
    }

    fn of_corner(p: Vec3, corners: [Vec3; 3], corner: usize) -> Option<Measure> {
        let at = corners[corner];
        let known = |x: f64| Bounded { value: double(x), error: 0.0 };
        let weight = |of: usize| known(f64::from(u8::from(of == corner)));
        let arm = difference(p, at);
        let distance = if length(&arm) == 0.0 {
            Bounded::ZERO
        } else {
            is_in_range(length(&arm)).then_some(())?;
            let value = root(dot(&arm, &arm));
            Bounded { value, error: CORNER_ERROR * value.high }
        };
        Some(Measure {
            distance,
            divisor: known(1.0),
            point: [known(at.x), known(at.y), known(at.z)],
            weights: [weight(1), weight(2)],
        })
    }

    fn of_edge(p: Vec3, corners: [Vec3; 3], edge: usize) -> Option<Measure> {
        let next = (edge + 1) % 3;
        let start = corners[edge];
        let (side, arm) = (difference(corners[next], start), difference(p, start));
        let (side_length, arm_length) = (length(&side), length(&arm));
        (is_in_range(side_length) && is_in_range(arm_length)).then_some(())?;
        let square = dot(&side, &side);
        let divisor = Bounded { value: root(square), error: CORNER_ERROR };
        let t = dot(&arm, &side).divided_by(square);
        let error = EDGE_ERROR * (side_length + arm_length);
        let step = [side[0].times(t), side[1].times(t), side[2].times(t)];
        let apart = [
            arm[0].minus_loosely(step[0]),
            arm[1].minus_loosely(step[1]),
            arm[2].minus_loosely(step[2]),
        ];
        let distance = if length(&apart) == 0.0 {
            // Not known to be zero.
            Bounded { value: double(0.0), error }
        } else {
            is_in_range(length(&apart)).then_some(())?;
            Bounded { value: root(dot(&apart, &apart)), error }
        };
        let mut point = [Bounded::ZERO; 3];
        for axis in 0..3 {
            let value = double(start[axis]).plus(step[axis]);
            point[axis] = Bounded { value, error: error + SUM_ERROR * start[axis].abs() };
        }
        let weight = |of: usize| match of {
            _ if of == next => Bounded { value: t, error: error / side_length },
            _ if of == edge => {
                let rest = double(1.0).minus(t);
                Bounded { value: rest, error: error / side_length + SUM_ERROR }
            }
            _ => Bounded::ZERO,
        };
        Some(Measure { distance, divisor, point, weights: [weight(1), weight(2)] })
    }

    fn of_inside(p: Vec3, [a, b, c]: [Vec3; 3]) -> Option<Measure> {
        let (ab, ac, arm) = (difference(b, a), difference(c, a), difference(p, a));
        let lengths = [length(&ab), length(&ac), length(&arm)];
        lengths.into_iter().all(is_in_range).then_some(())?;
        let [ab_length, ac_length, arm_length] = lengths;
        let normal = cross(&ab, &ac);
        let square = dot(&normal, &normal);
        let size = square.high.sqrt();
        let slenderness = ab_length * ac_length / size;
        (slenderness < MOST_SLENDER).then_some(())?;

        // The way along the normal is that by the square of the normal's length, times the normal.
        let height = dot(&normal, &arm);
        let magnitude = if height.high < 0.0 { minus(height) } else { height };
        let error = PLANE_ERROR * slenderness * arm_length;
        let divisor = Bounded { value: root(square), error: NORMAL_ERROR * (slenderness + 1.0) };
        let distance = Bounded { value: magnitude.divided_by(divisor.value), error };
        let share = height.divided_by(square);
        let mut point = [Bounded::ZERO; 3];
        for axis in 0..3 {
            let value = double(p[axis]).minus(normal[axis].times(share));
            point[axis] = Bounded { value, error: error + SUM_ERROR * p[axis].abs() };
        }
        let weight = |across: Vector, other: f64| Bounded {
            value: dot(&normal, &across).divided_by(square),
            error: WEIGHT_ERROR * slenderness.max(1.0) * (arm_length * other / size + 1.0),
        };
        let weights = [weight(cross(&arm, &ac), ac_length), weight(cross(&ab, &arm), ab_length)];
        Some(Measure { distance, divisor, point, weights })
    }

    /// The double nearest to the distance, if that is certain given the exact numbers that it comes of.
    pub fn distance_from(&self, offsets: &[BigFloat; 3]) -> Option<f64> {
        let mut near = [double(0.0); 3];
        for (near, offset) in near.iter_mut().zip(offsets) {
            *near = offset.to_double_double()?;
        }
        let longest = length(&near);
        if longest == 0.0 {
            return Some(0.0);
        }
        is_in_range(longest).then_some(())?;
        let value = root(dot(&near, &near)).divided_by(self.divisor.value);
        let error = (self.divisor.error + CORNER_ERROR) * value.high;
        Bounded { value, error }.rounded()
    }

    /// The nearest doubles, as far as they are certain.
    pub fn rounded(&self) -> Rounded {
        let [x, y, z] = &self.point;
        let [u, v] = &self.weights;
        Rounded {
            distance: self.distance.rounded(),
            point: [x.rounded(), y.rounded(), z.rounded()],
            weights: [u.rounded(), v.rounded()],
        }
    }
}
