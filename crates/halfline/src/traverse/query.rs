//! The questions that one walk through the tree answers.

use super::around_point::triangles_at;
use crate::geometry::{Hit, NO_FACE, SingleHit, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{Bounds, Meeting, PreparedRay, TakeMeeting, Touch, complete_hits};
use crate::tree::KdTree;

/// What a walk looks for, as far as the walk must know.
pub trait Search {
    /// The largest t that still matters, given the ray's own.
    fn t_max(&self, ray_t_max: f64) -> f64;

    /// True once nothing more can matter.
    fn is_done(&self) -> bool;
}

/// How far single precision answers a question, where it is certain that a triangle is hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shortcut {
    /// One such triangle is the answer.
    Any,
    /// Such a triangle, if it is also the nearest for certain, is the answer.
    Nearest,
    /// Each such triangle is crossed, and part of the answer.
    Each,
}

/// A search among exact meetings.
pub trait Query: Search + TakeMeeting {
    /// What it takes from single precision.
    const SHORTCUT: Shortcut;

    /// Forgets the last ray.
    fn restart(&mut self);

    /// This face is known to be hit, and to be the answer.
    fn settle(&mut self, _face: u32, _corners: [Vec3; 3]) {}

    /// For [`Shortcut::Each`]: what was found so far.
    fn contacts(&mut self) -> Option<&mut AllContacts> {
        None
    }

    /// For [`Shortcut::Nearest`]: the face of the nearest hit, and bounds of its t.
    fn nearest(&self) -> (u32, Bounds) {
        (NO_FACE, Bounds::UNKNOWN)
    }
}

/// The contact with the smallest t; of equal ones that with the lowest face index.
///
/// Bounds of t tell most contacts apart, so as long as they do no t is computed.
pub struct ClosestHit {
    nearest: Bounds,
    face: u32,
    corners: [Vec3; 3],
}

impl ClosestHit {
    /// The hit, once the walk is over.
    #[inline]
    pub fn finish(&self, ray: &PreparedRay) -> Hit {
        if self.is_hit() { ray.hit(self.face, self.corners) } else { Hit::MISS }
    }

    /// The same in single precision: bounds that round to the same number are enough.
    #[inline]
    pub fn finish_single(&self, ray: &PreparedRay) -> SingleHit {
        if !self.is_hit() {
            return SingleHit::MISS;
        }
        let Bounds { low, high } = self.nearest;
        let t = if low as f32 == high as f32 { low } else { ray.parameter(&self.corners) };
        // A zero below one half of the smallest denormal would keep its sign.
        SingleHit { t: t as f32 + 0.0, face: self.face }
    }

    fn is_hit(&self) -> bool {
        self.face != NO_FACE
    }

    /// Takes a contact whose bounds overlap those of the nearest, or whose range is open.
    #[cold]
    fn offer_exactly(&mut self, ray: &PreparedRay, meeting: &Meeting, face: u32) {
        let t = ray.parameter(&meeting.corners);
        if !ray.is_in_range(t) {
            return;
        }
        if self.nearest.low < self.nearest.high {
            self.nearest = Bounds::exactly(ray.parameter(&self.corners));
        }
        let nearest = self.nearest.low;
        if t < nearest || (t == nearest && face < self.face) {
            *self = ClosestHit { nearest: Bounds::exactly(t), face, corners: meeting.corners };
        }
    }
}

impl Default for ClosestHit {
    fn default() -> ClosestHit {
        let nearest = Bounds::exactly(f64::INFINITY);
        ClosestHit { nearest, face: NO_FACE, corners: [Vec3::ZERO; 3] }
    }
}

impl Search for ClosestHit {
    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        if self.is_hit() { self.nearest.high } else { ray_t_max }
    }

    #[inline]
    fn is_done(&self) -> bool {
        false
    }
}

impl Query for ClosestHit {
    const SHORTCUT: Shortcut = Shortcut::Nearest;

    #[inline]
    fn restart(&mut self) {
        self.nearest = Bounds::exactly(f64::INFINITY);
        self.face = NO_FACE;
    }

    #[inline]
    fn settle(&mut self, face: u32, corners: [Vec3; 3]) {
        *self = ClosestHit { nearest: Bounds::UNKNOWN, face, corners };
    }

