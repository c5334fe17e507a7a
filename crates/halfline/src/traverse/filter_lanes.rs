//! [`LeafFilter`](crate::numeric::LeafFilter)s for eight rays at once, on a vector unit.

use crate::numeric::{CENTER_ERROR, FARTHEST_CENTER, SINGLE_ROUNDOFF, SLACK};
use crate::simd::{F64x8, Simd, SimdF64};

/// Eight rays, by what is needed of them: the fields of [`LeafFilter`](crate::numeric::LeafFilter).
pub type FilterLanes<S> = [<S as Simd>::F32x8; 7];

/// Prepares eight rays, with origins in the frame, of which `from_origin` is the largest coordinate, for
/// corners whose frame coordinates are at most `reach`. As `LeafFilter::new` does for one, but that
/// bounds are in single precision.
#[inline(always)]
pub fn leaf_filters<S: Simd>(
    simd: S,
    longest: &Longest<S>,
    origin: &[F64x8<S>; 3],
    direction: &[F64x8<S>; 3],
    from_origin: S::F32x8,
    reach: f32,
) -> FilterLanes<S> {
    // Choose the axis along which to project, and where the line is there.
    let wide = simd.doubles();
    let ([a, b, c], [x, y, z]) = (*origin, *direction);
    let across = [longest.select_f64(simd, y, z, x), longest.select_f64(simd, z, x, y)];
    let start = [longest.select_f64(simd, b, c, a), longest.select_f64(simd, c, a, b)];
    let inverse = wide.div(wide.splat(1.0), longest.select_f64(simd, x, y, z));
    let depth = longest.select_f64(simd, a, b, c);
    let slope = [wide.mul(across[0], inverse), wide.mul(across[1], inverse)];
    let center = [
        simd.narrow(wide.sub(start[0], wide.mul(slope[0], depth))),
        simd.narrow(wide.sub(start[1], wide.mul(slope[1], depth))),
    ];

    // Bound the errors of a projected corner, and of a difference of two products.
    let (u, reach) = (SINGLE_ROUNDOFF as f32, reach.max(0.5));
    let farthest = simd.max(simd.abs(center[0]), simd.abs(center[1]));
    let center_error = simd.mul(from_origin, simd.splat(CENTER_ERROR as f32));
    let fixed_error = simd.add(center_error, simd.splat(8.0 * u * reach));
    let corner_error = simd.mul_add(farthest, simd.splat(2.0 * u), fixed_error);
    let largest = simd.add(simd.add(farthest, corner_error), simd.splat(2.0 * reach));
    let per_distance = simd.mul_add(largest, simd.splat(u), corner_error);
    let per_distance = simd.mul(per_distance, simd.splat(SLACK as f32));
    let twice = simd.mul(corner_error, simd.splat(2.0 * SLACK as f32));
    let at_least = simd.mul(corner_error, twice);

    // An infinite bound lets all triangles pass, also where something is NaN.
    let limit = simd.splat(FARTHEST_CENTER as f32);
    let infinite = simd.splat(f32::INFINITY);
    let unbounded = simd.select_lt(center_error, limit, simd.splat(0.0), infinite);
    let unbounded = simd.select_lt(farthest, limit, unbounded, infinite);
    [
        longest.axis(simd),
        simd.narrow(slope[0]),
        simd.narrow(slope[1]),
        center[0],
        center[1],
        simd.max(per_distance, unbounded),
        simd.max(at_least, unbounded),
    ]
}

/// The axes along which eight vectors are longest.
pub struct Longest<S: Simd> {
    size: [S::F32x8; 3],
    larger: [S::F32x8; 2],
    wide_size: [F64x8<S>; 3],
}

impl<S: Simd> Longest<S> {
    /// Of vectors, given by the magnitudes of their components.
    #[inline(always)]
    pub fn of(simd: S, size: [S::F32x8; 3]) -> Longest<S> {
        let larger = [simd.max(size[1], size[2]), size[2]];
        let wide_size = [simd.widen(size[0]), simd.widen(size[1]), simd.widen(size[2])];
        Longest { size, larger, wide_size }
    }

    /// What belongs to the axis of each.
    #[inline(always)]
    pub fn select(&self, simd: S, of_x: S::F32x8, of_y: S::F32x8, of_z: S::F32x8) -> S::F32x8 {
        let other = simd.select_lt(self.larger[1], self.size[1], of_y, of_z);
        simd.select_lt(self.larger[0], self.size[0], of_x, other)
    }

    /// The same in double precision.
    #[inline(always)]
    fn select_f64(&self, simd: S, of_x: F64x8<S>, of_y: F64x8<S>, of_z: F64x8<S>) -> F64x8<S> {
        select_by_size(simd, &self.wide_size, [of_x, of_y, of_z])
    }

    /// The axis in the lowest bits of a single-precision number.
    #[inline(always)]
    fn axis(&self, simd: S) -> S::F32x8 {
        let [x, y, z] = [simd.splat(UNITS), simd.splat(UNITS + 1.0), simd.splat(UNITS + 2.0)];
        self.select(simd, x, y, z)
    }
}

/// What belongs to the axis along which each of eight vectors is longest, by the magnitudes of their
/// components.
#[inline(always)]
pub fn select_by_size<S: Simd>(
    simd: S,
    size: &[F64x8<S>; 3],
    [of_x, of_y, of_z]: [F64x8<S>; 3],
) -> F64x8<S> {
    let wide = simd.doubles();
    let other = wide.select_lt(size[2], size[1], of_y, of_z);
    wide.select_lt(wide.max(size[1], size[2]), size[0], of_x, other)
}

/// From here on single-precision numbers have their units in the lowest bit.
pub const UNITS: f32 = 8_388_608.0;
