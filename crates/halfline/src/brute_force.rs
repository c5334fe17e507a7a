//! The lecture's first system: for all rays, for all triangles.
//!
//! It costs n_rays * n_triangles tests and knows nothing of trees, which makes it the judge of
//! everything that does.

use rayon::prelude::*;

use crate::geometry::{Hit, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{Contact, PreparedRay, Touch, complete_hits, is_nearer};

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
