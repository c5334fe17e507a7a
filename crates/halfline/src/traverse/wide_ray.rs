//! A ray in single precision, ready for the eight boxes of a node at once.
//!
//! Kay & Kajiya's slabs again, as in `slab.rs`, but in single precision: three fused products and
//! sums for the near sides of all eight boxes, three for the far ones. The ray starts where it enters
//! the root's box, found in double precision, so that single precision is good enough from there on,
//! however far its origin is. What may still be wrong is a position, so each box is widened by that:
//! the answer errs on one side.
//!
//! Rays are prepared eight at a time: one by one it would take as long as the walk.

use bytemuck::{Pod, Zeroable};

use super::filter_lanes::{Longest, UNITS, leaf_filters};
use super::slab::{Scale, SlabRay};
use crate::geometry::{Ray, Vec3};
use crate::numeric::{Frame, LeafFilter, UNIT_ROUNDOFF};
use crate::simd::{Doubles, LANES, Numbers, Simd};
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

/// A ray from where it enters the root's box, and its leaf filter.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(32))]
pub struct WideRay {
    inverse: [f32; 3],
    /// Minus the start times the inverse, less the widening, for near sides.
    near: [f32; 3],
    /// The same and the widening, for far sides.
    far: [f32; 3],
    /// Boxes that are entered beyond this do not matter.
    pub limit: f32,
    /// In the lowest bits, one for each axis along which the direction is negative.
    octant: u32,
    /// What triangles are missed.
    pub filter: LeafFilter,
    /// Where triangles are.
    pub depth: Depth,
}

/// Numbers in a [`WideRay`].
const FIELDS: usize = size_of::<WideRay>() / 4;

/// The parameter of a [`WideRay`]: that of [`SlabRay`] less the start's.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// Where it is zero.
    start: f64,
    scale: Scale,
}

/// Eight rays.
pub struct WideRays {
    rays: [WideRay; LANES],
    start: [f64; LANES],
    factor: [f64; LANES],
    /// Of those that were looked at by themselves.
    parameters: [Parameter; LANES],
    /// A bit for each ray that meets the root's box, or is to be looked at by itself.
    pub met: u32,
    /// Those to be looked at by themselves.
    pub single: u32,
}

/// The fields of eight [`WideRay`]s, each for all of them.
pub struct Columns([[f32; LANES]; FIELDS]);

impl Columns {
    /// The first of the near constants, and so on; inverse directions come first.
    pub const NEAR: usize = 3;
    /// Far constants.
    pub const FAR: usize = 6;
    const OCTANT: usize = 10;
    const LAST: usize = 11;
    /// Slopes of the projection.
    pub const SLOPE: usize = 12;
    /// And where the lines are in it.
    pub const CENTER: usize = 14;

    /// Before the first rays.
    pub fn none() -> Columns {
        Columns([[0.0; LANES]; FIELDS])
    }

    /// A field.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, field: usize) -> S::Floats {
        simd.load(&self.0[field])
    }

    /// A field of a ray.
    #[inline(always)]
    pub fn at(&self, field: usize, lane: usize) -> f32 {
        self.0[field][lane]
    }

    /// The octant of a ray.
    #[inline(always)]
    pub fn octant(&self, lane: usize) -> u32 {
        self.0[Columns::OCTANT][lane].to_bits()
    }

    /// The octant of a ray, and the axis that it follows most.
    #[inline(always)]
    pub fn kind(&self, lane: usize) -> [u32; 2] {
        [self.octant(lane), self.0[Columns::LAST][lane].to_bits()]
    }
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

/// Rays that the lanes can prepare: nothing in them is so large or small that a power of two could
/// leave the range of doubles. The others are prepared one by one.
const ORDINARY: std::ops::Range<f64> =
    f64::from_bits((1023 - 200) << 52)..f64::from_bits((1023 + 200) << 52);

/// Rays by number: their origins and directions by axis, then both ends of their ranges.
pub type RayLanes = [[f64; LANES]; 8];

impl WideRays {
    /// Rays that were never set.
    pub fn none() -> WideRays {
        let rays = [WideRay::zeroed(); LANES];
        let parameters = [Parameter::NONE; LANES];
        WideRays { rays, start: [0.0; LANES], factor: [0.0; LANES], parameters, met: 0, single: 0 }
    }

