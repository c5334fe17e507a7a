//! A ray in single precision, ready for the eight boxes of a node at once.
//!
//! Kay & Kajiya's slabs again, as in `slab.rs`, but in single precision: three fused products and
//! sums for the near sides of all eight boxes, three for the far ones. The ray starts where it enters
//! the root's box, found in double precision, so that single precision is good enough from there on,
//! however far its origin is. What may still be wrong is a position, so each box is widened by that:
//! the answer errs on one side.
//!
//! Rays are prepared eight at a time (`ray_octet.rs`): one by one it would take as long as the walk.

use bytemuck::{Pod, Zeroable};

use super::projection::Projection;
use super::slab::{Scale, SlabRay};
use crate::geometry::{Ray, Vec3};
use crate::numeric::{F32_ROUNDOFF, Frame, UNIT_ROUNDOFF};
use crate::simd::{LANES, Simd};
use crate::tree::{Bounds, Node, Tree};

/// Error of the position at which a ray passes a side, in single-precision roundings of the sum of
/// the start's and the side's coordinates: the direction one and its inverse one, the start one and its
/// product one, the side's product one, the sum one; then as many for the errors' own and the
/// widening's roundings.
pub const POSITION_ERROR: f64 = 12.0 * F32_ROUNDOFF;

/// Error of the start, in terms of the origin's largest coordinate and of the way to the box: the
/// frame's rounding, the product of the way with the direction, which is below two, and the sum.
pub const START_ERROR: f64 = 16.0 * UNIT_ROUNDOFF;

/// Inverse directions are limited to this. A component below its inverse moves the ray by less than
/// 2^-50 on its way through the scene, far below [`POSITION_ERROR`].
pub const STEEPEST: f64 = (1u64 << 60) as f64;

/// Widening beyond which a ray meets all boxes.
pub const WIDEST: f64 = 1e15;

/// A parameter beyond all triangles.
pub const FAR: f64 = 1e30;

/// Distances are compared with limits after a rounding to single precision; twice that.
pub const LIMIT_ERROR: f64 = 4.0 * F32_ROUNDOFF;

/// How much larger the error of a triangle's place on a ray is than [`POSITION_ERROR`]; see
/// [`Depth`].
pub const DEPTH_ERROR: f64 = 2.5;

/// What finds the places of triangles on a ray, in the ray's parameter: the mean of the corners'
/// coordinates along the axis that the ray follows most.
#[derive(Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Depth {
    /// From that coordinate to the parameter: a factor of at most one, and what is added.
    pub inverse: f32,
    /// What is added.
    pub base: f32,
    /// Error of the place beyond that of the weights.
    pub error: f32,
    /// Two numbers between which the ray's range begins.
    pub begin: [f32; 2],
    /// A number before its end.
    pub end: f32,
}

impl Depth {
    /// Of rays whose triangles may be anywhere.
    const UNKNOWN: Depth = Depth {
        inverse: 0.0,
        base: 0.0,
        error: f32::INFINITY,
        begin: [f32::NEG_INFINITY, f32::INFINITY],
        end: f32::NEG_INFINITY,
    };
}

/// A ray from where it enters the root's box, and how it meets triangles.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct TraversalRay {
    /// One over the direction.
    pub inverse: [f32; 3],
    /// Minus the start times the inverse, less the widening, for near sides.
    near: [f32; 3],
    /// Minus the start times the inverse, and the widening, for far sides.
    far: [f32; 3],
    /// Boxes that are entered beyond this do not matter.
    pub limit: f32,
    /// In the lowest bits, one for each axis along which the direction is negative.
    octant: u32,
    /// How triangles are projected.
    pub projection: Projection,
    /// Where triangles are.
    pub depth: Depth,
}

/// F64x8 in a [`TraversalRay`].
pub const FIELDS: usize = size_of::<TraversalRay>() / 4;

/// The parameter of a [`TraversalRay`]: that of [`SlabRay`] less the start's.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// Where it is zero.
    pub start: f64,
    /// From t to that of [`SlabRay`].
    pub scale: Scale,
}

/// What the preparation of a ray needs to know of the tree.
#[derive(Clone, Copy)]
pub struct RootFrame {
    /// The scene's frame.
    pub frame: Frame,
    /// The box of all that can be hit.
    pub bounds: Bounds,
    /// The largest coordinate of a corner.
    pub reach: f32,
}

impl RootFrame {
    /// That of a tree.
    pub fn of(tree: &Tree) -> RootFrame {
        RootFrame { frame: tree.frame, bounds: tree.bounds, reach: tree.reach }
    }
}

impl Parameter {
    /// Of a ray that is to be set.
    pub const NONE: Parameter = Parameter { start: 0.0, scale: Scale::UNBOUNDED };

    /// Boxes that are entered beyond this do not matter if what lies beyond t does not.
    #[inline(always)]
    pub fn limit(&self, t_max: f64) -> f32 {
        limit_of(self.scale.limit(t_max), self.start)
    }

    /// About t at a parameter.
    pub fn t(&self, parameter: f32) -> f64 {
        self.scale.t(f64::from(parameter) + self.start)
    }

