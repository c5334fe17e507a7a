//! An affine map of space.

use super::{Vec3, vec3};

/// `p -> linear * p + translation`, with the linear part in columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Images of the three unit vectors.
    pub columns: [Vec3; 3],
    /// Image of the origin.
    pub translation: Vec3,
}

impl Transform {
    /// Leaves every point where it is.
    pub const IDENTITY: Transform = Transform {
        columns: [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)],
        translation: Vec3::ZERO,
    };

    /// The image of a direction.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.columns[0] * v.x + self.columns[1] * v.y + self.columns[2] * v.z
    }

    /// The image of a point.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.vector(p) + self.translation
    }

    /// First `inner`, then this map.
    pub fn compose(&self, inner: &Transform) -> Transform {
        Transform {
            columns: inner.columns.map(|c| self.vector(c)),
            translation: self.point(inner.translation),
        }
    }
}
