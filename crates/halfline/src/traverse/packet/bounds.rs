//! Bounds of the rays of a packet: by interval arithmetic for boxes, and as a frustum for triangles.
//!
//! S. Boulos, I. Wald, P. Shirley, "Geometric and Arithmetic Culling Methods for Entire Ray Packets", 2006.
//!
//! Different here: the interval arithmetic is relative to a point near the starts, since inverse directions and
//! starts vary together, and each by itself would give far wider bounds.

use crate::intersect::filter_f32::Frustum;
use crate::rays::{ALL, RayFields, RayOctet, RootFrame, projection_axes};
use crate::simd::{Job, LANES, Simd};
use crate::tree::Node;

/// How far rays of a packet may be apart somewhere in the scene, in terms of its size.
const WIDEST: f32 = 0.1;

/// Single-precision roundings of a position that the interval arithmetic adds to those of a ray.
const INTERVAL_ERROR: f32 = 8.0 * f32::EPSILON;

/// Room for the roundings of a frustum, in terms of the coordinates that it is found from.
const FRUSTUM_ERROR: f32 = 8.0 * f32::EPSILON;

/// Bounds of the rays along an axis, for `(plane - center) * inverse + base`.
#[derive(Clone, Copy, Default)]
struct AxisBounds {
    center: f32,
    /// The smallest and the largest.
    inverse: [f32; 2],
    /// The smallest and the largest base of near sides.
    near: [f32; 2],
    /// The smallest and the largest base of far sides.
    far: [f32; 2],
}

/// Bounds of the rays of a packet, which have the same octant and the same axis of projection.
#[derive(Clone, Copy)]
pub struct PacketBounds {
    /// The axes of the projection, that along which is projected last.
    pub axes: [usize; 3],
    /// Bit `axis` is set where the directions are negative.
    pub octant: u32,
    /// What the rays have in common as lines.
    pub frustum: Frustum,
    bounds: [AxisBounds; 3],
}

/// How the children of a node lie to all rays of a packet.
pub struct ChildBounds<F> {
    /// Lower bounds of where rays enter each child.
    pub entry: F,
    /// Upper bounds of where rays leave each child.
    pub exit: F,
    /// A bit for each child whose box all rays meet.
    pub met_by_all: u32,
}

impl PacketBounds {
    /// Bounds of the rays of some octets, if these have the same octant of directions and the same axis, and are
    /// near to each other all the way.
    #[inline(always)]
    pub fn of<S: Simd>(simd: S, octets: &[RayOctet], root: &RootFrame) -> Option<PacketBounds> {
        simd.outlined(BoundsJob { octets, root })
    }

    #[inline(always)]
    fn compute<S: Simd>(simd: S, octets: &[RayOctet], root: &RootFrame) -> Option<PacketBounds> {
        // No ray misses the scene or was prepared by itself, and none differs in kind.
        let first = octets.first()?;
        let (octant, last) =
            (first.fields.at(RayFields::OCTANT, 0), first.fields.at(RayFields::LAST, 0));
        let mut different = 0;
        for octet in octets {
            let octants = octet.fields.load(simd, RayFields::OCTANT);
            let lasts = octet.fields.load(simd, RayFields::LAST);
            different |= !octet.met & ALL | octet.fallback;
            different |= differing(simd, octants, octant) | differing(simd, lasts, last);
        }
        if different != 0 {
            return None;
        }

        // How far do they spread at the ends of the scene?
        let zero = simd.splat(0.0);
        let infinite = simd.splat(f32::INFINITY);
        let reach = simd.splat(root.reach);
        let mut least = [infinite; LANES];
        for octet in octets {
            for axis in 0..2 {
                let slope = octet.fields.load(simd, RayFields::SLOPE + axis);
                let center = octet.fields.load(simd, RayFields::CENTER + axis);
                let before = simd.neg_mul_add(slope, reach, center);
                let behind = simd.mul_add(slope, reach, center);
                least[4 * axis] = simd.min(before, least[4 * axis]);
                least[4 * axis + 1] = simd.min(simd.sub(zero, before), least[4 * axis + 1]);
                least[4 * axis + 2] = simd.min(behind, least[4 * axis + 2]);
                least[4 * axis + 3] = simd.min(simd.sub(zero, behind), least[4 * axis + 3]);
            }
        }
        let ends = min_of_each(simd, least);
        let mut frustum = Frustum::default();
        for axis in 0..2 {
            let [low, high] = [ends[4 * axis], -ends[4 * axis + 1]];
            let [low_behind, high_behind] = [ends[4 * axis + 2], -ends[4 * axis + 3]];
            let spreads = [high - low, high_behind - low_behind];
            let widest = WIDEST * root.reach;
            // A spread that is NaN is not below anything.
            let is_narrow = (spreads[0] <= widest) & (spreads[1] <= widest);
            if !is_narrow {
                return None;
            }
            let spread = spreads[0].max(spreads[1]);
            let (before, behind) = ((low + high) * 0.5, (low_behind + high_behind) * 0.5);
            frustum.slope[axis] = (behind - before) * 0.5 / root.reach;
            frustum.center[axis] = (behind + before) * 0.5;
            let size = root.reach + before.abs() + behind.abs();
            frustum.margin[axis] = spread * 0.5 + FRUSTUM_ERROR * size;
        }

        // Bound what meets boxes.
        let mut centers = [0.0; 3];
        for axis in 0..3 {
            let fields = &first.fields;
            centers[axis] = -fields.at(RayFields::NEAR + axis, 0) / fields.at(axis, 0);
        }
        let mut sides = [infinite; LANES];
        let mut others = [infinite; LANES];
        let mut inverses = [infinite; LANES];
        for octet in octets {
            for axis in 0..3 {
                let center = simd.splat(centers[axis]);
                let inverse = octet.fields.load(simd, axis);
                let near = octet.fields.load(simd, RayFields::NEAR + axis);
                let far = octet.fields.load(simd, RayFields::FAR + axis);
                let near = simd.mul_add(center, inverse, near);
                let far = simd.mul_add(center, inverse, far);
                sides[axis] = simd.min(near, sides[axis]);
                sides[3 + axis] = simd.min(simd.sub(zero, far), sides[3 + axis]);
                others[axis] = simd.min(simd.sub(zero, near), others[axis]);
                others[3 + axis] = simd.min(far, others[3 + axis]);
                inverses[axis] = simd.min(inverse, inverses[axis]);
                inverses[3 + axis] = simd.min(simd.sub(zero, inverse), inverses[3 + axis]);
            }
            let error = octet.fields.load(simd, RayFields::ERROR);
            inverses[6] = simd.min(simd.sub(zero, error), inverses[6]);
        }
        let mut bounds = [AxisBounds::default(); 3];
        let (sides, others) = (min_of_each(simd, sides), min_of_each(simd, others));
        let inverses = min_of_each(simd, inverses);
        for axis in 0..3 {
            let (center, inverse) = (centers[axis], [inverses[axis], -inverses[3 + axis]]);
            let steepest = inverse[0].abs().max(inverse[1].abs());
            let room = INTERVAL_ERROR * (root.reach + center.abs()) * steepest;
            let near = [sides[axis] - room, room - others[axis]];
            let far = [others[3 + axis] - room, room - sides[3 + axis]];
            if !(near[0].is_finite() && far[1].is_finite()) {
                return None;
            }
            bounds[axis] = AxisBounds { center, inverse, near, far };
        }
        // The error of an edge function for each unit of distance is no less than that of a corner.
        frustum.margin = [frustum.margin[0] - inverses[6], frustum.margin[1] - inverses[6]];
        let axes = projection_axes(first.fields.last(0));
        Some(PacketBounds { axes, octant: octant.to_bits() & 7, bounds, frustum })
    }

