//! Points inside a closed surface, by exact parity.
//!
//! Candidates are the middle of the mesh's box, and of lines through the surface the middles of
//! their longest pieces inside. One counts as inside if half-lines in six directions all cross the
//! surface an odd number of times, and none of them begins on it.

use super::{Quiet, Random, grid, snapped};
use crate::topology::Topology;
use halfline::Scene;
use halfline::error::Result;
use halfline::geometry::{Ray, Vec3};
use halfline::progress::Observer;

/// Lines that are looked along. Each crosses the surface, and half of those through a body find
/// its inside at once, so that a few would do; more find roomier places.
const LINES: usize = 128;

/// Lines cast at a time, so that their crossings count little in memory.
const BATCH: usize = 16;

/// Three directions, and their opposites, that no plane of a usual model contains.
const DIRECTIONS: [[f64; 3]; 3] = [[0.36, 0.48, 0.80], [-0.81, 0.53, 0.25], [0.29, -0.71, 0.64]];

/// A point inside, and how far the surface is at least along the six directions.
#[derive(Clone, Copy)]
struct Place {
    point: Vec3,
    clearance: f64,
}

/// Up to `count` points inside, the middle of the mesh's box first if it is one; none if none is
/// found.
pub fn find(
    scene: &Scene,
    topology: &Topology,
    count: usize,
    seed: u64,
    observer: &dyn Observer,
) -> Result<Vec<Vec3>> {
    let bounds = scene.mesh().bounds();
    let grid = grid(&bounds);
    let mut chosen: Vec<Place> = Vec::new();
    let center = inside(scene, bounds.center());
    let snapped_center = inside(scene, snapped(bounds.center(), grid));
    chosen.extend(snapped_center.or(center));

    let mut candidates = Vec::new();
    for middle in chord_middles(scene, topology, seed, observer)? {
        observer.check()?;
        candidates.extend(inside(scene, snapped(middle, grid)).or_else(|| inside(scene, middle)));
    }

    // Take those with much room that are far from the ones taken already.
    while chosen.len() < count {
        let merit = |place: &Place| {
            let distance = |other: &Place| (place.point - other.point).length();
            let apart = chosen.iter().map(distance).fold(bounds.extent().length(), f64::min);
            place.clearance * apart
        };
        let best = candidates.iter().copied().max_by(|a, b| merit(a).total_cmp(&merit(b)));
        match best.filter(|best| merit(best) > 0.0) {
            Some(best) => chosen.push(best),
            None => break,
        }
    }
    Ok(chosen.into_iter().map(|place| place.point).collect())
}

/// Of lines in random directions through random places of the surface, the middle of the longest
/// piece of each between crossings whose numbers are odd and even.
fn chord_middles(
    scene: &Scene,
    topology: &Topology,
    seed: u64,
    observer: &dyn Observer,
) -> Result<Vec<Vec3>> {
    let mut random = Random::new(seed, 0);
    let mut middles = Vec::new();
    for _ in 0..LINES / BATCH {
        let lines: Vec<Ray> = (0..BATCH)
            .map(|_| {
                let index = random.below(topology.target_count());
                let through = topology.target(index).position(scene.mesh());
                let direction = random.direction();
                Ray::with_range(through, direction, f64::NEG_INFINITY, f64::INFINITY)
            })
            .collect();
        let all = scene.observed(&Quiet(observer)).intersect_all(&lines)?;
        for (i, line) in lines.iter().enumerate() {
            let crossings = &all.hits[all.splits[i]..all.splits[i + 1]];
            let longest = crossings
                .chunks_exact(2)
                .max_by(|a, b| (a[1].t - a[0].t).total_cmp(&(b[1].t - b[0].t)));
            middles.extend(longest.map(|piece| line.at(piece[0].t * 0.5 + piece[1].t * 0.5)));
        }
    }
    Ok(middles)
}

/// `point` if it is inside.
fn inside(scene: &Scene, point: Vec3) -> Option<Place> {
    let mut caster = scene.caster();
    let mut crossings = Vec::new();
    let mut clearance = f64::INFINITY;
    for direction in DIRECTIONS.into_iter().flat_map(|d| [Vec3::from(d), -Vec3::from(d)]) {
        let ray = Ray::new(point, direction);
        crossings.clear();
        caster.intersect_all(&ray, &mut crossings);
        // On the surface t is zero exactly.
        clearance = clearance.min(caster.intersect(&ray).map_or(f64::INFINITY, |hit| hit.t));
        if crossings.len().is_multiple_of(2) || clearance == 0.0 {
            return None;
        }
    }
    Some(Place { point, clearance })
}
