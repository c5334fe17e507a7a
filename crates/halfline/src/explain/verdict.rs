//! What came of a ray and a triangle, and why.

use super::nearest_miss::edge_distances;
use crate::geometry::{Hit, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{PreparedRay, is_zero_area};

/// An edge of a triangle with the corners a, b, c, by the corner opposite to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// From b to c.
    BC,
    /// From c to a.
    CA,
    /// From a to b.
    AB,
}

impl Edge {
    /// In the order of the corners opposite to them.
    pub const ALL: [Edge; 3] = [Edge::BC, Edge::CA, Edge::AB];

    /// "b-c", "c-a" or "a-b".
    pub const fn name(self) -> &'static str {
        match self {
            Edge::BC => "b-c",
            Edge::CA => "c-a",
            Edge::AB => "a-b",
        }
    }
}

/// What came of a ray and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The ray hits it.
    Hit(Hit),
    /// The ray's line meets it, but beyond `t_max`.
    Beyond {
        /// The t at which the line meets it.
        t: f64,
    },
    /// The ray's line meets it, but before `t_min`.
    Behind {
        /// The t at which the line meets it.
        t: f64,
    },
    /// The ray's line passes outside.
    Outside {
        /// The edge that it passes closest.
        edge: Edge,
        /// The distance between the line and that edge, in the mesh's units.
        distance: f64,
    },
    /// The ray's line lies in the triangle's plane, which is no hit by definition.
    EdgeOn,
    /// The triangle's corners lie on one line, or are not finite: nothing hits it.
    NoArea,
}

/// A triangle that a ray was tested against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleTest {
    /// The index of the face.
    pub face: u32,
    /// On which side of the edges b-c, c-a and a-b the line passes, exactly. It meets the triangle if no
    /// two of them are opposite, and not all are 0.
    pub edge_signs: [i8; 3],
    /// How the test ended.
    pub verdict: Verdict,
}

impl TriangleTest {
    /// Tests a ray, which was also `prepared`, against a face.
    pub fn new(mesh: &Mesh, ray: &Ray, prepared: &PreparedRay, face: u32) -> TriangleTest {
        let corners = mesh.corners(face);
        let Some(edge_signs) = prepared.edge_signs(&corners) else {
            return TriangleTest { face, edge_signs: [0; 3], verdict: Verdict::NoArea };
        };
        let verdict = verdict(ray, prepared, face, corners, edge_signs);
        TriangleTest { face, edge_signs, verdict }
    }

    /// The hit, if it is one.
    pub fn hit(&self) -> Option<&Hit> {
        match &self.verdict {
            Verdict::Hit(hit) => Some(hit),
            _ => None,
        }
    }
}

fn verdict(
    ray: &Ray,
    prepared: &PreparedRay,
    face: u32,
    corners: [Vec3; 3],
    edge_signs: [i8; 3],
) -> Verdict {
    if is_zero_area(corners) {
        return Verdict::NoArea;
    }
    if edge_signs == [0; 3] {
        return Verdict::EdgeOn;
    }
    if edge_signs.contains(&1) && edge_signs.contains(&-1) {
        let (edge, distance) = edge_distances(ray, &corners);
        return Verdict::Outside { edge, distance };
    }
    let hit = prepared.hit(face, corners);
    match hit.t {
        t if t < ray.t_min => Verdict::Behind { t },
        // A hit beyond the largest double does not count either.
        t if t > ray.t_max || !t.is_finite() => Verdict::Beyond { t },
        _ => Verdict::Hit(hit),
    }
}
