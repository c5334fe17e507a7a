//! [`LeafFilter`](crate::numeric::LeafFilter)s for eight rays at once, on a vector unit.

use crate::numeric::{CENTER_ERROR, FARTHEST_CENTER, SINGLE_ROUNDOFF, SLACK};
use crate::simd::{Doubles, Numbers, Simd};

/// Eight rays, by what is needed of them: the fields of [`LeafFilter`](crate::numeric::LeafFilter).
pub type FilterLanes<S> = [<S as Simd>::Floats; 7];

/// Prepares eight rays, with origins in the frame, of which `from_origin` is the largest coordinate, for
/// corners whose frame coordinates are at most `reach`. As `LeafFilter::new` does for one, but that
/// bounds are in single precision.
#[inline(always)]
pub fn leaf_filters<S: Simd>(
    simd: S,
    longest: &Longest<S>,
    origin: &[Numbers<S>; 3],
    direction: &[Numbers<S>; 3],
    from_origin: S::Floats,
    reach: f32,
) -> FilterLanes<S> {
    // Choose the axis along which to project, and where the line is there.
    let wide = simd.doubles();
    let ([a, b, c], [x, y, z]) = (*origin, *direction);
    let across = [longest.choose_wide(simd, y, z, x), longest.choose_wide(simd, z, x, y)];
    let start = [longest.choose_wide(simd, b, c, a), longest.choose_wide(simd, c, a, b)];
    let inverse = wide.divided(wide.splat(1.0), longest.choose_wide(simd, x, y, z));
    let depth = longest.choose_wide(simd, a, b, c);
    let slope = [wide.times(across[0], inverse), wide.times(across[1], inverse)];
    let center = [
        simd.narrow(wide.minus(start[0], wide.times(slope[0], depth))),
        simd.narrow(wide.minus(start[1], wide.times(slope[1], depth))),
    ];

    // Bound the errors of a projected corner, and of a difference of two products.
    let (u, reach) = (SINGLE_ROUNDOFF as f32, reach.max(0.5));
    let farthest = simd.largest(simd.magnitude(center[0]), simd.magnitude(center[1]));
    let center_error = simd.times(from_origin, simd.splat(CENTER_ERROR as f32));
    let fixed_error = simd.plus(center_error, simd.splat(8.0 * u * reach));
    let corner_error = simd.multiply_add(farthest, simd.splat(2.0 * u), fixed_error);
    let largest = simd.plus(simd.plus(farthest, corner_error), simd.splat(2.0 * reach));
    let per_distance = simd.multiply_add(largest, simd.splat(u), corner_error);
    let per_distance = simd.times(per_distance, simd.splat(SLACK as f32));
    let twice = simd.times(corner_error, simd.splat(2.0 * SLACK as f32));
    let at_least = simd.times(corner_error, twice);

    // An infinite bound lets all triangles pass, also where something is NaN.
    let limit = simd.splat(FARTHEST_CENTER as f32);
    let infinite = simd.splat(f32::INFINITY);
    let unbounded = simd.if_below(center_error, limit, simd.splat(0.0), infinite);
    let unbounded = simd.if_below(farthest, limit, unbounded, infinite);
    [
        longest.axis(simd),
        simd.narrow(slope[0]),
        simd.narrow(slope[1]),
        center[0],
        center[1],
        simd.largest(per_distance, unbounded),
        simd.largest(at_least, unbounded),
    ]
}

/// The axes along which eight vectors are longest.
pub struct Longest<S: Simd> {
    size: [S::Floats; 3],
    larger: [S::Floats; 2],
    wide_size: [Numbers<S>; 3],
}

impl<S: Simd> Longest<S> {
    /// Of vectors, given by the magnitudes of their components.
    #[inline(always)]
    pub fn of(simd: S, size: [S::Floats; 3]) -> Longest<S> {
        let larger = [simd.largest(size[1], size[2]), size[2]];
        let wide_size = [simd.widen(size[0]), simd.widen(size[1]), simd.widen(size[2])];
        Longest { size, larger, wide_size }
    }

    /// What belongs to the axis of each.
    #[inline(always)]
    pub fn choose(&self, simd: S, of_x: S::Floats, of_y: S::Floats, of_z: S::Floats) -> S::Floats {
        let other = simd.if_below(self.larger[1], self.size[1], of_y, of_z);
        simd.if_below(self.larger[0], self.size[0], of_x, other)
    }

    /// The same in double precision.
    #[inline(always)]
    fn choose_wide(
        &self,
        simd: S,
        of_x: Numbers<S>,
        of_y: Numbers<S>,
        of_z: Numbers<S>,
    ) -> Numbers<S> {
        choose_by_size(simd, &self.wide_size, [of_x, of_y, of_z])
    }

    /// The axis in the lowest bits of a single-precision number.
    #[inline(always)]
    fn axis(&self, simd: S) -> S::Floats {
        let [x, y, z] = [simd.splat(UNITS), simd.splat(UNITS + 1.0), simd.splat(UNITS + 2.0)];
        self.choose(simd, x, y, z)
    }
}

/// What belongs to the axis along which each of eight vectors is longest, by the magnitudes of their
/// components.
#[inline(always)]
pub fn choose_by_size<S: Simd>(
    simd: S,
    size: &[Numbers<S>; 3],
    [of_x, of_y, of_z]: [Numbers<S>; 3],
) -> Numbers<S> {
    let wide = simd.doubles();
    let other = wide.if_below(size[2], size[1], of_y, of_z);
    wide.if_below(wide.largest(size[1], size[2]), size[0], of_x, other)
}

/// From here on single-precision numbers have their units in the lowest bit.
pub const UNITS: f32 = 8_388_608.0;
