//! [`PreparedRay::hit`](crate::numeric::PreparedRay::hit) for eight lines and triangles at once.
//!
//! The same operations in the same order, none of them fused, so that u and v have the same bits;
//! t is the nearest double either way. Directions are as given and not scaled: where all that is
//! multiplied is neither very large nor very small, and not zero by a rounding, a power of two changes
//! no bit. The other lines are left open, as are those whose errors leave t or the weights in doubt.

use super::t_f32::{LineLanes, sub};
use crate::numeric::{
    BARYCENTRIC_ERROR, CORRECTION_ERROR, MAX_DETERMINANT_ERROR, POINT_ERROR, WEIGHT_ERROR,
};
use crate::simd::{F64x8, LANES, Simd, SimdF64};

/// Hits by lane.
pub struct HitLanes {
    /// Ray parameters.
    pub t: [f64; LANES],
    /// Weights of the second corners.
    pub u: [f64; LANES],
    /// Weights of the third corners.
    pub v: [f64; LANES],
    /// A bit for each that is what the scalar way gives.
    pub known: u32,
    /// A bit for each of which the weights are, at least.
    pub weights_known: u32,
}

/// What is multiplied is zero or in this range.
const PLAIN_RANGE: std::ops::Range<f64> =
    f64::from_bits((1023 - 150) << 52)..f64::from_bits((1023 + 150) << 52);

/// So that what is accurate here is accurate for the scalar way as well, whose errors have some more
/// terms, for underflow.
const STRICTER: f64 = 1.5;

