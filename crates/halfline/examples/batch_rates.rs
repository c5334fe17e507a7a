//! Millions of rays a second on one thread, by each instruction set of this machine, in turn.
//!
//! `cargo run --release --example batch_rates -- FILE [ROUNDS]`

use std::path::Path;
use std::time::Instant;

use halfline::progress::Silent;
use halfline::simd::Level;
use halfline::{Ray, Scene, Vec3};

const RAYS: usize = 1 << 20;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> halfline::error::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(file) = arguments.first() else {
        println!("usage: batch_rates FILE [ROUNDS]");
        return Ok(());
    };
    let rounds = arguments.get(1).and_then(|n| n.parse().ok()).unwrap_or(5);
    let mut scene = Scene::new(halfline::io::load(Path::new(file), &Silent)?)?;
    let statistics = scene.tree_statistics();
    println!(
        "{} triangles, built in {:.2} s, {:.1} bytes a triangle, {} wide nodes, {} waiting",
        scene.mesh().triangle_count(),
        scene.build_time().as_secs_f64(),
        statistics.bytes_per_triangle,
        scene.tree().wide.nodes.len(),
        scene.tree().wide.most_waiting,
    );

    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
    };
    let bounds = scene.mesh().bounds();
    let size = bounds.extent().max_element();
    let eye = bounds.center() + Vec3::from([0.4, 0.3, 1.0]).normalized() * (1.5 * size);
    let width = (RAYS as f64).sqrt() as usize;
    let primary: Vec<Ray> = (0..RAYS)
        .map(|i| {
            let [x, y] = [i % width, i / width].map(|p| p as f64 / width as f64 - 0.5);
            let target = bounds.center() + Vec3::from([x, y, -0.4 * x - 0.3 * y]) * size;
            Ray::new(eye, target - eye)
        })
        .collect();
    let mut point = || bounds.center() + Vec3::from([random(), random(), random()]) * size;
    let chords: Vec<Ray> = (0..RAYS)
        .map(|_| {
            let from = point();
            Ray::new(from, point() - from)
        })
        .collect();

    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    println!("rays     query     level    M rays/s");
    for (name, rays) in [("primary", &primary), ("chords", &chords)] {
        let levels = Level::available();
        let mut times = vec![[Vec::new(), Vec::new()]; levels.len()];
        for _ in 0..rounds {
            for (level, times) in levels.iter().zip(&mut times) {
                scene.set_simd_level(*level);
                let start = Instant::now();
                std::hint::black_box(pool.install(|| scene.intersect(rays)));
                times[0].push(start.elapsed().as_secs_f64());
                let start = Instant::now();
                std::hint::black_box(pool.install(|| scene.occluded(rays)));
                times[1].push(start.elapsed().as_secs_f64());
            }
        }
        for (i, query) in ["closest", "any"].into_iter().enumerate() {
            for (level, times) in levels.iter().zip(&times) {
                let rate = rays.len() as f64 / median(times[i].clone()) / 1e6;
                println!("{name:8} {query:8}  {:7} {rate:7.3}", level.name());
            }
        }
    }
    Ok(())
}
