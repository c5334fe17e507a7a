//! halfline against Embree: same meshes, same rays, in turns.
//!
//! `peers LIBEMBREE4 OUT.json [--rounds=N] [--rays=N] [--threads=N] [--alone=1] NAME=MESH...`
//!
//! An array of 32-byte rays goes in, and an array of t and face, or of booleans, comes out, inside
//! of what is timed. Embree is taken in every configuration (quality, packets; robust or not), and
//! the best of them, cell by cell, is what halfline is held against.

mod embree;
mod rays;

use std::path::Path;
use std::time::Instant;

use embree::{ALL_PACKETS, Embree, Packets, Quality, SingleMesh};
use halfline::progress::Silent;
use halfline::{Scene, SingleHit};
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
            "usage: peers LIBEMBREE4 OUT.json [--rounds=N] [--rays=N] [--threads=N] [--alone=1] NAME=MESH..."
        );
        std::process::exit(2);
    };
    let (mut rounds, mut most, mut threads, mut meshes) = (3, 1usize << 20, 1, Vec::new());
    let mut is_alone = false;
    for argument in arguments {
        let (name, value) = argument.split_once('=').expect("NAME=VALUE");
        let number = || value.parse::<usize>().expect("a number");
        match name {
            "--rounds" => rounds = number(),
            "--rays" => most = number(),
            "--threads" => threads = number(),
            "--alone" => is_alone = number() != 0,
            _ => meshes.push(argument),
        }
    }
    let embree = Embree::open(Path::new(&library)).expect("Embree's library");
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("threads");
    let mut rows = Vec::new();
    println!("Embree {}, {threads} thread(s), medians of {rounds}", embree.version());
    for argument in &meshes {
        let (name, path) = argument.split_once('=').expect("NAME=MESH");
        let embree = (!is_alone).then_some(&embree);
        measure(name, path, embree, rounds, most, threads, &mut rows);
    }
    let ratios: Vec<f64> = rows.iter().filter_map(|row| row["ratio"].as_f64()).collect();
    let mean = (ratios.iter().map(|r| r.ln()).sum::<f64>() / ratios.len() as f64).exp();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    println!("geometric mean {mean:.2}, worst {least:.2}");
    let text = serde_json::to_string_pretty(&rows).expect("JSON");
    std::fs::write(out, text).expect("the output can be written");
}

fn measure(
    name: &str,
    path: &str,
    embree: Option<&Embree>,
    rounds: usize,
    most: usize,
    threads: usize,
    rows: &mut Vec<serde_json::Value>,
) {
    let mesh = halfline::io::load(Path::new(path), &Silent).expect("a mesh");
    let single = Box::leak(Box::new(SingleMesh::of(&mesh)));
    let scene = Scene::new(mesh).expect("a scene");
    let bytes = scene.tree_statistics().bytes_per_triangle;
    println!("\n{name}: {} triangles, {bytes:.0} bytes each", single.triangles.len());
    println!("  build halfline {:.2} s", scene.build_time().as_secs_f64());
    let mut scenes = Vec::new();
    let all = [(Quality::High, false), (Quality::Medium, false), (Quality::High, true)];
    for (quality, robust) in embree.map_or(&all[..0], |_| &all[..]).iter().copied() {
        let Some(embree) = embree else { break };
        let start = Instant::now();
        let scene = embree.scene(single, quality, robust, threads);
        let robustness = if robust { ", robust" } else { "" };
        println!("  build Embree {quality:?}{robustness} {:.2} s", start.elapsed().as_secs_f64());
        scenes.push((quality, robust, scene));
    }

    println!(
        "  rays       halfline    Embree    ratio   Embree's best          its robust best, M rays/s"
    );
    let kinds = rays::for_scene(&scene, name == "hall", most);
    let only = std::env::var("PEERS_RAYS").unwrap_or_default();
    for kind in kinds.into_iter().filter(|kind| only.is_empty() || only == kind.name) {
        let rays = &kind.rays;
        let mut configurations: Vec<(usize, Packets)> = Vec::new();
        for number in 0..scenes.len() {
            configurations.extend(ALL_PACKETS.map(|packets| (number, packets)));
        }
        let mut times = vec![Vec::new(); configurations.len() + 1];
        let mut hits = vec![SingleHit::MISS; rays.len()];
        let mut flags = vec![false; rays.len()];
        let part = rays.len().div_ceil(threads * 8).next_multiple_of(16);
        for _ in 0..rounds {
            times[0].push(seconds(|| {
                if kind.is_any {
                    std::hint::black_box(scene.occluded(rays));
                } else {
                    std::hint::black_box(scene.intersect_single(rays));
                }
            }));
            for (&(number, packets), times) in configurations.iter().zip(&mut times[1..]) {
                let scene = &scenes[number].2;
                times.push(seconds(|| {
                    let rays = rays.par_chunks(part);
                    if kind.is_any {
                        let pairs = rays.zip(flags.par_chunks_mut(part));
                        pairs.for_each(|(rays, flags)| scene.occluded(packets, rays, flags));
                    } else {
                        let pairs = rays.zip(hits.par_chunks_mut(part));
                        pairs.for_each(|(rays, hits)| scene.intersect(packets, rays, hits));
                    }
                }));
            }
        }
        let rate = |times: &Vec<f64>| rays.len() as f64 / median(times) / 1e6;
        if configurations.is_empty() {
            println!("  {:9} {:9.2}", kind.name, rate(&times[0]));
            continue;
        }
        let best = |robust: bool| {
            let cells = configurations.iter().zip(&times[1..]);
            cells
                .filter(|((number, _), _)| scenes[*number].1 == robust)
                .map(|(&(number, packets), times)| (rate(times), scenes[number].0, packets))
                .max_by(|a, b| a.0.total_cmp(&b.0))
                .expect("a configuration")
        };
        let (ours, (theirs, quality, packets)) = (rate(&times[0]), best(false));
        let configuration = format!("{quality:?} {packets:?}");
        println!(
            "  {:9} {ours:9.2} {theirs:9.2} {:8.2}   {configuration:20} {:9.2}",
            kind.name,
            ours / theirs,
            best(true).0,
        );
        rows.push(json!({
            "mesh": name,
            "rays": kind.name,
            "threads": threads,
            "halfline": ours,
            "embree": theirs,
            "embree_config": configuration,
            "embree_robust": best(true).0,
            "ratio": ours / theirs,
        }));
    }
}
