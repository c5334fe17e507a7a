//! Rays against triangles, in single precision: which are missed for certain, which are hit for
//! certain, and where.
//!
//! There is one kernel of eight lanes, in two shapes: one ray against the eight triangles of a leaf, and
//! one triangle against eight rays. For packets of rays there is also
//! a frustum, a line with a margin around it: what it misses is missed by all lines within the margin.
//!
//! With `EXACT` false the same kernel takes rounded signs and depths as they come, as most ray tracers do: to
//! measure what the bounds cost, and for nothing else.

use crate::rays::{ALL, RayFields, TraversalRay};
use crate::simd::{LANES, Simd};
use crate::tree::CornerLanes;

/// What is certain about eight pairs of ray and triangle.
pub struct F32Verdict<F> {
    /// A bit for each where the ray may hit the triangle.
    pub candidates: u32,
    /// A bit for each of those where it does, in the inside and within its range.
    pub certain: u32,
    /// A bit for each where the place is known.
    pub has_interval: u32,
    /// In the ray's parameter, a lower bound of where its line meets the triangle, if it does and the place is
    /// known.
    pub low: F,
    /// The upper bound.
    pub high: F,
}

/// Bound on how far errors of the weights move a mean of coordinates, in terms of the error of one
/// weight times the distance between the coordinates: 2, and roundings.
const MEAN_ERROR: f32 = 2.5;

/// How many times its error the sum of the weights must be for the mean to be any good.
const WELL_CONDITIONED: f32 = 8.0;

/// Rays by lane, or one ray in all lanes: what the kernel needs of them, beginning with the slopes, in the
/// order of [`RayFields`].
type Lines<S> = [<S as Simd>::F32x8; RayFields::COUNT - RayFields::SLOPE];

const SLOPE: usize = 0;
const CENTER: usize = RayFields::CENTER - RayFields::SLOPE;
const ERROR: usize = RayFields::ERROR - RayFields::SLOPE;
const DEPTH: usize = RayFields::DEPTH - RayFields::SLOPE;
const BEGIN: usize = RayFields::BEGIN - RayFields::SLOPE;
const END: usize = RayFields::END - RayFields::SLOPE;

/// Triangles by lane, or one in all lanes: by corner, the coordinates across the axis of projection and
/// the one along it.
type Corners<S> = [[<S as Simd>::F32x8; 3]; 3];

/// Holds a ray against the triangles of a leaf.
#[inline(always)]
pub fn test_leaf<S: Simd, const EXACT: bool>(
    simd: S,
    ray: &TraversalRay,
    corners: &CornerLanes,
) -> F32Verdict<S::F32x8> {
    let numbers = ray.fields();
    let mut line = [simd.splat(0.0); RayFields::COUNT - RayFields::SLOPE];
    for field in 0..line.len() {
        line[field] = simd.splat(numbers[RayFields::SLOPE + field]);
    }
    let axes = ray.projection.axes();
    test::<S, EXACT>(simd, &line, simd.splat(ray.limit), &triangles(simd, axes, corners))
}

/// Holds a ray of an octet against the triangles of a leaf.
#[inline(always)]
pub fn test_leaf_by_lane<S: Simd, const EXACT: bool>(
    simd: S,
    (fields, lane): (&RayFields, usize),
    limit: f32,
    axes: [usize; 3],
    corners: &CornerLanes,
) -> F32Verdict<S::F32x8> {
    let mut line = [simd.splat(0.0); RayFields::COUNT - RayFields::SLOPE];
    for field in 0..line.len() {
        line[field] = simd.splat(fields.at(RayFields::SLOPE + field, lane));
    }
    test::<S, EXACT>(simd, &line, simd.splat(limit), &triangles(simd, axes, corners))
}

/// Holds some of eight rays, whose projections have these axes, against one triangle of a leaf. `None`
/// if all of them miss it.
#[inline(always)]
pub fn test_octet<S: Simd, const EXACT: bool>(
    simd: S,
    (fields, lanes): (&RayFields, u32),
    limits: &[f32; LANES],
    axes: [usize; 3],
    (corners, lane): (&CornerLanes, usize),
) -> Option<F32Verdict<S::F32x8>> {
    let mut lines = [simd.splat(0.0); RayFields::COUNT - RayFields::SLOPE];
    for field in 0..lines.len() {
        lines[field] = fields.load(simd, RayFields::SLOPE + field);
    }
    let mut triangle = [[simd.splat(0.0); 3]; 3];
    for corner in 0..3 {
        for axis in 0..3 {
            triangle[corner][axis] = simd.splat(corners[corner][axes[axis]][lane]);
        }
    }
    // Most triangles are missed by most octets: for them half of the work is enough.
    let sides = sides::<S, EXACT>(simd, &lines, &triangle);
    if !sides.is_missed & lanes == 0 {
        return None;
    }
    Some(depth_interval::<S, EXACT>(simd, &lines, simd.load(limits), &triangle, &sides))
}

