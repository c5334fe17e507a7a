//! Batches whose rays and answers are columns, as NumPy has them: an array of origins, one of
//! directions, one of t.
//!
//! A chunk of rays at a time is put together from the columns, cast as any other batch, and its
//! answers are taken apart. So nothing the size of the batch is copied, and what a chunk needs stays
//! in the second-level cache.

use std::ops::Range;

use bytemuck::Zeroable;
use rayon::prelude::*;

use super::all_rows::{all_hits_of, count_hits_of};
use super::batch::{Any, CHUNK, Closest, Question, Target, cast_chunk, start};
use crate::error::{Error, Result};
use crate::geometry::{Hit, Ray, SingleRay, Vec3};
use crate::progress::Observer;

/// What each ray has of one kind: the same for all, or an entry of an array in single precision or in
/// double.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Column<'a, S, D> {
    /// All rays have this.
    Same(D),
    /// Each ray has its own.
    Single(&'a [S]),
    /// Each ray has its own.
    Double(&'a [D]),
}

/// Origins or directions.
pub type Vectors<'a> = Column<'a, [f32; 3], [f64; 3]>;

/// Ends of ranges.
pub type Scalars<'a> = Column<'a, f32, f64>;

/// Rays as columns. No number is ever rounded: where all are single-precision numbers the rays are
/// [`SingleRay`]s, otherwise [`Ray`]s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayColumns<'a> {
    count: usize,
    origins: Vectors<'a>,
    directions: Vectors<'a>,
    t_min: Scalars<'a>,
    t_max: Scalars<'a>,
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

/// All hits of each ray, in compressed sparse rows: those of ray i are `splits[i]..splits[i + 1]` of the
/// other columns, sorted by t and then by face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllHitColumns {
    /// One more entry than there are rays.
    pub splits: Vec<i64>,
    /// Ray parameters.
    pub t: Vec<f64>,
    /// Indices of triangles.
    pub face: Vec<i64>,
    /// Barycentric weights of the triangles' second and third vertices.
    pub uv: Vec<[f64; 2]>,
}

impl<S, D> Column<'_, S, D> {
    /// A message if there are not `count` entries.
    fn check(&self, what: &str, count: usize) -> Result<()> {
        let found = match self {
            Column::Same(_) => return Ok(()),
            Column::Single(entries) => entries.len(),
            Column::Double(entries) => entries.len(),
        };
        if found == count {
            return Ok(());
        }
        Err(Error::invalid(what, format!("expected one or {count} entries, found {found}")))
    }

    /// The entries from `first` on that go with `rays`, one after another to `put`.
    #[inline(always)]
    fn each<R>(&self, first: usize, rays: &mut [R], put: impl Fn(&mut R, Entry<S, D>))
    where
        S: Copy,
        D: Copy,
    {
        let entries = first..first + rays.len();
        match self {
            Column::Same(entry) => rays.iter_mut().for_each(|ray| put(ray, Entry::Double(*entry))),
            Column::Single(all) => {
                rays.iter_mut().zip(&all[entries]).for_each(|(ray, x)| put(ray, Entry::Single(*x)));
            }
            Column::Double(all) => {
                rays.iter_mut().zip(&all[entries]).for_each(|(ray, x)| put(ray, Entry::Double(*x)));
            }
        }
    }
}

/// One entry of a column.
enum Entry<S, D> {
    Single(S),
    Double(D),
}

impl Entry<f32, f64> {
    #[inline(always)]
    fn double(self) -> f64 {
        match self {
            Entry::Single(x) => x.into(),
            Entry::Double(x) => x,
        }
    }

    /// Loses nothing of a number that [`is_single`].
    #[inline(always)]
    fn single(self) -> f32 {
        match self {
            Entry::Single(x) => x,
            Entry::Double(x) => x as f32,
        }
    }
}

impl Entry<[f32; 3], [f64; 3]> {
    #[inline(always)]
    fn double(self) -> [f64; 3] {
        match self {
            Entry::Single(x) => x.map(f64::from),
            Entry::Double(x) => x,
        }
    }

    #[inline(always)]
    fn single(self) -> [f32; 3] {
        match self {
            Entry::Single(x) => x,
            Entry::Double(x) => x.map(|x| x as f32),
        }
    }
}

/// True for a number that single precision has; all NaNs are alike.
fn is_single(x: f64) -> bool {
    f64::from(x as f32) == x || x.is_nan()
}

impl Vectors<'_> {
    fn are_single(&self) -> bool {
        match self {
            Column::Same(vector) => vector.iter().all(|&x| is_single(x)),
            Column::Single(_) => true,
            Column::Double(_) => false,
        }
    }
}

