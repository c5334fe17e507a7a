//! BigFloat sums, products and quotients of any finite doubles.
//!
//! A finite double is an integer times a power of two, and so are sums and products: big integers
//! hold them without any rounding, whatever their size.

use std::cmp::Ordering;

use smallvec::SmallVec;

use super::ExactNumber;
use crate::numeric::double_double::DoubleDouble;
use crate::numeric::power_of_two::scale_by_power_of_two;

/// Binary digits, 64 at a time, the least significant first.
type Limbs = SmallVec<[u64; 12]>;

/// `± limbs * 2^(64 * exponent)`. Neither the first nor the last limb is zero, so zero has none.
#[derive(Clone, Debug, Default)]
pub struct BigFloat {
    is_negative: bool,
    limbs: Limbs,
    exponent: i32,
}

impl BigFloat {
    /// The value of `x`, which is finite.
    pub fn from_double(x: f64) -> BigFloat {
        debug_assert!(x.is_finite());
        let bits = x.to_bits();
        let biased_exponent = (bits >> 52 & 0x7ff) as i32;
        let fraction = bits & ((1 << 52) - 1);
        let (significand, exponent) = match biased_exponent {
            0 => (fraction, -1074),
            normal => (fraction | 1 << 52, normal - 1075),
        };
        let shifted = u128::from(significand) << exponent.rem_euclid(64);
        let limbs = [shifted as u64, (shifted >> 64) as u64];
        BigFloat::new(x < 0.0, SmallVec::from_slice(&limbs), exponent.div_euclid(64))
    }

    fn new(is_negative: bool, mut limbs: Limbs, exponent: i32) -> BigFloat {
        while limbs.last() == Some(&0) {
            limbs.pop();
        }
        let zeros = limbs.iter().take_while(|&&limb| limb == 0).count();
        limbs.drain(..zeros);
        BigFloat { is_negative, limbs, exponent: exponent + zeros as i32 }
    }

    /// The limbs for a smaller `exponent`, the last of at least `length` being zero.
    fn aligned(&self, exponent: i32, length: usize) -> Limbs {
        let mut limbs = Limbs::from_elem(0, (self.exponent - exponent) as usize);
        limbs.extend_from_slice(&self.limbs);
        limbs.resize(length.max(limbs.len()), 0);
        limbs
    }

    /// The double nearest to `self / divisor`, ties to even: infinite beyond the largest double,
    /// and +0 for zero. `divisor` is not zero.
    pub fn quotient(&self, divisor: &BigFloat) -> f64 {
        if self.limbs.is_empty() {
            return 0.0;
        }
        // Shift dividend and divisor so that their quotient lies in [1, 2), and note how far.
        let (dividend_bits, divisor_bits) = (bit_length(&self.limbs), bit_length(&divisor.limbs));
        let bits = dividend_bits.max(divisor_bits);
        let length = bits / 64 + 2;
        let mut remainder = shifted_left(&self.limbs, bits - dividend_bits, length);
        let divided_by = shifted_left(&divisor.limbs, bits - divisor_bits, length);
        let mut exponent =
            dividend_bits as i32 - divisor_bits as i32 + 64 * (self.exponent - divisor.exponent);
        if compare(&remainder, &divided_by).is_lt() {
            double(&mut remainder);
            exponent -= 1;
        }

        // Doubles have 53 binary digits, denormals fewer: down to 2^-1074.
        let digits = (exponent + 1075).min(53);
        if digits < 0 {
            return 0.0;
        }
        let mut significand = 0u64;
        for _ in 0..digits {
            significand *= 2;
            if compare(&remainder, &divided_by).is_ge() {
                subtract(&mut remainder, &divided_by);
                significand += 1;
            }
            double(&mut remainder);
        }

        // Round to nearest: the remainder is now twice what is left, in units of the last digit.
        match compare(&remainder, &divided_by) {
            Ordering::Greater => significand += 1,
            Ordering::Equal => significand += significand & 1,
            Ordering::Less => {}
        }
        let magnitude = scale_by_power_of_two(significand as f64, exponent - digits + 1);
        if self.is_negative == divisor.is_negative { magnitude } else { -magnitude + 0.0 }
    }
}

