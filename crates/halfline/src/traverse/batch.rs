//! Batches of rays over all threads. The answers do not depend on how many there are.

use std::ops::Range;

use rayon::prelude::*;

use super::all_rows::{all_hits_of, count_hits_of};
use super::cast::{Batch, Cast, Ending};
use super::query::{AnyHit, ClosestHit, Query};
use super::ray_group::{RayLanes, RayRows};
use crate::error::Result;
use crate::geometry::{Hit, Ray, SingleHit, SingleRay};
use crate::mesh::Mesh;
use crate::numeric::PreparedRay;
use crate::progress::{Observer, SharedProgress, Stage};
use crate::simd::{LANES, Level, Simd};
use crate::tree::{KdTree, LeafBlock, WideNode};

/// Rays that one task casts: about a millisecond of work, and many to each slot of the queues.
pub(super) const CHUNK: usize = 1 << 12;

/// All hits of each ray of a batch, in compressed sparse rows: those of ray i are
/// `hits[splits[i]..splits[i + 1]]`, sorted by t and then by face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllHits {
    /// One more entry than there are rays.
    pub splits: Vec<usize>,
    /// The hits.
    pub hits: Vec<Hit>,
}

/// Nothing is done yet of what `observer` hears of.
pub(super) fn start(observer: &dyn Observer, rays: usize) -> SharedProgress<'_> {
    let progress = SharedProgress::new(observer, Stage::Trace, rays);
    observer.report(Stage::Trace, 0, rays as u64);
    progress
}

/// What is asked about each ray, and the form of its answer.
pub(super) trait Question {
    type Query: Query + Default;
    type Answer: Copy + Send;
    const MISS: Self::Answer;

    /// What eight rays at a time can be asked.
    const ENDING: Ending = Ending::None;

    /// The answer of [`Ending::Single`].
    #[inline(always)]
    fn single_answer(_t: f32, _face: u32) -> Self::Answer {
        Self::MISS
    }

    /// The answer of [`Ending::Double`].
    #[inline(always)]
    fn double_answer(_hit: Hit) -> Self::Answer {
        Self::MISS
    }

    /// The answer if there is a hit.
    const FOUND: Self::Answer = Self::MISS;

    /// The answer of a walk that is over.
    fn answer(query: &mut Self::Query, ray: &PreparedRay) -> Self::Answer;
}

/// The closest hit.
pub(super) struct Closest;

impl Question for Closest {
    type Query = ClosestHit;
    type Answer = Hit;
    const MISS: Hit = Hit::MISS;
    const ENDING: Ending = Ending::Double;

    #[inline(always)]
    fn double_answer(hit: Hit) -> Hit {
        hit
    }

    #[inline(always)]
    fn answer(query: &mut ClosestHit, ray: &PreparedRay) -> Hit {
        query.finish(ray)
    }
}

struct ClosestSingle;

impl Question for ClosestSingle {
    type Query = ClosestHit;
    type Answer = SingleHit;
    const MISS: SingleHit = SingleHit::MISS;

    const ENDING: Ending = Ending::Single;

    #[inline(always)]
    fn single_answer(t: f32, face: u32) -> SingleHit {
        SingleHit { t, face }
    }

    #[inline(always)]
    fn answer(query: &mut ClosestHit, ray: &PreparedRay) -> SingleHit {
        query.finish_single(ray)
    }
}

/// Whether there is a hit.
pub(super) struct Any;

impl Question for Any {
    type Query = AnyHit;
    type Answer = bool;
    const MISS: bool = false;
    const FOUND: bool = true;

    #[inline(always)]
    fn answer(query: &mut AnyHit, _ray: &PreparedRay) -> bool {
        query.found
    }
}

/// Rays and the places for their answers.
struct Rows<'a, R, Q: Question> {
    rays: &'a [R],
    answers: &'a mut [Q::Answer],
}