#[inline(always)]
fn triangles<S: Simd>(simd: S, axes: [usize; 3], corners: &CornerLanes) -> Corners<S> {
    let mut triangles = [[simd.splat(0.0); 3]; 3];
    for corner in 0..3 {
        for axis in 0..3 {
            triangles[corner][axis] = simd.load(&corners[corner][axes[axis]]);
        }
    }
    triangles
}

/// The kernel. The bounds hold for fused and for separate roundings, so the sets of instructions may
/// differ in what is certain, but in nothing that is met.
#[inline(always)]
fn test<S: Simd, const EXACT: bool>(
    simd: S,
    lines: &Lines<S>,
    limit: S::F32x8,
    corners: &Corners<S>,
) -> F32Verdict<S::F32x8> {
    let sides = sides::<S, EXACT>(simd, lines, corners);
    depth_interval::<S, EXACT>(simd, lines, limit, corners, &sides)
}

/// On which sides of a triangle's edges a line passes.
struct Sides<F> {
    edges: [F; 3],
    error: F,
    /// A bit for each line that misses it for certain.
    is_missed: u32,
    /// A bit for each line that passes through its inside for certain.
    is_crossed: u32,
}

/// The first half of the kernel.
#[inline(always)]
fn sides<S: Simd, const EXACT: bool>(
    simd: S,
    lines: &Lines<S>,
    corners: &Corners<S>,
) -> Sides<S::F32x8> {
    // Project the corners along the line, which goes to the origin.
    let slope = [lines[SLOPE], lines[SLOPE + 1]];
    let center = [lines[CENTER], lines[CENTER + 1]];
    let a = project(simd, slope, center, &corners[0]);
    let b = project(simd, slope, center, &corners[1]);
    let c = project(simd, slope, center, &corners[2]);

    // Take the edge functions, their least and largest, and the bound on their error.
    let (u, v, w) = (edge(simd, c, b), edge(simd, a, c), edge(simd, b, a));
    let distance = simd.add(simd.add(length(simd, a), length(simd, b)), length(simd, c));
    let error = if EXACT {
        simd.mul_add(lines[ERROR], distance, lines[ERROR + 1])
    } else {
        simd.splat(0.0)
    };
    let least = simd.min(simd.min(u, v), w);
    let largest = simd.max(simd.max(u, v), w);

    // An infinite or NaN bound is certain of nothing: such triangles stay candidates.
    let minus_error = simd.sub(simd.splat(0.0), error);
    let is_missed = simd.lt(least, minus_error) & simd.lt(error, largest);
    let is_crossed = simd.lt(error, least) | simd.lt(largest, minus_error);
    Sides { edges: [u, v, w], error, is_missed, is_crossed }
}

/// The second half.
#[inline(always)]
fn depth_interval<S: Simd, const EXACT: bool>(
    simd: S,
    lines: &Lines<S>,
    limit: S::F32x8,
    corners: &Corners<S>,
    sides: &Sides<S::F32x8>,
) -> F32Verdict<S::F32x8> {
    // Take the mean of the corners' depths, as a parameter, and what may be wrong there.
    let depths = [corners[0][2], corners[1][2], corners[2][2]];
    let ([u, v, w], error) = (sides.edges, sides.error);
    let sum = simd.add(simd.add(u, v), w);
    let inverse = simd.div(simd.splat(1.0), sum);
    let mean = simd.mul_add(v, depths[1], simd.mul(w, depths[2]));
    let mean = simd.mul(simd.mul_add(u, depths[0], mean), inverse);
    let at = simd.mul_add(mean, lines[DEPTH], lines[DEPTH + 1]);
    let nearest = simd.min(simd.min(depths[0], depths[1]), depths[2]);
    let farthest = simd.max(simd.max(depths[0], depths[1]), depths[2]);
    let extent = simd.mul(simd.sub(farthest, nearest), simd.splat(MEAN_ERROR));
    let share = simd.abs(simd.mul(error, inverse));
    let room = if EXACT { simd.mul_add(extent, share, lines[DEPTH + 2]) } else { simd.splat(0.0) };
    let (low, high) = (simd.sub(at, room), simd.add(at, room));

    // Which are out of range for certain, and which within it?
    let is_well_conditioned = simd.lt(simd.mul(error, simd.splat(WELL_CONDITIONED)), simd.abs(sum));
    let is_beyond = simd.lt(limit, low);
    let is_before = simd.lt(high, lines[BEGIN]);
    let is_within = simd.lt(lines[BEGIN + 1], low) & simd.lt(high, lines[END]);
    let candidates = !sides.is_missed & !(is_well_conditioned & (is_beyond | is_before)) & ALL;
    let certain = candidates & is_well_conditioned & sides.is_crossed & is_within;
    let candidates = if EXACT { candidates } else { certain };
    F32Verdict { candidates, certain, has_interval: is_well_conditioned, low, high }
}

