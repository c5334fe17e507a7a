//! [`LeafFilter::candidates`] on a vector unit.

use crate::numeric::{CornerLanes, LeafFilter};
use crate::simd::Simd;

/// A bit for each triangle that the line may meet; all others it misses for certain. The bounds hold
/// for fused and for separate roundings, so the sets of instructions may differ in what is left, but
/// in nothing that is met.
#[inline(always)]
pub fn candidates<S: Simd>(simd: S, filter: &LeafFilter, corners: &CornerLanes) -> u32 {
    // Project the corners along the line, which goes to the origin.
    let (axes, slope, center, error) = filter.parts();
    let slope = [simd.splat(slope[0]), simd.splat(slope[1])];
    let center = [simd.splat(center[0]), simd.splat(center[1])];
    let a = project(simd, axes, slope, center, &corners[0]);
    let b = project(simd, axes, slope, center, &corners[1]);
    let c = project(simd, axes, slope, center, &corners[2]);

    // Take the edge functions, their least and largest, and the bound on their error.
    let (u, v, w) = (edge(simd, c, b), edge(simd, a, c), edge(simd, b, a));
    let distance = simd.plus(simd.plus(length(simd, a), length(simd, b)), length(simd, c));
    let error = simd.multiply_add(simd.splat(error[0]), distance, simd.splat(error[1]));
    let least = simd.least(simd.least(u, v), w);
    let largest = simd.largest(simd.largest(u, v), w);

    // An infinite or NaN bound is certain of nothing: such triangles stay candidates.
    let negative = simd.are_below(least, simd.minus(simd.splat(0.0), error));
    let positive = simd.are_below(error, largest);
    !(negative & positive) & 0xff
}

// Functions and not closures, which could not be told to be compiled for the caller's instructions.

#[inline(always)]
fn project<S: Simd>(
    simd: S,
    axes: [usize; 3],
    slope: [S::Floats; 2],
    center: [S::Floats; 2],
    corner: &[[f32; 8]; 3],
) -> [S::Floats; 2] {
    let depth = simd.load(&corner[axes[2]]);
    let across = [simd.load(&corner[axes[0]]), simd.load(&corner[axes[1]])];
    [
        simd.minus(simd.subtract_product(slope[0], depth, across[0]), center[0]),
        simd.minus(simd.subtract_product(slope[1], depth, across[1]), center[1]),
    ]
}

#[inline(always)]
fn edge<S: Simd>(simd: S, p: [S::Floats; 2], q: [S::Floats; 2]) -> S::Floats {
    simd.subtract_product(p[1], q[0], simd.times(p[0], q[1]))
}

#[inline(always)]
fn length<S: Simd>(simd: S, p: [S::Floats; 2]) -> S::Floats {
    simd.plus(simd.magnitude(p[0]), simd.magnitude(p[1]))
}