impl Scalars<'_> {
    fn are_single(&self) -> bool {
        match self {
            Column::Same(x) => is_single(*x),
            Column::Single(_) => true,
            Column::Double(_) => false,
        }
    }
}

impl<'a> RayColumns<'a> {
    /// `count` rays.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a column that is not the same for all has not `count` entries.
    pub fn new(
        count: usize,
        origins: Vectors<'a>,
        directions: Vectors<'a>,
        t_min: Scalars<'a>,
        t_max: Scalars<'a>,
    ) -> Result<RayColumns<'a>> {
        origins.check("origins", count)?;
        directions.check("directions", count)?;
        t_min.check("t_min", count)?;
        t_max.check("t_max", count)?;
        Ok(RayColumns { count, origins, directions, t_min, t_max })
    }

    /// Number of rays.
    pub fn len(&self) -> usize {
        self.count
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Where the rays begin.
    pub fn origins(&self) -> Vectors<'a> {
        self.origins
    }

    /// How far one unit of t reaches.
    pub fn directions(&self) -> Vectors<'a> {
        self.directions
    }

    /// The smallest t that count.
    pub fn t_min(&self) -> Scalars<'a> {
        self.t_min
    }

    /// The largest t that count.
    pub fn t_max(&self) -> Scalars<'a> {
        self.t_max
    }

    /// True if single precision has all the numbers.
    fn are_single(&self) -> bool {
        let vectors = self.origins.are_single() && self.directions.are_single();
        vectors && self.t_min.are_single() && self.t_max.are_single()
    }
}

/// A chunk of rays, put together from columns.
enum Rays {
    Single(Vec<SingleRay>),
    Double(Vec<Ray>),
}

impl Rays {
    /// Memory for rays of the precision that `columns` need.
    fn none(columns: &RayColumns) -> Rays {
        match columns.are_single() {
            true => Rays::Single(Vec::new()),
            false => Rays::Double(Vec::new()),
        }
    }

    /// Holds those of `numbers` from here on.
    fn fill(&mut self, columns: &RayColumns, numbers: Range<usize>) {
        let RayColumns { origins, directions, t_min, t_max, .. } = columns;
        let first = numbers.start;
        match self {
            Rays::Single(rays) => {
                rays.resize(numbers.len(), SingleRay::zeroed());
                origins.each(first, rays, |ray, entry| ray.origin = entry.single());
                directions.each(first, rays, |ray, entry| ray.direction = entry.single());
                t_min.each(first, rays, |ray, entry| ray.t_min = entry.single());
                t_max.each(first, rays, |ray, entry| ray.t_max = entry.single());
            }
            Rays::Double(rays) => {
                rays.resize(numbers.len(), Ray::new(Vec3::ZERO, Vec3::ZERO));
                origins.each(first, rays, |ray, entry| ray.origin = entry.double().into());
                directions.each(first, rays, |ray, entry| ray.direction = entry.double().into());
                t_min.each(first, rays, |ray, entry| ray.t_min = entry.double());
                t_max.each(first, rays, |ray, entry| ray.t_max = entry.double());
            }
        }
    }

    fn len(&self) -> usize {
        match self {
            Rays::Single(rays) => rays.len(),
            Rays::Double(rays) => rays.len(),
        }
    }

    fn cast<Q: Question>(&self, target: Target, answers: &mut [Q::Answer]) {
        match self {
            Rays::Single(rays) => cast_chunk::<_, Q>(target, rays, answers),
            Rays::Double(rays) => cast_chunk::<_, Q>(target, rays, answers),
        }
    }

    /// How many hits each ray has, and the hits.
    fn all_hits(&self, target: Target, observer: &dyn Observer) -> (Vec<usize>, Vec<Hit>) {
        match self {
            Rays::Single(rays) => all_hits_of(target, rays, observer),
            Rays::Double(rays) => all_hits_of(target, rays, observer),
        }
    }

    /// How many hits each ray has.
    fn count_hits(&self, target: Target, observer: &dyn Observer) -> Vec<usize> {
        let mut counts = vec![0; self.len()];
        match self {
            Rays::Single(rays) => count_hits_of(target, rays, &mut counts, observer),
            Rays::Double(rays) => count_hits_of(target, rays, &mut counts, observer),
        }
        counts
    }
}

