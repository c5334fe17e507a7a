//! What a tree that is a file costs: to write, to open, to the first hit, and in rays a second.
//!
//! `cargo run --release --example tree_file -- scan.ply` builds the mesh's tree and writes it beside.

use std::path::Path;
use std::time::Instant;

use halfline::geometry::vec3;
use halfline::progress::NoProgress;
use halfline::tree::Verify;
use halfline::{Ray, RayF32, Scene, Vec3};

/// Rays from outside of the scene's box to random places in it.
fn random_rays(scene: &Scene, count: usize) -> Vec<RayF32> {
    let bounds = scene.mesh().bounds();
    let mut state = 1_u64;
    let mut unit = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24)
    };
    let mut point = |share: f64| {
        let [x, y, z] = [unit(), unit(), unit()].map(|u| 0.5 + (u - 0.5) * share);
        let size = bounds.max - bounds.min;
        bounds.min + vec3(size.x * x, size.y * y, size.z * z)
    };
    let single = |v: Vec3| v.to_array().map(|x| x as f32);
    let ray = |_| {
        let (origin, target) = (point(3.0), point(1.0));
        let direction = single(target - origin);
        RayF32 { origin: single(origin), t_min: 0.0, direction, t_max: f32::INFINITY }
    };
    (0..count).map(ray).collect()
}

fn main() -> Result<(), halfline::Error> {
    let path = std::env::args().nth(1).expect("the path of a mesh");
    let tree = Path::new(&path).with_extension("hlt");
    let timed = |what: &str, start: Instant| {
        println!("{what:32} {:10.3} ms", 1e3 * start.elapsed().as_secs_f64())
    };

    let start = Instant::now();
    let mesh = halfline_io::load(Path::new(&path), &NoProgress)?;
    timed("load the mesh", start);
    let start = Instant::now();
    let scene = Scene::new(mesh)?;
    timed("build", start);
    let start = Instant::now();
    scene.save(&tree, &NoProgress)?;
    timed("save", start);

    let rays = random_rays(&scene, 2_000_000);
    let first = Ray::from(rays[0]);
    for (name, verify) in [
        ("open, untouched", Verify::IfTouched),
        ("open, verified", Verify::Always),
        ("open, not verified", Verify::Never),
    ] {
        for _ in 0..3 {
            let start = Instant::now();
            let opened = Scene::open(&tree, verify, &NoProgress)?;
            timed(name, start);
            opened.caster().intersect(&first).unwrap_or(halfline::Hit::MISS);
            timed("   and the first hit", start);
        }
    }

    let opened = Scene::open(&tree, Verify::IfTouched, &NoProgress)?;
    assert_eq!(opened.intersect_f32(&rays), scene.intersect_f32(&rays));
    for _ in 0..5 {
        for (name, scene) in [("in memory", &scene), ("from the file", &opened)] {
            let start = Instant::now();
            scene.intersect_f32(&rays);
            let rate = rays.len() as f64 / start.elapsed().as_secs_f64() * 1e-6;
            println!("{name:32} {rate:10.3} M rays/s");
        }
    }
    Ok(())
}
