//! halfline against Embree: same meshes, same rays, in turns.
//!
//! `peers LIBEMBREE4 OUT.json [--rounds=N] [--rays=N] [--threads=N] [--alone=1] [--only=RAYS]
//! NAME=MESH...`
//!
//! An array of 32-byte rays goes in, and an array of t and face, or of booleans, comes out, inside
//! of what is timed. Embree is taken in every configuration (quality, packets; robust or not), and
//! the best of them, cell by cell, is what halfline is held against. obvhs, a Rust crate, is asked too.

mod embree;
mod obvhs_peer;
mod rays;

use std::path::Path;
use std::time::Instant;

use embree::{ALL_PACKETS, Embree, Packets, Quality, SingleMesh};
use halfline::progress::Silent;
use halfline::{Ray, Scene, SingleHit, SingleRay};
use obvhs_peer::{Obvhs, Tree};
use rayon::prelude::*;
use serde_json::json;

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (Some(library), Some(out)) = (arguments.next(), arguments.next()) else {
        eprintln!(
            "usage: peers LIBEMBREE4 OUT.json [--rounds=N] [--rays=N] [--threads=N] [--alone=1] [--only=RAYS] NAME=MESH..."
        );
        std::process::exit(2);
    };
    let mut plan =
        Plan { rounds: 3, most: 1 << 20, threads: 1, is_alone: false, only: String::new() };
    let mut meshes = Vec::new();
    for argument in arguments {
        let (name, value) = argument.split_once('=').expect("NAME=VALUE");
        let number = || value.parse::<usize>().expect("a number");
        match name {
            "--rounds" => plan.rounds = number(),
            "--rays" => plan.most = number(),
            "--threads" => plan.threads = number(),
            "--alone" => plan.is_alone = number() != 0,
            "--only" => plan.only = value.to_string(),
            _ => meshes.push(argument),
        }
    }
    let (rounds, threads) = (plan.rounds, plan.threads);
    let embree = Embree::open(Path::new(&library)).expect("Embree's library");
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("threads");
    let mut rows = Vec::new();
    println!("Embree {}, {threads} thread(s), medians of {rounds}", embree.version());
    for argument in &meshes {
        let (name, path) = argument.split_once('=').expect("NAME=MESH");
        measure(name, path, &embree, &plan, &mut rows);
    }
    let ratios: Vec<f64> = rows.iter().filter_map(|row| row["ratio"].as_f64()).collect();
    let mean = (ratios.iter().map(|r| r.ln()).sum::<f64>() / ratios.len() as f64).exp();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    println!("geometric mean {mean:.2}, worst {least:.2}");
    let text = serde_json::to_string_pretty(&rows).expect("JSON");
    std::fs::write(out, text).expect("the output can be written");
}

/// A rival, ready to be asked.
enum Rival<'a> {
    Embree { scene: embree::Scene<'a>, quality: Quality, is_robust: bool, packets: Vec<Packets> },
    Obvhs(Box<Obvhs>),
}

/// Casts rays, each with a place for its answer.
type Casts<'a, Answer> = Box<dyn Fn(&[SingleRay], &mut [Answer]) + Sync + 'a>;

/// One way to ask a rival.
struct Way<'a> {
    name: String,
    kind: Kind,
    intersect: Casts<'a, SingleHit>,
    occluded: Casts<'a, bool>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Embree,
    RobustEmbree,
    Obvhs,
}

fn ways<'a>(rivals: &'a [Rival]) -> Vec<Way<'a>> {
    let mut ways = Vec::new();
    for rival in rivals {
        match rival {
            Rival::Embree { scene, quality, is_robust, packets } => {
                ways.extend(packets.iter().map(|&packets| Way {
                    name: format!("{quality:?} {packets:?}"),
                    kind: if *is_robust { Kind::RobustEmbree } else { Kind::Embree },
                    intersect: Box::new(move |rays, hits| scene.intersect(packets, rays, hits)),
                    occluded: Box::new(move |rays, flags| scene.occluded(packets, rays, flags)),
                }));
            }
            Rival::Obvhs(trees) => ways.extend([Tree::Binary, Tree::Wide].map(|tree| Way {
                name: format!("{tree:?}"),
                kind: Kind::Obvhs,
                intersect: Box::new(move |rays, hits| trees.intersect(tree, rays, hits)),
                occluded: Box::new(move |rays, flags| trees.occluded(tree, rays, flags)),
            })),
        }
    }
    ways
}

