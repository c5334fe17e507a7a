//! Eight rays made ready at once, on a vector unit.
//!
//! What decides where a ray is, its origin in the frame, its start, its slopes, is taken in double
//! precision and rounded then; what only bounds something is taken in single precision from the
//! beginning.

use std::ops::Range;

use bytemuck::Zeroable;

use super::projection::{Longest, UNITS, project_octet};
use super::ray_order::RayOrder;
use super::ray_source::{RayLanes, RaySource};
use super::slab::Scale;
use super::traversal_ray::{
    DEPTH_ERROR, FAR, FIELDS, LIMIT_ERROR, POSITION_ERROR, Parameter, RootFrame, START_ERROR,
    STEEPEST, TraversalRay, WIDEST,
};
use crate::geometry::Ray;
use crate::numeric::F32_ROUNDOFF;
use crate::simd::{F64x8, Job, LANES, Simd, SimdF64};

/// Eight rays.
pub struct RayOctet {
    /// The number of the first ray in the batch.
    pub first: usize,
    /// By what is needed of them.
    pub fields: RayFields,
    /// The same ray by ray, once that was needed.
    rays: [TraversalRay; LANES],
    has_rays: bool,
    start: [f32; LANES],
    factor: [f64; LANES],
    /// Of those that were looked at by themselves.
    parameters: [Parameter; LANES],
    /// A bit for each ray that meets the root's box, or is to be looked at by itself.
    pub met: u32,
    /// Those to be looked at by themselves.
    pub fallback: u32,
}

/// The fields of eight [`TraversalRay`]s, each for all of them (structure of arrays).
pub struct RayFields([[f32; LANES]; FIELDS]);

impl RayFields {
    /// The first of the near constants, and so on; inverse directions come first.
    pub const NEAR: usize = 3;
    /// Far constants.
    pub const FAR: usize = 6;
    /// Where boxes stop to matter.
    pub const LIMIT: usize = 9;
    /// The octant of the direction, in the lowest bits of a number that is compared as such.
    pub const OCTANT: usize = 10;
    /// The axis that the ray follows most, in the lowest bits of a number.
    pub const LAST: usize = 11;
    /// Slopes of the projection.
    pub const SLOPE: usize = 12;
    /// Where the lines are in the projection.
    pub const CENTER: usize = 14;
    /// The errors of edge functions.
    pub const ERROR: usize = 16;
    /// From places along the last axis to parameters: a factor, what is added, and the error.
    pub const DEPTH: usize = 18;
    /// Between which numbers the range begins.
    pub const BEGIN: usize = 21;
    /// Before which number the range ends.
    pub const END: usize = 23;
    /// How many fields there are.
    pub const COUNT: usize = FIELDS;

    /// Before the first rays.
    pub fn none() -> RayFields {
        RayFields([[0.0; LANES]; FIELDS])
    }

    /// A field.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, field: usize) -> S::F32x8 {
        simd.load(&self.0[field])
    }

    /// A field of a ray.
    #[inline(always)]
    pub fn at(&self, field: usize, lane: usize) -> f32 {
        self.0[field][lane]
    }

    /// The axis that a ray follows most.
    #[inline(always)]
    pub fn last(&self, lane: usize) -> u32 {
        self.0[RayFields::LAST][lane].to_bits()
    }
}

/// Directions, scales and origins that the lanes can prepare: nothing is so large or small that a power
/// of two could leave the range of doubles. The other rays are prepared one by one.
const ORDINARY: std::ops::Range<f64> =
    f64::from_bits((1023 - 200) << 52)..f64::from_bits((1023 + 200) << 52);

/// Origins farther than this, in units of the scene, are left to single rays.
const FARTHEST: f32 = (1u32 << 30) as f32;

