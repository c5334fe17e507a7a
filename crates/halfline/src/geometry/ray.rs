//! A half-line, cut to a range of its parameter.

use super::Vec3;

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
