//! A ray in single precision, ready for the eight boxes of a node at once.
//!
//! Kay & Kajiya's slabs again, as in `slab.rs`, but in single precision: three fused products and
//! sums for the near sides of all eight boxes, three for the far ones. The ray starts where it enters
//! the root's box, found in double precision, so that single precision is good enough from there on,
//! however far its origin is. What may still be wrong is a position, so each box is widened by that:
//! the answer errs on one side.
//!
//! Rays are prepared eight at a time, in loops over lanes without a branch, which compilers
//! vectorise: one by one it would take as long as the walk.

use super::slab::{Scale, SlabRay};
use crate::geometry::{Ray, Vec3};
use crate::numeric::{Frame, LeafFilter, LeafFilters, UNIT_ROUNDOFF};
use crate::simd::{LANES, Simd};
use crate::tree::{Bounds, WideNode};

/// Half the distance from 1 to the next single-precision number.
const SINGLE_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

/// Error of the position at which a ray passes a side, in single-precision roundings of the sum of
/// the start's and the side's coordinates: the inverse direction one, its product with the side one,
/// the start's product one, the sum one; then as many for the errors' own and the widening's roundings.
const POSITION_ERROR: f64 = 8.0 * SINGLE_ROUNDOFF;

/// Error of the start, in terms of the origin's largest coordinate and of the way to the box: the
/// frame's rounding, the product of the way with the direction, which is below two, and the sum.
const START_ERROR: f64 = 16.0 * UNIT_ROUNDOFF;

/// Inverse directions are limited to this. A component below its inverse moves the ray by less than
/// 2^-50 on its way through the scene, far below [`POSITION_ERROR`].
const STEEPEST: f64 = (1u64 << 60) as f64;

/// Widening beyond which a ray meets all boxes.
const WIDEST: f64 = 1e15;

/// A parameter beyond all triangles.
const FAR: f64 = 1e30;

/// Distances are compared with limits after a rounding to single precision; twice that.
const LIMIT_ERROR: f64 = 4.0 * SINGLE_ROUNDOFF;

/// How much larger the error of a triangle's place on a ray is than [`POSITION_ERROR`]; see
/// [`Depth`].
const DEPTH_ERROR: f64 = 5.0;

/// What finds the places of triangles on a ray, in the ray's parameter: the mean of the corners'
/// coordinates along the axis that the ray follows most.
#[derive(Clone, Copy, Default)]
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

/// A ray from where it enters the root's box. Its parameter is that of [`SlabRay`] less the start's.
#[derive(Clone, Copy)]
pub struct WideRay {
    inverse: [f32; 3],
    /// Minus the start times the inverse, less the widening, for near sides.
    near: [f32; 3],
    /// The same and the widening, for far sides.
    far: [f32; 3],
    /// Boxes that are entered beyond this do not matter.
    pub limit: f32,
    /// Where triangles are.
    pub depth: Depth,
    /// A bit for each axis along which the direction is negative.
    octant: u32,
    /// Where the parameter is zero.
    start: f64,
    scale: Scale,
}

/// Eight rays, in lanes.
pub struct WideRays {
    inverse: [[f32; LANES]; 3],
    near: [[f32; LANES]; 3],
    far: [[f32; LANES]; 3],
    limit: [f32; LANES],
    depth_inverse: [f32; LANES],
    depth_base: [f32; LANES],
    depth_error: [f32; LANES],
    begin: [[f32; LANES]; 2],
    end: [f32; LANES],
    octant: [u32; LANES],
    start: Lanes,
    factor: Lanes,
    filters: LeafFilters,
    /// A bit for each ray that meets the root's box, or is to be looked at by itself.
    pub met: u32,
    /// Those to be looked at by themselves.
    pub single: u32,
}

/// What all rays of a scene have in common.
#[derive(Clone, Copy)]
pub struct World {
    /// The scene's frame.
    pub frame: Frame,
    /// The root's box.
    pub root: Bounds,
    /// The largest coordinate of a corner.
    pub reach: f32,
}

/// Eight numbers.
type Lanes = [f64; LANES];