/// Error of where a ray enters a box, in single-precision roundings of the sum of the origin's and the
/// side's coordinates: the origin one, the difference one, the direction one and its inverse one, the
/// product one; then as many for the errors' own.
const ENTRY_ERROR: f64 = 10.0 * F32_ROUNDOFF;

impl RayOctet {
    /// Room for eight rays.
    pub fn none() -> RayOctet {
        let rays = [TraversalRay::zeroed(); LANES];
        let parameters = [Parameter::NONE; LANES];
        RayOctet {
            first: 0,
            fields: RayFields::none(),
            rays,
            has_rays: false,
            start: [0.0; LANES],
            factor: [0.0; LANES],
            parameters,
            met: 0,
            fallback: 0,
        }
    }

    /// Finds the parts of rays within the root's box.
    #[inline(always)]
    fn set<S: Simd>(&mut self, simd: S, rays: &RayLanes<S>, root: &RootFrame) {
        let wide = simd.doubles();
        let reach = simd.splat(root.reach);
        let zero = simd.splat(0.0);

        // Scale the directions by powers of two to [1, 2), and bring the origins into the frame.
        let along = &rays.direction;
        let largest = wide.max(wide.abs(along[0]), wide.abs(along[1]));
        let largest = wide.max(largest, wide.abs(along[2]));
        let power = wide.power(largest);
        let inverse_power = wide.inverse_power(power);
        let scale = root.frame.scale();
        let factor = wide.mul(power, wide.splat(scale));
        let offset = root.frame.offset();
        let (mut direction, mut origin) = (*along, rays.origin);
        for axis in 0..3 {
            direction[axis] = wide.mul(along[axis], inverse_power);
            let moved = wide.sub(origin[axis], wide.splat(offset[axis]));
            origin[axis] = wide.mul(moved, wide.splat(scale));
        }

        // Which can be prepared so? A sum shows whether any of its parts is NaN; a maximum may not.
        let near_origin = [simd.narrow(origin[0]), simd.narrow(origin[1]), simd.narrow(origin[2])];
        let course =
            [simd.narrow(direction[0]), simd.narrow(direction[1]), simd.narrow(direction[2])];
        let course_size = magnitudes(simd, &course);
        let [a, b, c] = magnitudes(simd, &near_origin);
        let from_origin = simd.max(simd.max(a, b), c);
        let sum = simd.add(simd.add(a, b), c);
        let sum = simd.add(simd.add(course_size[0], course_size[1]), simd.add(course_size[2], sum));
        let mut ordinary = simd.lt(sum, simd.splat(FARTHEST))
            & wide.lt(wide.splat(ORDINARY.start), largest)
            & wide.lt(largest, wide.splat(ORDINARY.end))
            & wide.le(rays.t_min, rays.t_max);
        if !ORDINARY.contains(&scale) {
            ordinary = 0;
        }

        // Find where they enter and leave the root's box, at least and at most.
        let begin = wide.mul(rays.t_min, factor);
        let far = simd.splat(FAR as f32);
        let mut enter = simd.min(simd.max(simd.narrow(begin), simd.sub(zero, far)), far);
        let before = simd.splat(-4.0 * F32_ROUNDOFF as f32);
        enter = simd.mul_add(simd.abs(enter), before, enter);
        let mut leave = simd.splat(f32::INFINITY);
        let room = simd.mul(simd.add(from_origin, reach), simd.splat(ENTRY_ERROR as f32));
        let mut inverse = course;
        let mut steepness = course;
        for axis in 0..3 {
            let steepest = simd.splat(STEEPEST as f32);
            let inverted = simd.div(simd.splat(1.0), course[axis]);
            let inverted = simd.min(simd.max(inverted, simd.sub(zero, steepest)), steepest);
            inverse[axis] = inverted;
            steepness[axis] = simd.abs(inverted);
            let room = simd.mul(room, steepness[axis]);
            let (low, high) = (root.bounds.min[axis], root.bounds.max[axis]);
            let one = simd.mul(simd.sub(simd.splat(low), near_origin[axis]), inverted);
            let other = simd.mul(simd.sub(simd.splat(high), near_origin[axis]), inverted);
            enter = simd.max(enter, simd.sub(simd.min(one, other), room));
            leave = simd.min(leave, simd.add(simd.max(one, other), room));
        }

        // Go to the start, and bound what may be wrong there.
        let start = simd.widen(enter);
        let at = [
            simd.narrow(wide.mul_add(start, direction[0], origin[0])),
            simd.narrow(wide.mul_add(start, direction[1], origin[1])),
            simd.narrow(wide.mul_add(start, direction[2], origin[2])),
        ];
        let way = simd.add(simd.abs(enter), simd.abs(enter));
        let error = simd.mul(simd.add(from_origin, way), simd.splat(START_ERROR as f32));
        let error = simd.add(error, simd.splat(f32::MIN_POSITIVE));
        let [a, b, c] = magnitudes(simd, &at);
        let around = simd.add(simd.max(simd.max(a, b), c), reach);
        let error = simd.mul_add(around, simd.splat(POSITION_ERROR as f32), error);

        // NaN, after an overflow, leaves the answer open.
        let bounded = simd.lt(error, simd.splat(WIDEST as f32));
        let end = range_of(simd, wide.mul(rays.t_max, factor), start, enter);
        let begin = range_of(simd, begin, start, enter);
        let met = !simd.lt(leave, enter) & !simd.lt(end[1], zero);

        // Write down what boxes and leaves need.
        let (mut away, mut near, mut far) = (at, at, at);
        let mut octant = simd.splat(UNITS);
        for axis in 0..3 {
            away[axis] = simd.mul(at[axis], inverse[axis]);
            let room = simd.mul(error, steepness[axis]);
            near[axis] = simd.sub(simd.sub(zero, away[axis]), room);
            far[axis] = simd.sub(room, away[axis]);
            let bit = simd.splat((1 << axis) as f32);
            octant = simd.add(octant, simd.select_lt(inverse[axis], zero, bit, zero));
        }
        let longest = Longest::of(simd, course_size);
        let depth_inverse = longest.select(simd, inverse[0], inverse[1], inverse[2]);
        let depth_base = longest.select(simd, away[0], away[1], away[2]);
        let filter = project_octet(simd, &longest, &origin, &direction, from_origin, root.reach);
        let [last, slope, slope_2, center, center_2, per_distance, at_least] = filter;
        let parts = [
            [inverse[0], inverse[1], inverse[2], near[0], near[1], near[2], far[0], far[1]],
            [far[2], end[1], octant, last, slope, slope_2, center, center_2],
            [
                per_distance,
                at_least,
                depth_inverse,
                simd.sub(zero, depth_base),
                simd.mul(error, simd.splat(DEPTH_ERROR as f32)),
                begin[0],
                begin[1],
                end[0],
            ],
        ];
        for part in 0..FIELDS / LANES {
            for field in 0..LANES {
                simd.store(parts[part][field], &mut self.fields.0[LANES * part + field]);
            }
        }
        self.has_rays = false;
        simd.store(enter, &mut self.start);
        wide.store(factor, &mut self.factor);
        self.fallback = !(ordinary & bounded) & ALL;
        self.met = met & ALL | self.fallback;
    }

