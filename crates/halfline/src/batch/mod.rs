//! Batches of rays over all threads. The answers do not depend on how many there are.

mod all_hits;
mod closest_points;

use std::ops::Range;

use rayon::prelude::*;

pub use all_hits::{
    AllHitColumns, AllHits, AllHitsIter, count_hits, find_all_hits, find_all_hits_columns,
};

pub use closest_points::{closest_points, closest_points_columns, record_point_visits};

use crate::error::Result;
use crate::geometry::{Hit, HitF32, Ray, RayF32};
use crate::progress::{Observer, SharedProgress, Stage};
use crate::rays::{RayColumns, RaySource, rays_per_band};
use crate::traverse::{
    Answers, AnyHit, Cast, ClosestHit, HitColumns, PrefetchTuner, Query, Target, cast,
};
use crate::tree::{LeafBlock, Node};

/// Rays that one task casts: about a millisecond of work, and many to each slot of a stream.
pub const CHUNK: usize = 1 << 12;

/// A ray in either precision: [`Ray`] or [`RayF32`], and no other type.
pub trait BatchRay: Copy + Into<Ray> + Sync + sealed::Sealed {
    /// The rays of a slice.
    #[doc(hidden)]
    fn source(rays: &[Self]) -> Rays<'_>;
}

/// Rays in memory, in whatever form.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Rays<'a>(pub(crate) RaySource<'a>);

mod sealed {
    /// Keeps [`BatchRay`](super::BatchRay) from being implemented outside of this crate.
    pub trait Sealed {}

    impl Sealed for crate::geometry::Ray {}
    impl Sealed for crate::geometry::RayF32 {}
}

impl BatchRay for Ray {
    fn source(rays: &[Ray]) -> Rays<'_> {
        Rays(RaySource::Rows(rays))
    }
}

impl BatchRay for RayF32 {
    fn source(rays: &[RayF32]) -> Rays<'_> {
        Rays(RaySource::RowsF32(rays))
    }
}

impl<'a> From<RayColumns<'a>> for Rays<'a> {
    fn from(columns: RayColumns<'a>) -> Rays<'a> {
        Rays(RaySource::Columns(columns))
    }
}

/// Casts rays chunk by chunk: `parts` has the places for the answers of each chunk. A single chunk is the calling
/// thread's own, so that a few rays do not wait for other threads. What one chunk finds out about prefetching, the
/// next ones know.
pub fn in_chunks<P: Send, A: Send>(
    target: Target,
    (source, chunk_len): (RaySource, usize),
    parts: Vec<P>,
    observer: &dyn Observer,
    work: impl Fn(Target, RaySource, P) -> A + Sync,
) -> Result<Vec<A>> {
    let range = (source.len(), chunk_len);
    in_ranges(target, range, parts, observer, |target, numbers, part| {
        work(target, source.slice(numbers), part)
    })
}

/// Answers about so many rays or points chunk by chunk, each a range of their numbers.
fn in_ranges<P: Send, A: Send>(
    target: Target,
    (count, chunk_len): (usize, usize),
    parts: Vec<P>,
    observer: &dyn Observer,
    work: impl Fn(Target, Range<usize>, P) -> A + Sync,
) -> Result<Vec<A>> {
    let tuner = PrefetchTuner::default();
    let target = Target { tuner: Some(&tuner), ..target };
    let progress = SharedProgress::new(observer, Stage::Trace, count);
    observer.report(Stage::Trace, 0, count as u64);
    let one_chunk = |(chunk, part): (usize, P)| {
        progress.check()?;
        let numbers = chunk * chunk_len..count.min((chunk + 1) * chunk_len);
        let answer = work(target, numbers.clone(), part);
        progress.advance(numbers.len())?;
        Ok(answer)
    };
    if parts.len() <= 1 {
        return parts.into_iter().enumerate().map(one_chunk).collect();
    }
    parts.into_par_iter().enumerate().map(one_chunk).collect()
}

/// How many rays one task casts where each has one answer: a band of an image, or [`CHUNK`].
fn chunk_len(source: &RaySource) -> usize {
    rays_per_band(source.image_width()).unwrap_or(CHUNK)
}

const PLACES: &str = "there is a place for the answer of each ray";

/// The closest hit of each ray, put into the same place of `hits`.
pub fn intersect(
    target: Target,
    Rays(source): Rays,
    hits: &mut [Hit],
    observer: &dyn Observer,
) -> Result<()> {
    assert_eq!(hits.len(), source.len(), "{PLACES}");
    let chunk = chunk_len(&source);
    let parts = hits.chunks_mut(chunk).collect();
    in_chunks(target, (source, chunk), parts, observer, |target, rays, hits: &mut [Hit]| {
        hits.fill(Hit::MISS);
        cast::<ClosestHit>(Cast::new(target, rays, Answers::Hits(hits)));
    })?;
    Ok(())
}