/// Rays that the lanes can prepare: nothing in them is so large or small that a power of two could
/// leave the range of doubles. The others are prepared one by one.
const ORDINARY: std::ops::Range<f64> =
    f64::from_bits((1023 - 200) << 52)..f64::from_bits((1023 + 200) << 52);

impl WideRays {
    /// Finds the parts of rays within the root's box.
    #[inline(always)]
    pub fn new(rays: &[Ray; LANES], world: &World) -> WideRays {
        let mut origin = [[0.0; LANES]; 3];
        let mut direction = [[0.0; LANES]; 3];
        let (mut t_min, mut t_max) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let ray = &rays[lane];
            for axis in 0..3 {
                origin[axis][lane] = ray.origin[axis];
                direction[axis][lane] = ray.direction[axis];
            }
            (t_min[lane], t_max[lane]) = (ray.t_min, ray.t_max);
        }

        // Scale the directions by powers of two to [1, 2), and bring the origins into the frame.
        let (mut factor, mut is_ordinary) = ([0.0; LANES], [0u64; LANES]);
        let scale = world.frame.scale();
        let is_world_ordinary = ORDINARY.contains(&scale);
        for lane in 0..LANES {
            let [x, y, z] = [0, 1, 2].map(|axis| direction[axis][lane].abs());
            let largest = larger(larger(x, y), z);
            let [p, q, r] = [0, 1, 2].map(|axis| origin[axis][lane].abs());
            let is_right = is_world_ordinary
                & (largest > ORDINARY.start)
                & (largest < ORDINARY.end)
                & (x < ORDINARY.end)
                & (y < ORDINARY.end)
                & (z < ORDINARY.end)
                & (p < ORDINARY.end)
                & (q < ORDINARY.end)
                & (r < ORDINARY.end)
                & (t_min[lane] <= t_max[lane]);
            is_ordinary[lane] = u64::from(is_right);
            let exponent = largest.to_bits() & EXPONENT_BITS;
            factor[lane] = f64::from_bits(exponent);
            let inverse = f64::from_bits((2046u64 << 52).wrapping_sub(exponent));
            for axis in 0..3 {
                direction[axis][lane] *= inverse;
            }
        }
        let offset = world.frame.offset();
        let mut way_error = [0.0; LANES];
        for axis in 0..3 {
            for lane in 0..LANES {
                origin[axis][lane] = (origin[axis][lane] - offset[axis]) * scale;
                way_error[lane] = larger(way_error[lane], origin[axis][lane].abs());
            }
        }