    /// Writes the rays down ray by ray, if that was not done yet.
    #[inline(always)]
    pub fn write_rays<S: Simd>(&mut self, simd: S) {
        if self.has_rays {
            return;
        }
        self.has_rays = true;
        for part in 0..FIELDS / LANES {
            let mut fields = [simd.splat(0.0); LANES];
            for field in 0..LANES {
                fields[field] = self.fields.load(simd, LANES * part + field);
            }
            let rows = simd.transpose(fields);
            for lane in 0..LANES {
                simd.store(rows[lane], &mut self.rays[lane].parts_mut()[part]);
            }
        }
    }

    /// Looks at a ray by itself, once the others were written down; false if it does not meet the root's box.
    #[cold]
    pub fn set_fallback(&mut self, lane: usize, ray: &Ray, root: &RootFrame) -> bool {
        match TraversalRay::new(ray, root) {
            Some(prepared) => {
                (self.rays[lane], self.parameters[lane]) = prepared;
                true
            }
            None => false,
        }
    }

    /// A ray that meets the root's box, once it was written down.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> (&TraversalRay, Parameter) {
        if self.fallback >> lane & 1 == 1 {
            return (&self.rays[lane], self.parameters[lane]);
        }
        (&self.rays[lane], self.parameter(lane))
    }

    /// The parameter of a ray that was not looked at by itself.
    #[inline(always)]
    pub fn parameter(&self, lane: usize) -> Parameter {
        let scale = Scale::by(self.factor[lane]);
        Parameter { start: f64::from(self.start[lane]), scale }
    }
}

