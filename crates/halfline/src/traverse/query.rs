//! The questions that one walk through the tree answers.

use super::around_point::triangles_at;
use crate::geometry::{Hit, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{Contact, PreparedRay, Touch, complete_hits, is_nearer};
use crate::tree::KdTree;

/// What a walk does with the contacts that it finds.
pub trait Query {
    /// Takes the contact of `ray` with `face`, whose corners these are.
    fn offer(&mut self, ray: &PreparedRay, contact: &Contact, face: u32, corners: [Vec3; 3]);

    /// The largest t that still matters, given the ray's own.
    fn t_max(&self, ray_t_max: f64) -> f64;

    /// True once nothing more can matter.
    fn is_done(&self) -> bool;
}

/// The contact with the smallest t; of equal ones that with the lowest face index.
pub struct ClosestHit {
    nearest: Hit,
}

impl ClosestHit {
    /// What was found so far, without its barycentrics.
    #[cfg(feature = "variants")]
    pub fn nearest(&self) -> Hit {
        self.nearest
    }

    /// The hit, once the walk is over.
    pub fn finish(self, ray: &PreparedRay, mesh: &Mesh) -> Hit {
        let Hit { t, face, .. } = self.nearest;
        if self.nearest.is_hit() { ray.hit(t, face, mesh.corners(face)) } else { Hit::MISS }
    }
}

impl Default for ClosestHit {
    fn default() -> ClosestHit {
        ClosestHit { nearest: Hit::MISS }
    }
}

impl Query for ClosestHit {
    #[inline]
    fn offer(&mut self, _ray: &PreparedRay, contact: &Contact, face: u32, _corners: [Vec3; 3]) {
        // Barycentrics wait until it is known whose are wanted.
        let hit = Hit { t: contact.t, face, ..Hit::MISS };
        if is_nearer(&hit, &self.nearest) {
            self.nearest = hit;
        }
    }

    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        if self.nearest.is_hit() { self.nearest.t } else { ray_t_max }
    }

    #[inline]
    fn is_done(&self) -> bool {
        false
    }
}

/// Whether there is any contact.
#[derive(Default)]
pub struct AnyHit {
    /// True once one was found.
    pub found: bool,
}

impl Query for AnyHit {
    #[inline]
    fn offer(&mut self, _ray: &PreparedRay, _contact: &Contact, _face: u32, _corners: [Vec3; 3]) {
        self.found = true;
    }

    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        ray_t_max
    }

    #[inline]
    fn is_done(&self) -> bool {
        self.found
    }
}

/// All hits, each face once.
pub struct AllContacts<'a> {
    hits: &'a mut Vec<Hit>,
    first: usize,
    /// The contacts that are no crossings, which are few.
    touches: &'a mut Vec<Touch>,
}

impl<'a> AllContacts<'a> {
    /// Appends to `hits`. What `touches` holds does not matter, only its room.
    pub fn appending_to(hits: &'a mut Vec<Hit>, touches: &'a mut Vec<Touch>) -> AllContacts<'a> {
        touches.clear();
        let first = hits.len();
        AllContacts { hits, first, touches }
    }

    /// Sorts the hits by t and then by face, once the walk is over.
    pub fn finish(self, ray: &PreparedRay, tree: &KdTree, mesh: &Mesh) {
        complete_hits(
            ray,
            self.hits,
            self.first,
            self.touches,
            |face| mesh.corners(face),
            |point| triangles_at(tree, mesh, point),
        );
    }
}

impl Query for AllContacts<'_> {
    #[inline]
    fn offer(&mut self, ray: &PreparedRay, contact: &Contact, face: u32, corners: [Vec3; 3]) {
        let &Contact { t, touched, .. } = contact;
        if contact.is_crossing {
            self.hits.push(ray.hit(t, face, corners));
        } else {
            self.touches.push(Touch { t, face, touched });
        }
    }

    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        ray_t_max
    }

    #[inline]
    fn is_done(&self) -> bool {
        false
    }
}