        // Find where they enter and leave the root's box, at least and at most.
        let reach = f64::from(world.reach);
        let mut inverse = [[0.0; LANES]; 3];
        let (mut enter, mut leave): (Lanes, Lanes) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            factor[lane] *= scale;
            let s_min = t_min[lane] * factor[lane];
            enter[lane] = s_min - START_ERROR * s_min.abs();
            leave[lane] = f64::INFINITY;
        }
        for axis in 0..3 {
            let (low, high) = (f64::from(world.root.min[axis]), f64::from(world.root.max[axis]));
            for lane in 0..LANES {
                let inverted = 1.0 / direction[axis][lane];
                let inverted = smaller(larger(inverted, -STEEPEST), STEEPEST);
                inverse[axis][lane] = inverted;
                let room = START_ERROR * (way_error[lane] + reach) * inverted.abs();
                let one = (low - origin[axis][lane]) * inverted;
                let other = (high - origin[axis][lane]) * inverted;
                enter[lane] = larger(enter[lane], smaller(one, other) - room);
                leave[lane] = smaller(leave[lane], larger(one, other) + room);
            }
        }

        // Go to the start, and bound what may be wrong there.
        let (mut at, mut position_error) = ([[0.0; LANES]; 3], [0.0; LANES]);
        for axis in 0..3 {
            for lane in 0..LANES {
                at[axis][lane] = origin[axis][lane] + enter[lane] * direction[axis][lane];
                position_error[lane] = larger(position_error[lane], at[axis][lane].abs());
            }
        }
        let (mut limit, mut is_met, mut is_open) = ([0.0f32; LANES], [0u64; LANES], [0u64; LANES]);
        for lane in 0..LANES {
            position_error[lane] = POSITION_ERROR * (position_error[lane] + reach)
                + START_ERROR * (way_error[lane] + 2.0 * enter[lane].abs())
                + f64::from(f32::MIN_POSITIVE);
            limit[lane] = limit_of(t_max[lane] * factor[lane], enter[lane]);
            // NaN, after an overflow, leaves the answer open.
            let is_bounded = position_error[lane] < WIDEST;
            is_open[lane] = u64::from(!is_bounded);
            let is_right = (is_ordinary[lane] == 1)
                & is_bounded
                & (enter[lane] <= leave[lane])
                & (limit[lane] >= 0.0);
            is_met[lane] = u64::from(is_right);
        }
        let mut inverted = [[0.0f32; LANES]; 3];
        let (mut near, mut far) = ([[0.0f32; LANES]; 3], [[0.0f32; LANES]; 3]);
        let mut octant = [0u32; LANES];
        for axis in 0..3 {
            for lane in 0..LANES {
                let inverse = inverse[axis][lane];
                let (away, room) =
                    (-at[axis][lane] * inverse, position_error[lane] * inverse.abs());
                inverted[axis][lane] = inverse as f32;
                near[axis][lane] = (away - room) as f32;
                far[axis][lane] = (away + room) as f32;
                octant[lane] |= ((inverse.to_bits() >> 63) as u32) << axis;
            }
        }

        // Take the axis that the ray follows most, and where its range begins and ends.
        let (mut depth_inverse, mut depth_base) = ([0.0f32; LANES], [0.0f32; LANES]);
        let (mut depth_error, mut end) = ([0.0f32; LANES], [0.0f32; LANES]);
        let mut begin = [[0.0f32; LANES]; 2];
        for lane in 0..LANES {
            let [x, y, z] = [direction[0][lane], direction[1][lane], direction[2][lane]];
            let is_x = (x.abs() > y.abs()) & (x.abs() > z.abs());
            let is_y = !is_x & (y.abs() > z.abs());
            let of = |lanes: &[Lanes; 3]| {
                let other = if is_y { lanes[1][lane] } else { lanes[2][lane] };
                if is_x { lanes[0][lane] } else { other }
            };
            let inverse = of(&inverse);
            depth_inverse[lane] = inverse as f32;
            depth_base[lane] = (-of(&at) * inverse) as f32;
            depth_error[lane] = (DEPTH_ERROR * position_error[lane]) as f32;
            let [low, high] = range_of(t_min[lane] * factor[lane], enter[lane]);
            (begin[0][lane], begin[1][lane]) = (low as f32, high as f32);
            end[lane] = range_of(t_max[lane] * factor[lane], enter[lane])[0] as f32;
        }

        let (mut met, mut single) = (0, 0);
        for lane in 0..LANES {
            single |= ((is_ordinary[lane] ^ 1 | is_open[lane]) as u32) << lane;
            met |= (is_met[lane] as u32) << lane;
        }
        WideRays {
            inverse: inverted,
            near,
            far,
            limit,
            depth_inverse,
            depth_base,
            depth_error,
            begin,
            end,
            octant,
            start: enter,
            factor,
            filters: LeafFilters::new(&origin, &direction, world.reach),
            met: met | single,
            single,
        }
    }

    /// The ray in a lane that is met and not single, and its filter.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> (WideRay, LeafFilter) {
        let of = |lanes: &[[f32; LANES]; 3]| [lanes[0][lane], lanes[1][lane], lanes[2][lane]];
        let wide = WideRay {
            inverse: of(&self.inverse),
            near: of(&self.near),
            far: of(&self.far),
            limit: self.limit[lane],
            depth: Depth {
                inverse: self.depth_inverse[lane],
                base: self.depth_base[lane],
                error: self.depth_error[lane],
                begin: [self.begin[0][lane], self.begin[1][lane]],
                end: self.end[lane],
            },
            octant: self.octant[lane],
            start: self.start[lane],
            scale: Scale::by(self.factor[lane]),
        };
        (wide, self.filters.lane(lane))
    }
}