impl BigFloat {
    /// The largest k with 2^k <= |self|; `None` for zero.
    fn binary_exponent(&self) -> Option<i32> {
        let bits = bit_length(&self.limbs) as i32;
        (bits > 0).then(|| bits + 64 * self.exponent - 1)
    }

    /// `self * 2^exponent`.
    fn times_power_of_two(&self, exponent: i32) -> BigFloat {
        let low = scale_by_power_of_two(1.0, exponent.rem_euclid(64));
        let mut product = self.scaled(low);
        product.exponent += exponent.div_euclid(64);
        product
    }

    /// The number in double-double, with a relative error below 2^-100; `None` outside of 2^-800 to 2^800.
    pub fn to_double_double(&self) -> Option<DoubleDouble> {
        let Some(exponent) = self.binary_exponent() else {
            return Some(DoubleDouble { high: 0.0, low: 0.0 });
        };
        (-800..=800).contains(&exponent).then_some(())?;
        // The first three limbs have 129 digits at least. Halves of limbs are doubles.
        let mut sum = DoubleDouble { high: 0.0, low: 0.0 };
        for (behind, &limb) in self.limbs.iter().rev().take(3).enumerate() {
            let unit = 64 * (self.exponent + (self.limbs.len() - 1 - behind) as i32);
            for half in [(limb >> 32) as f64 * 4_294_967_296.0, (limb & 0xffff_ffff) as f64] {
                let high = scale_by_power_of_two(half, unit);
                sum = sum.plus(DoubleDouble { high, low: 0.0 });
            }
        }
        let negated = DoubleDouble { high: -sum.high, low: -sum.low };
        Some(if self.is_negative { negated } else { sum })
    }

    /// The double nearest to the root of `self / divisor`, ties to even: infinite beyond the largest double.
    /// Neither number is negative, and `divisor` is not zero.
    pub fn root_of_quotient(&self, divisor: &BigFloat) -> f64 {
        let (Some(high), Some(low)) = (self.binary_exponent(), divisor.binary_exponent()) else {
            return 0.0;
        };

        // Come near to it from a quotient near one.
        let half = (high - low).div_euclid(2);
        let near_one = self.times_power_of_two(-2 * half).quotient(divisor).sqrt();
        let mut root = scale_by_power_of_two(near_one, half).min(f64::MAX);

        // Step to the neighbour as long as what is halfway to it is on this side.
        let halfway = |x: f64, y: f64| {
            // Beyond the largest double as far as the doubles before it are apart.
            let step = if y.is_finite() { y - x } else { x - x.next_down() };
            BigFloat::from_double(x).plus(&BigFloat::from_double(step).times_power_of_two(-1))
        };
        let beyond = |middle: BigFloat| self.minus(&middle.times(&middle).times(divisor)).sign();
        loop {
            let is_odd = root.to_bits() & 1 == 1;
            let above = beyond(halfway(root, root.next_up()));
            if above > 0 || (above == 0 && is_odd) {
                root = root.next_up();
                if root.is_infinite() {
                    return root;
                }
                continue;
            }
            if root == 0.0 {
                return 0.0;
            }
            let below = beyond(halfway(root.next_down(), root));
            if below > 0 || (below == 0 && !is_odd) {
                return root;
            }
            root = root.next_down();
        }
    }
}

impl ExactNumber for BigFloat {
    fn difference(a: f64, b: f64) -> Self {
        BigFloat::from_double(a).minus(&BigFloat::from_double(b))
    }

    fn plus(&self, other: &Self) -> Self {
        if self.limbs.is_empty() {
            return other.clone();
        }
        if other.limbs.is_empty() {
            return self.clone();
        }
        let exponent = self.exponent.min(other.exponent);
        let end = |x: &BigFloat| x.exponent + x.limbs.len() as i32;
        let length = (end(self).max(end(other)) - exponent) as usize + 1;
        let mut left = self.aligned(exponent, length);
        let mut right = other.aligned(exponent, length);
        if self.is_negative == other.is_negative {
            add(&mut left, &right);
            BigFloat::new(self.is_negative, left, exponent)
        } else if compare(&left, &right).is_ge() {
            subtract(&mut left, &right);
            BigFloat::new(self.is_negative, left, exponent)
        } else {
            subtract(&mut right, &left);
            BigFloat::new(other.is_negative, right, exponent)
        }
    }