/// The closest hit of each ray in single precision, put into the same place of `hits`.
pub fn intersect_f32(
    target: Target,
    Rays(source): Rays,
    hits: &mut [HitF32],
    observer: &dyn Observer,
) -> Result<()> {
    assert_eq!(hits.len(), source.len(), "{PLACES}");
    let chunk = chunk_len(&source);
    let parts = hits.chunks_mut(chunk).collect();
    in_chunks(target, (source, chunk), parts, observer, |target, rays, hits: &mut [HitF32]| {
        hits.fill(HitF32::MISS);
        cast::<ClosestHit>(Cast::new(target, rays, Answers::HitsF32(hits)));
    })?;
    Ok(())
}

/// The closest hit of each ray, put into columns.
pub fn intersect_columns(
    target: Target,
    Rays(source): Rays,
    hits: HitColumns,
    observer: &dyn Observer,
) -> Result<()> {
    let HitColumns { t, face, uv } = hits;
    assert_eq!([t.len(), face.len(), uv.len()], [source.len(); 3], "{PLACES}");
    let chunk = chunk_len(&source);
    let parts = t.chunks_mut(chunk).zip(face.chunks_mut(chunk)).zip(uv.chunks_mut(chunk));
    in_chunks(
        target,
        (source, chunk),
        parts.collect(),
        observer,
        |target, rays, ((t, face), uv)| {
            let mut hits = HitColumns { t, face, uv };
            hits.fill_with_misses();
            cast::<ClosestHit>(Cast::new(target, rays, Answers::HitColumns(hits)));
        },
    )?;
    Ok(())
}

/// For each ray whether it hits anything, put into the same place of `flags`.
pub fn occluded(
    target: Target,
    Rays(source): Rays,
    flags: &mut [bool],
    observer: &dyn Observer,
) -> Result<()> {
    assert_eq!(flags.len(), source.len(), "{PLACES}");
    let chunk = chunk_len(&source);
    let parts = flags.chunks_mut(chunk).collect();
    in_chunks(target, (source, chunk), parts, observer, |target, rays, flags: &mut [bool]| {
        flags.fill(false);
        cast::<AnyHit>(Cast::new(target, rays, Answers::Occluded(flags)));
    })?;
    Ok(())
}

/// What casting a batch costs. What it takes together counts once: a node is fetched once for all rays
/// of a packet.
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
        self.nodes * lines(size_of::<Node>()) + self.leaves * lines(size_of::<LeafBlock>())
    }
}

/// What it costs to find the closest hits in single precision, or whether there is any.
pub fn count_work(target: Target, Rays(source): Rays, is_any: bool) -> WorkCounts {
    let count = source.len();
    let chunks = (0..count.div_ceil(CHUNK)).into_par_iter().map(|chunk| {
        let rays = source.slice(chunk * CHUNK..count.min((chunk + 1) * CHUNK));
        if is_any {
            let mut flags = vec![false; rays.len()];
            work_of::<AnyHit>(target, rays, Answers::Occluded(&mut flags))
        } else {
            let mut hits = vec![HitF32::MISS; rays.len()];
            work_of::<ClosestHit>(target, rays, Answers::HitsF32(&mut hits))
        }
    });
    let [nodes, leaves, exact] =
        chunks.reduce(|| [0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
    WorkCounts { rays: count as u64, nodes, leaves, exact }
}

fn work_of<Q: Query>(target: Target, rays: RaySource, answers: Answers) -> [u64; 3] {
    cast::<Q>(Cast::new(target, rays, answers)).work.counts()
}

/// The closest hit of each ray where rounded signs and depths are taken as they come, as most ray tracers do:
/// rays leak, and faces are wrong. To measure what exactness costs.
#[cfg(feature = "variants")]
pub fn intersect_plain(target: Target, Rays(source): Rays, hits: &mut [HitF32]) {
    let chunk = chunk_len(&source);
    let parts = hits.chunks_mut(chunk).collect();
    let silent = &crate::progress::NoProgress;
    in_chunks(target, (source, chunk), parts, silent, |target, rays, hits: &mut [HitF32]| {
        hits.fill(HitF32::MISS);
        cast::<ClosestHit<false>>(Cast::new(target, rays, Answers::HitsF32(hits)));
    })
    .expect("nobody interrupts");
}

/// For each ray whether it hits anything, where rounded signs are taken as they come.
#[cfg(feature = "variants")]
pub fn occluded_plain(target: Target, Rays(source): Rays, flags: &mut [bool]) {
    let chunk = chunk_len(&source);
    let parts = flags.chunks_mut(chunk).collect();
    let silent = &crate::progress::NoProgress;
    in_chunks(target, (source, chunk), parts, silent, |target, rays, flags: &mut [bool]| {
        flags.fill(false);
        cast::<AnyHit<false>>(Cast::new(target, rays, Answers::Occluded(flags)));
    })
    .expect("nobody interrupts");
}