/// Builds what each rival has, and tells how long that takes.
fn rivals<'a>(embree: &'a Embree, single: &'static SingleMesh, threads: usize) -> Vec<Rival<'a>> {
    let mut rivals = Vec::new();
    for (quality, is_robust) in
        [(Quality::High, false), (Quality::Medium, false), (Quality::High, true)]
    {
        let start = Instant::now();
        let scene = embree.scene(single, quality, is_robust, threads);
        let robustness = if is_robust { ", robust" } else { "" };
        println!("  build Embree {quality:?}{robustness} {:.2} s", start.elapsed().as_secs_f64());
        let packets = ALL_PACKETS.to_vec();
        rivals.push(Rival::Embree { scene, quality, is_robust, packets });
    }
    let start = Instant::now();
    let trees = Obvhs::new(single);
    println!("  build obvhs, both trees, one thread {:.2} s", start.elapsed().as_secs_f64());
    rivals.push(Rival::Obvhs(Box::new(trees)));
    rivals
}

/// What is measured.
struct Plan {
    rounds: usize,
    /// Rays of each kind, at most.
    most: usize,
    threads: usize,
    /// Without rivals.
    is_alone: bool,
    /// Only rays of this kind, if it is not empty.
    only: String,
}

fn measure(
    name: &str,
    path: &str,
    embree: &Embree,
    plan: &Plan,
    rows: &mut Vec<serde_json::Value>,
) {
    let mesh = halfline::io::load(Path::new(path), &Silent).expect("a mesh");
    let single: &'static SingleMesh = Box::leak(Box::new(SingleMesh::of(&mesh)));
    let scene = Scene::new(mesh).expect("a scene");
    let bytes = scene.tree_statistics().bytes_per_triangle;
    println!("\n{name}: {} triangles, {bytes:.0} bytes each", single.triangles.len());
    println!("  build halfline {:.2} s", scene.build_time().as_secs_f64());
    let rivals = if plan.is_alone { Vec::new() } else { rivals(embree, single, plan.threads) };
    let ways = ways(&rivals);

    println!("  M rays/s   halfline    Embree    ratio   Embree's best     robust best     obvhs");
    for kind in rays::for_scene(&scene, name == "hall", plan.most) {
        if !plan.only.is_empty() && plan.only != kind.name {
            continue;
        }
        let rays = &kind.rays;
        let (mut ours, mut times) = (Vec::new(), vec![Vec::new(); ways.len()]);
        let mut hits = vec![SingleHit::MISS; rays.len()];
        let mut flags = vec![false; rays.len()];
        let part = rays.len().div_ceil(plan.threads * 8).next_multiple_of(16);
        for _ in 0..plan.rounds {
            ours.push(seconds(|| {
                if kind.is_any {
                    std::hint::black_box(scene.occluded(rays));
                } else {
                    std::hint::black_box(scene.intersect_single(rays));
                }
            }));
            for (way, times) in ways.iter().zip(&mut times) {
                times.push(seconds(|| {
                    let rays = rays.par_chunks(part);
                    if kind.is_any {
                        let pairs = rays.zip(flags.par_chunks_mut(part));
                        pairs.for_each(|(rays, flags)| (way.occluded)(rays, flags));
                    } else {
                        let pairs = rays.zip(hits.par_chunks_mut(part));
                        pairs.for_each(|(rays, hits)| (way.intersect)(rays, hits));
                    }
                }));
            }
        }
        let rate = |times: &[f64]| rays.len() as f64 / median(times) / 1e6;
        let best = |wanted: Kind| {
            let rates = ways.iter().zip(&times).filter(|(way, _)| way.kind == wanted);
            let rates = rates.map(|(way, times)| (rate(times), way.name.as_str()));
            rates.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NAN, "not asked"))
        };
        let ours_rate = rate(&ours);
        let (theirs, configuration) = best(Kind::Embree);
        let (robust, obvhs) = (best(Kind::RobustEmbree).0, best(Kind::Obvhs).0);
        if plan.is_alone {
            println!("  {:9} {ours_rate:9.2}", kind.name);
            if !kind.is_any {
                let rays: Vec<Ray> = rays.iter().map(|&ray| ray.into()).collect();
                let turns = (0..plan.rounds).map(|_| {
                    seconds(|| {
                        std::hint::black_box(scene.intersect(&rays));
                    })
                });
                println!("   in doubles {:7.2}", rate(&turns.collect::<Vec<_>>()));
            }
            continue;
        }
        println!(
            "  {:9} {ours_rate:9.2} {theirs:9.2} {:8.2}   {configuration:20} {robust:9.2} {obvhs:9.2}",
            kind.name,
            ours_rate / theirs,
        );
        // How far the turns differ, as a share of the median.
        let spread = |times: &[f64]| {
            let slowest = times.iter().copied().fold(0.0, f64::max);
            let quickest = times.iter().copied().fold(f64::INFINITY, f64::min);
            (slowest - quickest) / median(times)
        };
        rows.push(json!({
            "mesh": name,
            "rays": kind.name,
            "threads": plan.threads,
            "halfline": ours_rate,
            "halfline_spread": spread(&ours),
            "embree": theirs,
            "embree_config": configuration,
            "embree_robust": robust,
            "obvhs": obvhs,
            "ratio": ours_rate / theirs,
        }));
    }
}