    #[inline]
    fn nearest(&self) -> (u32, Bounds) {
        (self.face, self.nearest)
    }
}

impl TakeMeeting for ClosestHit {
    #[inline(always)]
    fn take(&mut self, ray: &PreparedRay, meeting: &Meeting, face: u32) {
        let bounds = meeting.bounds(ray);
        let is_in_range = ray.are_in_range(bounds);
        if is_in_range == Some(false) || bounds.low > self.nearest.high || face == self.face {
            return;
        }
        if is_in_range == Some(true) && bounds.high < self.nearest.low {
            self.nearest = bounds;
            self.face = face;
            self.corners = meeting.corners;
            return;
        }
        self.offer_exactly(ray, meeting, face);
    }
}

/// Whether there is any contact.
#[derive(Default)]
pub struct AnyHit {
    /// True once one was found.
    pub found: bool,
}

impl Search for AnyHit {
    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        ray_t_max
    }

    #[inline]
    fn is_done(&self) -> bool {
        self.found
    }
}

impl Query for AnyHit {
    const SHORTCUT: Shortcut = Shortcut::Any;

    #[inline]
    fn restart(&mut self) {
        self.found = false;
    }

    #[inline]
    fn settle(&mut self, _face: u32, _corners: [Vec3; 3]) {
        self.found = true;
    }
}

impl TakeMeeting for AnyHit {
    #[inline(always)]
    fn take(&mut self, ray: &PreparedRay, meeting: &Meeting, _face: u32) {
        self.found |= match ray.are_in_range(meeting.bounds(ray)) {
            Some(answer) => answer,
            None => ray.is_in_range(ray.parameter(&meeting.corners)),
        };
    }
}

/// All hits, each face once.
#[derive(Default)]
pub struct AllContacts {
    /// Crossings by faces that single precision is certain of, and where the faces are. A face that lies
    /// in several leaves is there as often.
    pub certain: Vec<CertainCrossing>,
    /// The other crossings.
    pub hits: Vec<Hit>,
    /// The contacts that are no crossings, which are few.
    pub touches: Vec<Touch>,
}

/// A face that a ray crosses, in the inside and within the ray's range.
#[derive(Clone, Copy)]
pub struct CertainCrossing {
    /// The face.
    pub face: u32,
    /// In which block and lane it was found.
    pub place: (u32, u32),
}

impl AllContacts {
    /// True if nothing was met.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.certain.is_empty() && self.hits.is_empty() && self.touches.is_empty()
    }

    /// How many faces are crossed, if there are no touches.
    pub fn count_crossings(&mut self, faces: &mut Vec<u32>) -> usize {
        faces.clear();
        faces.extend(self.certain.iter().map(|certain| certain.face));
        faces.extend(self.hits.iter().map(|hit| hit.face));
        faces.sort_unstable();
        faces.dedup();
        faces.len()
    }

    /// The hits, sorted by t and then by face, once the walk is over and nothing is merely certain.
    pub fn finish(&mut self, ray: &PreparedRay, tree: &KdTree, mesh: &Mesh) -> &[Hit] {
        complete_hits(
            ray,
            &mut self.hits,
            0,
            &mut self.touches,
            |face| mesh.corners(face),
            |point| triangles_at(tree, mesh, point),
        );
        &self.hits
    }
}

impl Search for AllContacts {
    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        ray_t_max
    }

    #[inline]
    fn is_done(&self) -> bool {
        false
    }
}

impl Query for AllContacts {
    const SHORTCUT: Shortcut = Shortcut::Each;

    #[inline]
    fn restart(&mut self) {
        self.certain.clear();
        self.hits.clear();
        self.touches.clear();
    }

    #[inline(always)]
    fn contacts(&mut self) -> Option<&mut AllContacts> {
        Some(self)
    }
}

impl TakeMeeting for AllContacts {
    #[inline]
    fn take(&mut self, ray: &PreparedRay, meeting: &Meeting, face: u32) {
        if ray.are_in_range(meeting.bounds(ray)) == Some(false) {
            return;
        }
        let hit = ray.hit(face, meeting.corners);
        if !ray.is_in_range(hit.t) {
            return;
        }
        if meeting.is_crossing(ray) {
            self.hits.push(hit);
        } else {
            self.touches.push(Touch { t: hit.t, face, touched: meeting.touched() });
        }
    }
}
