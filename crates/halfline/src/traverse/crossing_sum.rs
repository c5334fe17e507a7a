//! Signed crossings: how often a ray leaves a solid through a surface, less how often it enters.
//!
//! The crossings are those of all hits (`query.rs`); their signs, and whether the ray starts on the surface,
//! are found once the walk is over, so that no walk of another question pays for them.

use super::cast::Cast;
use super::query::{AllContacts, CertainCrossing};
use crate::geometry::{Ray, Vec3};
use crate::numeric::{facing_sign, plane_side};

/// What the crossings of a ray amount to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CrossingSum {
    /// Crossings out of a solid less those into it.
    pub signed: i32,
    /// All crossings.
    pub count: u32,
    /// True if the ray starts on one of the triangles that it meets.
    pub is_on_surface: bool,
}

/// A face that a ray crosses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SignedCrossing {
    /// The face.
    pub face: u32,
    /// 1 if the ray leaves a solid there, -1 if it enters one.
    pub sign: i8,
}

impl AllContacts {
    /// Puts the crossings of a ray into `crossings`, sorted by face. Returns true if the ray starts on the surface.
    pub fn signed_crossings(
        &self,
        ray: &Ray,
        corners_of: impl Fn(&CertainCrossing) -> [Vec3; 3],
        mesh_corners: impl Fn(u32) -> [Vec3; 3],
        crossings: &mut Vec<SignedCrossing>,
    ) -> bool {
        crossings.clear();
        let mut is_on_surface = false;
        for certain in &self.certain {
            let sign = facing_sign(ray.direction, corners_of(certain));
            crossings.push(SignedCrossing { face: certain.face, sign });
        }
        for hit in &self.hits {
            let corners = mesh_corners(hit.face);
            let sign = facing_sign(ray.direction, corners);
            if hit.t == 0.0 {
                // A t that is no more than half of the smallest double rounds to zero, from both sides.
                let side = plane_side(ray.origin, corners);
                if side == sign {
                    continue;
                }
                is_on_surface |= side == 0;
            }
            crossings.push(SignedCrossing { face: hit.face, sign });
        }
        for touch in &self.touches {
            is_on_surface |=
                touch.t == 0.0 && plane_side(ray.origin, mesh_corners(touch.face)) == 0;
        }
        if crossings.len() > 1 {
            // Faces that lie in several leaves are there as often.
            crossings.sort_unstable();
            crossings.dedup();
        }
        is_on_surface
    }
}

impl Cast<'_> {
    /// Puts what the crossings of a ray amount to, once its walk is over.
    #[inline(never)]
    pub(super) fn put_crossing_sum(&mut self, number: usize, contacts: &AllContacts) {
        let ray = self.source.ray(number);
        let mut crossings = self.answers.take_crossings();
        let target = self.target;
        let is_on_surface = contacts.signed_crossings(
            &ray,
            |certain| self.corners_at(certain.slot),
            |face| target.mesh.corners(face),
            &mut crossings,
        );
        let signed = crossings.iter().map(|crossing| i32::from(crossing.sign)).sum();
        let sum = CrossingSum { signed, count: crossings.len() as u32, is_on_surface };
        self.answers.put_crossing_sum(number, sum, crossings);
    }
}
