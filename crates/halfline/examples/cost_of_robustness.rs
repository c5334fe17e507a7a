//! What the exact triangle test costs: the engine with it and with a plain one, in turn.
//!
//! `cargo run --release --features variants --example cost_of_robustness -- FILE [ROUNDS]`
//!
//! Both are the batch engine over the same tree and the same rays, on one thread. The plain one takes the rounded
//! signs and depths of single precision as they come. Prints the medians of their rates, the median of the rounds'
//! ratios, and on how many rays the plain one gives another answer.

use std::path::Path;
use std::time::Instant;

use halfline::progress::NoProgress;
use halfline::{HitF32, RayF32, Scene, Vec3, inspect};

const RAYS: usize = 400_000;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Seconds that `work` takes.
fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn single(origin: Vec3, direction: Vec3) -> RayF32 {
    let rounded = |v: Vec3| v.to_array().map(|x| x as f32);
    let (origin, direction) = (rounded(origin), rounded(direction));
    RayF32 { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
}

fn main() -> halfline::error::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(file) = arguments.first() else {
        println!("usage: cost_of_robustness FILE [ROUNDS]");
        return Ok(());
    };
    let rounds = arguments.get(1).and_then(|n| n.parse().ok()).unwrap_or(15);
    let scene = Scene::new(halfline_io::load(Path::new(file), &NoProgress)?)?;

    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
    };
    let bounds = scene.mesh().bounds();
    let size = bounds.extent().max_element();
    let eye = bounds.center() + Vec3::from([0.4, 0.3, 1.0]).normalized() * (1.5 * size);
    let width = (RAYS as f64).sqrt() as usize;
    let primary: Vec<RayF32> = (0..RAYS)
        .map(|i| {
            let [x, y] = [i % width, i / width].map(|p| p as f64 / width as f64 - 0.5);
            let target = bounds.center() + Vec3::from([x, y, -0.4 * x - 0.3 * y]) * size;
            single(eye, target - eye)
        })
        .collect();
    let mut point = || bounds.center() + Vec3::from([random(), random(), random()]) * size;
    let chords: Vec<RayF32> = (0..RAYS)
        .map(|_| {
            let from = point();
            single(from, point() - from)
        })
        .collect();

    println!("{} triangles, {RAYS} rays, {rounds} rounds", scene.mesh().triangle_count());
    println!("rays     query     exact    plain  (M rays/s)  exact takes   other answers");
    for (name, rays) in [("primary", &primary), ("chords", &chords)] {
        let mut exact = vec![HitF32::MISS; rays.len()];
        let (mut plain, mut flags) = (exact.clone(), vec![false; rays.len()]);
        let mut times = [(); 4].map(|()| Vec::new());
        let observed = scene.observed(&NoProgress);
        let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        for _ in 0..rounds {
            one_thread.install(|| {
                times[0].push(seconds(|| {
                    observed.intersect_f32_into(rays, &mut exact).expect("casts")
                }));
                times[1].push(seconds(|| inspect::intersect_plain(&scene, rays, &mut plain)));
                times[2].push(seconds(|| observed.occluded_into(rays, &mut flags).expect("casts")));
                times[3].push(seconds(|| inspect::occluded_plain(&scene, rays, &mut flags)));
            });
        }
        let different = exact.iter().zip(&plain).filter(|(e, p)| e.face != p.face).count();
        for (query, first, other) in
            [("closest", 0, format!("{different}")), ("any", 2, String::new())]
        {
            let ratios: Vec<f64> =
                times[first].iter().zip(&times[first + 1]).map(|(e, p)| e / p).collect();
            let rate = |times: &[f64]| rays.len() as f64 / median(times.to_vec()) / 1e6;
            println!(
                "{name:8} {query:8} {:6.3}   {:6.3}              {:5.3} times   {other}",
                rate(&times[first]),
                rate(&times[first + 1]),
                median(ratios),
            );
        }
    }
    Ok(())
}
