//! The point of a surface that is nearest to a given one.

use super::{NO_FACE, Vec3};

/// In which part of its face a closest point lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Feature {
    /// In the inside.
    #[default]
    Face = 0,
    /// On an edge, and at none of its ends.
    Edge = 1,
    /// At a vertex.
    Vertex = 2,
}

/// The point of a surface that is nearest to a given one. Where there is none, `distance` is infinite and
/// `face` equal to [`NO_FACE`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// How far away it is: the double nearest to the exact distance.
    pub distance: f64,
    /// Where it is: each coordinate the double nearest to the exact one.
    pub point: Vec3,
    /// Index of the triangle in the mesh; of those equally near the lowest.
    pub face: u32,
    /// Barycentric weight of the triangle's second vertex.
    pub u: f64,
    /// Barycentric weight of the triangle's third vertex; the first has 1 - u - v.
    pub v: f64,
    /// In which part of the triangle.
    pub feature: Feature,
}

impl ClosestPoint {
    /// The answer where there is no closest point.
    pub const NONE: ClosestPoint = ClosestPoint {
        distance: f64::INFINITY,
        point: Vec3::splat(f64::NAN),
        face: NO_FACE,
        u: f64::NAN,
        v: f64::NAN,
        feature: Feature::Face,
    };

    /// True unless there is no closest point.
    pub fn is_found(&self) -> bool {
        self.face != NO_FACE
    }
}