/// Does `work` with each chunk of rays and what `parts` has for it. A single chunk is the calling
/// thread's own, so that a few rays do not wait for other threads.
fn in_chunks<P: Send, A: Send>(
    columns: &RayColumns,
    parts: Vec<P>,
    observer: &dyn Observer,
    work: impl Fn(&Rays, P) -> A + Sync,
) -> Result<Vec<A>> {
    let count = columns.len();
    let progress = start(observer, count);
    let one_chunk = |rays: &mut Rays, (chunk, part): (usize, P)| {
        progress.check()?;
        rays.fill(columns, chunk * CHUNK..count.min((chunk + 1) * CHUNK));
        let answer = work(rays, part);
        progress.advance(rays.len())?;
        Ok(answer)
    };
    if parts.len() <= 1 {
        let mut rays = Rays::none(columns);
        return parts.into_iter().enumerate().map(|part| one_chunk(&mut rays, part)).collect();
    }
    parts.into_par_iter().enumerate().map_init(|| Rays::none(columns), one_chunk).collect()
}

/// The closest hit of each ray.
pub fn intersect(
    target: Target,
    columns: &RayColumns,
    hits: HitColumns,
    observer: &dyn Observer,
) -> Result<()> {
    let HitColumns { t, face, uv } = hits;
    assert_eq!([t.len(), face.len(), uv.len()], [columns.len(); 3], "{PLACES}");
    let parts = t.chunks_mut(CHUNK).zip(face.chunks_mut(CHUNK)).zip(uv.chunks_mut(CHUNK));
    in_chunks(columns, parts.collect(), observer, |rays, ((t, face), uv)| {
        let mut hits = vec![Hit::MISS; rays.len()];
        rays.cast::<Closest>(target, &mut hits);
        scatter(&hits, t, face, uv);
    })?;
    Ok(())
}

const PLACES: &str = "there is a place for the answer of each ray";

/// Takes hits apart.
fn scatter(hits: &[Hit], t: &mut [f64], face: &mut [i64], uv: &mut [[f64; 2]]) {
    for (((hit, t), face), uv) in hits.iter().zip(t).zip(face).zip(uv) {
        *t = hit.t;
        *face = if hit.is_hit() { hit.face.into() } else { -1 };
        *uv = [hit.u, hit.v];
    }
}

/// For each ray whether it hits anything.
pub fn occluded(
    target: Target,
    columns: &RayColumns,
    flags: &mut [bool],
    observer: &dyn Observer,
) -> Result<()> {
    assert_eq!(flags.len(), columns.len(), "{PLACES}");
    let parts = flags.chunks_mut(CHUNK).collect();
    in_chunks(columns, parts, observer, |rays, flags| rays.cast::<Any>(target, flags))?;
    Ok(())
}

/// How many hits each ray has.
pub fn count(
    target: Target,
    columns: &RayColumns,
    counts: &mut [i64],
    observer: &dyn Observer,
) -> Result<()> {
    assert_eq!(counts.len(), columns.len(), "{PLACES}");
    let parts = counts.chunks_mut(CHUNK).collect();
    in_chunks(columns, parts, observer, |rays, counts: &mut [i64]| {
        for (place, count) in counts.iter_mut().zip(rays.count_hits(target, observer)) {
            *place = count as i64;
        }
    })?;
    Ok(())
}

/// All hits of each ray.
pub fn intersect_all(
    target: Target,
    columns: &RayColumns,
    observer: &dyn Observer,
) -> Result<AllHitColumns> {
    let parts = vec![(); columns.len().div_ceil(CHUNK)];
    let chunks = in_chunks(columns, parts, observer, |rays, ()| rays.all_hits(target, observer))?;

    // Chunk by chunk to the places that follow from how many hits the earlier ones have.
    let total = chunks.iter().map(|(_, hits)| hits.len()).sum();
    let mut all = AllHitColumns {
        splits: vec![0; columns.len() + 1],
        t: vec![0.0; total],
        face: vec![0; total],
        uv: vec![[0.0; 2]; total],
    };
    let (mut t, mut face, mut uv) = (&mut all.t[..], &mut all.face[..], &mut all.uv[..]);
    let mut before = 0;
    let mut parts = Vec::with_capacity(chunks.len());
    for (chunk, splits) in chunks.into_iter().zip(all.splits[1..].chunks_mut(CHUNK)) {
        let count = chunk.1.len();
        let columns = (
            t.split_off_mut(..count).expect("a place for each hit"),
            face.split_off_mut(..count).expect("a place for each hit"),
            uv.split_off_mut(..count).expect("a place for each hit"),
        );
        parts.push((chunk, splits, before, columns));
        before += count;
    }
    let put = |((counts, hits), splits, before, (t, face, uv)): Part| {
        let mut end = before;
        for (count, split) in counts.into_iter().zip(splits) {
            end += count;
            *split = end as i64;
        }
        scatter(&hits, t, face, uv);
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
