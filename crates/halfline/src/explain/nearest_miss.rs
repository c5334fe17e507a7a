//! By how much a ray missed: the triangle that it passes closest.
//!
//! The distance between a segment and a triangle that it does not meet is attained at an edge of the
//! triangle or at an end of the segment: C. Ericson, "Real-Time Collision Detection" (2005), sections
//! 5.1.5, 5.1.9 and 5.1.10. Different here: the segment may be a half-line. All of it is done in
//! coordinates about the point of the ray nearest to the mesh's centre, in units of the mesh's size, so
//! that the square of a length neither over- nor underflows, and no digit is lost to a distant origin.

use rayon::prelude::*;

use super::verdict::{Edge, TriangleTest};
use crate::error::Result;
use crate::geometry::{Aabb, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{Frame, PreparedRay};
use crate::progress::Observer;

/// The triangle that a ray passes closest without hitting it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestMiss {
    /// The triangle, and why it is not hit. Of equally close ones that with the lowest index.
    pub test: TriangleTest,
    /// The distance between it and the ray, in the mesh's units, with the error of some roundings.
    pub distance: f64,
    /// The t of the point on the ray that is nearest.
    pub t: f64,
    /// The point of the ray at that t.
    pub point_on_ray: Vec3,
    /// The point of the triangle nearest to it.
    pub point_on_face: Vec3,
}

/// The triangle that a ray, which hits nothing, passes closest; `None` for a mesh without finite
/// triangles.
pub fn nearest_miss(
    mesh: &Mesh,
    ray: &Ray,
    bounds: &Aabb,
    observer: &dyn Observer,
) -> Result<Option<NearestMiss>> {
    let Some(prepared) = PreparedRay::new(ray) else { return Ok(None) };
    if bounds.is_empty() {
        return Ok(None);
    }
    let local = Local::new(ray, bounds);
    const CHUNK: u32 = 1 << 14;
    let count = mesh.triangle_count() as u32;
    let closest_of = |chunk: u32| -> Result<Option<(f64, u32)>> {
        observer.check()?;
        let mut closest: Option<(f64, u32)> = None;
        for face in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
            let corners = mesh.corners(face);
            if !corners.into_iter().all(Vec3::is_finite) {
                continue;
            }
            let corners = local.corners(&corners);
            // Pass over those whose surrounding sphere is farther than the closest so far.
            let center = corners[0];
            let reach = (corners[1] - center).length().max((corners[2] - center).length());
            let far = local.segment.distance_to(center) - reach;
            if closest.is_some_and(|(least, _)| far > least) {
                continue;
            }
            let distance = local.segment.nearest(&corners).distance;
            if closest.is_none_or(|(least, _)| distance < least) {
                closest = Some((distance, face));
            }
        }
        Ok(closest)
    };
    let chunks = (0..count.div_ceil(CHUNK)).into_par_iter().map(closest_of);
    let closest = chunks.try_reduce(|| None, |a, b| Ok(nearer(a, b)))?;
    Ok(closest.map(|(_, face)| {
        let corners = mesh.corners(face);
        let nearest = local.segment.nearest(&local.corners(&corners));
        NearestMiss {
            test: TriangleTest::new(mesh, ray, &prepared, face),
            distance: nearest.distance * local.unit,
            t: local.t(nearest.s),
            point_on_ray: local.to_user(nearest.on_segment),
            point_on_face: local.to_user(nearest.on_triangle),
        }
    }))
}

/// The nearer of two, of equal ones the lower face.
fn nearer(a: Option<(f64, u32)>, b: Option<(f64, u32)>) -> Option<(f64, u32)> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if (b.0, b.1) < (a.0, a.1) { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// The edge of a triangle that the line of a ray passes closest, and the distance.
pub fn edge_distances(ray: &Ray, corners: &[Vec3; 3]) -> (Edge, f64) {
    let [a, b, c] = *corners;
    let bounds = Aabb::EMPTY.including(a).including(b).including(c);
    let whole = Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..*ray };
    let local = Local::new(&whole, &bounds);
    let corners = local.corners(corners);
    let distance = |edge: usize| {
        let ends = [corners[(edge + 1) % 3], corners[(edge + 2) % 3]];
        local.segment.nearest_to_edge(ends).distance
    };
    let nearest = (0..3).min_by(|&i, &j| distance(i).total_cmp(&distance(j))).unwrap_or(0);
    (Edge::ALL[nearest], distance(nearest) * local.unit)
}

/// Coordinates about the point of a ray nearest to the centre of a box, in units of the box's size.
struct Local {
    origin: Vec3,
    t_origin: f64,
    /// A power of two, in the user's units.
    unit: f64,
    /// One unit of t, in units of the box's size.
    units_per_t: f64,
    segment: Segment,
}

