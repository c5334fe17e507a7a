//! Rays aimed where rays slip through: at every vertex and at the middle of every edge.
//!
//! What a ray must do is known without asking any engine:
//!
//! - *No leak.* From inside a closed surface every ray hits.
//! - *Odd.* It crosses the surface an odd number of times.
//! - *Not late.* The closest hit does not lie behind the first crossing. And where the target less
//!   the origin is a double, exactly, and the origin lies off the target's plane (decided by
//!   Shewchuk's `orient3d`, from the crate `robust`), the ray meets the target's face at t = 1 and
//!   the closest hit does not lie behind that. This holds for open surfaces too, where it is all
//!   that is known; from outside as well as from inside.
//!
//! Inside is found by exact parities (`interior.rs`), and so that directions are exact, origins lie
//! on a grid of about a thousandth of the mesh's size.

mod interior;
mod judge;

use std::time::{Duration, Instant};

use crate::topology::{Target, Topology};
use halfline::Scene;
use halfline::error::Result;
use halfline::geometry::random::{Random, mix};
use halfline::geometry::{Aabb, Ray, Vec3};
use halfline::progress::{Observer, Part};

pub use judge::Wrong;
use judge::{certainly_meets, judge};

/// How many rays, and which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// At most so many rays. Where there are fewer targets, the first origin sees them all and the
    /// other origins share what is left; where there are more, all origins share, and the rays of
    /// each are spread evenly over the vertices and edges in the order of the mesh.
    pub rays: usize,
    /// Which targets are taken of too many, and where origins are looked for.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Options {
        Options { rays: 1_000_000, seed: 0 }
    }
}

/// What came of the rays.
#[derive(Clone, Debug, Default)]
pub struct LeakReport {
    /// Where rays began.
    pub origins: Vec<Vec3>,
    /// True if the origins lie inside a closed surface, so that each ray must hit, and must cross
    /// an odd number of times.
    pub from_inside: bool,
    /// Vertices and edges there are to aim at.
    pub targets: usize,
    /// Rays cast.
    pub rays: u64,
    /// Rays of which it is certain that they meet the face they are aimed at.
    pub certain_rays: u64,
    /// Crossings in all.
    pub crossings: u64,
    /// Rays that hit nothing, though they must.
    pub leaks: u64,
    /// Rays with an even number of crossings, though it must be odd.
    pub wrong_parities: u64,
    /// Rays whose closest hit lies behind one that is nearer.
    pub late_hits: u64,
    /// The first rays, at most five, that hit nothing, crossed wrongly or hit too late.
    pub examples: Vec<Example>,
    /// How long the question for the closest hits took.
    pub closest_time: Duration,
    /// How long the question for all crossings took.
    pub crossings_time: Duration,
}

impl LeakReport {
    /// True if every ray did what it must.
    pub fn is_clean(&self) -> bool {
        self.leaks + self.wrong_parities + self.late_hits == 0
    }
}

/// A ray that did not do what it must.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// The ray.
    pub ray: Ray,
    /// What it was aimed at.
    pub target: Target,
    /// What is wrong with its hits.
    pub wrong: Wrong,
    /// The closest hit's t.
    pub closest_t: f64,
    /// How many crossings were reported.
    pub crossings: usize,
}

/// How many examples are kept.
const EXAMPLES: usize = 5;

/// From how many points rays are cast: a ray tracer that is right from the middle of a sphere may
/// be wrong elsewhere.
const ORIGINS: usize = 4;

/// The rays of the first batch, of the largest, and how many crossings the next batch may have if
/// its rays have as many as those of the last one: 32 bytes each. So memory is bounded for stacks
/// of a million sheets too.
const FIRST_BATCH: usize = 64;
const LARGEST_BATCH: usize = 1 << 15;
const CROSSINGS_OF_A_BATCH: u64 = 1 << 22;
const GROWTH_OF_BATCHES: usize = 4;

/// Aims rays at the vertices and edges of `topology`, that of the scene's mesh, and judges what
/// they hit. Reports [`Stage::Trace`](halfline::progress::Stage::Trace) in rays.
///
/// # Errors
/// [`Error::Interrupted`](halfline::Error::Interrupted).
///
/// # Panics
/// If `topology` is that of another mesh with more triangles.
pub fn aim(
    scene: &Scene,
    topology: &Topology,
    options: &Options,
    observer: &dyn Observer,
) -> Result<LeakReport> {
    let mesh = scene.mesh();
    let mut report = LeakReport { targets: topology.target_count(), ..LeakReport::default() };
    if report.targets == 0 {
        return Ok(report);
    }

    // Look for places inside; an open surface has none.
    if topology.is_closed() {
        report.origins = interior::find(scene, topology, ORIGINS, options.seed, observer)?;
        report.from_inside = !report.origins.is_empty();
    }
    if report.origins.is_empty() {
        report.origins = around(&mesh.bounds());
    }

    // Cast each origin's share of the rays in batches.
    let shares = shares(options.rays, report.targets, report.origins.len());
    let total = shares.iter().sum::<usize>() as u64;
    let mut batch_size = FIRST_BATCH;
    for (number, &share) in shares.iter().enumerate() {
        let origin = report.origins[number];
        let seed = mix(options.seed ^ mix(number as u64));
        let mut next = 0;
        while next < share {
            let end = (next + batch_size).min(share);
            let aims: Vec<Target> = (next..end)
                .map(|i| topology.target(stratum(i, share, report.targets, seed)))
                .collect();
            let before = report.crossings;
            let share = aims.len() as u64;
            let part = Part { observer, before: report.rays, share, total };
            report.cast(scene, origin, &aims, &part)?;
            next = end;
            let per_ray = (report.crossings - before) / aims.len() as u64 + 1;
            batch_size = (batch_size * GROWTH_OF_BATCHES)
                .min(LARGEST_BATCH)
                .min((CROSSINGS_OF_A_BATCH / per_ray).max(1) as usize);
        }
    }
    Ok(report)
}

