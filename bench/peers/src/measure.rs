//! One mesh: build every tool's tree, and cast every kind of rays in turns.

use std::hint::black_box;
use std::path::Path;

use halfline::progress::NoProgress;
use halfline::{HitF32, Mesh, Ray, RayF32, Scene, inspect};
use halfline_io::models::{self, Kind as Shape};
use serde_json::{Value, json};

use crate::clock::Clock;
use crate::embree::{Embree, SingleMesh};
use crate::rays::{self, Rays};
use crate::tools::{self, Built, Kind, Rivals, Tool, Way};

/// Every way is first tried on one block of rays in so many. That brings its tree into the caches
/// too, as far as it fits.
const TRIAL_BLOCK: usize = 1024;
const TRIAL_STEP: usize = 16;

/// The best of so many tries counts, so that whatever else the machine does throws nobody out.
const TRIES: usize = 3;

/// A way that takes so many times as long in the trial as the quickest of its kind is left out of
/// what follows.
const HOPELESS: f64 = 1.5;

/// Hits whose t differ by no more than this share are of the same place, whichever of the faces that
/// touch there they name.
const SAME_PLACE: f32 = 1e-3;

/// What is measured.
pub struct Plan {
    /// Turns of each tool.
    pub rounds: usize,
    /// Rays of each kind, at most.
    pub most: usize,
    pub threads: usize,
    pub rivals: Rivals,
    /// Only rays of these kinds, if there are any.
    pub only: Vec<String>,
    /// Whether nodes, leaves and the like are counted as well.
    pub is_counted: bool,
}

impl Default for Plan {
    fn default() -> Plan {
        Plan {
            rounds: 3,
            most: 1 << 20,
            threads: 1,
            rivals: Rivals::All,
            only: Vec::new(),
            is_counted: false,
        }
    }
}

/// Everything about a mesh: what the trees cost, and the seconds of each turn.
pub fn measure(name: &str, source: &str, embree: &Embree, plan: &Plan) -> Result<Value, String> {
    let clock = Clock::of(plan.threads);
    let mesh = load(source)?;
    // Embree keeps no copy, and its scenes are never released.
    let single: &'static SingleMesh = Box::leak(Box::new(SingleMesh::of(&mesh)));
    let mut built = vec![tools::halfline(mesh, clock)?];
    built.extend(tools::rivals(plan.rivals, embree, single, plan.threads));
    let Tool::Halfline(scene) = &built[0].tool else { unreachable!("halfline is the first") };
    let ways: Vec<Way> = built.iter().flat_map(|built| tools::ways(&built.tool)).collect();

    let mut cells = Vec::new();
    for kind in rays::for_scene(scene, name == "hall", plan.most) {
        if !plan.only.is_empty() && !plan.only.iter().any(|name| name == kind.name) {
            continue;
        }
        cells.push(cell(&kind, scene, &ways, clock, plan));
    }
    Ok(json!({
        "mesh": name,
        "triangles": single.triangles.len(),
        "builds": built.iter().map(Built::figures).collect::<Vec<_>>(),
        "cells": cells,
    }))
}

/// A mesh from a file, or generated: `scan:1000`.
fn load(source: &str) -> Result<Mesh, String> {
    let told = |error: halfline::Error| error.to_string();
    let generated = source.split_once(':').and_then(|(kind, triangles)| {
        Some((kind.parse::<Shape>().ok()?, triangles.parse::<usize>().ok()?))
    });
    match generated {
        Some((kind, triangles)) => models::generate(kind, triangles, 0, &NoProgress).map_err(told),
        None => halfline_io::load(Path::new(source), &NoProgress).map_err(told),
    }
}

/// Where answers go.
struct Answers {
    hits: Vec<HitF32>,
    flags: Vec<bool>,
}

impl Answers {
    /// Places for so many, all of them written to.
    fn new(count: usize) -> Answers {
        let nothing = HitF32 { t: 0.0, face: 0 };
        Answers { hits: vec![nothing; count], flags: vec![true; count] }
    }

    fn ask(&mut self, way: &Way, rays: &[RayF32], is_any: bool) {
        if is_any {
            (way.occluded)(rays, black_box(&mut self.flags));
        } else {
            (way.intersect)(rays, black_box(&mut self.hits));
        }
    }

