//! All hits of the rays of a batch, and their number.
//!
//! Most hits are crossings of which single precision is certain, and come with t and weights found eight
//! at a time (`traverse/leaf/resolve.rs`), in any order. Where only their number is asked for, no t is found at
//! all, but for rays that touch an edge or a vertex: what counts there depends on what is crossed at the same t.

use std::cmp::Ordering;

use rayon::prelude::*;

use super::{CHUNK, PLACES, Rays, chunk_len, in_chunks};
use crate::error::Result;
use crate::geometry::Hit;
use crate::progress::Observer;
use crate::rays::RaySource;
use crate::traverse::{
    AllContacts, Answers, CancelCheck, Cast, FoundHits, HitColumns, HitCounts, Target, cast,
};

/// All hits of each ray of a batch, in compressed sparse rows: those of ray i are [`row(i)`](AllHits::row),
/// which is `hits[splits[i]..splits[i + 1]]`, sorted by t and then by face.
///
/// ```
/// use halfline::{Mesh, Ray, Scene, vec3};
///
/// // Two squares, one above the other, as four triangles.
/// let square = |z| [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
/// let corners = [square(0.0), square(1.0)].concat();
/// let scene = Scene::new(Mesh::new(corners, [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])?)?;
///
/// let down = vec3(0.0, 0.0, -1.0);
/// let rays = [Ray::new(vec3(0.75, 0.25, 3.0), down), Ray::new(vec3(5.0, 5.0, 3.0), down)];
/// let all = scene.intersect_all(&rays);
/// assert_eq!(all.len(), rays.len());
/// assert_eq!(all.row(0).iter().map(|hit| hit.t).collect::<Vec<_>>(), [2.0, 3.0]);
/// for (ray, hits) in rays.iter().zip(&all) {
///     assert!(hits.iter().all(|hit| ray.at(hit.t).z == scene.mesh().corners(hit.face)[0].z));
/// }
/// # Ok::<(), halfline::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AllHits {
    /// Where the hits of each ray begin, and after the last where they end: one more entry than there are rays.
    pub splits: Vec<usize>,
    /// The hits of all rays, one ray's after the other's.
    pub hits: Vec<Hit>,
}

impl AllHits {
    /// How many rays there are.
    pub fn len(&self) -> usize {
        self.splits.len() - 1
    }

    /// True if there are no rays. Rays without hits are rays too.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The hits of one ray, sorted by t and then by face.
    ///
    /// # Panics
    /// If there is no ray of this number.
    pub fn row(&self, ray: usize) -> &[Hit] {
        &self.hits[self.splits[ray]..self.splits[ray + 1]]
    }

    /// The hits of each ray, in the rays' order.
    pub fn iter(&self) -> AllHitsIter<'_> {
        AllHitsIter { splits: self.splits.windows(2), hits: &self.hits }
    }

    /// Takes the hits of one more ray, sorted by t and then by face.
    pub fn push_row(&mut self, hits: impl IntoIterator<Item = Hit>) {
        self.hits.extend(hits);
        self.splits.push(self.hits.len());
    }
}

/// The hits of no rays.
impl Default for AllHits {
    fn default() -> AllHits {
        AllHits { splits: vec![0], hits: Vec::new() }
    }
}

impl<'a> IntoIterator for &'a AllHits {
    type Item = &'a [Hit];
    type IntoIter = AllHitsIter<'a>;

    fn into_iter(self) -> AllHitsIter<'a> {
        self.iter()
    }
}

/// The hits of each ray of a batch, in the rays' order: [`AllHits::iter`] gives it.
#[derive(Clone, Debug)]
pub struct AllHitsIter<'a> {
    splits: std::slice::Windows<'a, usize>,
    hits: &'a [Hit],
}

impl<'a> Iterator for AllHitsIter<'a> {
    type Item = &'a [Hit];

    fn next(&mut self) -> Option<&'a [Hit]> {
        let split = self.splits.next()?;
        Some(&self.hits[split[0]..split[1]])
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.splits.size_hint()
    }
}

impl ExactSizeIterator for AllHitsIter<'_> {}

/// All hits of each ray, in compressed sparse rows: those of ray i are `splits[i]..splits[i + 1]` of the
/// other columns, sorted by t and then by face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllHitColumns {
    /// Where the hits of each ray begin, and after the last where they end: one more entry than there are rays.
    pub splits: Vec<i64>,
    /// Ray parameters of the hits.
    pub t: Vec<f64>,
    /// Indices of triangles.
    pub face: Vec<i64>,
    /// Barycentric weights of the triangles' second and third vertices.
    pub uv: Vec<[f64; 2]>,
}