impl Local {
    fn new(ray: &Ray, bounds: &Aabb) -> Local {
        let unit = Frame::around(bounds).unit();
        // A unit direction, found without over- or underflow.
        let largest = ray.direction.abs().max_element();
        let scaled = ray.direction / largest;
        let direction = scaled / scaled.length();
        let speed = largest * scaled.length();
        let way = (bounds.center() - ray.origin).dot(direction);
        let t_origin = (way / speed).clamp(ray.t_min, ray.t_max);
        let t_origin = if t_origin.is_finite() { t_origin } else { 0.0 };
        let origin = ray.origin + ray.direction * t_origin;
        let units_per_t = speed / unit;
        // Zero times infinity: a direction so long that it stands for where it begins.
        let place = |t: f64| Some((t - t_origin) * units_per_t).filter(|s| !s.is_nan());
        let range = [ray.t_min, ray.t_max].map(|t| place(t).unwrap_or(0.0));
        Local { origin, t_origin, unit, units_per_t, segment: Segment { direction, range } }
    }

    fn corners(&self, corners: &[Vec3; 3]) -> [Vec3; 3] {
        corners.map(|corner| (corner - self.origin) / self.unit)
    }

    fn t(&self, s: f64) -> f64 {
        self.t_origin + s / self.units_per_t
    }

    fn to_user(&self, point: Vec3) -> Vec3 {
        self.origin + point * self.unit
    }
}

/// The points `s * direction` with s in a range that may be infinite; the direction has unit length.
struct Segment {
    direction: Vec3,
    range: [f64; 2],
}

/// Where a segment and a triangle are nearest to each other.
#[derive(Clone, Copy)]
struct Nearest {
    distance: f64,
    s: f64,
    on_segment: Vec3,
    on_triangle: Vec3,
}

impl Segment {
    fn clamp(&self, s: f64) -> f64 {
        s.clamp(self.range[0], self.range[1])
    }

    fn distance_to(&self, point: Vec3) -> f64 {
        (point - self.direction * self.clamp(point.dot(self.direction))).length()
    }

    fn between(&self, s: f64, on_triangle: Vec3) -> Nearest {
        let on_segment = self.direction * s;
        Nearest { distance: (on_triangle - on_segment).length(), s, on_segment, on_triangle }
    }

    /// A triangle that the segment does not pass through.
    fn nearest(&self, corners: &[Vec3; 3]) -> Nearest {
        let [a, b, c] = *corners;
        let edges = [[b, c], [c, a], [a, b]].map(|edge| self.nearest_to_edge(edge));
        let ends = self.range.into_iter().filter(|s| s.is_finite());
        let ends = ends.map(|s| self.between(s, nearest_of_triangle(self.direction * s, corners)));
        let first = edges[0];
        edges.into_iter().chain(ends).fold(first, |nearest, other| {
            if other.distance < nearest.distance { other } else { nearest }
        })
    }

    /// Ericson 5.1.9, for a first segment of unit direction.
    fn nearest_to_edge(&self, [p, q]: [Vec3; 2]) -> Nearest {
        let edge = q - p;
        let squared = edge.dot(edge);
        if squared == 0.0 {
            return self.between(self.clamp(p.dot(self.direction)), p);
        }
        // Seen along the segment it is a point and a line; where they are parallel any point will do.
        let (across, away) = (edge.cross(self.direction), p.cross(self.direction));
        let width = across.dot(across);
        let share = if width > 0.0 { -away.dot(across) / width } else { 0.0 };
        let s = self.clamp((p + edge * share.clamp(0.0, 1.0)).dot(self.direction));
        // Clamping one may move the other.
        let share = ((self.direction * s - p).dot(edge) / squared).clamp(0.0, 1.0);
        let on_edge = p + edge * share;
        self.between(self.clamp(on_edge.dot(self.direction)), on_edge)
    }
}

/// The point of a triangle nearest to `point`: Ericson 5.1.5.
fn nearest_of_triangle(point: Vec3, &[a, b, c]: &[Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let length = d1 - d3;
        return a + ab * if length > 0.0 { d1 / length } else { 0.0 };
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let length = d2 - d6;
        return a + ac * if length > 0.0 { d2 / length } else { 0.0 };
    }
    let va = d3 * d6 - d5 * d4;
    let (from_b, from_c) = (d4 - d3, d5 - d6);
    if va <= 0.0 && from_b >= 0.0 && from_c >= 0.0 {
        let length = from_b + from_c;
        return b + (c - b) * if length > 0.0 { from_b / length } else { 0.0 };
    }
    let sum = va + vb + vc;
    if sum > 0.0 { a + ab * (vb / sum) + ac * (vc / sum) } else { a }
}