    /// How many answers are the same, or name another face of the same place.
    fn agreeing(&self, other: &Answers, is_any: bool) -> usize {
        if is_any {
            self.flags.iter().zip(&other.flags).filter(|(a, b)| a == b).count()
        } else {
            // Two misses have the same face; the distance of a miss to anything is no number, or
            // infinite.
            let is_same = |a: &HitF32, b: &HitF32| {
                a.face == b.face || (a.t - b.t).abs() <= SAME_PLACE * b.t.min(a.t)
            };
            self.hits.iter().zip(&other.hits).filter(|(a, b)| is_same(a, b)).count()
        }
    }
}

/// One kind of rays.
fn cell(kind: &Rays, scene: &Scene, ways: &[Way], clock: Clock, plan: &Plan) -> Value {
    let (rays, is_any) = (&kind.rays, kind.is_any);

    // Try each way, compare its answers with halfline's, and leave out what is hopeless.
    let trial: Vec<RayF32> =
        rays.chunks(TRIAL_BLOCK).step_by(TRIAL_STEP).flatten().copied().collect();
    let mut ours = Answers::new(trial.len());
    let (mut trials, mut agreements) = (Vec::new(), Vec::new());
    for way in ways {
        let mut answers = Answers::new(trial.len());
        let tries = (0..TRIES).map(|_| clock.time(|| answers.ask(way, &trial, is_any)).0);
        trials.push(tries.fold(f64::INFINITY, f64::min));
        if way.kind == Kind::Halfline {
            ours = answers;
            agreements.push(1.0);
        } else {
            agreements.push(ours.agreeing(&answers, is_any) as f64 / trial.len() as f64);
        }
    }
    let quickest = |wanted: Kind| {
        let of_kind = ways.iter().zip(&trials).filter(|(way, _)| way.kind == wanted);
        of_kind.map(|(_, &seconds)| seconds).fold(f64::INFINITY, f64::min)
    };

    // Measure the others in turns.
    let mut answers = Answers::new(rays.len());
    let mut seconds = vec![Vec::new(); ways.len()];
    for _ in 0..plan.rounds {
        for ((way, &trial), seconds) in ways.iter().zip(&trials).zip(&mut seconds) {
            if trial <= HOPELESS * quickest(way.kind) {
                seconds.push(clock.time(|| answers.ask(way, rays, is_any)).0);
            }
        }
    }
    if plan.rivals == Rivals::None {
        print_alone(kind, scene, &seconds[0], clock);
    }

    let mut asked = Vec::new();
    for ((way, seconds), agreement) in ways.iter().zip(seconds).zip(agreements) {
        asked.push(json!({
            "name": way.name,
            "kind": way.kind.name(),
            "agreement": agreement,
            "seconds": seconds,
        }));
    }
    json!({
        "rays": kind.name,
        "count": rays.len(),
        "ways": asked,
        "work": plan.is_counted.then(|| work(scene, rays, is_any)),
    })
}

/// What a ray costs whatever the machine.
fn work(scene: &Scene, rays: &[RayF32], is_any: bool) -> Value {
    let counts = inspect::count_work(scene, rays, is_any);
    let per_ray = |count: u64| count as f64 / counts.rays.max(1) as f64;
    json!({
        "nodes_per_ray": per_ray(counts.nodes),
        "leaves_per_ray": per_ray(counts.leaves),
        "cache_lines_per_ray": per_ray(counts.cache_lines()),
        "exact_per_ray": per_ray(counts.exact),
    })
}

/// Rates in single precision and, where hits are asked for, in doubles.
fn print_alone(kind: &Rays, scene: &Scene, seconds: &[f64], clock: Clock) {
    let rate = |seconds: &[f64]| {
        let mut seconds = seconds.to_vec();
        seconds.sort_by(f64::total_cmp);
        kind.rays.len() as f64 / seconds[seconds.len() / 2] / 1e6
    };
    print!("{:15} {:7.2} Mrays/s", kind.name, rate(seconds));
    if !kind.is_any {
        let rays: Vec<Ray> = kind.rays.iter().map(|&ray| ray.into()).collect();
        let turns = seconds.iter().map(|_| clock.time(|| black_box(scene.intersect(&rays))).0);
        print!(", in doubles {:7.2}", rate(&turns.collect::<Vec<_>>()));
    }
    println!();
}
