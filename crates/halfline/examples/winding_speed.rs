//! How many points a second get a winding number, beside rays whose crossings are counted: on a mesh from a
//! file, and on an open one with ten thousand boundary edges.
//!
//! ```text
//! cargo run --release --example winding_speed -- MESH
//! ```

use std::time::Instant;

use halfline::mesh::Positions;
use halfline::{Mesh, Ray, Scene, Vec3, vec3};

/// How long all threads of this program were on a processor, so that others on the machine do not count; by the
/// clock where the system does not tell.
fn busy_seconds(start: Instant) -> f64 {
    let Ok(tasks) = std::fs::read_dir("/proc/self/task") else {
        return start.elapsed().as_secs_f64();
    };
    let nanoseconds = |task: std::fs::DirEntry| -> Option<f64> {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse().ok()
    };
    tasks.flatten().filter_map(nanoseconds).sum::<f64>() / 1e9
}

/// Million points a second and thread, the best of three.
fn rate(points: usize, mut work: impl FnMut()) -> f64 {
    let start = Instant::now();
    let seconds = (0..3).map(|_| {
        let before = busy_seconds(start);
        work();
        busy_seconds(start) - before
    });
    points as f64 / seconds.fold(f64::INFINITY, f64::min) / 1e6
}

fn measure(name: &str, scene: &Scene, count: usize) {
    let bounds = scene.mesh().bounds();
    let mut state = 1_u64;
    let mut number = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let size = bounds.max - bounds.min;
    let points: Vec<Vec3> = (0..count)
        .map(|_| bounds.min + vec3(number() * size.x, number() * size.y, number() * size.z))
        .collect();
    let boundary = scene.boundary();
    println!(
        "{name}: {} triangles, {} boundary edges, {} bytes, {:.3} s",
        scene.mesh().triangle_count(),
        boundary.edge_count(),
        boundary.bytes(),
        boundary.build_time().as_secs_f64()
    );
    let along = scene.explain_winding(points[0]).direction;
    let rays: Vec<Ray> = points.iter().map(|point| Ray::new(*point, along)).collect();
    let counts = rate(count, || drop(scene.count_intersections(&rays)));
    let numbers = rate(count, || drop(scene.winding_numbers(&points)));
    let inside = rate(count, || drop(scene.contains(&points)));
    println!("  million a second and thread: crossings counted {counts:.3},");
    println!("  winding numbers {numbers:.3}, contains {inside:.3}");
}

/// A bumpy bowl whose border has `edges` edges.
fn bowl(edges: u32, rows: u32) -> Mesh {
    let mut vertices = Vec::new();
    for row in 0..=rows {
        for i in 0..edges {
            let (turn, up) = (f64::from(i) / f64::from(edges), f64::from(row) / f64::from(rows));
            let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
            let noise = 0.002 * (f64::from(i * 7919 % 1000) / 1000.0);
            let radius = up.sqrt() + noise;
            vertices.push([radius * cos, radius * sin, up + noise]);
        }
    }
    vertices.push([0.0, 0.0, -0.01]);
    let tip = vertices.len() as u32 - 1;
    let mut faces = Vec::new();
    for i in 0..edges {
        let next = (i + 1) % edges;
        faces.push([tip, next, i]);
        for row in 0..rows {
            let [a, b] = [row * edges + i, row * edges + next];
            faces.extend([[a, b, b + edges], [a, b + edges, a + edges]]);
        }
    }
    Mesh::new(Positions::F64(vertices.into()), faces).expect("a valid mesh")
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let threads = std::env::var("THREADS").map_or(Ok(1), |text| text.parse())?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    for (edges, rows) in [(1_000, 100), (10_000, 10)] {
        let scene = Scene::new(bowl(edges, rows))?;
        measure(&format!("bowl of {edges}"), &scene, 200_000);
    }
    for path in std::env::args().skip(1) {
        let mesh = halfline_io::load(std::path::Path::new(&path), &halfline::NoProgress)?;
        measure(&path, &Scene::new(mesh)?, 1_000_000);
    }
    Ok(())
}