    /// Finds the parts of rays within the root's box.
    #[inline(always)]
    pub fn set<S: Simd>(&mut self, simd: S, rays: &RayLanes, world: &World, columns: &mut Columns) {
        let wide = simd.doubles();
        let given = [wide.load(&rays[0]), wide.load(&rays[1]), wide.load(&rays[2])];
        let along = [wide.load(&rays[3]), wide.load(&rays[4]), wide.load(&rays[5])];
        let (t_min, t_max) = (wide.load(&rays[6]), wide.load(&rays[7]));

        // Scale the directions by powers of two to [1, 2), and bring the origins into the frame.
        let largest = size(simd, &along);
        let scale = world.frame.scale();
        let (first, last) = (wide.splat(ORDINARY.start), wide.splat(ORDINARY.end));
        // Comparisons with NaN are false, but maxima may hide it: look at every component.
        let mut ordinary = wide.are_below(first, largest) & wide.are_ordered(t_min, t_max);
        for axis in 0..3 {
            ordinary &= wide.are_below(wide.magnitude(along[axis]), last);
            ordinary &= wide.are_below(wide.magnitude(given[axis]), last);
        }
        if !ORDINARY.contains(&scale) {
            ordinary = 0;
        }
        let power = wide.power(largest);
        let inverse_power = wide.divided(wide.splat(1.0), power);
        let factor = wide.times(power, wide.splat(scale));
        let offset = world.frame.offset();
        let direction = [
            wide.times(along[0], inverse_power),
            wide.times(along[1], inverse_power),
            wide.times(along[2], inverse_power),
        ];
        let mut origin = given;
        for axis in 0..3 {
            let moved = wide.minus(given[axis], wide.splat(offset[axis]));
            origin[axis] = wide.times(moved, wide.splat(scale));
        }
        let way_error = size(simd, &origin);

        // Find where they enter and leave the root's box, at least and at most.
        let reach = f64::from(world.reach);
        let begin = wide.times(t_min, factor);
        let start_error = wide.splat(-START_ERROR);
        let mut enter = wide.multiply_add(wide.magnitude(begin), start_error, begin);
        let mut leave = wide.splat(f64::INFINITY);
        let far_error =
            wide.times(wide.plus(way_error, wide.splat(reach)), wide.splat(START_ERROR));
        let mut inverse = [wide.splat(0.0); 3];
        for axis in 0..3 {
            let (low, high) = (f64::from(world.root.min[axis]), f64::from(world.root.max[axis]));
            let inverted = wide.divided(wide.splat(1.0), direction[axis]);
            let inverted =
                wide.least(wide.largest(inverted, wide.splat(-STEEPEST)), wide.splat(STEEPEST));
            inverse[axis] = inverted;
            let room = wide.times(far_error, wide.magnitude(inverted));
            let one = wide.times(wide.minus(wide.splat(low), origin[axis]), inverted);
            let other = wide.times(wide.minus(wide.splat(high), origin[axis]), inverted);
            enter = wide.largest(enter, wide.minus(wide.least(one, other), room));
            leave = wide.least(leave, wide.plus(wide.largest(one, other), room));
        }

        // Go to the start, and bound what may be wrong there.
        let at = [
            wide.multiply_add(enter, direction[0], origin[0]),
            wide.multiply_add(enter, direction[1], origin[1]),
            wide.multiply_add(enter, direction[2], origin[2]),
        ];
        let way = wide.plus(wide.magnitude(enter), wide.magnitude(enter));
        let error = wide.times(wide.plus(way_error, way), wide.splat(START_ERROR));
        let error = wide.plus(error, wide.splat(f64::from(f32::MIN_POSITIVE)));
        let around = wide.plus(size(simd, &at), wide.splat(reach));
        let error = wide.multiply_add(around, wide.splat(POSITION_ERROR), error);

        // NaN, after an overflow, leaves the answer open.
        let bounded = wide.are_below(error, wide.splat(WIDEST));
        let end = range_of(simd, wide.times(t_max, factor), enter);
        let begin = range_of(simd, begin, enter);
        let met = !wide.are_below(leave, enter) & !wide.are_below(end[1], wide.splat(0.0));

        // Write down what boxes and leaves need.
        let zero = wide.splat(0.0);
        let (mut away, mut near, mut far) = (at, [simd.splat(0.0); 3], [simd.splat(0.0); 3]);
        let mut octant = wide.splat(UNITS);
        for axis in 0..3 {
            away[axis] = wide.times(at[axis], inverse[axis]);
            let room = wide.times(error, wide.magnitude(inverse[axis]));
            near[axis] = simd.narrow(wide.minus(zero, wide.plus(away[axis], room)));
            far[axis] = simd.narrow(wide.minus(room, away[axis]));
            let bit = wide.splat(f64::from(1 << axis));
            octant = wide.plus(octant, wide.if_below(inverse[axis], zero, bit, zero));
        }
        let longest = Longest::of(simd, &direction);
        let depth_inverse = longest.choose(simd, inverse[0], inverse[1], inverse[2]);
        let depth_base = longest.choose(simd, away[0], away[1], away[2]);
        let filter = leaf_filters(simd, &origin, &direction, reach.max(0.5));
        let [last, slope, slope_2, center, center_2, per_distance, at_least] = filter;
        let parts = [
            [
                simd.narrow(inverse[0]),
                simd.narrow(inverse[1]),
                simd.narrow(inverse[2]),
                near[0],
                near[1],
                near[2],
                far[0],
                far[1],
            ],
            [
                far[2],
                simd.narrow(end[1]),
                simd.narrow(octant),
                last,
                slope,
                slope_2,
                center,
                center_2,
            ],
            [
                per_distance,
                at_least,
                simd.narrow(depth_inverse),
                simd.narrow(wide.minus(zero, depth_base)),
                simd.narrow(wide.times(error, wide.splat(DEPTH_ERROR))),
                simd.narrow(begin[0]),
                simd.narrow(begin[1]),
                simd.narrow(end[0]),
            ],
        ];
        for part in 0..FIELDS / LANES {
            for field in 0..LANES {
                simd.store(parts[part][field], &mut columns.0[LANES * part + field]);
            }
            let rows = simd.transposed(parts[part]);
            for lane in 0..LANES {
                simd.store(rows[lane], &mut self.rays[lane].fields_mut()[part]);
            }
        }
        wide.store(enter, &mut self.start);
        wide.store(factor, &mut self.factor);
        self.single = !(ordinary & bounded) & ALL;
        self.met = met & ALL | self.single;
    }