/// Prepares rays of a source, eight in each octet but the last, given which of those that are cast, and returns
/// how many octets they take.
#[inline(always)]
pub fn prepare_octets<S: Simd>(
    simd: S,
    octets: &mut [RayOctet],
    (source, order): (&RaySource, &RayOrder),
    numbers: Range<usize>,
    root: &RootFrame,
) -> usize {
    simd.outlined(PrepareOctets { octets, source, order, numbers, root })
}

/// The preparation in a function of its own: every kind of batch calls the same.
struct PrepareOctets<'a> {
    octets: &'a mut [RayOctet],
    source: &'a RaySource<'a>,
    order: &'a RayOrder,
    numbers: Range<usize>,
    root: &'a RootFrame,
}

impl Job for PrepareOctets<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> usize {
        let PrepareOctets { octets, source, order, numbers, root } = self;
        let count = numbers.len().div_ceil(LANES);
        for (number, octet) in octets[..count].iter_mut().enumerate() {
            let first = numbers.start + number * LANES;
            let begin = order.octet(first);
            let numbers = begin..begin + LANES.min(numbers.end - first);
            octet.first = begin;
            octet.set(simd, &source.load8(simd, numbers.clone()), root);
            let in_use = (1 << numbers.len()) - 1;
            octet.met &= in_use;
            octet.fallback &= in_use;
            let mut rest = octet.fallback;
            if rest != 0 {
                octet.write_rays(simd);
            }
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                if !octet.set_fallback(lane, &source.ray(begin + lane), root) {
                    octet.met &= !(1 << lane);
                }
            }
        }
        count
    }
}

/// A bit for each lane.
pub const ALL: u32 = (1 << LANES) - 1;

#[inline(always)]
fn magnitudes<S: Simd>(simd: S, v: &[S::F32x8; 3]) -> [S::F32x8; 3] {
    [simd.abs(v[0]), simd.abs(v[1]), simd.abs(v[2])]
}

/// Two numbers between which a parameter is for walks that begin at `start`, which is also `single`,
/// given one for the whole line.
#[inline(always)]
fn range_of<S: Simd>(
    simd: S,
    parameter: F64x8<S>,
    start: F64x8<S>,
    single: S::F32x8,
) -> [S::F32x8; 2] {
    let way = simd.narrow(simd.doubles().sub(parameter, start));
    let size = simd.add(simd.abs(simd.narrow(parameter)), simd.abs(single));
    let error = simd.mul(simd.abs(way), simd.splat(LIMIT_ERROR as f32));
    let error = simd.mul_add(size, simd.splat(START_ERROR as f32), error);
    // Far beyond everything no error matters, and infinite ones would not do.
    let is_near = (simd.abs(way), simd.splat(FAR as f32));
    let error = simd.select_lt(is_near.0, is_near.1, error, simd.splat(0.0));
    [simd.sub(way, error), simd.add(way, error)]
}