impl WideRay {
    /// The part of one ray within the root's box, as far as it matters.
    #[cold]
    pub fn new(ray: &Ray, world: &World) -> Option<(WideRay, LeafFilter)> {
        if !ray.is_valid() {
            return None;
        }
        let slab_ray = SlabRay::new(ray, &world.frame);
        let SlabRay { origin, direction, scale, inverse_direction, .. } = slab_ray;
        let start = slab_ray.entry(&world.root, scale.limit(ray.t_max));
        if start == f64::INFINITY {
            return None;
        }
        let at: Vec3 = origin + direction * start;
        let position_error = POSITION_ERROR * (at.abs().max_element() + f64::from(world.reach))
            + START_ERROR * (origin.abs().max_element() + 2.0 * start.abs())
            + f64::from(f32::MIN_POSITIVE);
        let mut wide = WideRay {
            inverse: [1.0; 3],
            near: [f32::MIN; 3],
            far: [f32::MAX; 3],
            limit: 0.0,
            depth: Depth::UNKNOWN,
            octant: 0,
            start,
            scale,
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
        wide.set_limit(ray.t_max);
        Some((wide, LeafFilter::new(ray, &world.frame, world.reach)))
    }

    /// Boxes that are entered beyond t_max do not matter.
    #[inline(always)]
    pub fn set_limit(&mut self, t_max: f64) {
        self.limit = limit_of(self.scale.limit(t_max), self.start);
    }

    /// A lower bound of the parameter at t.
    #[inline(always)]
    pub fn lower(&self, t: f64) -> f32 {
        range_of(self.scale.lower(t), self.start)[0] as f32
    }

    /// Puts the children of a node that the ray meets, the last first, to the front of `nears` and
    /// `words`, with lower bounds of where it enters them. Returns how many.
    #[inline(always)]
    pub fn push_children<S: Simd>(
        &self,
        simd: S,
        node: &WideNode,
        nears: &mut [f32; LANES],
        words: &mut [u32; LANES],
    ) -> usize {
        let mut near = simd.splat(0.0);
        let mut far = simd.splat(self.limit);
        let octant = self.octant as usize;
        for axis in 0..3 {
            let side = octant >> axis & 1;
            let inverse = simd.splat(self.inverse[axis]);
            let near_sides = simd.load(&node.planes[axis][side]);
            let far_sides = simd.load(&node.planes[axis][1 - side]);
            let enter = simd.multiply_add(near_sides, inverse, simd.splat(self.near[axis]));
            let leave = simd.multiply_add(far_sides, inverse, simd.splat(self.far[axis]));
            near = simd.largest(enter, near);
            far = simd.least(leave, far);
        }
        simd.push(near, far, &node.words, node.orders[octant & 7], nears, words)
    }
}

const EXPONENT_BITS: u64 = 0x7ff << 52;

/// The limit for a walk that starts at `start`, given one for the whole line.
#[inline(always)]
fn limit_of(limit: f64, start: f64) -> f32 {
    let way = limit - start;
    let error = START_ERROR * (limit.abs() + start.abs()) + LIMIT_ERROR * way.abs();
    let limit = (way + error) as f32;
    // Infinite less infinite, or times: no limit.
    if limit.is_nan() { f32::INFINITY } else { limit }
}

/// Two numbers between which a parameter is for a walk that starts at `start`, given one for the
/// whole line; those still to be rounded to single precision.
#[inline(always)]
fn range_of(parameter: f64, start: f64) -> [f64; 2] {
    let way = parameter - start;
    let error = START_ERROR * (parameter.abs() + start.abs()) + LIMIT_ERROR * way.abs();
    // Far beyond everything no error matters, and infinite ones would not do.
    let error = if way.abs() < FAR { error } else { 0.0 };
    [way - error, way + error]
}

/// One instruction each, other than `f64::min`, which has rules for NaN.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
