//! Where a ray passes through a box, at least and at most.
//!
//! T. L. Kay, J. T. Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986, in double precision on
//! the single-precision boxes of the tree. Different here: the answer errs on one side only, by the
//! bounds named below, so that no box is passed over that could hold a hit.

use crate::geometry::{Ray, Vec3};
use crate::numeric::{Frame, UNIT_ROUNDOFF, exponent_of, scale_vector, two_powers};
use crate::tree::Bounds;

/// A ray in the scene frame, ready for boxes.
///
/// Its parameter `s` is t times a power of two, chosen so that the largest component of the
/// direction lies in [1, 2): neither a tiny nor a huge direction can overflow.
pub struct SlabRay {
    /// The origin and the scaled direction in the frame.
    pub origin: Vec3,
    /// Its largest component lies in [1, 2).
    pub direction: Vec3,
    /// The origin, moved along each axis so that the near plane seems nearer by [`ORIGIN_ERROR`].
    near_origin: [f64; 3],
    /// The same so that the far plane seems farther.
    far_origin: [f64; 3],
    /// Limited to [`STEEPEST`].
    pub inverse_direction: [f64; 3],
    /// For each axis whether the direction is negative.
    pub is_negative: [bool; 3],
    s_min: f64,
    /// From t to s.
    pub scale: Scale,
}

/// What takes t to s.
#[derive(Clone, Copy)]
pub struct Scale {
    /// Two powers of two, since their product may be out of range.
    factors: [f64; 2],
    /// The s of the smallest denormal t: no rounding of a denormal t is larger.
    smallest_s: f64,
}

impl Scale {
    fn new(exponent: i32) -> Scale {
        let factors = two_powers(exponent);
        Scale { factors, smallest_s: f64::from_bits(1) * factors[0] * factors[1] }
    }

    /// That of a factor whose products with t neither overflow nor underflow where it matters.
    #[inline(always)]
    pub fn by(factor: f64) -> Scale {
        Scale { factors: [factor, 1.0], smallest_s: 0.0 }
    }

    /// Of a ray that meets everything.
    pub const UNBOUNDED: Scale = Scale { factors: [f64::INFINITY; 2], smallest_s: 0.0 };

    /// False for a ray that meets everything.
    #[inline(always)]
    pub fn is_bounded(&self) -> bool {
        self.factors[0] < f64::INFINITY
    }

    /// About the t of s.
    pub fn t(&self, s: f64) -> f64 {
        s / self.factors[0] / self.factors[1]
    }

    /// An s that is no larger than that of t.
    #[inline(always)]
    pub fn lower(&self, t: f64) -> f64 {
        if !self.is_bounded() {
            return f64::NEG_INFINITY;
        }
        let s = t * self.factors[0] * self.factors[1];
        s - DISTANCE_ERROR * s.abs() - self.smallest_s
    }

    /// The largest s at which a box may be entered, for hits with t up to `t_max`.
    #[inline(always)]
    pub fn limit(&self, t_max: f64) -> f64 {
        if !self.is_bounded() {
            return f64::INFINITY;
        }
        widened(t_max * self.factors[0] * self.factors[1]) + self.smallest_s
    }
}

/// The origin's relative error: the frame's subtraction, and the two roundings of moving it by
/// the error itself.
const ORIGIN_ERROR: f64 = 4.0 * UNIT_ROUNDOFF;

/// Added to the above, so that an origin of exactly zero is moved too: far below the resolution of
/// the frame, and far above the displacement along a direction that [`STEEPEST`] cut off.
const SMALLEST_ORIGIN_ERROR: f64 = 1e-30;

/// Inverses of direction components are limited to this. So a component of zero needs no case of
/// its own: a ray within the slab, or less than [`SMALLEST_ORIGIN_ERROR`] beside it, gets the
/// interval of at least ±1e120, beyond all hits; one outside of it gets an empty one.
const STEEPEST: f64 = 1e150;

/// Rays from beyond this, in units of the scene, are tested against everything: the bounds above
/// hold for hits up to 1e111 or so.
const FARTHEST_ORIGIN: f64 = 1e110;

/// Relative error of the distance to a plane: subtraction, inverse, product, each one rounding,
/// doubled since near and far may both be off, and doubled again for the comparison with t, which
/// is itself rounded.
const DISTANCE_ERROR: f64 = 16.0 * UNIT_ROUNDOFF;

impl SlabRay {
    /// Prepares a valid ray.
    #[inline(always)]
    pub fn new(ray: &Ray, frame: &Frame) -> SlabRay {
        let size = exponent_of(ray.direction.abs().max_element());
        let direction = scale_vector(ray.direction, -size);
        let origin = frame.point(ray.origin);
        if origin.abs().max_element() >= FARTHEST_ORIGIN {
            return SlabRay::through_everything();
        }
        let exponent = size + exponent_of(frame.scale());
        let scale = Scale::new(exponent);
        let s_min = ray.t_min * scale.factors[0] * scale.factors[1] - scale.smallest_s;
        let mut slab_ray = SlabRay {
            origin,
            direction,
            near_origin: [0.0; 3],
            far_origin: [0.0; 3],
            inverse_direction: [0.0; 3],
            is_negative: [false; 3],
            s_min,
            scale,
        };
        for axis in 0..3 {
            let inverse = (1.0 / direction[axis]).clamp(-STEEPEST, STEEPEST);
            let error = ORIGIN_ERROR * origin[axis].abs() + SMALLEST_ORIGIN_ERROR;
            let ahead = if inverse < 0.0 { -error } else { error };
            slab_ray.near_origin[axis] = origin[axis] + ahead;
            slab_ray.far_origin[axis] = origin[axis] - ahead;
            slab_ray.inverse_direction[axis] = inverse;
            slab_ray.is_negative[axis] = inverse < 0.0;
        }
        slab_ray
    }

    /// A ray that meets every box, and each at s = 0: what is tested then decides.
    fn through_everything() -> SlabRay {
        SlabRay {
            origin: Vec3::ZERO,
            direction: Vec3::splat(1.0),
            near_origin: [0.0; 3],
            far_origin: [0.0; 3],
            inverse_direction: [0.0; 3],
            is_negative: [false; 3],
            s_min: 0.0,
            scale: Scale::UNBOUNDED,
        }
    }

    /// A lower bound for the s at which the ray enters the box, or infinity if it misses it or
    /// enters beyond `limit`.
    #[inline(always)]
    pub fn entry(&self, bounds: &Bounds, limit: f64) -> f64 {
        let mut enter = self.s_min;
        let mut leave = f64::INFINITY;
        for axis in 0..3 {
            let (low, high) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
            let (near, far) = if self.is_negative[axis] { (high, low) } else { (low, high) };
            let near = (near - self.near_origin[axis]) * self.inverse_direction[axis];
            let far = (far - self.far_origin[axis]) * self.inverse_direction[axis];
            // No NaN arises: boxes, origins and inverses are finite, and an empty box's infinite
            // sides give an empty interval. A comparison with NaN would keep the box.
            enter = if near > enter { near } else { enter };
            leave = if far < leave { far } else { leave };
        }
        let passes = enter <= widened(leave) && enter <= limit;
        if passes { enter } else { f64::INFINITY }
    }
}

/// `s` or a little more, by [`DISTANCE_ERROR`]; infinities stay what they are.
#[inline(always)]
fn widened(s: f64) -> f64 {
    s + if s.is_finite() { DISTANCE_ERROR * s.abs() } else { 0.0 }
}