/// A line, and how far from it others may be, across the axis along which they are projected, as far as
/// the scene goes.
#[derive(Clone, Copy, Default)]
pub struct Frustum {
    /// Of the line.
    pub slope: [f32; 2],
    /// Of the line.
    pub center: [f32; 2],
    /// How far from its projected corners, along both axes, those of another line may be found.
    pub margin: [f32; 2],
}

/// Room for the roundings of a bound.
const BOUND_ROUNDING: f32 = 1.0 + 1.0 / 1024.0;

impl Frustum {
    /// A bit for each triangle of a leaf that one of the lines may meet.
    ///
    /// Where corners are off by up to (p, q), an edge function is by up to q times the distances along
    /// the first axis, p times those along the second, and 2 p q: the bound of the leaf filter, with
    /// margins of their own for the axes.
    #[inline(always)]
    pub fn candidates<S: Simd>(&self, simd: S, axes: [usize; 3], corners: &CornerLanes) -> u32 {
        let slope = [simd.splat(self.slope[0]), simd.splat(self.slope[1])];
        let center = [simd.splat(self.center[0]), simd.splat(self.center[1])];
        let [p, q] = self.margin;
        let corners = triangles(simd, axes, corners);
        let a = project(simd, slope, center, &corners[0]);
        let b = project(simd, slope, center, &corners[1]);
        let c = project(simd, slope, center, &corners[2]);
        let (u, v, w) = (edge(simd, c, b), edge(simd, a, c), edge(simd, b, a));
        let across = [distance(simd, a[0], b[0], c[0]), distance(simd, a[1], b[1], c[1])];
        let least_error = simd.splat(2.0 * BOUND_ROUNDING * p * q);
        let error = simd.mul_add(simd.splat(p), across[1], least_error);
        let error = simd.mul_add(simd.splat(q), across[0], error);
        let least = simd.min(simd.min(u, v), w);
        let largest = simd.max(simd.max(u, v), w);
        let minus_error = simd.sub(simd.splat(0.0), error);
        !(simd.lt(least, minus_error) & simd.lt(error, largest)) & ALL
    }
}

#[inline(always)]
fn distance<S: Simd>(simd: S, a: S::F32x8, b: S::F32x8, c: S::F32x8) -> S::F32x8 {
    simd.add(simd.add(simd.abs(a), simd.abs(b)), simd.abs(c))
}

// Functions and not closures, which could not be told to be compiled for the caller's instructions.

#[inline(always)]
fn project<S: Simd>(
    simd: S,
    slope: [S::F32x8; 2],
    center: [S::F32x8; 2],
    [x, y, depth]: &[S::F32x8; 3],
) -> [S::F32x8; 2] {
    [
        simd.sub(simd.neg_mul_add(slope[0], *depth, *x), center[0]),
        simd.sub(simd.neg_mul_add(slope[1], *depth, *y), center[1]),
    ]
}

#[inline(always)]
fn edge<S: Simd>(simd: S, p: [S::F32x8; 2], q: [S::F32x8; 2]) -> S::F32x8 {
    simd.neg_mul_add(p[1], q[0], simd.mul(p[0], q[1]))
}

#[inline(always)]
fn length<S: Simd>(simd: S, p: [S::F32x8; 2]) -> S::F32x8 {
    simd.add(simd.abs(p[0]), simd.abs(p[1]))
}
