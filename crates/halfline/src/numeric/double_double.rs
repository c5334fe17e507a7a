//! Error-free transformations and double-double arithmetic.
//!
//! T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math.
//! 18 (1971); J.-M. Muller et al., "Tight and rigorous error bounds for basic building blocks of
//! double-word arithmetic", ACM TOMS 44 (2017), whose bounds are named at the operations.
//!
//! Different here: products are split after Veltkamp and not fused, since a fused multiply-add
//! that the hardware lacks is a slow call; both give the same bits.

/// Half the distance from 1 to the next double: the largest relative error of one rounding.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// `a + b` as the rounded sum and its exact error (Knuth).
#[inline(always)]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_virtual = sum - a;
    let a_virtual = sum - b_virtual;
    (sum, (a - a_virtual) + (b - b_virtual))
}

/// [`two_sum`] for `|a| >= |b|` or `a == 0` (Dekker).
#[inline(always)]
pub fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// `a - b` as the rounded difference and its exact error.
#[inline(always)]
pub fn two_difference(a: f64, b: f64) -> (f64, f64) {
    two_sum(a, -b)
}

/// Cuts `a` into two halves of at most 26 bits that sum to it (Veltkamp). Exact for |a| < 2^996.
#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    const SPLITTER: f64 = 134_217_729.0; // 2^27 + 1
    let c = SPLITTER * a;
    let high = c - (c - a);
    (high, a - high)
}

/// `a * b` as the rounded product and its exact error (Dekker). Exact unless the error underflows,
/// that is for |a b| > 2^-968 or so.
#[inline(always)]
pub fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    let error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
    (product, error)
}

/// The unevaluated sum `high + low` with `|low|` at most half a unit in the last place of `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleDouble {
    /// The sum, rounded.
    pub high: f64,
    /// What rounding left out.
    pub low: f64,
}

impl DoubleDouble {
    /// `a - b`, exactly.
    #[inline(always)]
    pub fn difference(a: f64, b: f64) -> DoubleDouble {
        let (high, low) = two_difference(a, b);
        DoubleDouble { high, low }
    }

    /// Sum; relative error at most 3 u^2 (1 + 4 u) (AccurateDWPlusDW).
    #[inline(always)]
    pub fn plus(self, other: DoubleDouble) -> DoubleDouble {
        let (s_high, s_low) = two_sum(self.high, other.high);
        let (t_high, t_low) = two_sum(self.low, other.low);
        let (v_high, v_low) = fast_two_sum(s_high, s_low + t_high);
        let (high, low) = fast_two_sum(v_high, t_low + v_low);
        DoubleDouble { high, low }
    }

    /// Sum; error at most 4 u^2 (|self| + |other|), which is as good for a bound in terms of a
    /// permanent, and takes half as long (SloppyDWPlusDW).
    #[inline(always)]
    pub fn plus_loosely(self, other: DoubleDouble) -> DoubleDouble {
        let (s_high, s_low) = two_sum(self.high, other.high);
        let (high, low) = fast_two_sum(s_high, s_low + (self.low + other.low));
        DoubleDouble { high, low }
    }

    /// Difference; the error of [`DoubleDouble::plus_loosely`].
    #[inline(always)]
    pub fn minus_loosely(self, other: DoubleDouble) -> DoubleDouble {
        self.plus_loosely(DoubleDouble { high: -other.high, low: -other.low })
    }

    /// Difference; the error of [`DoubleDouble::plus`].
    #[inline(always)]
    pub fn minus(self, other: DoubleDouble) -> DoubleDouble {
        self.plus(DoubleDouble { high: -other.high, low: -other.low })
    }

    /// Product; relative error below 8 u^2 (DWTimesDW1 without fused operations).
    #[inline(always)]
    pub fn times(self, other: DoubleDouble) -> DoubleDouble {
        let (p_high, p_low) = two_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        let (high, low) = fast_two_sum(p_high, p_low + cross);
        DoubleDouble { high, low }
    }

    /// Product with a double; relative error below 3 u^2 (DWTimesFP1).
    #[inline(always)]
    pub fn times_double(self, other: f64) -> DoubleDouble {
        let (p_high, p_low) = two_product(self.high, other);
        let (high, low) = fast_two_sum(p_high, p_low + self.low * other);
        DoubleDouble { high, low }
    }

    /// Quotient; relative error below 16 u^2 (DWDivDW1, whose bound is 15 u^2 + 56 u^3).
    #[inline(always)]
    pub fn divided_by(self, other: DoubleDouble) -> DoubleDouble {
        let quotient = self.high / other.high;
        let remainder = self.minus(other.times_double(quotient));
        let (high, low) = fast_two_sum(quotient, remainder.high / other.high);
        DoubleDouble { high, low }
    }
}
