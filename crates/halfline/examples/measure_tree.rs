//! Loads a mesh, builds its tree and casts rays at it: prints times, sizes and counts.
//!
//! `cargo run --release --example measure_tree -- FILE [spatial_split_min_triangles [duplication_budget]]`

use std::path::Path;
use std::time::Instant;

use halfline::inspect::RayCounters;
use halfline::progress::NoProgress;
use halfline::{BuildParameters, Ray, Scene, Vec3};

fn main() -> halfline::error::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(file) = arguments.first() else {
        println!("usage: measure_tree FILE [spatial_split_min_triangles [duplication_budget]]");
        return Ok(());
    };
    let mut parameters = BuildParameters::default();
    if let Some(number) = arguments.get(1).and_then(|n| n.parse().ok()) {
        parameters.spatial_split_min_triangles = number;
    }
    if let Some(number) = arguments.get(2).and_then(|n| n.parse().ok()) {
        parameters.duplication_budget = number;
    }

    let start = Instant::now();
    let mesh = halfline_io::load(Path::new(file), &NoProgress)?;
    println!("load   {:.3} s, {} triangles", start.elapsed().as_secs_f64(), mesh.triangle_count());
    let scene = Scene::builder(mesh).parameters(parameters).observer(&NoProgress).build()?;
    println!("build  {:.3} s", scene.build_time().as_secs_f64());
    let statistics = scene.statistics();
    println!("{statistics:#.2?}");

    // Primary rays through a square of pixels, and chords between random points around the mesh.
    let bounds = scene.mesh().bounds();
    let size = bounds.extent().max_element();
    let eye = bounds.center() + Vec3::from([0.4, 0.3, 1.0]).normalized() * (2.0 * size);
    let pixels = 700;
    let primary: Vec<Ray> = (0..pixels * pixels)
        .map(|i| {
            let x = f64::from(i % pixels) / f64::from(pixels) - 0.5;
            let y = f64::from(i / pixels) / f64::from(pixels) - 0.5;
            let target = bounds.center() + Vec3::from([x, y, -0.4 * x - 0.3 * y]) * size;
            Ray::new(eye, target - eye)
        })
        .collect();
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
    };
    let mut point = || bounds.center() + Vec3::from([random(), random(), random()]) * (1.2 * size);
    let chords: Vec<Ray> = (0..500_000)
        .map(|_| {
            let from = point();
            Ray::new(from, point() - from)
        })
        .collect();

    for (name, rays) in [("primary", primary), ("chords", chords)] {
        let start = Instant::now();
        let hits = scene.intersect(&rays).iter().filter(|hit| hit.is_hit()).count();
        let closest_seconds = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let occluded = scene.occluded(&rays).into_iter().filter(|&hit| hit).count();
        let any_seconds = start.elapsed().as_secs_f64();
        assert_eq!(hits, occluded);
        let mut counters = RayCounters::default();
        let mut caster = scene.caster();
        for ray in &rays[..rays.len().min(100_000)] {
            caster.intersect_counted(ray, &mut counters);
        }
        let per_ray = |count: u32| f64::from(count) / rays.len().min(100_000) as f64;
        println!(
            "{name:8} {:6.2} closest, {:6.2} any (M rays/s); {:.1} nodes, {:.1} leaves, {:.1} triangles a ray; {:.0} % hit",
            rays.len() as f64 / closest_seconds / 1e6,
            rays.len() as f64 / any_seconds / 1e6,
            per_ray(counters.nodes),
            per_ray(counters.leaves),
            per_ray(counters.triangles),
            100.0 * hits as f64 / rays.len() as f64,
        );
    }
    Ok(())
}