/// All hits of a chunk of rays, cast on this thread: how many each ray has, and the hits, by ray and
/// then along it. Fewer if the observer wants the end.
fn all_hits_of(target: Target, rays: RaySource, observer: &dyn Observer) -> (Vec<usize>, Vec<Hit>) {
    let found = FoundHits { hits: Vec::new(), cancel: CancelCheck::new(observer) };
    let batch = cast::<AllContacts>(Cast::new(target, rays, Answers::AllHits(found)));
    let Answers::AllHits(FoundHits { hits: found, .. }) = batch.answers else {
        unreachable!("a batch keeps its answers")
    };

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

/// All hits of each ray.
pub fn find_all_hits(
    target: Target,
    Rays(source): Rays,
    observer: &dyn Observer,
) -> Result<AllHits> {
    let parts = vec![(); source.len().div_ceil(CHUNK)];
    let chunks = in_chunks(target, (source, CHUNK), parts, observer, |target, rays, ()| {
        all_hits_of(target, rays, observer)
    })?;
    let mut all = AllHits::default();
    all.splits.reserve_exact(source.len());
    all.hits.reserve_exact(chunks.iter().map(|(_, hits)| hits.len()).sum());
    for (counts, hits) in chunks {
        let mut end = all.hits.len();
        for count in counts {
            end += count;
            all.splits.push(end);
        }
        all.hits.extend_from_slice(&hits);
    }
    Ok(all)
}

/// How many hits each ray has, put into the same place of `counts`.
pub fn count_hits<C: TryFrom<usize> + Copy + Send>(
    target: Target,
    Rays(source): Rays,
    counts: &mut [C],
    observer: &dyn Observer,
) -> Result<()> {
    assert_eq!(counts.len(), source.len(), "{PLACES}");
    let chunk = chunk_len(&source);
    let parts = counts.chunks_mut(chunk).collect();
    in_chunks(target, (source, chunk), parts, observer, |target, rays, places: &mut [C]| {
        let mut counts = vec![0; rays.len()];
        let cancel = CancelCheck::new(observer);
        let answers = Answers::Counts(HitCounts { counts: &mut counts, faces: Vec::new(), cancel });
        cast::<AllContacts>(Cast::new(target, rays, answers));
        for (place, count) in places.iter_mut().zip(counts) {
            *place = C::try_from(count).unwrap_or_else(|_| unreachable!("no more hits than faces"));
        }
    })?;
    Ok(())
}

/// All hits of each ray, as columns.
pub fn find_all_hits_columns(
    target: Target,
    Rays(source): Rays,
    observer: &dyn Observer,
) -> Result<AllHitColumns> {
    let count = source.len();
    let parts = vec![(); count.div_ceil(CHUNK)];
    let chunks = in_chunks(target, (source, CHUNK), parts, observer, |target, rays, ()| {
        all_hits_of(target, rays, observer)
    })?;

    // Chunk by chunk to the places that follow from how many hits the earlier ones have.
    let total = chunks.iter().map(|(_, hits)| hits.len()).sum();
    let mut all = AllHitColumns {
        splits: vec![0; count + 1],
        t: vec![0.0; total],
        face: vec![0; total],
        uv: vec![[0.0; 2]; total],
    };
    let (mut t, mut face, mut uv) = (&mut all.t[..], &mut all.face[..], &mut all.uv[..]);
    let mut before = 0;
    let mut parts = Vec::with_capacity(chunks.len());
    for (chunk, splits) in chunks.into_iter().zip(all.splits[1..].chunks_mut(CHUNK)) {
        let length = chunk.1.len();
        let columns = (
            t.split_off_mut(..length).expect("a place for each hit"),
            face.split_off_mut(..length).expect("a place for each hit"),
            uv.split_off_mut(..length).expect("a place for each hit"),
        );
        parts.push((chunk, splits, before, columns));
        before += length;
    }
    let put = |((counts, hits), splits, before, (t, face, uv)): Part| {
        let mut end = before;
        for (hits_of_ray, split) in counts.into_iter().zip(splits) {
            end += hits_of_ray;
            *split = end as i64;
        }
        let mut columns = HitColumns { t, face, uv };
        hits.iter().enumerate().for_each(|(number, hit)| columns.put(number, hit));
    };
    if parts.len() <= 1 {
        parts.into_iter().for_each(put);
    } else {
        parts.into_par_iter().for_each(put);
    }
    Ok(all)
}

/// What a chunk's rays hit, and where it goes: splits, the hits of earlier chunks, and t, face and uv.
type Part<'a> = (
    (Vec<usize>, Vec<Hit>),
    &'a mut [i64],
    usize,
    (&'a mut [f64], &'a mut [i64], &'a mut [[f64; 2]]),
);