    /// About how many of so many leaves the rays pass through, if these lie side by side on one surface.
    pub fn leaves_of(&self, leaves: usize, root: &RootFrame) -> f32 {
        let [p, q] = self.frustum.margin;
        let share = p.max(q) / root.reach;
        leaves as f32 * share * share
    }

    /// Holds the boxes of a node's children against all rays, up to `limit`.
    #[inline(always)]
    pub fn meet_children<S: Simd>(
        &self,
        simd: S,
        node: &Node,
        limit: f32,
    ) -> ChildBounds<S::F32x8> {
        let mut near = simd.splat(0.0);
        let mut far = simd.splat(limit);
        let (mut latest, mut soonest) = (simd.splat(0.0), simd.splat(f32::INFINITY));
        for axis in 0..3 {
            let bounds = &self.bounds[axis];
            let side = (self.octant >> axis & 1) as usize;
            let center = simd.splat(bounds.center);
            let inverse = [simd.splat(bounds.inverse[0]), simd.splat(bounds.inverse[1])];
            let near_sides = simd.sub(simd.load(&node.sides[axis][side]), center);
            let far_sides = simd.sub(simd.load(&node.sides[axis][1 - side]), center);
            let enter = [simd.mul(near_sides, inverse[0]), simd.mul(near_sides, inverse[1])];
            let leave = [simd.mul(far_sides, inverse[0]), simd.mul(far_sides, inverse[1])];
            let enter_first = simd.add(simd.min(enter[0], enter[1]), simd.splat(bounds.near[0]));
            let enter_last = simd.add(simd.max(enter[0], enter[1]), simd.splat(bounds.near[1]));
            let leave_first = simd.add(simd.min(leave[0], leave[1]), simd.splat(bounds.far[0]));
            let leave_last = simd.add(simd.max(leave[0], leave[1]), simd.splat(bounds.far[1]));
            near = simd.max(enter_first, near);
            far = simd.min(leave_last, far);
            latest = simd.max(enter_last, latest);
            soonest = simd.min(leave_first, soonest);
        }
        ChildBounds { entry: near, exit: far, met_by_all: simd.lt(latest, soonest) }
    }
}

/// Finds bounds in a function of its own: all questions call the same.
struct BoundsJob<'a> {
    octets: &'a [RayOctet],
    root: &'a RootFrame,
}

impl Job for BoundsJob<'_> {
    type Output = Option<PacketBounds>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<PacketBounds> {
        PacketBounds::compute(simd, self.octets, self.root)
    }
}

/// A bit for each number that is not this one.
#[inline(always)]
fn differing<S: Simd>(simd: S, a: S::F32x8, b: f32) -> u32 {
    let b = simd.splat(b);
    simd.lt(a, b) | simd.lt(b, a)
}

/// The smallest number of each of eight vectors, none of which is NaN.
#[inline(always)]
fn min_of_each<S: Simd>(simd: S, a: [S::F32x8; LANES]) -> [f32; LANES] {
    let columns = simd.transpose(a);
    let mut least = columns[0];
    for column in 1..LANES {
        least = simd.min(columns[column], least);
    }
    let mut lanes = [0.0; LANES];
    simd.store(least, &mut lanes);
    lanes
}
