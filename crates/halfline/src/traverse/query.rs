//! The questions that one walk through the tree answers.

use crate::geometry::{Hit, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{Contact, PreparedRay, is_nearer};

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

/// Every crossing, each face once.
pub struct AllCrossings<'hits> {
    hits: &'hits mut Vec<Hit>,
    first: usize,
}

impl<'hits> AllCrossings<'hits> {
    /// Appends to `hits`.
    pub fn appending_to(hits: &'hits mut Vec<Hit>) -> AllCrossings<'hits> {
        let first = hits.len();
        AllCrossings { hits, first }
    }

    /// Sorts the crossings by t and then by face, and drops the repeats of faces that lie in
    /// several cells. By face, never by distance: two faces may be crossed at the same t.
    pub fn finish(self) {
        self.hits[self.first..].sort_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
        // The same face has the same t, so its repeats are neighbours.
        let mut kept = self.first;
        for i in self.first..self.hits.len() {
            if kept == self.first || self.hits[kept - 1].face != self.hits[i].face {
                self.hits[kept] = self.hits[i];
                kept += 1;
            }
        }
        self.hits.truncate(kept);
    }
}

impl Query for AllCrossings<'_> {
    #[inline]
    fn offer(&mut self, ray: &PreparedRay, contact: &Contact, face: u32, corners: [Vec3; 3]) {
        if contact.is_crossing {
            self.hits.push(ray.hit(contact.t, face, corners));
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
