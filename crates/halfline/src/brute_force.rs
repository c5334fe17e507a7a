//! The lecture's first system: for all rays, for all triangles.
//!
//! It costs n_rays * n_triangles tests and knows nothing of trees, which makes it the judge of
//! everything that does.

use rayon::prelude::*;

use crate::geometry::{Hit, Ray};
use crate::mesh::Mesh;
use crate::numeric::{PreparedRay, is_nearer};

/// The closest hit of each ray; of hits with equal t the one with the lowest face index.
pub fn intersect(mesh: &Mesh, rays: &[Ray]) -> Vec<Hit> {
    rays.par_iter().map(|ray| closest(mesh, ray)).collect()
}

/// The closest hit of one ray.
pub fn closest(mesh: &Mesh, ray: &Ray) -> Hit {
    let mut nearest = Hit::MISS;
    for_each_hit(mesh, ray, |hit, _| {
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

/// Appends every crossing of one ray to `hits`, sorted by t and then by face.
pub fn all(mesh: &Mesh, ray: &Ray, hits: &mut Vec<Hit>) {
    let first = hits.len();
    for_each_hit(mesh, ray, |hit, is_crossing| {
        if is_crossing {
            hits.push(hit);
        }
    });
    hits[first..].sort_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
}

/// Calls `found` with each contact of `ray` and whether it is a crossing, in face order.
fn for_each_hit(mesh: &Mesh, ray: &Ray, mut found: impl FnMut(Hit, bool)) {
    let Some(prepared) = PreparedRay::new(ray) else { return };
    for face in 0..mesh.triangle_count() as u32 {
        let corners = mesh.corners(face);
        if let Some(contact) = prepared.meet(corners) {
            found(prepared.hit(contact.t, face, corners), contact.is_crossing);
        }
    }
}