impl LeakReport {
    /// Casts a ray from `origin` at each of the targets.
    fn cast(
        &mut self,
        scene: &Scene,
        origin: Vec3,
        targets: &[Target],
        observer: &dyn Observer,
    ) -> Result<()> {
        let aimed = |target: &Target| Ray::new(origin, target.position(scene.mesh()) - origin);
        let rays: Vec<Ray> = targets.iter().map(aimed).collect();
        self.cast_rays(scene, &rays, targets, observer)
    }

    /// Casts rays, each aimed at the target of its number.
    fn cast_rays(
        &mut self,
        scene: &Scene,
        rays: &[Ray],
        targets: &[Target],
        observer: &dyn Observer,
    ) -> Result<()> {
        let start = Instant::now();
        let closest = scene.observed(observer).intersect(rays)?;
        self.closest_time += start.elapsed();
        let start = Instant::now();
        let all = scene.observed(&Quiet(observer)).intersect_all(rays)?;
        self.crossings_time += start.elapsed();

        for (i, (ray, &target)) in rays.iter().zip(targets).enumerate() {
            let crossings = &all.hits[all.splits[i]..all.splits[i + 1]];
            let certain = certainly_meets(ray, target, scene.mesh());
            let wrong = judge(self.from_inside, certain, &closest[i], crossings);
            self.certain_rays += u64::from(certain);
            self.leaks += u64::from(wrong.leak);
            self.wrong_parities += u64::from(wrong.parity);
            self.late_hits += u64::from(wrong.late);
            if wrong != Wrong::default() && self.examples.len() < EXAMPLES {
                let (closest_t, crossings) = (closest[i].t, crossings.len());
                self.examples.push(Example { ray: *ray, target, wrong, closest_t, crossings });
            }
        }
        self.rays += rays.len() as u64;
        self.crossings += all.hits.len() as u64;
        Ok(())
    }
}

/// How many rays each origin gets.
fn shares(rays: usize, targets: usize, origins: usize) -> Vec<usize> {
    let first = if rays >= targets || origins == 1 { rays.min(targets) } else { 0 };
    let sharing = origins - usize::from(first > 0);
    let rest = rays - first;
    let mut shares = if first > 0 { vec![first] } else { Vec::new() };
    let share = |i: usize| (rest / sharing + usize::from(i < rest % sharing)).min(targets);
    shares.extend((0..sharing).map(share));
    shares
}

/// The `i`-th of `count` targets chosen from `total`: one of each of `count` ranges that are equal
/// but for rounding.
fn stratum(i: usize, count: usize, total: usize, seed: u64) -> usize {
    let begin = |i: usize| (i as u128 * total as u128 / count as u128) as usize;
    let (begin, end) = (begin(i), begin(i + 1));
    begin + (mix(seed ^ mix(i as u64)) % (end - begin) as u64) as usize
}

/// Where to aim from at a surface that has no inside: the middle, and places around it, one of
/// which is off the plane of a flat one.
fn around(bounds: &Aabb) -> Vec<Vec3> {
    let (center, grid) = (bounds.center(), grid(bounds));
    let size = bounds.extent().max_element();
    // Directions that no plane of a usual model contains.
    let directions = [[0.35, 0.61, 0.71], [-0.83, 0.29, 0.47], [0.19, -0.53, -0.83]];
    std::iter::once(center)
        .chain(directions.map(|d| center + Vec3::from(d) * size))
        .map(|p| snapped(p, grid))
        .collect()
}

/// A power of two, about a thousandth of the box.
fn grid(bounds: &Aabb) -> f64 {
    let size = bounds.extent().max_element();
    // Of a single point any grid will do; nor can one be told if the size overflows.
    if size > 0.0 && size.is_finite() { (size / 1024.0).log2().floor().exp2() } else { 1.0 }
}

/// The point of the grid nearest to `p`.
fn snapped(p: Vec3, grid: f64) -> Vec3 {
    p.to_array().map(|c| (c / grid).round() * grid).into()
}

/// Passes on nothing but the wish to end.
struct Quiet<'a>(&'a dyn Observer);

impl Observer for Quiet<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

#[cfg(test)]
mod tests;
