//! Where eight lines cross the planes of eight triangles, in single precision.

use crate::numeric::{MAX_DETERMINANT_ERROR, UNIT_ROUNDOFF};
use crate::simd::{F64x8, LANES, Simd, SimdF64};

/// Eight lines and triangles: origins, directions, and corners, by axis.
pub type LineLanes<S> = [[F64x8<S>; 3]; 5];

/// Where eight lines cross planes, in plain doubles.
pub struct PlaneT<S: Simd> {
    /// About t.
    pub t: F64x8<S>,
    /// Bound on its error; infinite or NaN where something is so large or small that it is not known.
    pub error: F64x8<S>,
}

/// t of eight lines and the planes of triangles, in plain doubles: `n . (a - origin) / (n . direction)`.
#[inline(always)]
pub fn plane_t<S: Simd>(simd: S, lanes: &LineLanes<S>) -> PlaneT<S> {
    let wide = simd.doubles();
    let [origin, along, a, b, c] = *lanes;
    let (ab, ac, oa) = (sub(simd, &b, &a), sub(simd, &c, &a), sub(simd, &a, &origin));
    let (mut numerator, mut determinant) = (wide.splat(0.0), wide.splat(0.0));
    let (mut numerator_permanent, mut determinant_permanent) = (numerator, numerator);
    let (mut largest, mut normal_permanents) = (numerator, numerator);
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let left = wide.mul(ab[next], ac[last]);
        let right = wide.mul(ab[last], ac[next]);
        let normal = wide.sub(left, right);
        let permanent = wide.add(wide.abs(left), wide.abs(right));
        numerator = wide.mul_add(normal, oa[axis], numerator);
        determinant = wide.mul_add(normal, along[axis], determinant);
        let (far, fast) = (wide.abs(oa[axis]), wide.abs(along[axis]));
        numerator_permanent = wide.mul_add(permanent, far, numerator_permanent);
        determinant_permanent = wide.mul_add(permanent, fast, determinant_permanent);
        normal_permanents = wide.add(normal_permanents, permanent);
        largest = wide.add(largest, wide.add(far, fast));
    }
    let inverse = wide.div(wide.splat(1.0), determinant);
    let t = wide.mul(numerator, inverse);

    // Where it is small, t and twice the inverse bound what the determinant's error does.
    let plain = wide.splat(PLAIN_ERROR);
    let twice = wide.mul(wide.splat(2.0), wide.abs(t));
    let error = wide.mul_add(twice, determinant_permanent, numerator_permanent);
    let error = wide.mul(wide.mul(error, plain), wide.abs(inverse));

    // And where all is known: sums and products that are NaN are below nothing.
    let unknown = wide.splat(f64::INFINITY);
    let (determinant, numerator) = (wide.abs(determinant), wide.abs(numerator));
    let (first, last) = (wide.splat(PLAIN_RANGE.start), wide.splat(PLAIN_RANGE.end));
    let relative = wide.mul(determinant_permanent, wide.splat(PLAIN_ERROR / MAX_DETERMINANT_ERROR));
    let sizes = wide.add(wide.add(largest, normal_permanents), wide.add(determinant, numerator));
    let error = wide.select_lt(relative, determinant, error, unknown);
    let error = wide.select_lt(first, wide.min(determinant, numerator), error, unknown);
    let error = wide.select_lt(sizes, last, error, unknown);
    PlaneT { t, error }
}

/// t in single precision, for eight lines that are known to cross the planes of triangles. A bit for each that is
/// known: not where its error leaves two numbers to choose from.
#[inline(always)]
pub fn t_f32x8<S: Simd>(simd: S, lanes: &LineLanes<S>) -> ([f32; LANES], u32) {
    let wide = simd.doubles();
    let PlaneT { t, error } = plane_t(simd, lanes);
    let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
    // A zero would keep its sign.
    simd.store(simd.add(simd.narrow(wide.sub(t, error)), simd.splat(0.0)), &mut low);
    simd.store(simd.add(simd.narrow(wide.add(t, error)), simd.splat(0.0)), &mut high);
    let mut certain = 0;
    for lane in 0..LANES {
        certain |= u32::from(low[lane] == high[lane]) << lane;
    }
    (low, certain)
}

