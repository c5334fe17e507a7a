//! [`LeafFilter`](crate::numeric::LeafFilter)s for eight rays at once, on a vector unit.

use crate::numeric::{CENTER_ERROR, FARTHEST_CENTER, SINGLE_ROUNDOFF, SLACK};
use crate::simd::{Doubles, Numbers, Simd};

/// Eight rays, by lane, or a ray, by what is needed of it: the fields of [`LeafFilter`].
pub type FilterLanes<S> = [<S as Simd>::Floats; 7];

/// Prepares eight rays, with origins in the frame, by axis, for corners whose frame coordinates are at
/// most `reach`, which is at least one half. The same as [`LeafFilter::new`] does for one.
#[inline(always)]
pub fn leaf_filters<S: Simd>(
    simd: S,
    origin: &[Numbers<S>; 3],
    direction: &[Numbers<S>; 3],
    reach: f64,
) -> FilterLanes<S> {
    // Choose the axis along which to project, and where the line is there.
    let wide = simd.doubles();
    let [a, b, c] = *origin;
    let longest = Longest::of(simd, direction);
    let [x, y, z] = *direction;
    let across = [longest.choose(simd, y, z, x), longest.choose(simd, z, x, y)];
    let start = [longest.choose(simd, b, c, a), longest.choose(simd, c, a, b)];
    let inverse = wide.divided(wide.splat(1.0), longest.choose(simd, x, y, z));
    let depth = longest.choose(simd, a, b, c);
    let slope = [wide.times(across[0], inverse), wide.times(across[1], inverse)];
    let center = [
        wide.minus(start[0], wide.times(slope[0], depth)),
        wide.minus(start[1], wide.times(slope[1], depth)),
    ];

    // Bound the errors of a projected corner, and of a difference of two products.
    let farthest = wide.largest(wide.magnitude(center[0]), wide.magnitude(center[1]));
    let from_origin = wide.largest(wide.magnitude(a), wide.magnitude(b));
    let from_origin = wide.largest(from_origin, wide.magnitude(c));
    let center_error = wide.times(from_origin, wide.splat(CENTER_ERROR));
    let corner_error = wide.multiply_add(
        farthest,
        wide.splat(SINGLE_ROUNDOFF * 2.0),
        wide.plus(center_error, wide.splat(SINGLE_ROUNDOFF * 8.0 * reach)),
    );
    let largest = wide.plus(wide.plus(farthest, corner_error), wide.splat(2.0 * reach));
    let per_distance = wide.multiply_add(largest, wide.splat(SINGLE_ROUNDOFF), corner_error);
    let per_distance = wide.times(per_distance, wide.splat(SLACK));
    let at_least = wide.times(wide.times(corner_error, corner_error), wide.splat(2.0 * SLACK));

    // An infinite bound lets all triangles pass, also where something is NaN.
    let limit = wide.splat(FARTHEST_CENTER);
    let infinite = wide.splat(f64::INFINITY);
    let unbounded = wide.if_below(center_error, limit, wide.splat(0.0), infinite);
    let unbounded = wide.if_below(farthest, limit, unbounded, infinite);
    let (per_distance, at_least) =
        (wide.largest(per_distance, unbounded), wide.largest(at_least, unbounded));
    [
        simd.narrow(longest.axis(simd)),
        simd.narrow(slope[0]),
        simd.narrow(slope[1]),
        simd.narrow(center[0]),
        simd.narrow(center[1]),
        simd.narrow(per_distance),
        simd.narrow(at_least),
    ]
}

/// The axes along which eight vectors are longest, as [`LeafFilter`] chooses them.
pub struct Longest<S: Simd> {
    size: [Numbers<S>; 3],
    larger: [Numbers<S>; 2],
}

impl<S: Simd> Longest<S> {
    /// Of vectors by axis.
    #[inline(always)]
    pub fn of(simd: S, direction: &[Numbers<S>; 3]) -> Longest<S> {
        let wide = simd.doubles();
        let [x, y, z] = *direction;
        let size = [wide.magnitude(x), wide.magnitude(y), wide.magnitude(z)];
        Longest { size, larger: [wide.largest(size[1], size[2]), size[2]] }
    }

    /// The number of each axis.
    #[inline(always)]
    pub fn choose(
        &self,
        simd: S,
        of_x: Numbers<S>,
        of_y: Numbers<S>,
        of_z: Numbers<S>,
    ) -> Numbers<S> {
        let wide = simd.doubles();
        let other = wide.if_below(self.larger[1], self.size[1], of_y, of_z);
        wide.if_below(self.larger[0], self.size[0], of_x, other)
    }

    /// The axis in the lowest bits of a single-precision number.
    #[inline(always)]
    fn axis(&self, simd: S) -> Numbers<S> {
        let wide = simd.doubles();
        let [x, y, z] = [wide.splat(UNITS), wide.splat(UNITS + 1.0), wide.splat(UNITS + 2.0)];
        self.choose(simd, x, y, z)
    }
}

/// From here on single-precision numbers have their units in the lowest bit.
pub const UNITS: f64 = 8_388_608.0;
