//! The questions that one walk through the tree answers.

use crate::geometry::Hit;
use crate::numeric::is_nearer;

/// What a walk does with the contacts that it finds.
pub trait Query {
    /// Takes a contact; `is_crossing` as in [`Contact`](crate::numeric::Contact).
    fn offer(&mut self, hit: Hit, is_crossing: bool);

    /// The largest t that still matters, given the ray's own.
    fn t_max(&self, ray_t_max: f64) -> f64;

    /// True once nothing more can matter.
    fn is_done(&self) -> bool;
}

/// The contact with the smallest t; of equal ones that with the lowest face index.
pub struct ClosestHit(
    /// The best so far.
    pub Hit,
);

impl Query for ClosestHit {
    #[inline]
    fn offer(&mut self, hit: Hit, _is_crossing: bool) {
        if is_nearer(&hit, &self.0) {
            self.0 = hit;
        }
    }

    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        if self.0.is_hit() { self.0.t } else { ray_t_max }
    }

    #[inline]
    fn is_done(&self) -> bool {
        false
    }
}

/// Whether there is any contact.
pub struct AnyHit(
    /// True once one was found.
    pub bool,
);

impl Query for AnyHit {
    #[inline]
    fn offer(&mut self, _hit: Hit, _is_crossing: bool) {
        self.0 = true;
    }

    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        ray_t_max
    }

    #[inline]
    fn is_done(&self) -> bool {
        self.0
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
    fn offer(&mut self, hit: Hit, is_crossing: bool) {
        if is_crossing {
            self.hits.push(hit);
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