    fn minus(&self, other: &Self) -> Self {
        let negated = BigFloat { is_negative: !other.is_negative, ..other.clone() };
        self.plus(&negated)
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Limbs::from_elem(0, self.limbs.len() + other.limbs.len());
        for (i, &x) in self.limbs.iter().enumerate() {
            let mut carry = 0;
            for (j, &y) in other.limbs.iter().enumerate() {
                let sum = u128::from(x) * u128::from(y) + u128::from(product[i + j]) + carry;
                product[i + j] = sum as u64;
                carry = sum >> 64;
            }
            product[i + other.limbs.len()] = carry as u64;
        }
        let is_negative = self.is_negative != other.is_negative;
        BigFloat::new(is_negative, product, self.exponent + other.exponent)
    }

    fn scaled(&self, factor: f64) -> Self {
        self.times(&BigFloat::from_double(factor))
    }

    fn sign(&self) -> i8 {
        match (self.limbs.is_empty(), self.is_negative) {
            (true, _) => 0,
            (false, true) => -1,
            (false, false) => 1,
        }
    }
}

/// Compares numbers of equal length.
fn compare(a: &Limbs, b: &Limbs) -> Ordering {
    a.iter().rev().cmp(b.iter().rev())
}

/// `a += b` for numbers of equal length whose sum has no more limbs.
fn add(a: &mut Limbs, b: &Limbs) {
    let mut carry = false;
    for (x, &y) in a.iter_mut().zip(b) {
        (*x, carry) = x.carrying_add(y, carry);
    }
}

/// `a -= b` for numbers of equal length with `a >= b`.
fn subtract(a: &mut Limbs, b: &Limbs) {
    let mut borrow = false;
    for (x, &y) in a.iter_mut().zip(b) {
        (*x, borrow) = x.borrowing_sub(y, borrow);
    }
}

/// `a *= 2` for a number whose last bit is free.
fn double(a: &mut Limbs) {
    let mut carry = 0;
    for limb in a.iter_mut() {
        (*limb, carry) = (*limb << 1 | carry, *limb >> 63);
    }
}

/// Number of binary digits of a number whose last limb is not zero.
fn bit_length(limbs: &Limbs) -> usize {
    64 * limbs.len() - limbs.last().map_or(0, |last| last.leading_zeros() as usize)
}

