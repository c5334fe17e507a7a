//! Eight rays made ready at once, on a vector unit.
//!
//! What decides where a ray is, its origin in the frame, its start, its slopes, is taken in double
//! precision and rounded then; what only bounds something is taken in single precision from the
//! beginning.

use bytemuck::Zeroable;

use super::filter_lanes::{Longest, UNITS, leaf_filters};
use super::slab::Scale;
use super::wide_ray::{
    DEPTH_ERROR, FAR, FIELDS, LIMIT_ERROR, POSITION_ERROR, Parameter, SINGLE_ROUNDOFF, START_ERROR,
    STEEPEST, WIDEST, WideRay, World,
};
use crate::geometry::{Ray, SingleRay};
use crate::simd::{F64x8, LANES, Simd, SimdF64};

/// Eight rays.
pub struct RayGroup {
    /// By what is needed of them.
    pub columns: Columns,
    /// The same ray by ray, once that was needed.
    rays: [WideRay; LANES],
    has_rays: bool,
    start: [f32; LANES],
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
    /// Where boxes stop to matter.
    pub const LIMIT: usize = 9;
    /// The octant of the direction, and the axis that it follows most, in the lowest bits of numbers
    /// that are compared as such.
    pub const OCTANT: usize = 10;
    /// The second.
    pub const LAST: usize = 11;
    /// Slopes of the projection,
    pub const SLOPE: usize = 12;
    /// where the lines are in it,
    pub const CENTER: usize = 14;
    /// and the errors of edge functions.
    pub const ERROR: usize = 16;
    /// From places along the last axis to parameters: a factor, what is added, and the error.
    pub const DEPTH: usize = 18;
    /// Between which numbers the range begins,
    pub const BEGIN: usize = 21;
    /// and before which it ends.
    pub const END: usize = 23;
    /// How many fields there are.
    pub const COUNT: usize = FIELDS;