impl<R: RayRows, Q: Question> Batch for Rows<'_, R, Q> {
    type Query = Q::Query;
    const ENDING: Ending = Q::ENDING;

    #[inline(always)]
    fn count(&self) -> usize {
        self.rays.len()
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
    fn finish_single(&mut self, number: usize, t: f32, face: u32) {
        self.answers[number] = Q::single_answer(t, face);
    }

    #[inline(always)]
    fn finish_double(&mut self, number: usize, hit: Hit) {
        self.answers[number] = Q::double_answer(hit);
    }

    #[inline(always)]
    fn finish_found(&mut self, number: usize) {
        self.answers[number] = Q::FOUND;
    }

    #[inline(always)]
    fn finish(&mut self, number: usize, ray: &PreparedRay, query: &mut Q::Query) {
        self.answers[number] = Q::answer(query, ray);
    }
}

/// Casts a chunk of rays on this thread, and puts their answers into the same places of `answers`.
pub(super) fn cast_chunk<R: RayRows, Q: Question>(
    Target { tree, mesh, level }: Target,
    rays: &[R],
    answers: &mut [Q::Answer],
) {
    answers.fill(Q::MISS);
    level.run(Cast::new(tree, mesh, Rows::<R, Q> { rays, answers }));
}

/// Casts each ray and puts its answer into the same place of `answers`.
fn cast_into<R: RayRows + Sync, Q: Question>(
    target: Target,
    rays: &[R],
    answers: &mut [Q::Answer],
    observer: &dyn Observer,
) -> Result<()> {
    assert_eq!(rays.len(), answers.len(), "there is a place for the answer of each ray");
    let progress = start(observer, rays.len());
    answers.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).try_for_each(|(answers, rays)| {
        progress.check()?;
        cast_chunk::<R, Q>(target, rays, answers);
        progress.advance(rays.len())
    })
}

/// Casts each ray and puts its answer into the same place of the result.
fn cast<R: RayRows + Sync, Q: Question>(
    target: Target,
    rays: &[R],
    observer: &dyn Observer,
) -> Result<Vec<Q::Answer>> {
    let mut answers = vec![Q::MISS; rays.len()];
    cast_into::<R, Q>(target, rays, &mut answers, observer)?;
    Ok(answers)
}

/// What casting a batch costs. What it takes together counts once: a node is fetched once for all rays
/// of a bundle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorkCounts {
    /// Rays that were cast.
    pub rays: u64,
    /// Nodes of up to eight children that were fetched.
    pub nodes: u64,
    /// Leaves that were fetched.
    pub leaves: u64,
    /// How often triangles of a leaf were decided exactly for a ray, since neither single nor double
    /// precision was certain.
    pub exact: u64,
}

impl WorkCounts {
    /// Cache lines of nodes and leaves that were asked for.
    pub fn cache_lines(&self) -> u64 {
        let lines = |bytes: usize| bytes as u64 / 64;
        self.nodes * lines(size_of::<WideNode>()) + self.leaves * lines(size_of::<LeafBlock>())
    }
}

/// What it costs to find the closest hits, or whether there is any.
fn count_work<R: RayRows + Sync>(target: Target, rays: &[R], is_any: bool) -> WorkCounts {
    if is_any { work_of::<R, Any>(target, rays) } else { work_of::<R, ClosestSingle>(target, rays) }
}

