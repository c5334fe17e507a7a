//! The lecture's first system: for all rays, for all triangles.
//!
//! It costs n_rays * n_triangles tests and knows nothing of trees, which makes it the judge of
//! everything that does.

use rayon::prelude::*;

use crate::geometry::{ClosestPoint, Hit, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{Contact, NearestPart, PreparedRay, Touch, complete_hits, is_nearer};

/// The closest hit of each ray; of hits with equal t the one with the lowest face index.
pub fn intersect(mesh: &Mesh, rays: &[Ray]) -> Vec<Hit> {
    rays.par_iter().map(|ray| closest(mesh, ray)).collect()
}

/// The closest hit of one ray.
pub fn closest(mesh: &Mesh, ray: &Ray) -> Hit {
    let Some(prepared) = PreparedRay::new(ray) else { return Hit::MISS };
    let mut nearest = Hit::MISS;
    for_each_contact(mesh, &prepared, |_, face| {
        let hit = prepared.hit(face, mesh.corners(face));
        if is_nearer(&hit, &nearest) {
            nearest = hit;
        }
    });
    nearest
}

/// True if one ray hits anything.
pub fn any(mesh: &Mesh, ray: &Ray) -> bool {
    closest(mesh, ray).is_hit()
}

/// Appends all hits of one ray to `hits`, sorted by t and then by face; see
/// [`numeric`](crate::numeric).
pub fn all(mesh: &Mesh, ray: &Ray, hits: &mut Vec<Hit>) {
    let Some(prepared) = PreparedRay::new(ray) else { return };
    let first = hits.len();
    let mut touches = Vec::new();
    for_each_contact(mesh, &prepared, |contact, face| {
        let Contact { t, touched, .. } = contact;
        if contact.is_crossing {
            hits.push(prepared.hit(face, mesh.corners(face)));
        } else {
            touches.push(Touch { t, face, touched });
        }
    });
    let corners_of = |face| mesh.corners(face);
    let triangles_at = |point: Vec3| {
        let triangles = (0..mesh.triangle_count() as u32).map(corners_of);
        triangles.filter(|corners| corners.contains(&point)).collect()
    };
    complete_hits(&prepared, hits, first, &mut touches, corners_of, triangles_at);
}

/// Calls `found` with each contact of the ray and its face, in face order.
fn for_each_contact(mesh: &Mesh, ray: &PreparedRay, mut found: impl FnMut(Contact, u32)) {
    for face in 0..mesh.triangle_count() as u32 {
        if let Some(contact) = ray.meet(mesh.corners(face)) {
            found(contact, face);
        }
    }
}

/// The closest point for each of some points, if it is no farther than `max_distance`; of equally close faces the
/// lowest.
pub fn closest_points(mesh: &Mesh, points: &[Vec3], max_distance: f64) -> Vec<ClosestPoint> {
    points.par_iter().map(|&point| closest_point(mesh, point, max_distance)).collect()
}

/// The closest point for one point.
fn closest_point(mesh: &Mesh, point: Vec3, max_distance: f64) -> ClosestPoint {
    let mut nearest: Option<NearestPart> = None;
    let is_valid = point.is_finite() && max_distance >= 0.0;
    for face in (0..mesh.triangle_count() as u32).filter(|_| is_valid) {
        let corners = mesh.corners(face);
        if corners.into_iter().all(Vec3::is_finite) {
            let part = NearestPart::of(point, face, corners);
            if nearest.is_none_or(|nearest| part.is_before(point, &nearest)) {
                nearest = Some(part);
            }
        }
    }
    let answer = nearest.map_or(ClosestPoint::NONE, |part| part.closest_point(point));
    if answer.distance <= max_distance { answer } else { ClosestPoint::NONE }
}