    /// Before the first rays.
    pub fn none() -> Columns {
        Columns([[0.0; LANES]; FIELDS])
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
        self.0[Columns::LAST][lane].to_bits()
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
const ENTRY_ERROR: f64 = 10.0 * SINGLE_ROUNDOFF;

/// Eight rays as they were given.
pub struct RayLanes<S: Simd> {
    /// By axis.
    pub origin: [F64x8<S>; 3],
    /// By axis.
    pub direction: [F64x8<S>; 3],
    /// Where the ranges begin,
    pub t_min: F64x8<S>,
    /// and end.
    pub t_max: F64x8<S>,
}

/// Rays that can be taken eight at a time.
pub trait RayRows: Copy + Into<Ray> {
    /// The first eight, or fewer: what the other lanes hold does not matter.
    fn lanes<S: Simd>(simd: S, rays: &[Self]) -> RayLanes<S>;

    /// Those of eight numbers.
    fn gather<S: Simd>(simd: S, rays: &[Self], numbers: &[usize; LANES]) -> RayLanes<S>;
}

impl RayRows for SingleRay {
    #[inline(always)]
    fn lanes<S: Simd>(simd: S, rays: &[SingleRay]) -> RayLanes<S> {
        let mut rows = [simd.splat(0.0); LANES];
        for (row, ray) in rows.iter_mut().zip(rays) {
            *row = simd.load(bytemuck::cast_ref(ray));
        }
        of_rows(simd, rows)
    }

    #[inline(always)]
    fn gather<S: Simd>(simd: S, rays: &[SingleRay], numbers: &[usize; LANES]) -> RayLanes<S> {
        let mut rows = [simd.splat(0.0); LANES];
        for lane in 0..LANES {
            rows[lane] = simd.load(bytemuck::cast_ref(&rays[numbers[lane]]));
        }
        of_rows(simd, rows)
    }
}

/// From rays as they lie in memory.
#[inline(always)]
fn of_rows<S: Simd>(simd: S, rows: [S::F32x8; LANES]) -> RayLanes<S> {
    let [a, b, c, t_min, x, y, z, t_max] = simd.transpose(rows);
    RayLanes {
        origin: [simd.widen(a), simd.widen(b), simd.widen(c)],
        direction: [simd.widen(x), simd.widen(y), simd.widen(z)],
        t_min: simd.widen(t_min),
        t_max: simd.widen(t_max),
    }
}

impl RayRows for Ray {
    #[inline(always)]
    fn lanes<S: Simd>(simd: S, rays: &[Ray]) -> RayLanes<S> {
        let mut lanes = [[0.0; LANES]; 8];
        for (lane, ray) in rays.iter().take(LANES).enumerate() {
            for axis in 0..3 {
                lanes[axis][lane] = ray.origin[axis];
                lanes[3 + axis][lane] = ray.direction[axis];
            }
            (lanes[6][lane], lanes[7][lane]) = (ray.t_min, ray.t_max);
        }
        let wide = simd.doubles();
        RayLanes {
            origin: [wide.load(&lanes[0]), wide.load(&lanes[1]), wide.load(&lanes[2])],
            direction: [wide.load(&lanes[3]), wide.load(&lanes[4]), wide.load(&lanes[5])],
            t_min: wide.load(&lanes[6]),
            t_max: wide.load(&lanes[7]),
        }
    }

    #[inline(always)]
    fn gather<S: Simd>(simd: S, rays: &[Ray], numbers: &[usize; LANES]) -> RayLanes<S> {
        let mut picked = [rays[numbers[0]]; LANES];
        for lane in 1..LANES {
            picked[lane] = rays[numbers[lane]];
        }
        Ray::lanes(simd, &picked)
    }
}

impl RayGroup {
    /// Rays that were never set.
    pub fn none() -> RayGroup {
        let rays = [WideRay::zeroed(); LANES];
        let parameters = [Parameter::NONE; LANES];
        RayGroup {
            columns: Columns::none(),
            rays,
            has_rays: false,
            start: [0.0; LANES],
            factor: [0.0; LANES],
            parameters,
            met: 0,
            single: 0,
        }
    }

    /// Finds the parts of rays within the root's box.
    #[inline(always)]
    pub fn set<S: Simd>(&mut self, simd: S, rays: &RayLanes<S>, world: &World) {
        let wide = simd.doubles();
        let reach = simd.splat(world.reach);
        let zero = simd.splat(0.0);

        // Scale the directions by powers of two to [1, 2), and bring the origins into the frame.
        let along = &rays.direction;
        let largest = wide.max(wide.abs(along[0]), wide.abs(along[1]));
        let largest = wide.max(largest, wide.abs(along[2]));
        let power = wide.power(largest);
        let inverse_power = wide.inverse_power(power);
        let scale = world.frame.scale();
        let factor = wide.mul(power, wide.splat(scale));
        let offset = world.frame.offset();
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
        let before = simd.splat(-4.0 * SINGLE_ROUNDOFF as f32);
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
            let (low, high) = (world.root.min[axis], world.root.max[axis]);
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
        let filter = leaf_filters(simd, &longest, &origin, &direction, from_origin, world.reach);
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
                simd.store(parts[part][field], &mut self.columns.0[LANES * part + field]);
            }
        }
        self.has_rays = false;
        simd.store(enter, &mut self.start);
        wide.store(factor, &mut self.factor);
        self.single = !(ordinary & bounded) & ALL;
        self.met = met & ALL | self.single;
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
                fields[field] = self.columns.load(simd, LANES * part + field);
            }
            let rows = simd.transpose(fields);
            for lane in 0..LANES {
                simd.store(rows[lane], &mut self.rays[lane].parts_mut()[part]);
            }
        }
    }

    /// Looks at a ray by itself, once the others were written down; false if it does not meet the root's box.
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

    /// A ray that meets the root's box, once it was written down.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> (&WideRay, Parameter) {
        if self.single >> lane & 1 == 1 {
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

const ALL: u32 = (1 << LANES) - 1;

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
