//! Where the answers of a batch go.
//!
//! Answers are put eight at a time or one by one, whatever their form; what is put that was not asked for is a
//! mistake in the program, and never a miss. Rays of which nothing is put are misses, as which the places were
//! filled before.

use crate::geometry::{Hit, HitF32};
use crate::progress::Observer;

use super::crossing_sum::{CrossingSum, SignedCrossing};
use super::query::AllContacts;

/// Places for answers, by the number of the ray.
pub enum Answers<'a> {
    /// The closest hits.
    Hits(&'a mut [Hit]),
    /// The closest hits in single precision.
    HitsF32(&'a mut [HitF32]),
    /// The closest hits as columns.
    HitColumns(HitColumns<'a>),
    /// Whether there is any hit.
    Occluded(&'a mut [bool]),
    /// All hits.
    AllHits(FoundHits<'a>),
    /// How many hits there are.
    Counts(HitCounts<'a>),
    /// What crossings amount to.
    Crossings(CrossingSums<'a>),
}

/// Where the closest hits go, an entry of each for each ray: what the fields of [`Hit`] mean, but that
/// the face of a miss is -1.
#[derive(Debug)]
pub struct HitColumns<'a> {
    /// Ray parameters; infinite for a miss.
    pub t: &'a mut [f64],
    /// Indices of triangles.
    pub face: &'a mut [i64],
    /// Barycentric weights of the triangles' second and third vertices; zero for a miss.
    pub uv: &'a mut [[f64; 2]],
}

/// All hits, each with the number of its ray, in the order in which they are found.
pub struct FoundHits<'a> {
    /// The hits.
    pub hits: Vec<(u32, Hit)>,
    /// Whether they are still wanted.
    pub cancel: CancelCheck<'a>,
}

/// How many hits each ray has.
pub struct HitCounts<'a> {
    /// By ray.
    pub counts: &'a mut [usize],
    /// Room to sort the faces of one ray.
    pub faces: Vec<u32>,
    /// Whether they are still wanted.
    pub cancel: CancelCheck<'a>,
}

/// What the crossings of each ray amount to.
pub struct CrossingSums<'a> {
    /// By ray.
    pub sums: &'a mut [CrossingSum],
    /// Room for the crossings of one ray.
    pub crossings: Vec<SignedCrossing>,
    /// Whether they are still wanted.
    pub cancel: CancelCheck<'a>,
}

/// Whether the observer wants the end; then a batch begins no more rays. A ray may have as many hits as there
/// are triangles, so this is asked as hits are found.
pub struct CancelCheck<'a> {
    observer: &'a dyn Observer,
    hits: usize,
    is_cancelled: bool,
}

/// Hits that are found between two looks at the observer.
const HITS_PER_CHECK: usize = 1 << 12;

impl<'a> CancelCheck<'a> {
    /// Nothing is found yet.
    pub fn new(observer: &'a dyn Observer) -> CancelCheck<'a> {
        CancelCheck { observer, hits: 0, is_cancelled: false }
    }

    /// Counts what was found, and may ask.
    #[inline(always)]
    pub fn count(&mut self, hits: usize) {
        self.hits += hits;
        if self.hits > HITS_PER_CHECK {
            self.hits = 0;
            self.is_cancelled = self.observer.cancelled();
        }
    }

    /// True if the observer wanted the end when asked last.
    pub fn is_cancelled(&self) -> bool {
        self.is_cancelled
    }
}

#[cold]
fn not_asked() -> ! {
    unreachable!("an answer of a kind that was not asked for")
}

impl Answers<'_> {
    /// True if the observer wants the end.
    #[inline]
    pub fn are_cancelled(&self) -> bool {
        match self {
            Answers::AllHits(found) => found.cancel.is_cancelled,
            Answers::Counts(counts) => counts.cancel.is_cancelled,
            Answers::Crossings(crossings) => crossings.cancel.is_cancelled,
            _ => false,
        }
    }

    /// True if t is wanted in single precision, and the weights not at all.
    #[inline]
    pub fn are_f32(&self) -> bool {
        matches!(self, Answers::HitsF32(_))
    }

    /// True if only the number of hits is wanted.
    #[inline]
    pub fn are_counts(&self) -> bool {
        matches!(self, Answers::Counts(_))
    }

    /// True if only what crossings amount to is wanted.
    #[inline]
    pub fn are_crossings(&self) -> bool {
        matches!(self, Answers::Crossings(_))
    }

    /// Room for the crossings of one ray, to be given back.
    pub fn take_crossings(&mut self) -> Vec<SignedCrossing> {
        match self {
            Answers::Crossings(places) => std::mem::take(&mut places.crossings),
            _ => not_asked(),
        }
    }

    /// Puts what the crossings of a ray amount to, and gives their room back.
    pub fn put_crossing_sum(&mut self, number: usize, sum: CrossingSum, room: Vec<SignedCrossing>) {
        match self {
            Answers::Crossings(places) => {
                places.cancel.count(room.len());
                places.sums[number] = sum;
                places.crossings = room;
            }
            _ => not_asked(),
        }
    }

    /// Puts the closest hit of a ray, or one of all.
    #[inline]
    pub fn put_hit(&mut self, number: usize, hit: Hit) {
        match self {
            Answers::Hits(hits) => hits[number] = hit,
            Answers::HitColumns(columns) => columns.put(number, &hit),
            Answers::AllHits(found) => {
                found.cancel.count(1);
                found.hits.push((number as u32, hit));
            }
            _ => not_asked(),
        }
    }

    /// Puts the closest hit of a ray in single precision.
    #[inline]
    pub fn put_hit_f32(&mut self, number: usize, hit: HitF32) {
        match self {
            Answers::HitsF32(hits) => hits[number] = hit,
            _ => not_asked(),
        }
    }

    /// Puts that there is a hit.
    #[inline]
    pub fn put_occluded(&mut self, number: usize) {
        match self {
            Answers::Occluded(flags) => flags[number] = true,
            _ => not_asked(),
        }
    }

    /// Puts all hits of a ray, or their number.
    pub fn put_all(&mut self, number: usize, hits: &[Hit]) {
        match self {
            Answers::AllHits(found) => {
                found.cancel.count(hits.len());
                found.hits.extend(hits.iter().map(|hit| (number as u32, *hit)));
            }
            Answers::Counts(counts) => {
                counts.cancel.count(hits.len());
                counts.counts[number] = hits.len();
            }
            _ => not_asked(),
        }
    }

    /// Puts the number of faces that a ray crosses, if it touches none without crossing it.
    pub fn put_crossings(&mut self, number: usize, contacts: &mut AllContacts) {
        match self {
            Answers::Counts(counts) => {
                let count = contacts.count_crossings(&mut counts.faces);
                counts.cancel.count(count);
                counts.counts[number] = count;
            }
            _ => not_asked(),
        }
    }
}

impl HitColumns<'_> {
    /// Puts the hit of a ray, or its miss.
    #[inline]
    pub fn put(&mut self, number: usize, hit: &Hit) {
        self.t[number] = hit.t;
        self.face[number] = if hit.is_hit() { hit.face.into() } else { -1 };
        self.uv[number] = [hit.u, hit.v];
    }

    /// Makes misses of all.
    pub fn fill_with_misses(&mut self) {
        self.t.fill(f64::INFINITY);
        self.face.fill(-1);
        self.uv.fill([0.0; 2]);
    }
}
