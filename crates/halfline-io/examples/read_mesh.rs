//! Reads a mesh file and says how fast: `read_mesh FILE`, or writes one to read first:
//! `read_mesh --make TRIANGLES FILE`.

use std::path::Path;
use std::time::Instant;

use halfline::Mesh;
use halfline::mesh::Positions;
use halfline::progress::NoProgress;
use halfline_io::{load, save_ply};

/// Loads of the same file; the first may have to wait for the disk.
const LOADS: usize = 5;

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(1);
    }
}

fn run() -> halfline::error::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [file] => read(Path::new(file)),
        ["--make", triangles, file] => {
            let triangles = triangles.parse().map_err(|_| {
                halfline::Error::invalid("--make", "expected a number of triangles")
            })?;
            make(triangles, Path::new(file))
        }
        _ => {
            eprintln!("usage: read_mesh FILE, or read_mesh --make TRIANGLES FILE");
            std::process::exit(2);
        }
    }
}

fn read(path: &Path) -> halfline::error::Result<()> {
    let megabytes =
        std::fs::metadata(path).map_err(|e| halfline::Error::io(path, e))?.len() as f64 / 1e6;
    for _ in 0..LOADS {
        let start = Instant::now();
        let mesh = load(path, &NoProgress)?;
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{} vertices, {} triangles in {seconds:.4} s: {:.0} MB/s",
            mesh.positions().len(),
            mesh.triangle_count(),
            megabytes / seconds
        );
    }
    Ok(())
}

/// Writes a wavy square of at least `triangles` triangles.
fn make(triangles: usize, path: &Path) -> halfline::error::Result<()> {
    let n = ((triangles as f64 / 2.0).sqrt().ceil() as u32).max(1);
    let positions = (0..=n).flat_map(|j| {
        (0..=n).map(move |i| {
            let (x, y) = (i as f32 / n as f32, j as f32 / n as f32);
            [x, y, 0.1 * (20.0 * x).sin() * (30.0 * y).cos()]
        })
    });
    let faces = (0..n).flat_map(|j| {
        (0..n).flat_map(move |i| {
            let a = j * (n + 1) + i;
            [[a, a + 1, a + n + 1], [a + 1, a + n + 2, a + n + 1]]
        })
    });
    let mesh = Mesh::new(Positions::F32(positions.collect()), faces.collect::<Vec<_>>())?;
    let start = Instant::now();
    save_ply(&mesh, path, &NoProgress)?;
    println!(
        "{} triangles written in {:.3} s",
        mesh.triangle_count(),
        start.elapsed().as_secs_f64()
    );
    Ok(())
}
