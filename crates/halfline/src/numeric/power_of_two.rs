//! Scaling by powers of two, which is exact unless it leaves the range of doubles.

use crate::geometry::Vec3;

/// 2^exponent, for exponents of normal doubles.
#[inline(always)]
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

/// The largest k with 2^k <= value, for a positive finite value, denormal or not.
#[inline(always)]
pub fn exponent_of(value: f64) -> i32 {
    let (value, shift) =
        if value < f64::MIN_POSITIVE { (value * power_of_two(54), 54) } else { (value, 0) };
    (value.to_bits() >> 52) as i32 - 1023 - shift
}

/// Two powers whose product is 2^exponent: a single one could itself be out of range. Beyond
/// +-2000, where every product is infinite or zero but for factors near the other end, the
/// exponent is cut off.
#[inline(always)]
pub fn two_powers(exponent: i32) -> [f64; 2] {
    let exponent = exponent.clamp(-2000, 2000);
    let half = exponent / 2;
    [power_of_two(half), power_of_two(exponent - half)]
}

/// `x * 2^exponent`; infinite where it is too large.
pub fn scale_by_power_of_two(x: f64, exponent: i32) -> f64 {
    let [a, b] = two_powers(exponent);
    x * a * b
}

/// [`scale_by_power_of_two`] for each coordinate.
#[inline(always)]
pub fn scale_vector(v: Vec3, exponent: i32) -> Vec3 {
    let [a, b] = two_powers(exponent);
    v * a * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_and_scales_reach_over_the_whole_range() {
        for (value, exponent) in
            [(1.0, 0), (1.99, 0), (2.0, 1), (0.5, -1), (5e-324, -1074), (f64::MAX, 1023)]
        {
            assert_eq!(exponent_of(value), exponent, "{value}");
        }
        assert_eq!(scale_by_power_of_two(5e-324, 1574), scale_by_power_of_two(1.0, 500));
        assert_eq!(scale_by_power_of_two(1.0, 1024), f64::INFINITY);
        assert_eq!(scale_by_power_of_two(f64::MAX, -1023), f64::MAX / 2.0 * power_of_two(-1022));
    }
}