    /// A lower bound of the parameter at t.
    #[inline(always)]
    pub fn lower(&self, t: f64) -> f32 {
        let s = self.scale.lower(t);
        let way = s - self.start;
        let error = START_ERROR * (s.abs() + self.start.abs()) + LIMIT_ERROR * way.abs();
        let lower = (way - error) as f32;
        if lower.is_nan() { f32::NEG_INFINITY } else { lower }
    }
}

impl TraversalRay {
    /// Before the first ray.
    pub fn none() -> TraversalRay {
        TraversalRay::zeroed()
    }

    /// The part of one ray within the root's box, as far as it matters.
    #[cold]
    pub fn new(ray: &Ray, root: &RootFrame) -> Option<(TraversalRay, Parameter)> {
        if !ray.is_valid() {
            return None;
        }
        let slab_ray = SlabRay::new(ray, &root.frame);
        let SlabRay { origin, direction, scale, inverse_direction, .. } = slab_ray;
        let start = slab_ray.entry(&root.bounds, scale.limit(ray.t_max));
        if start == f64::INFINITY {
            return None;
        }
        let at: Vec3 = origin + direction * start;
        let position_error = POSITION_ERROR * (at.abs().max_element() + f64::from(root.reach))
            + START_ERROR * (origin.abs().max_element() + 2.0 * start.abs())
            + f64::from(f32::MIN_POSITIVE);
        let parameter = Parameter { start, scale };
        let mut wide = TraversalRay {
            inverse: [1.0; 3],
            near: [f32::MIN; 3],
            far: [f32::MAX; 3],
            limit: parameter.limit(ray.t_max),
            octant: 0,
            projection: Projection::new(ray, &root.frame, root.reach),
            depth: Depth::UNKNOWN,
        };
        // Where even doubles are too coarse, as for origins beyond the range of `slab.rs`, the ray
        // meets everything but empty boxes: NaN ends here too.
        if position_error < WIDEST && scale.is_bounded() {
            for axis in 0..3 {
                let inverse = inverse_direction[axis].clamp(-STEEPEST, STEEPEST);
                let (away, room) = (-at[axis] * inverse, position_error * inverse.abs());
                wide.octant |= u32::from(inverse < 0.0) << axis;
                wide.inverse[axis] = inverse as f32;
                wide.near[axis] = (away - room) as f32;
                wide.far[axis] = (away + room) as f32;
            }
        }
        Some((wide, parameter))
    }

    /// Its numbers, in the order of the [`RayFields`](super::RayFields) of an octet.
    #[inline(always)]
    pub fn fields(&self) -> &[f32; FIELDS] {
        bytemuck::cast_ref(self)
    }

    /// The same in the pieces in which they are written.
    #[inline(always)]
    pub fn parts_mut(&mut self) -> &mut [[f32; LANES]; FIELDS / LANES] {
        bytemuck::cast_mut(self)
    }

    /// Copies a ray in the pieces in which `RayOctet::write_rays` wrote it: larger ones would have to wait
    /// until all of them have come to the cache.
    #[inline(always)]
    pub fn copy_from<S: Simd>(&mut self, simd: S, other: &TraversalRay) {
        let from: &[[f32; LANES]; FIELDS / LANES] = bytemuck::cast_ref(other);
        let to = self.parts_mut();
        for part in 0..FIELDS / LANES {
            simd.store(simd.load(&from[part]), &mut to[part]);
        }
    }

    /// Puts the children of a node that the ray meets, the last first, to the front of `refs`, and lower bounds
    /// of where it enters them to the front of `entries`. Returns how many.
    #[inline(always)]
    pub fn intersect_children<S: Simd>(
        &self,
        simd: S,
        node: &Node,
        entries: &mut [f32; LANES],
        refs: &mut [u32; LANES],
    ) -> usize {
        let mut near = simd.splat(0.0);
        let mut far = simd.splat(self.limit);
        let octant = (self.octant & 7) as usize;
        for axis in 0..3 {
            let side = octant >> axis & 1;
            let inverse = simd.splat(self.inverse[axis]);
            let near_sides = simd.load(&node.sides[axis][side]);
            let far_sides = simd.load(&node.sides[axis][1 - side]);
            let enter = simd.mul_add(near_sides, inverse, simd.splat(self.near[axis]));
            let leave = simd.mul_add(far_sides, inverse, simd.splat(self.far[axis]));
            near = simd.max(enter, near);
            far = simd.min(leave, far);
        }
        simd.compress(near, far, &node.refs, node.orders[octant], entries, refs)
    }
}

/// The limit for a walk that starts at `start`, given one for the whole line.
#[inline(always)]
fn limit_of(limit: f64, start: f64) -> f32 {
    let way = limit - start;
    let error = START_ERROR * (limit.abs() + start.abs()) + LIMIT_ERROR * way.abs();
    let limit = (way + error) as f32;
    // Infinite less infinite, or times: no limit.
    if limit.is_nan() { f32::INFINITY } else { limit }
}