    /// Looks at a ray by itself; false if it does not meet the root's box.
    #[cold]
    pub fn set_single(&mut self, lane: usize, ray: &Ray, world: &World) -> bool {
        match WideRay::new(ray, world) {
            Some(prepared) => {
                (self.rays[lane], self.parameters[lane]) = prepared;
                true
            }
            None => false,
        }
    }

    /// A ray that meets the root's box.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> (&WideRay, Parameter) {
        if self.single >> lane & 1 == 1 {
            return (&self.rays[lane], self.parameters[lane]);
        }
        let scale = Scale::by(self.factor[lane]);
        (&self.rays[lane], Parameter { start: self.start[lane], scale })
    }
}

const ALL: u32 = (1 << LANES) - 1;

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

impl WideRay {
    /// Before the first ray.
    pub fn none() -> WideRay {
        WideRay::zeroed()
    }

    /// The part of one ray within the root's box, as far as it matters.
    #[cold]
    pub fn new(ray: &Ray, world: &World) -> Option<(WideRay, Parameter)> {
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
        let parameter = Parameter { start, scale };
        let mut wide = WideRay {
            inverse: [1.0; 3],
            near: [f32::MIN; 3],
            far: [f32::MAX; 3],
            limit: parameter.limit(ray.t_max),
            octant: 0,
            filter: LeafFilter::new(ray, &world.frame, world.reach),
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

    #[inline(always)]
    fn fields_mut(&mut self) -> &mut [[f32; LANES]; FIELDS / LANES] {
        bytemuck::cast_mut(self)
    }

    /// Copies a ray in the pieces in which [`WideRays::set`] wrote it: larger ones would have to wait
    /// until all of them have come to the cache.
    #[inline(always)]
    pub fn copy_from<S: Simd>(&mut self, simd: S, other: &WideRay) {
        let from: &[[f32; LANES]; FIELDS / LANES] = bytemuck::cast_ref(other);
        let to = self.fields_mut();
        for part in 0..FIELDS / LANES {
            simd.store(simd.load(&from[part]), &mut to[part]);
        }
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
        let octant = (self.octant & 7) as usize;
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
        simd.push(near, far, &node.words, node.orders[octant], nears, words)
    }
}

/// The largest component, without its sign.
#[inline(always)]
fn size<S: Simd>(simd: S, v: &[Numbers<S>; 3]) -> Numbers<S> {
    let wide = simd.doubles();
    let xy = wide.largest(wide.magnitude(v[0]), wide.magnitude(v[1]));
    wide.largest(xy, wide.magnitude(v[2]))
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

/// Two numbers between which a parameter is for walks that begin at `start`, given one for the whole
/// line, still to be rounded to single precision.
#[inline(always)]
fn range_of<S: Simd>(simd: S, parameter: Numbers<S>, start: Numbers<S>) -> [Numbers<S>; 2] {
    let wide = simd.doubles();
    let way = wide.minus(parameter, start);
    let size = wide.plus(wide.magnitude(parameter), wide.magnitude(start));
    let error = wide.times(wide.magnitude(way), wide.splat(LIMIT_ERROR));
    let error = wide.multiply_add(size, wide.splat(START_ERROR), error);
    // Far beyond everything no error matters, and infinite ones would not do.
    let is_near = (wide.magnitude(way), wide.splat(FAR));
    let error = wide.if_below(is_near.0, is_near.1, error, wide.splat(0.0));
    [wide.minus(way, error), wide.plus(way, error)]
}
