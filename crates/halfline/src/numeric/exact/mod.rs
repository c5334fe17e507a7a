//! Exact sums and products of doubles, for the few signs that an error bound leaves open.
//!
//! Expansions are quick, but exact only while the errors of their products do not underflow; big
//! floats are exact for all finite doubles. [`DigitRange`] says which will do.

mod big_float;
mod expansion;

pub use big_float::BigFloat;
pub use expansion::Expansion;

use super::power_of_two::exponent_of;
use crate::geometry::Vec3;

/// A number that knows neither rounding nor underflow.
pub trait ExactNumber: Default {
    /// `a - b`.
    fn difference(a: f64, b: f64) -> Self;
    /// `self + other`.
    fn plus(&self, other: &Self) -> Self;
    /// `self - other`.
    fn minus(&self, other: &Self) -> Self;
    /// `self * factor`.
    fn scaled(&self, factor: f64) -> Self;
    /// `self * other`.
    fn times(&self, other: &Self) -> Self;
    /// -1, 0 or 1.
    fn sign(&self) -> i8;
}

/// Between which binary exponents the digits of some numbers lie, zeros left out.
#[derive(Clone, Copy, Debug)]
pub struct DigitRange {
    lowest: i32,
    highest: i32,
}

impl DigitRange {
    /// The digits of the number one.
    pub const OF_ONE: DigitRange = DigitRange { lowest: 0, highest: 0 };

    /// The digits of all coordinates of `points`.
    pub fn of(points: &[Vec3]) -> DigitRange {
        let mut range = DigitRange { lowest: 0, highest: 0 };
        for x in points.iter().flat_map(|point| point.to_array()) {
            if x != 0.0 {
                let exponent = exponent_of(x.abs());
                range.lowest = range.lowest.min(exponent - 52);
                range.highest = range.highest.max(exponent);
            }
        }
        range
    }

    /// True if sums of a dozen products, each of two differences of coordinates and a third number,
    /// are exact as expansions. Whatever occurs is a multiple of the product of the lowest digits:
    /// if that is no denormal's fraction, nothing underflows. And it is below 2^5 times the product
    /// of the highest, which [`Expansion`] can split below 2^996. NaN is beyond that.
    pub fn suits_expansions(coordinates: DigitRange, other: DigitRange) -> bool {
        2 * coordinates.lowest + other.lowest >= -1074
            && 2 * (coordinates.highest + 1) + other.highest + 1 < 990
    }
}
