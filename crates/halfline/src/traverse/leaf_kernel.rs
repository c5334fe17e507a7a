//! A ray against the eight triangles of a leaf, in single precision: which it misses for certain,
//! which it hits for certain, and where.

use super::ray_group::{Columns, RayGroup, RayRows};
use super::wide_ray::{WideRay, World};
use crate::geometry::Ray;
use crate::numeric::{CornerLanes, UNIT_ROUNDOFF};
use crate::simd::{Job, LANES, Level, Simd};
use crate::tree::{KdTree, LeafBlock};

/// What is certain about eight triangles.
pub struct Verdict<F> {
    /// A bit for each that the ray may hit.
    pub candidates: u32,
    /// A bit for each of those that it hits, in the inside and within its range.
    pub certain: u32,
    /// A bit for each whose place is known.
    pub placed: u32,
    /// In the ray's parameter, two numbers between which its line meets the triangle, if it does and
    /// its place is known.
    pub low: F,
    /// The second.
    pub high: F,
}

/// Bound on how far errors of the weights move a mean of coordinates, in terms of the error of one
/// weight times the distance between the coordinates: 2, and roundings.
const MEAN_ERROR: f32 = 2.5;

/// How many times its error the sum of the weights must be for the mean to be any good.
const STABLE: f32 = 8.0;

/// Holds a ray against the triangles of a leaf. The bounds hold for fused and for separate roundings,
/// so the sets of instructions may differ in what is certain, but in nothing that is met.
#[inline(always)]
pub fn test<S: Simd>(simd: S, ray: &WideRay, corners: &CornerLanes) -> Verdict<S::Floats> {
    // Project the corners along the line, which goes to the origin.
    let (axes, slope, center, error) = ray.filter.parts();
    let slope = [simd.splat(slope[0]), simd.splat(slope[1])];
    let center = [simd.splat(center[0]), simd.splat(center[1])];
    let depths = [
        simd.load(&corners[0][axes[2]]),
        simd.load(&corners[1][axes[2]]),
        simd.load(&corners[2][axes[2]]),
    ];
    let a = project(simd, axes, slope, center, depths[0], &corners[0]);
    let b = project(simd, axes, slope, center, depths[1], &corners[1]);
    let c = project(simd, axes, slope, center, depths[2], &corners[2]);

    // Take the edge functions, their least and largest, and the bound on their error.
    let (u, v, w) = (edge(simd, c, b), edge(simd, a, c), edge(simd, b, a));
    let distance = simd.plus(simd.plus(length(simd, a), length(simd, b)), length(simd, c));
    let error = simd.multiply_add(simd.splat(error[0]), distance, simd.splat(error[1]));
    let least = simd.least(simd.least(u, v), w);
    let largest = simd.largest(simd.largest(u, v), w);

    // An infinite or NaN bound is certain of nothing: such triangles stay candidates.
    let minus_error = simd.minus(simd.splat(0.0), error);
    let is_missed = simd.are_below(least, minus_error) & simd.are_below(error, largest);
    let is_crossed = simd.are_below(error, least) | simd.are_below(largest, minus_error);

    // Take the mean of the corners' depths, as a parameter, and what may be wrong there.
    let sum = simd.plus(simd.plus(u, v), w);
    let inverse = simd.divided(simd.splat(1.0), sum);
    let mean = simd.multiply_add(v, depths[1], simd.times(w, depths[2]));
    let mean = simd.times(simd.multiply_add(u, depths[0], mean), inverse);
    let at = simd.multiply_add(mean, simd.splat(ray.depth.inverse), simd.splat(ray.depth.base));
    let nearest = simd.least(simd.least(depths[0], depths[1]), depths[2]);
    let farthest = simd.largest(simd.largest(depths[0], depths[1]), depths[2]);
    let extent = simd.times(simd.minus(farthest, nearest), simd.splat(MEAN_ERROR));
    let share = simd.magnitude(simd.times(error, inverse));
    let room = simd.multiply_add(extent, share, simd.splat(ray.depth.error));
    let (low, high) = (simd.minus(at, room), simd.plus(at, room));

    // Which are out of range for certain, and which within it?
    let is_stable = simd.are_below(simd.times(error, simd.splat(STABLE)), simd.magnitude(sum));
    let [begin, begun] = ray.depth.begin;
    let is_beyond = simd.are_below(simd.splat(ray.limit), low);
    let is_before = simd.are_below(high, simd.splat(begin));
    let is_within =
        simd.are_below(simd.splat(begun), low) & simd.are_below(high, simd.splat(ray.depth.end));
    let candidates = !is_missed & !(is_stable & (is_beyond | is_before)) & ALL;
    let certain = candidates & is_stable & is_crossed & is_within;
    Verdict { candidates, certain, placed: is_stable, low, high }
}

const ALL: u32 = (1 << LANES) - 1;

/// What single precision knows about a ray and the triangles of a leaf.
#[derive(Clone, Copy, Debug)]
pub struct LeafVerdict {
    /// A bit for each triangle that the ray may hit; it hits no other.
    pub candidates: u32,
    /// A bit for each of those that it hits for certain, neither on an edge nor at a corner.
    pub certain: u32,
    /// For each triangle two numbers between which t is if the ray's line meets it.
    pub bounds: [[f64; 2]; LANES],
}

/// Holds a ray against a leaf of a tree, as a batch does. `None` if the ray does not meet the root's
/// box, or is so large or so small, or so far away, that batches look at it by itself.
pub fn leaf_verdict(
    tree: &KdTree,
    ray: &Ray,
    block: &LeafBlock,
    level: Level,
) -> Option<LeafVerdict> {
    level.run(Judged { tree, ray, block })
}

struct Judged<'a> {
    tree: &'a KdTree,
    ray: &'a Ray,
    block: &'a LeafBlock,
}

impl Job for Judged<'_> {
    type Output = Option<LeafVerdict>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<LeafVerdict> {
        let tree = self.tree;
        let world = World { frame: tree.frame, root: tree.root.bounds, reach: tree.reach };
        let lanes = RayRows::lanes(simd, &[*self.ray; LANES]);
        let (mut rays, mut columns) = (RayGroup::none(), Columns::none());
        rays.set(simd, &lanes, &world, &mut columns);
        if rays.met & 1 == 0 || rays.single & 1 == 1 {
            return None;
        }
        let (wide, parameter) = rays.lane(0);
        let verdict = test(simd, wide, &self.block.corners);
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        simd.store(verdict.low, &mut low);
        simd.store(verdict.high, &mut high);
        let mut bounds = [[0.0; 2]; LANES];
        for lane in 0..LANES {
            let [a, b] = [parameter.t(low[lane]), parameter.t(high[lane])];
            let room = 8.0 * UNIT_ROUNDOFF * (a.abs() + b.abs() + parameter.t(0.0).abs());
            let is_placed = verdict.placed >> lane & 1 == 1;
            let unknown = [f64::NEG_INFINITY, f64::INFINITY];
            bounds[lane] = if is_placed { [a - room, b + room] } else { unknown };
        }
        Some(LeafVerdict { candidates: verdict.candidates, certain: verdict.certain, bounds })
    }
}

// Functions and not closures, which could not be told to be compiled for the caller's instructions.

#[inline(always)]
fn project<S: Simd>(
    simd: S,
    axes: [usize; 3],
    slope: [S::Floats; 2],
    center: [S::Floats; 2],
    depth: S::Floats,
    corner: &[[f32; 8]; 3],
) -> [S::Floats; 2] {
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
