//! Exact sums and products of doubles.
//!
//! J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates", Discrete & Computational Geometry 18 (1997): GROW-EXPANSION, SCALE-EXPANSION. An
//! expansion is a sum of doubles that do not overlap, smallest first; the sign of the
//! sum is the sign of the last.
//!
//! Different here: sums grow term by term and not by merging. The exact path is taken for one
//! candidate in thousands, so it is kept short.

use smallvec::SmallVec;

use super::ExactNumber;
use crate::numeric::double_double::{DoubleDouble, fast_two_sum, two_product, two_sum};

/// A number as a sum of doubles that do not overlap, in increasing magnitude, without zeros.
#[derive(Clone, Debug, Default)]
pub struct Expansion {
    terms: SmallVec<[f64; 12]>,
}

impl Expansion {
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
}

impl ExactNumber for Expansion {
    fn difference(a: f64, b: f64) -> Self {
        let DoubleDouble { high, low } = DoubleDouble::difference(a, b);
        let mut expansion = Self::default();
        expansion.push(low);
        expansion.push(high);
        expansion
    }

    fn plus(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        for &term in &other.terms {
            sum.grow(term);
        }
        sum
    }

    fn minus(&self, other: &Self) -> Self {
        let mut difference = self.clone();
        for &term in &other.terms {
            difference.grow(-term);
        }
        difference
    }

    /// The product with a number, by Shewchuk's SCALE-EXPANSION.
    fn scaled(&self, factor: f64) -> Self {
        let mut product = Self::default();
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

    fn times(&self, other: &Self) -> Self {
        other.terms.iter().fold(Self::default(), |sum, &term| sum.plus(&self.scaled(term)))
    }

    fn sign(&self) -> i8 {
        match self.terms.last() {
            None => 0,
            Some(&largest) if largest > 0.0 => 1,
            Some(_) => -1,
        }
    }
}
