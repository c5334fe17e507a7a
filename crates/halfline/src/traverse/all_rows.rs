//! Chunks of rays of which all hits are asked for.
//!
//! Most hits are crossings of which single precision is certain, and come with t and weights found eight
//! at a time (`cast/pairs.rs`), in any order. Where only their number is asked for, no t is found at all,
//! but for rays that touch an edge or a vertex: what counts there depends on what is crossed at the same t.

use std::cmp::Ordering;
use std::ops::Range;

use super::batch::Target;
use super::cast::{Batch, Cast, Ending};
use super::query::AllContacts;
use super::ray_group::{RayLanes, RayRows};
use crate::geometry::{Hit, Ray};
use crate::numeric::PreparedRay;
use crate::progress::Observer;
use crate::simd::{LANES, Simd};

/// Hits that are found between two looks at the observer: a ray may have as many as there are triangles.
const CHECKED: usize = 1 << 12;

/// Whether the work should end. A chunk then begins no more rays.
struct Patience<'a> {
    observer: &'a dyn Observer,
    hits: usize,
    is_over: bool,
}

impl<'a> Patience<'a> {
    fn new(observer: &'a dyn Observer) -> Patience<'a> {
        Patience { observer, hits: 0, is_over: false }
    }

    #[inline(always)]
    fn take(&mut self, hits: usize) {
        self.hits += hits;
        if self.hits > CHECKED {
            self.hits = 0;
            self.is_over = self.observer.cancelled();
        }
    }
}

/// Rays and all their hits, in the order in which they are found.
struct AllRows<'a, R> {
    target: Target<'a>,
    rays: &'a [R],
    found: Vec<(u32, Hit)>,
    patience: Patience<'a>,
}

impl<R: RayRows> Batch for AllRows<'_, R> {
    type Query = AllContacts;
    const ENDING: Ending = Ending::Double;

    #[inline(always)]
    fn count(&self) -> usize {
        if self.patience.is_over { 0 } else { self.rays.len() }
    }

    #[inline(always)]
    fn ray(&self, number: usize) -> Ray {
        self.rays[number].into()
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, numbers: Range<usize>) -> RayLanes<S> {
        R::lanes(simd, &self.rays[numbers])
    }

    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, numbers: &[usize; LANES]) -> RayLanes<S> {
        R::gather(simd, self.rays, numbers)
    }

    #[inline(always)]
    fn finish_double(&mut self, number: usize, hit: Hit) {
        self.patience.take(1);
        self.found.push((number as u32, hit));
    }

    #[inline(always)]
    fn finish(&mut self, number: usize, ray: &PreparedRay, query: &mut AllContacts) {
        let hits = query.finish(ray, self.target.tree, self.target.mesh);
        self.patience.take(hits.len());
        self.found.extend(hits.iter().map(|hit| (number as u32, *hit)));
    }
}

/// All hits of a chunk of rays, cast on this thread: how many each ray has, and the hits, by ray and
/// then along it. Fewer if the observer wants the end.
pub fn all_hits_of<R: RayRows>(
    target: Target,
    rays: &[R],
    observer: &dyn Observer,
) -> (Vec<usize>, Vec<Hit>) {
    let Target { tree, mesh, level } = target;
    let patience = Patience::new(observer);
    let batch = AllRows { target, rays, found: Vec::new(), patience };
    let found = level.run(Cast::new(tree, mesh, batch)).0.found;

    // Bring them to their rays.
    let mut ends = vec![0; rays.len() + 1];
    for (number, _) in &found {
        ends[*number as usize + 1] += 1;
    }
    for number in 0..rays.len() {
        ends[number + 1] += ends[number];
    }
    let mut next = ends.clone();
    let mut hits = vec![Hit::MISS; found.len()];
    for (number, hit) in found {
        let place = &mut next[number as usize];
        hits[*place] = hit;
        *place += 1;
    }

    // Sort those of each ray, and drop the repeats of faces that lie in several leaves: they have the
    // same t, and so are neighbours.
    let (mut counts, mut kept) = (vec![0; rays.len()], 0);
    for number in 0..rays.len() {
        let (begin, first) = (ends[number], kept);
        let row = begin..ends[number + 1];
        hits[row.clone()].sort_unstable_by(along);
        for i in row {
            if kept == first || hits[kept - 1].face != hits[i].face {
                hits[kept] = hits[i];
                kept += 1;
            }
        }
        counts[number] = kept - first;
    }
    hits.truncate(kept);
    (counts, hits)
}

/// By t, and then by face.
fn along(a: &Hit, b: &Hit) -> Ordering {
    a.t.total_cmp(&b.t).then(a.face.cmp(&b.face))
}

/// Rays and the places for how many hits they have.
struct CountRows<'a, R> {
    target: Target<'a>,
    rays: &'a [R],
    counts: &'a mut [usize],
    faces: Vec<u32>,
    patience: Patience<'a>,
}

impl<R: RayRows> Batch for CountRows<'_, R> {
    type Query = AllContacts;
    const ENDING: Ending = Ending::None;

    #[inline(always)]
    fn count(&self) -> usize {
        if self.patience.is_over { 0 } else { self.rays.len() }
    }

    #[inline(always)]
    fn ray(&self, number: usize) -> Ray {
        self.rays[number].into()
    }

    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, numbers: Range<usize>) -> RayLanes<S> {
        R::lanes(simd, &self.rays[numbers])
    }

    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, numbers: &[usize; LANES]) -> RayLanes<S> {
        R::gather(simd, self.rays, numbers)
    }

    #[inline(always)]
    fn finish_count(&mut self, number: usize, contacts: &mut AllContacts) {
        let count = contacts.count_crossings(&mut self.faces);
        self.patience.take(count);
        self.counts[number] = count;
    }

    #[inline(always)]
    fn finish(&mut self, number: usize, ray: &PreparedRay, query: &mut AllContacts) {
        let hits = query.finish(ray, self.target.tree, self.target.mesh);
        self.patience.take(hits.len());
        self.counts[number] = hits.len();
    }
}

/// Counts the hits of each of a chunk of rays, on this thread.
pub fn count_hits_of<R: RayRows>(
    target: Target,
    rays: &[R],
    counts: &mut [usize],
    observer: &dyn Observer,
) {
    let Target { tree, mesh, level } = target;
    counts.fill(0);
    let patience = Patience::new(observer);
    let batch = CountRows { target, rays, counts, faces: Vec::new(), patience };
    level.run(Cast::new(tree, mesh, batch));
}
