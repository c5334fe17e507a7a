//! The questions that a walk through the tree answers: closest hit, any hit, all hits.
//!
//! One traversal body serves all three, compiled for each.

use super::Target;
use super::answers::Answers;
use super::point::triangles_at;
use crate::geometry::{Hit, HitF32, NO_FACE, Vec3};
use crate::numeric::{
    Interval, LineIntersection, PreparedRay, TakeIntersection, Touch, complete_hits,
};

/// What is asked about a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueryKind {
    /// Whether there is any hit: one triangle that is hit for certain is the answer.
    Any,
    /// The closest hit: a triangle that is hit for certain, and is the nearest for certain, is the answer.
    Closest,
    /// All hits: each triangle that is hit for certain is crossed, and part of the answer.
    All,
}

/// Where a triangle lies in the tree: the index of its leaf's block, and its lane there.
pub type Slot = (u32, u32);

/// A question about one ray, and what is known of the answer so far.
pub trait Query: Default + TakeIntersection {
    /// What is asked.
    const KIND: QueryKind;

    /// False if rounded signs and depths are taken as they come, to measure what exactness costs.
    const EXACT: bool;

    /// Forgets the last ray.
    fn restart(&mut self);

    /// True once nothing more can matter.
    fn is_done(&self) -> bool;

    /// The largest t that still matters, given the ray's own.
    fn t_max(&self, ray_t_max: f64) -> f64;

    /// The face of the nearest hit, or [`NO_FACE`], and bounds of its t. Only the closest hit has one.
    fn nearest(&self) -> (u32, Interval);

    /// Takes a face that is hit for certain, in the inside and within the ray's range, where no t is needed.
    fn accept(&mut self, face: u32, slot: Slot);

    /// What was found so far, where all hits are asked for.
    fn contacts(&mut self) -> Option<&mut AllContacts>;

    /// Puts the answer where it belongs, once the walk is over and nothing is merely certain.
    fn answer(&mut self, number: usize, ray: &PreparedRay, target: Target, answers: &mut Answers);
}

/// The contact with the smallest t; of equal ones that with the lowest face index.
///
/// Bounds of t tell most contacts apart, so as long as they do no t is computed.
pub struct ClosestHit<const EXACT: bool = true> {
    nearest: Interval,
    face: u32,
    corners: [Vec3; 3],
}

impl<const EXACT: bool> ClosestHit<EXACT> {
    /// The hit, once the walk is over.
    #[inline]
    pub fn finish(&self, ray: &PreparedRay) -> Hit {
        if self.is_hit() { ray.hit(self.face, self.corners) } else { Hit::MISS }
    }

    /// The hit in single precision, for which bounds of t that round to the same number are enough.
    #[inline]
    pub fn finish_f32(&self, ray: &PreparedRay) -> HitF32 {
        if !self.is_hit() {
            return HitF32::MISS;
        }
        let Interval { low, high } = self.nearest;
        let t = if low as f32 == high as f32 { low } else { ray.parameter(&self.corners) };
        // A zero below one half of the smallest denormal would keep its sign.
        HitF32 { t: t as f32 + 0.0, face: self.face }
    }

    fn is_hit(&self) -> bool {
        self.face != NO_FACE
    }

    /// Takes a contact whose bounds overlap those of the nearest, or whose range is open.
    #[cold]
    fn offer_exactly(&mut self, ray: &PreparedRay, meeting: &LineIntersection, face: u32) {
        let t = ray.parameter(&meeting.corners);
        if !ray.is_in_range(t) {
            return;
        }
        if self.nearest.low < self.nearest.high {
            self.nearest = Interval::exactly(ray.parameter(&self.corners));
        }
        let nearest = self.nearest.low;
        if t < nearest || (t == nearest && face < self.face) {
            *self = ClosestHit { nearest: Interval::exactly(t), face, corners: meeting.corners };
        }
    }
}