/// Hits of lines that are known to meet the triangles.
#[inline(always)]
pub fn hit_f64x8<S: Simd>(simd: S, lanes: &LineLanes<S>) -> HitLanes {
    let wide = simd.doubles();
    let (zero, one) = (wide.splat(0.0), wide.splat(1.0));
    let [origin, direction, a, b, c] = *lanes;

    // Take the normal, and the approximate t.
    let (ab, ac) = (sub(simd, &b, &a), sub(simd, &c, &a));
    let normal = cross(simd, &ab, &ac);
    let normal_permanent = permanent(simd, &magnitudes(simd, &ab), &magnitudes(simd, &ac));
    let determinant = dot(simd, &normal, &direction);
    let inverse = wide.div(one, determinant);
    let speed = magnitudes(simd, &direction);
    let determinant_permanent = dot(simd, &normal_permanent, &speed);
    let numerator = dot(simd, &normal, &sub(simd, &a, &origin));
    let rough = wide.mul(numerator, inverse);

    // Take the point there relative to the first corner, and what of it may be wrong.
    let (mut at, mut at_low, mut reach, mut size) = ([zero; 3], [zero; 3], [zero; 3], [zero; 3]);
    for axis in 0..3 {
        let start = two_sum(simd, origin[axis], wide.sub(zero, a[axis]));
        let step = two_product(simd, rough, direction[axis]);
        let sum = two_sum(simd, start[0], step[0]);
        let rest = wide.add(sum[1], wide.add(start[1], step[1]));
        [at[axis], at_low[axis]] = two_sum(simd, sum[0], rest);
        size[axis] = wide.add(wide.abs(start[0]), wide.abs(step[0]));
        let error = wide.mul(wide.splat(POINT_ERROR), size[axis]);
        reach[axis] = wide.add(wide.abs(at[axis]), error);
    }

    // Correct t by the distance to the plane, and round it if its error allows.
    let determinant_error = wide.mul(wide.splat(WEIGHT_ERROR), determinant_permanent);
    let plane = Plane { normal, normal_permanent, inverse, determinant_error };
    let (low, high) = plane.corrected(simd, rough, &at, &reach);

    // Solve for the weights, with the permanents of both determinants.
    let p = cross(simd, &direction, &ac);
    let q = cross(simd, &at, &ab);
    let u = wide.mul(wide.sub(zero, dot(simd, &at, &p)), inverse);
    let v = wide.mul(wide.sub(zero, dot(simd, &direction, &q)), inverse);
    let p_permanent = permanent(simd, &speed, &magnitudes(simd, &ac));
    let q_permanent = permanent(simd, &reach, &magnitudes(simd, &ab));
    let error = wide.add(
        wide.add(dot(simd, &reach, &p_permanent), dot(simd, &speed, &q_permanent)),
        wide.mul(wide.splat(2.0), determinant_permanent),
    );
    let error = wide.mul(wide.splat(STRICTER * WEIGHT_ERROR), error);

    // A weight of zero may have come out below zero by the error, or as negative zero.
    let mut hits =
        HitLanes { t: [0.0; LANES], u: [0.0; LANES], v: [0.0; LANES], known: 0, weights_known: 0 };
    wide.store(low, &mut hits.t);
    wide.store(wide.add(wide.min(wide.max(u, zero), one), zero), &mut hits.u);
    wide.store(wide.add(wide.min(wide.max(v, zero), one), zero), &mut hits.v);

    // What is multiplied is zero or of a middle size.
    let slowness = wide.abs(determinant);
    let (mut least, mut largest) = (wide.min(wide.abs(low), slowness), slowness);
    for axis in 0..3 {
        for number in [at[axis], ab[axis], ac[axis], direction[axis]] {
            let size = wide.abs(number);
            largest = wide.max(size, largest);
            least = wide.min(wide.select_lt(zero, size, size, one), least);
        }
        largest = wide.max(wide.abs(origin[axis]), largest);
    }
    largest = wide.max(wide.abs(low), largest);
    let bound = wide.splat(MAX_DETERMINANT_ERROR / STRICTER);
    let accuracy = wide.mul(wide.splat(BARYCENTRIC_ERROR), slowness);
    hits.weights_known = wide.lt(determinant_error, wide.mul(bound, slowness))
        & wide.lt(error, accuracy)
        & wide.lt(wide.splat(PLAIN_RANGE.start), least)
        & wide.lt(largest, wide.splat(PLAIN_RANGE.end));
    hits.known = hits.weights_known & wide.le(high, low) & wide.le(low, high);
    if hits.known == hits.weights_known {
        return hits;
    }

    // Where its error does not, take the point relative to that with these weights instead of the first corner: it
    // lies in the plane as well, and what is left is little more than roundings.
    let (mut near, mut near_reach) = (at, reach);
    for axis in 0..3 {
        let minus_a = wide.sub(zero, a[axis]);
        let (ab, ac) = (two_sum(simd, b[axis], minus_a), two_sum(simd, c[axis], minus_a));
        let (of_b, of_c) = (two_product(simd, u, ab[0]), two_product(simd, v, ac[0]));
        let first = two_sum(simd, at[axis], wide.sub(zero, of_b[0]));
        let second = two_sum(simd, first[0], wide.sub(zero, of_c[0]));
        let lows = wide.add(at_low[axis], wide.add(first[1], second[1]));
        let of_lows = wide.add(wide.mul(u, ab[1]), wide.mul(v, ac[1]));
        let lows = wide.sub(lows, wide.add(of_lows, wide.add(of_b[1], of_c[1])));
        near[axis] = wide.add(second[0], lows);
        let parts = wide.add(wide.abs(of_b[0]), wide.abs(of_c[0]));
        let parts = wide.mul(wide.splat(2.0), wide.add(wide.abs(at[axis]), parts));
        let error = wide.mul(wide.splat(POINT_ERROR), wide.add(size[axis], parts));
        near_reach[axis] = wide.add(wide.abs(near[axis]), error);
    }
    let (low, high) = plane.corrected(simd, rough, &near, &near_reach);
    let settled = wide.le(high, low) & wide.le(low, high) & hits.weights_known & !hits.known;
    let mut t = [0.0; LANES];
    wide.store(low, &mut t);
    for lane in 0..LANES {
        hits.t[lane] = if settled >> lane & 1 == 1 { t[lane] } else { hits.t[lane] };
    }
    hits.known |= settled;
    hits
}

/// The planes of eight triangles, and how lines go through them.
struct Plane<F> {
    normal: [F; 3],
    normal_permanent: [F; 3],
    /// One over the product of the normal and the direction.
    inverse: F,
    /// What may be wrong with that product.
    determinant_error: F,
}