fn work_of<R: RayRows + Sync, Q: Question>(
    Target { tree, mesh, level }: Target,
    rays: &[R],
) -> WorkCounts {
    let chunks = rays.par_chunks(CHUNK).map(|rays| {
        let mut answers = vec![Q::MISS; rays.len()];
        let batch = Rows::<R, Q> { rays, answers: &mut answers };
        level.run(Cast::new(tree, mesh, batch)).1.counts()
    });
    let [nodes, leaves, exact] =
        chunks.reduce(|| [0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    WorkCounts { rays: rays.len() as u64, nodes, leaves, exact }
}

/// What rays are cast at, and by which instruction set.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// The tree.
    pub tree: &'a KdTree,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The instruction set.
    pub level: Level,
}

/// The closest hit of each ray.
pub fn intersect(target: Target, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<Hit>> {
    cast::<_, Closest>(target, rays, observer)
}

/// The same into given memory.
pub fn intersect_into(
    target: Target,
    rays: &[Ray],
    hits: &mut [Hit],
    observer: &dyn Observer,
) -> Result<()> {
    cast_into::<_, Closest>(target, rays, hits, observer)
}

/// The same in single precision.
pub fn intersect_single_into(
    target: Target,
    rays: &[SingleRay],
    hits: &mut [SingleHit],
    observer: &dyn Observer,
) -> Result<()> {
    cast_into::<_, ClosestSingle>(target, rays, hits, observer)
}

/// The same into new memory.
pub fn intersect_single(
    target: Target,
    rays: &[SingleRay],
    observer: &dyn Observer,
) -> Result<Vec<SingleHit>> {
    cast::<_, ClosestSingle>(target, rays, observer)
}

/// All hits of each ray.
fn cast_for_hits<R: RayRows + Sync>(
    target: Target,
    rays: &[R],
    observer: &dyn Observer,
) -> Result<AllHits> {
    let progress = start(observer, rays.len());
    let chunks = rays.par_chunks(CHUNK).map(|rays| {
        progress.check()?;
        let chunk = all_hits_of(target, rays, observer);
        progress.advance(rays.len())?;
        Ok(chunk)
    });
    let chunks = chunks.collect::<Result<Vec<_>>>()?;
    let mut all = AllHits::default();
    all.splits.reserve_exact(rays.len() + 1);
    all.splits.push(0);
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

/// How many hits each ray has.
fn cast_for_counts<R: RayRows + Sync>(
    target: Target,
    rays: &[R],
    observer: &dyn Observer,
) -> Result<Vec<usize>> {
    let progress = start(observer, rays.len());
    let mut counts = vec![0; rays.len()];
    let chunks = counts.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK));
    chunks.try_for_each(|(counts, rays)| {
        progress.check()?;
        count_hits_of(target, rays, counts, observer);
        progress.advance(rays.len())
    })?;
    Ok(counts)
}

/// A ray in either precision. The engine is compiled for both of them here, and not again wherever it
/// is used.
pub trait BatchRay: Copy + Into<Ray> + Sync {
    /// For each ray whether it hits anything.
    #[doc(hidden)]
    fn occluded_into(
        target: Target,
        rays: &[Self],
        flags: &mut [bool],
        observer: &dyn Observer,
    ) -> Result<()>;

    /// All hits of each ray.
    #[doc(hidden)]
    fn intersect_all(target: Target, rays: &[Self], observer: &dyn Observer) -> Result<AllHits>;

    /// How many hits each ray has.
    #[doc(hidden)]
    fn count(target: Target, rays: &[Self], observer: &dyn Observer) -> Result<Vec<usize>>;

    /// What it costs to cast them.
    #[doc(hidden)]
    fn count_work(target: Target, rays: &[Self], is_any: bool) -> WorkCounts;
}

impl BatchRay for Ray {
    fn occluded_into(
        target: Target,
        rays: &[Ray],
        flags: &mut [bool],
        observer: &dyn Observer,
    ) -> Result<()> {
        cast_into::<_, Any>(target, rays, flags, observer)
    }

    fn intersect_all(target: Target, rays: &[Ray], observer: &dyn Observer) -> Result<AllHits> {
        cast_for_hits(target, rays, observer)
    }

    fn count(target: Target, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<usize>> {
        cast_for_counts(target, rays, observer)
    }

    fn count_work(target: Target, rays: &[Ray], is_any: bool) -> WorkCounts {
        count_work(target, rays, is_any)
    }
}

impl BatchRay for SingleRay {
    fn occluded_into(
        target: Target,
        rays: &[SingleRay],
        flags: &mut [bool],
        observer: &dyn Observer,
    ) -> Result<()> {
        cast_into::<_, Any>(target, rays, flags, observer)
    }

    fn intersect_all(
        target: Target,
        rays: &[SingleRay],
        observer: &dyn Observer,
    ) -> Result<AllHits> {
        cast_for_hits(target, rays, observer)
    }

    fn count(target: Target, rays: &[SingleRay], observer: &dyn Observer) -> Result<Vec<usize>> {
        cast_for_counts(target, rays, observer)
    }

    fn count_work(target: Target, rays: &[SingleRay], is_any: bool) -> WorkCounts {
        count_work(target, rays, is_any)
    }
}