impl<const EXACT: bool> Default for ClosestHit<EXACT> {
    fn default() -> Self {
        let nearest = Interval::exactly(f64::INFINITY);
        ClosestHit { nearest, face: NO_FACE, corners: [Vec3::ZERO; 3] }
    }
}

impl<const EXACT: bool> Query for ClosestHit<EXACT> {
    const KIND: QueryKind = QueryKind::Closest;
    const EXACT: bool = EXACT;

    #[inline]
    fn restart(&mut self) {
        self.nearest = Interval::exactly(f64::INFINITY);
        self.face = NO_FACE;
    }

    #[inline]
    fn is_done(&self) -> bool {
        false
    }

    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        if self.is_hit() { self.nearest.high } else { ray_t_max }
    }

    #[inline]
    fn nearest(&self) -> (u32, Interval) {
        (self.face, self.nearest)
    }

    fn accept(&mut self, _face: u32, _slot: Slot) {
        unreachable!("a closest hit needs bounds of t")
    }

    fn contacts(&mut self) -> Option<&mut AllContacts> {
        None
    }

    fn answer(&mut self, number: usize, ray: &PreparedRay, _target: Target, answers: &mut Answers) {
        if answers.are_f32() {
            answers.put_hit_f32(number, self.finish_f32(ray));
        } else {
            answers.put_hit(number, self.finish(ray));
        }
    }
}

impl<const EXACT: bool> TakeIntersection for ClosestHit<EXACT> {
    #[inline(always)]
    fn take(&mut self, ray: &PreparedRay, meeting: &LineIntersection, face: u32) {
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
pub struct AnyHit<const EXACT: bool = true> {
    /// True once one was found.
    pub found: bool,
}

impl<const EXACT: bool> Query for AnyHit<EXACT> {
    const KIND: QueryKind = QueryKind::Any;
    const EXACT: bool = EXACT;

    #[inline]
    fn restart(&mut self) {
        self.found = false;
    }

    #[inline]
    fn is_done(&self) -> bool {
        self.found
    }

    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        ray_t_max
    }

    #[inline]
    fn nearest(&self) -> (u32, Interval) {
        (NO_FACE, Interval::UNKNOWN)
    }

    #[inline(always)]
    fn accept(&mut self, _face: u32, _slot: Slot) {
        self.found = true;
    }

    fn contacts(&mut self) -> Option<&mut AllContacts> {
        None
    }

    fn answer(
        &mut self,
        number: usize,
        _ray: &PreparedRay,
        _target: Target,
        answers: &mut Answers,
    ) {
        if self.found {
            answers.put_occluded(number);
        }
    }
}

impl<const EXACT: bool> TakeIntersection for AnyHit<EXACT> {
    #[inline(always)]
    fn take(&mut self, ray: &PreparedRay, meeting: &LineIntersection, _face: u32) {
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
    /// Where it was found.
    pub slot: Slot,
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
    pub fn finish(&mut self, ray: &PreparedRay, target: Target) -> &[Hit] {
        let Target { tree, mesh, .. } = target;
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

impl Query for AllContacts {
    const KIND: QueryKind = QueryKind::All;
    const EXACT: bool = true;

    #[inline]
    fn restart(&mut self) {
        self.certain.clear();
        self.hits.clear();
        self.touches.clear();
    }

    #[inline]
    fn is_done(&self) -> bool {
        false
    }

    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        ray_t_max
    }

    #[inline]
    fn nearest(&self) -> (u32, Interval) {
        (NO_FACE, Interval::UNKNOWN)
    }

    #[inline(always)]
    fn accept(&mut self, face: u32, slot: Slot) {
        self.certain.push(CertainCrossing { face, slot });
    }

    #[inline(always)]
    fn contacts(&mut self) -> Option<&mut AllContacts> {
        Some(self)
    }

    fn answer(&mut self, number: usize, ray: &PreparedRay, target: Target, answers: &mut Answers) {
        answers.put_all(number, self.finish(ray, target));
    }
}

impl TakeIntersection for AllContacts {
    #[inline]
    fn take(&mut self, ray: &PreparedRay, meeting: &LineIntersection, face: u32) {
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
