//! Where eight lines cross the planes of eight triangles, in single precision.

use crate::numeric::{MAX_DETERMINANT_ERROR, UNIT_ROUNDOFF};
use crate::simd::{Doubles, LANES, Numbers, Simd};

/// Eight lines and triangles, by lane: origins, directions, and corners, by axis.
pub type LineLanes = [[[f64; LANES]; 3]; 5];

/// t in single precision, for eight lines that are known to cross the planes of triangles, in plain
/// doubles: `n . (a - origin) / (n . direction)`. A bit for each that is known: not where its error
/// leaves two numbers to choose from, or something is so large or small that the error is not known.
#[inline(always)]
pub fn single_parameters<S: Simd>(simd: S, lanes: &LineLanes) -> ([f32; LANES], u32) {
    let wide = simd.doubles();
    let [origin, along, a, b, c] = [
        load(simd, &lanes[0]),
        load(simd, &lanes[1]),
        load(simd, &lanes[2]),
        load(simd, &lanes[3]),
        load(simd, &lanes[4]),
    ];
    let (ab, ac, oa) = (minus(simd, &b, &a), minus(simd, &c, &a), minus(simd, &a, &origin));
    let (mut numerator, mut determinant) = (wide.splat(0.0), wide.splat(0.0));
    let (mut numerator_permanent, mut determinant_permanent) = (numerator, numerator);
    let (mut largest, mut normal_permanents) = (numerator, numerator);
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let left = wide.times(ab[next], ac[last]);
        let right = wide.times(ab[last], ac[next]);
        let normal = wide.minus(left, right);
        let permanent = wide.plus(wide.magnitude(left), wide.magnitude(right));
        numerator = wide.multiply_add(normal, oa[axis], numerator);
        determinant = wide.multiply_add(normal, along[axis], determinant);
        let (far, fast) = (wide.magnitude(oa[axis]), wide.magnitude(along[axis]));
        numerator_permanent = wide.multiply_add(permanent, far, numerator_permanent);
        determinant_permanent = wide.multiply_add(permanent, fast, determinant_permanent);
        normal_permanents = wide.plus(normal_permanents, permanent);
        largest = wide.plus(largest, wide.plus(far, fast));
    }
    let inverse = wide.divided(wide.splat(1.0), determinant);
    let t = wide.times(numerator, inverse);

    // Where it is small, t and twice the inverse bound what the determinant's error does.
    let plain = wide.splat(PLAIN_ERROR);
    let twice = wide.times(wide.splat(2.0), wide.magnitude(t));
    let error = wide.multiply_add(twice, determinant_permanent, numerator_permanent);
    let error = wide.times(wide.times(error, plain), wide.magnitude(inverse));
    let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
    // A zero would keep its sign.
    simd.store(simd.plus(simd.narrow(wide.minus(t, error)), simd.splat(0.0)), &mut low);
    simd.store(simd.plus(simd.narrow(wide.plus(t, error)), simd.splat(0.0)), &mut high);
    let mut certain = 0;
    for lane in 0..LANES {
        certain |= u32::from(low[lane] == high[lane]) << lane;
    }

    // And where all is known: sums and products that are NaN are below nothing.
    let determinant = wide.magnitude(determinant);
    let (first, last) = (wide.splat(PLAIN_RANGE.start), wide.splat(PLAIN_RANGE.end));
    let numerator = wide.magnitude(numerator);
    let relative =
        wide.times(determinant_permanent, wide.splat(PLAIN_ERROR / MAX_DETERMINANT_ERROR));
    certain &= wide.are_below(relative, determinant)
        & wide.are_below(first, wide.least(determinant, numerator))
        & wide.are_below(wide.largest(determinant, numerator), last)
        & wide.are_below(wide.plus(largest, normal_permanents), last);
    (low, certain)
}

#[inline(always)]
fn load<S: Simd>(simd: S, lanes: &[[f64; LANES]; 3]) -> [Numbers<S>; 3] {
    let wide = simd.doubles();
    [wide.load(&lanes[0]), wide.load(&lanes[1]), wide.load(&lanes[2])]
}

#[inline(always)]
fn minus<S: Simd>(simd: S, p: &[Numbers<S>; 3], q: &[Numbers<S>; 3]) -> [Numbers<S>; 3] {
    let wide = simd.doubles();
    [wide.minus(p[0], q[0]), wide.minus(p[1], q[1]), wide.minus(p[2], q[2])]
}

/// Numbers in [`single_parameters`] that underflow, by up to 2^-1074, changes by less than a rounding,
/// even after two products with others of this range.
const PLAIN_RANGE: std::ops::Range<f64> =
    f64::from_bits((1023 - 300) << 52)..f64::from_bits((1023 + 200) << 52);

/// Error of numerator, determinant, and quotient in [`single_parameters`], in terms of the permanents:
/// three differences, two products, three sums, the inverse and its product, ten roundings; and the
/// permanents' own.
const PLAIN_ERROR: f64 = 16.0 * UNIT_ROUNDOFF;
