//! What a ray hit.

use bytemuck::{Pod, Zeroable};

/// The face index of a miss.
pub const NO_FACE: u32 = u32::MAX;

/// Where a ray met a face. A miss has `t` infinite and `face` equal to [`NO_FACE`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter, in units of the ray's direction.
    pub t: f64,
    /// Index of the triangle in the mesh.
    pub face: u32,
    /// Barycentric weight of the triangle's second vertex.
    pub u: f64,
    /// Barycentric weight of the triangle's third vertex; the first has 1 - u - v.
    pub v: f64,
}

impl Hit {
    /// The answer to a ray that hits nothing.
    pub const MISS: Hit = Hit { t: f64::INFINITY, face: NO_FACE, u: 0.0, v: 0.0 };

    /// True unless this is a miss.
    pub fn is_hit(&self) -> bool {
        self.face != NO_FACE
    }
}

/// What a [`RayF32`](super::RayF32) hit. A miss has `t` infinite and `face` equal to
/// [`NO_FACE`].
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct HitF32 {
    /// Ray parameter: the double nearest to the exact one, rounded to single precision.
    pub t: f32,
    /// Index of the triangle in the mesh.
    pub face: u32,
}

impl HitF32 {
    /// The answer to a ray that hits nothing.
    pub const MISS: HitF32 = HitF32 { t: f32::INFINITY, face: NO_FACE };

    /// True unless this is a miss.
    pub fn is_hit(&self) -> bool {
        self.face != NO_FACE
    }
}