/// `limbs * 2^shift`, in `length` limbs, which suffice.
fn shifted_left(limbs: &Limbs, shift: usize, length: usize) -> Limbs {
    let mut shifted = Limbs::from_elem(0, length);
    for (i, &limb) in limbs.iter().enumerate() {
        let wide = u128::from(limb) << (shift % 64);
        shifted[i + shift / 64] |= wide as u64;
        shifted[i + shift / 64 + 1] |= (wide >> 64) as u64;
    }
    shifted
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_rational::BigRational;
    use num_traits::Signed;
    use proptest::prelude::*;

    /// Any finite double, and often one of few digits or at the ends of the range.
    fn doubles() -> impl Strategy<Value = f64> {
        prop_oneof![
            any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite()),
            (-9i32..10, -1080i32..1020).prop_map(|(m, e)| scale_by_power_of_two(f64::from(m), e)),
            (-4f64..4.0),
        ]
    }

    fn rational(x: f64) -> BigRational {
        BigRational::from_float(x).expect("finite")
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn signs_of_sums_of_products_are_exact(x in prop::array::uniform6(doubles())) {
            let [a, b, c, d, e, f] = x;
            let value = BigFloat::difference(a, b)
                .times(&BigFloat::difference(c, d))
                .minus(&BigFloat::from_double(e).scaled(f));
            let expected = (rational(a) - rational(b)) * (rational(c) - rational(d))
                - rational(e) * rational(f);
            prop_assert_eq!(i32::from(value.sign()), expected.cmp(&rational(0.0)) as i32);
            // A difference that cancels leaves nothing.
            prop_assert_eq!(value.minus(&value).sign(), 0);
        }

        #[test]
        fn quotients_are_the_nearest_doubles(x in prop::array::uniform4(doubles())) {
            let [a, b, c, d] = x;
            prop_assume!(c != 0.0 || d != 0.0);
            let (dividend, divisor) = (BigFloat::difference(a, b), BigFloat::difference(c, d));
            prop_assume!(divisor.sign() != 0);
            let found = dividend.quotient(&divisor);
            let exact = (rational(a) - rational(b)) / (rational(c) - rational(d));
            let largest = rational(f64::MAX);
            // Halfway between the largest double and the next power of two.
            let limit = &largest + rational(2f64.powi(970));
            if exact.abs() >= limit {
                prop_assert!(found.is_infinite() && (found > 0.0) == exact.is_positive());
            } else {
                prop_assert!(found.is_finite());
                let error = (rational(found) - &exact).abs();
                for neighbour in [found.next_down(), found.next_up()] {
                    if neighbour.is_finite() {
                        let other = (rational(neighbour) - &exact).abs();
                        let is_even = found.to_bits() & 1 == 0;
                        prop_assert!(error < other || (error == other && is_even));
                    }
                }
                prop_assert!(found != 0.0 || found.is_sign_positive());
            }
        }

        #[test]
        fn roots_of_quotients_are_the_nearest_doubles(x in prop::array::uniform3(doubles()), is_square: bool) {
            let [a, b, c] = x;
            prop_assume!(c != 0.0 && a.next_up().is_finite());
            // A square now and then, of a double or of what is halfway between two.
            let sum = BigFloat::from_double(a).plus(&BigFloat::from_double(a.next_up()).scaled(f64::from(u8::from(b > 0.0))));
            let (dividend, divisor) = if is_square {
                (sum.times(&sum), BigFloat::from_double(1.0))
            } else {
                (BigFloat::from_double(a.abs()).scaled(b.abs()), BigFloat::from_double(c.abs()))
            };
            let value = if is_square {
                let sum = rational(a) + if b > 0.0 { rational(a.next_up()) } else { rational(0.0) };
                &sum * &sum
            } else {
                rational(a.abs()) * rational(b.abs()) / rational(c.abs())
            };
            let found = dividend.root_of_quotient(&divisor);
            let middle = |x: f64, y: f64| (rational(x) + rational(y)) * rational(0.5);
            if found.is_infinite() {
                let limit = rational(f64::MAX) + rational(2f64.powi(970));
                prop_assert!(value >= &limit * &limit);
            } else {
                let next = found.next_up();
                let above = if next.is_finite() {
                    middle(found, next)
                } else {
                    rational(f64::MAX) + rational(2f64.powi(970))
                };
                let is_even = found.to_bits() & 1 == 0;
                let square = &above * &above;
                prop_assert!(value < square || (value == square && is_even));
                if found > 0.0 {
                    let below = middle(found.next_down(), found);
                    let square = &below * &below;
                    prop_assert!(value > square || (value == square && is_even));
                }
            }
        }

        #[test]
        fn double_doubles_have_a_hundred_digits(x in prop::array::uniform4(-1e9f64..1e9)) {
            let [a, b, c, d] = x;
            let value = BigFloat::difference(a, b).times(&BigFloat::difference(c, d)).scaled(a);
            let exact = (rational(a) - rational(b)) * (rational(c) - rational(d)) * rational(a);
            let DoubleDouble { high, low } = value.to_double_double().expect("in range");
            let error = (rational(high) + rational(low) - &exact).abs();
            prop_assert!(error <= exact.abs() * rational(2f64.powi(-100)));
        }

        #[test]
        fn quotients_of_products_are_undone(a in doubles(), b in doubles(), k in -60i32..60) {
            prop_assume!(b != 0.0);
            let product = BigFloat::from_double(a).scaled(b).scaled(2f64.powi(k));
            let expected = BigFloat::from_double(a).scaled(2f64.powi(k));
            let expected = expected.quotient(&BigFloat::from_double(1.0));
            prop_assert_eq!(product.quotient(&BigFloat::from_double(b)), expected);
        }
    }
}