/// `p - q`.
#[inline(always)]
pub fn sub<S: Simd>(simd: S, p: &[F64x8<S>; 3], q: &[F64x8<S>; 3]) -> [F64x8<S>; 3] {
    let wide = simd.doubles();
    [wide.sub(p[0], q[0]), wide.sub(p[1], q[1]), wide.sub(p[2], q[2])]
}

/// What in [`plane_t`] that underflow, by up to 2^-1074, changes by less than a rounding,
/// even after two products with others of this range.
const PLAIN_RANGE: std::ops::Range<f64> =
    f64::from_bits((1023 - 300) << 52)..f64::from_bits((1023 + 200) << 52);

/// Error of numerator, determinant, and quotient in [`plane_t`], in terms of the permanents:
/// three differences, two products, three sums, the inverse and its product, ten roundings; and the
/// permanents' own.
const PLAIN_ERROR: f64 = 16.0 * UNIT_ROUNDOFF;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Ray, Vec3, vec3};
    use crate::numeric::PreparedRay;
    use crate::simd::{Job, Level};

    struct Lines([[[f64; LANES]; 3]; 5]);

    impl Job for &Lines {
        type Output = ([f32; LANES], u32);

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> ([f32; LANES], u32) {
            let wide = simd.doubles();
            let mut lanes = [[wide.splat(0.0); 3]; 5];
            for row in 0..5 {
                for axis in 0..3 {
                    lanes[row][axis] = wide.set(self.0[row][axis]);
                }
            }
            t_f32x8(simd, &lanes)
        }
    }

    struct Random(u64);

    impl Random {
        /// In [-1, 1) (xorshift).
        fn signed(&mut self) -> f64 {
            for shift in [13, -7, 17] {
                self.0 ^= if shift > 0 { self.0 << shift } else { self.0 >> -shift };
            }
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        fn point(&mut self) -> Vec3 {
            vec3(self.signed(), self.signed(), self.signed())
        }
    }

    /// Casts lines at planes that they cross where `t_of` says, up to a rounding or two. Returns how
    /// many of how many were certain; those are right.
    fn check(t_of: impl Fn(&mut Random) -> f64, seed: u64) -> (usize, usize) {
        let (mut random, mut certain, mut all) = (Random(seed), 0, 0);
        for _ in 0..2000 {
            let mut lines = Lines([[[0.0; LANES]; 3]; 5]);
            let mut expected = [0.0f32; LANES];
            for lane in 0..LANES {
                let (origin, direction) = (random.point(), random.point());
                let at = origin + direction * t_of(&mut random);
                let (p, q) = (random.point(), random.point());
                let corners = [at - p, at + p * 2.0 - q, at + q];
                let prepared = PreparedRay::new(&Ray::new(origin, direction)).expect("valid");
                expected[lane] = prepared.parameter(&corners) as f32;
                let [a, b, c] = corners;
                for axis in 0..3 {
                    for (row, v) in [origin, direction, a, b, c].into_iter().enumerate() {
                        lines.0[row][axis][lane] = v[axis];
                    }
                }
            }
            for level in Level::available() {
                let (t, mask) = level.run(&lines);
                for lane in (0..LANES).filter(|lane| mask >> lane & 1 == 1) {
                    assert_eq!(t[lane], expected[lane], "{} {:?}", level.name(), lines.0);
                    certain += 1;
                }
                all += LANES;
            }
        }
        (certain, all)
    }

    #[test]
    fn what_is_certain_is_t_rounded() {
        let (certain, all) = check(|random| 1.5 + random.signed(), 7);
        assert!(certain * 1000 > all * 999, "{certain} of {all}");
    }

    /// Halfway between two single-precision numbers the last bits of a double decide.
    #[test]
    fn what_is_halfway_is_left_open() {
        let halfway = |random: &mut Random| {
            let t = (1.5 + random.signed()) as f32;
            (f64::from(t) + f64::from(t.next_up())) * 0.5
        };
        let (certain, all) = check(halfway, 8);
        assert!(certain * 10 < all, "{certain} of {all}");
    }

    #[test]
    fn what_may_underflow_or_overflow_is_left_open() {
        for size in [1e-110, 1e-70, 1e70, 1e150] {
            let (mut random, mut lines) = (Random(9), Lines([[[1.0; LANES]; 3]; 5]));
            for row in &mut lines.0 {
                for lane in row.iter_mut().flatten() {
                    *lane = random.signed() * size;
                }
            }
            for level in Level::available() {
                assert_eq!(level.run(&lines).1, 0, "{} {size}", level.name());
            }
        }
    }
}