impl<F: Copy> Plane<F> {
    /// Two numbers between which t is, given about where it is, and the point there relative to one in the plane with
    /// the point's sizes and eight times what may be wrong with it, in roundings.
    #[inline(always)]
    fn corrected<S: Simd>(&self, simd: S, rough: F, at: &[F; 3], reach: &[F; 3]) -> (F, F)
    where
        S::F64: SimdF64<F64x8 = F>,
    {
        let wide = simd.doubles();
        let correction = wide.mul(dot(simd, &self.normal, at), self.inverse);
        let correction = wide.sub(wide.splat(0.0), correction);
        let twice = wide.mul(wide.splat(2.0), wide.abs(correction));
        let error = wide.add(
            wide.mul(wide.splat(CORRECTION_ERROR), dot(simd, &self.normal_permanent, reach)),
            wide.mul(twice, self.determinant_error),
        );
        let steepness = wide.abs(self.inverse);
        let error = wide.mul(wide.mul(error, wide.splat(STRICTER)), steepness);
        let low = wide.add(rough, wide.sub(correction, error));
        (low, wide.add(rough, wide.add(correction, error)))
    }
}

#[inline(always)]
fn magnitudes<S: Simd>(simd: S, a: &[F64x8<S>; 3]) -> [F64x8<S>; 3] {
    let wide = simd.doubles();
    [wide.abs(a[0]), wide.abs(a[1]), wide.abs(a[2])]
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[F64x8<S>; 3], b: &[F64x8<S>; 3]) -> F64x8<S> {
    let wide = simd.doubles();
    let xy = wide.add(wide.mul(a[0], b[0]), wide.mul(a[1], b[1]));
    wide.add(xy, wide.mul(a[2], b[2]))
}

#[inline(always)]
fn cross<S: Simd>(simd: S, a: &[F64x8<S>; 3], b: &[F64x8<S>; 3]) -> [F64x8<S>; 3] {
    let wide = simd.doubles();
    let mut product = *a;
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        product[axis] = wide.sub(wide.mul(a[next], b[last]), wide.mul(a[last], b[next]));
    }
    product
}

/// What a cross product would be if nothing cancelled, for vectors without negative components.
#[inline(always)]
fn permanent<S: Simd>(simd: S, a: &[F64x8<S>; 3], b: &[F64x8<S>; 3]) -> [F64x8<S>; 3] {
    let wide = simd.doubles();
    let mut product = *a;
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        product[axis] = wide.add(wide.mul(a[next], b[last]), wide.mul(a[last], b[next]));
    }
    product
}

/// Knuth's sum and its exact error, as in `numeric/double_double.rs`.
#[inline(always)]
fn two_sum<S: Simd>(simd: S, a: F64x8<S>, b: F64x8<S>) -> [F64x8<S>; 2] {
    let wide = simd.doubles();
    let sum = wide.add(a, b);
    let b_virtual = wide.sub(sum, a);
    let a_virtual = wide.sub(sum, b_virtual);
    [sum, wide.add(wide.sub(a, a_virtual), wide.sub(b, b_virtual))]
}

/// Dekker's product and its exact error, as there.
#[inline(always)]
fn two_product<S: Simd>(simd: S, a: F64x8<S>, b: F64x8<S>) -> [F64x8<S>; 2] {
    let wide = simd.doubles();
    let product = wide.mul(a, b);
    let ([a_high, a_low], [b_high, b_low]) = (split(simd, a), split(simd, b));
    let rest = wide.sub(product, wide.mul(a_high, b_high));
    let rest = wide.sub(rest, wide.mul(a_low, b_high));
    let rest = wide.sub(rest, wide.mul(a_high, b_low));
    [product, wide.sub(wide.mul(a_low, b_low), rest)]
}

#[inline(always)]
fn split<S: Simd>(simd: S, a: F64x8<S>) -> [F64x8<S>; 2] {
    let wide = simd.doubles();
    let c = wide.mul(wide.splat(134_217_729.0), a);
    let high = wide.sub(c, wide.sub(c, a));
    [high, wide.sub(a, high)]
}

#[cfg(test)]
mod tests;
