//! Batches of rays over all threads. The answers do not depend on how many there are.

use rayon::prelude::*;

use super::caster::Caster;
use crate::error::Result;
use crate::geometry::{Hit, Ray};
use crate::mesh::Mesh;
use crate::progress::{Observer, SharedProgress, Stage};
use crate::tree::KdTree;

/// Rays that one task casts: some milliseconds of work.
const CHUNK: usize = 1 << 10;

/// All hits of each ray of a batch, in compressed sparse rows: those of ray i are
/// `hits[splits[i]..splits[i + 1]]`, sorted by t and then by face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllHits {
    /// One more entry than there are rays.
    pub splits: Vec<usize>,
    /// The hits.
    pub hits: Vec<Hit>,
}

fn start(observer: &dyn Observer, rays: usize) -> SharedProgress<'_> {
    let progress = SharedProgress::new(observer, Stage::Trace, rays);
    observer.report(Stage::Trace, 0, rays as u64);
    progress
}

/// Casts each ray and puts its answer into the same place of the result.
fn cast<A: Clone + Send>(
    tree: &KdTree,
    mesh: &Mesh,
    rays: &[Ray],
    miss: A,
    observer: &dyn Observer,
    answer: impl Fn(&mut Caster, &Ray) -> A + Sync,
) -> Result<Vec<A>> {
    let progress = start(observer, rays.len());
    let mut answers = vec![miss; rays.len()];
    answers.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).try_for_each(|(answers, rays)| {
        observer.check()?;
        let mut caster = Caster::new(tree, mesh);
        for (slot, ray) in answers.iter_mut().zip(rays) {
            *slot = answer(&mut caster, ray);
        }
        progress.advance(rays.len())
    })?;
    Ok(answers)
}

/// The closest hit of each ray.
pub fn intersect(
    tree: &KdTree,
    mesh: &Mesh,
    rays: &[Ray],
    observer: &dyn Observer,
) -> Result<Vec<Hit>> {
    cast(tree, mesh, rays, Hit::MISS, observer, |caster, ray| caster.closest(ray))
}

/// For each ray whether it hits anything.
pub fn occluded(
    tree: &KdTree,
    mesh: &Mesh,
    rays: &[Ray],
    observer: &dyn Observer,
) -> Result<Vec<bool>> {
    cast(tree, mesh, rays, false, observer, |caster, ray| caster.any(ray))
}

/// All hits of each ray.
pub fn intersect_all(
    tree: &KdTree,
    mesh: &Mesh,
    rays: &[Ray],
    observer: &dyn Observer,
) -> Result<AllHits> {
    let progress = start(observer, rays.len());
    let chunks: Vec<(Vec<usize>, Vec<Hit>)> = rays
        .par_chunks(CHUNK)
        .map(|rays| {
            observer.check()?;
            let mut ends = Vec::with_capacity(rays.len());
            let mut hits = Vec::new();
            let mut caster = Caster::new(tree, mesh);
            for ray in rays {
                caster.all(ray, &mut hits);
                ends.push(hits.len());
            }
            progress.advance(rays.len())?;
            Ok((ends, hits))
        })
        .collect::<Result<_>>()?;

    let mut all = AllHits::default();
    all.splits.reserve_exact(rays.len() + 1);
    all.splits.push(0);
    all.hits.reserve_exact(chunks.iter().map(|(_, hits)| hits.len()).sum());
    for (ends, hits) in chunks {
        let before = all.hits.len();
        all.splits.extend(ends.iter().map(|end| before + end));
        all.hits.extend_from_slice(&hits);
    }
    Ok(all)
}
