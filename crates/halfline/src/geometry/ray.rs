//! A half-line, cut to a range of its parameter.

use bytemuck::{Pod, Zeroable};

use super::{Vec3, vec3};

/// The points `origin + t * direction` with `t_min <= t <= t_max`. The direction need not have
/// unit length: `t` counts in units of the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where t is zero.
    pub origin: Vec3,
    /// How far one unit of t reaches.
    pub direction: Vec3,
    /// Smallest t that counts, itself included.
    pub t_min: f64,
    /// Largest t that counts, itself included; may be infinite.
    pub t_max: f64,
}

impl Ray {
    /// The whole half-line from `origin` along `direction`.
    pub fn new(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
    }

    /// The part of the line with t in `[t_min, t_max]`.
    pub fn with_range(origin: Vec3, direction: Vec3, t_min: f64, t_max: f64) -> Ray {
        Ray { origin, direction, t_min, t_max }
    }

    /// The point at parameter t.
    pub fn at(&self, t: f64) -> Vec3 {
        self.origin + self.direction * t
    }

    /// False for a ray that hits nothing by definition: an origin or direction that is not
    /// finite, a direction of zero, a NaN in the range, or `t_min > t_max`.
    pub fn is_valid(&self) -> bool {
        self.origin.is_finite()
            && self.direction.is_finite()
            && self.direction != Vec3::ZERO
            && self.t_min <= self.t_max
    }
}

/// A ray in single precision, 32 bytes, for large batches: the ray of the same numbers as doubles.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RayF32 {
    /// Where t is zero.
    pub origin: [f32; 3],
    /// Smallest t that counts, itself included.
    pub t_min: f32,
    /// How far one unit of t reaches.
    pub direction: [f32; 3],
    /// Largest t that counts, itself included; may be infinite.
    pub t_max: f32,
}

impl RayF32 {
    /// The whole half-line from `origin` along `direction`.
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> RayF32 {
        RayF32::with_range(origin, direction, 0.0, f32::INFINITY)
    }

    /// The part of the line with t in `[t_min, t_max]`.
    pub fn with_range(origin: [f32; 3], direction: [f32; 3], t_min: f32, t_max: f32) -> RayF32 {
        RayF32 { origin, t_min, direction, t_max }
    }
}

impl From<RayF32> for Ray {
    #[inline(always)]
    fn from(ray: RayF32) -> Ray {
        let [[a, b, c], [x, y, z]] = [ray.origin, ray.direction];
        Ray {
            origin: vec3(f64::from(a), f64::from(b), f64::from(c)),
            direction: vec3(f64::from(x), f64::from(y), f64::from(z)),
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        }
    }
}
