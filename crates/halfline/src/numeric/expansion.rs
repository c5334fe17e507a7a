//! Exact sums and products of doubles.
//!
//! J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates", Discrete & Computational Geometry 18 (1997): GROW-EXPANSION, SCALE-EXPANSION,
//! COMPRESS. An expansion is a sum of doubles that do not overlap, smallest first; the sign of the
//! sum is the sign of the last.
//!
//! Different here: sums grow term by term and not by merging. The exact path is taken for one
//! candidate in thousands, so it is kept short.

use std::cmp::Ordering;

use smallvec::SmallVec;

use super::double_double::{DoubleDouble, fast_two_sum, two_product, two_sum};

/// A number as a sum of doubles that do not overlap, in increasing magnitude, without zeros.
#[derive(Clone, Debug, Default)]
pub struct Expansion {
    terms: SmallVec<[f64; 24]>,
}

impl Expansion {
    /// `a - b`.
    pub fn difference(a: f64, b: f64) -> Expansion {
        Expansion::from_double_double(DoubleDouble::difference(a, b))
    }

    /// The value of `number`.
    pub fn from_double_double(number: DoubleDouble) -> Expansion {
        let mut expansion = Expansion::default();
        expansion.push(number.low);
        expansion.push(number.high);
        expansion
    }

    fn push(&mut self, term: f64) {
        if term != 0.0 {
            self.terms.push(term);
        }
    }

    /// Adds one double (GROW-EXPANSION).
    fn grow(&mut self, addend: f64) {
        let mut carry = addend;
        let mut kept = 0;
        for i in 0..self.terms.len() {
            let (sum, error) = two_sum(carry, self.terms[i]);
            if error != 0.0 {
                self.terms[kept] = error;
                kept += 1;
            }
            carry = sum;
        }
        self.terms.truncate(kept);
        self.push(carry);
    }

    /// `self + other`.
    pub fn plus(&self, other: &Expansion) -> Expansion {
        let mut sum = self.clone();
        for &term in &other.terms {
            sum.grow(term);
        }
        sum
    }

    /// `self - other`.
    pub fn minus(&self, other: &Expansion) -> Expansion {
        let mut difference = self.clone();
        for &term in &other.terms {
            difference.grow(-term);
        }
        difference
    }

    /// `self * factor` (SCALE-EXPANSION).
    pub fn scaled(&self, factor: f64) -> Expansion {
        let mut product = Expansion::default();
        let mut carry = 0.0;
        for &term in &self.terms {
            let (high, low) = two_product(term, factor);
            let (sum, error) = two_sum(carry, low);
            product.push(error);
            let (sum, error) = fast_two_sum(high, sum);
            product.push(error);
            carry = sum;
        }
        product.push(carry);
        product
    }

    /// `self * other`.
    pub fn times(&self, other: &Expansion) -> Expansion {
        other.terms.iter().fold(Expansion::default(), |sum, &term| sum.plus(&self.scaled(term)))
    }

    /// -1, 0 or 1.
    pub fn sign(&self) -> i8 {
        match self.terms.last() {
            None => 0,
            Some(&largest) if largest > 0.0 => 1,
            Some(_) => -1,
        }
    }

    /// The value to within one unit in the last place (COMPRESS, first pass).
    pub fn estimate(&self) -> f64 {
        self.terms.iter().sum()
    }

    /// The double nearest to `self / divisor`, ties to even. `divisor` is not zero.
    pub fn quotient(&self, divisor: &Expansion) -> f64 {
        if self.sign() == 0 {
            return 0.0;
        }
        let mut nearest = self.estimate() / divisor.estimate();

        // The estimate is off by a few units in the last place at most. Step towards the true
        // quotient until it lies between the midpoints to both neighbours.
        loop {
            if !nearest.is_finite() {
                return nearest;
            }
            let up = nearest.next_up();
            let down = nearest.next_down();
            if self.compare_to_midpoint(divisor, nearest, up) == Ordering::Greater {
                nearest = up;
            } else if self.compare_to_midpoint(divisor, nearest, down) == Ordering::Less {
                nearest = down;
            } else {
                break;
            }
        }
        for neighbour in [nearest.next_up(), nearest.next_down()] {
            let is_tie = self.compare_to_midpoint(divisor, nearest, neighbour) == Ordering::Equal;
            if is_tie && nearest.to_bits() & 1 == 1 {
                return neighbour;
            }
        }
        nearest
    }

    /// Compares `self / divisor` with the middle between two neighbouring doubles.
    fn compare_to_midpoint(&self, divisor: &Expansion, a: f64, b: f64) -> Ordering {
        // (b - a) / 2 is a power of two: exact unless it underflows.
        let half_step = 0.5 * (b - a);
        let product = divisor.scaled(a).plus(&divisor.scaled(half_step));
        (self.minus(&product).sign() * divisor.sign()).cmp(&0)
    }
}
