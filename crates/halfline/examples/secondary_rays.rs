//! Counts self-hits: rays that leave a surface and come upon the very face that they leave.
//!
//! `cargo run --release --example secondary_rays -- MESH [--rays N]`
//!
//! Rays from around the mesh find points on it. From each, rays leave as light does (cosine
//! distributed), and at grazing angles down to 10^-16 on either side. They start at the origins that
//! the library offers, at the rounded points, and at the points in single precision, as it is usual.
//! Exit code 1 if one of the first kind hits its face.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use halfline::numeric::PreparedRay;
use halfline::progress::NoProgress;
use halfline::{Aabb, Error, Hit, Ray, Scene, Vec3};

/// Rays from each point: half of them cosine-distributed, half grazing.
const RAYS_PER_POINT: usize = 16;

/// Points at a time, so that memory does not grow with the number of rays.
const POINTS_PER_BATCH: usize = 1 << 16;

fn main() -> ExitCode {
    match run() {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(1),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(1)
        }
    }
}

/// The number of self-hits from the library's origins.
fn run() -> halfline::error::Result<usize> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (file, wanted) = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [file] => (file, 10_000_000),
        [file, "--rays", rays] => {
            let rays = rays.parse().map_err(|_| Error::invalid("--rays", "expected a number"))?;
            (file, rays)
        }
        _ => {
            eprintln!("usage: secondary_rays MESH [--rays N]");
            std::process::exit(2);
        }
    };
    let scene = Scene::new(halfline_io::load(Path::new(file), &NoProgress)?)?;
    println!("{file}: {} triangles", scene.mesh().triangle_count());
    let counts = count(&scene, wanted)?;
    println!("secondary rays                     {:>12}", counts.rays);
    for (name, self_hits) in [
        ("from offset origins", counts.from_offset),
        ("from points in double precision", counts.from_double),
        ("from points in single precision", counts.from_single),
    ] {
        let percent = 100.0 * self_hits as f64 / counts.rays.max(1) as f64;
        println!("self-hits {name:<33}{self_hits:>12}   {percent:.4} %");
    }
    println!(
        "speed from offset origins {:.2} million rays/s",
        counts.rays as f64 / counts.seconds / 1e6
    );
    Ok(counts.from_offset)
}

#[derive(Default)]
struct Counts {
    rays: usize,
    from_offset: usize,
    from_double: usize,
    from_single: usize,
    /// What casting the rays from offset origins took, their origins included.
    seconds: f64,
}

fn count(scene: &Scene, wanted: usize) -> halfline::error::Result<Counts> {
    let mut counts = Counts::default();
    let mut random = Random(1);
    let bounds = scene.mesh().bounds();
    while counts.rays < wanted {
        // Find points on the mesh, and directions from them.
        let left = (wanted - counts.rays).div_ceil(RAYS_PER_POINT);
        let primary: Vec<Ray> =
            (0..POINTS_PER_BATCH).map(|_| primary_ray(&bounds, &mut random)).collect();
        let hits = scene.intersect(&primary);
        let mut leaving: Vec<(Hit, Vec3)> = Vec::new();
        for (ray, hit) in primary.iter().zip(hits).filter(|(_, hit)| hit.is_hit()).take(left) {
            let normal = scene.surface_point(&hit).normal;
            let seen = if ray.direction.dot(normal) > 0.0 { -normal } else { normal };
            let directions = (0..RAYS_PER_POINT).map(|i| match i % 4 {
                0 | 1 => random.cosine_distributed(seen),
                2 => random.grazing(seen),
                _ => random.grazing(-seen),
            });
            leaving.extend(directions.map(|direction| (hit, direction)));
        }
        if leaving.is_empty() {
            return Err(Error::invalid("mesh", "no ray hits it"));
        }
        leaving.truncate(wanted - counts.rays);
        counts.rays += leaving.len();

        // Cast them from the library's origins. The face must not be hit at all, behind others
        // neither.
        let start = Instant::now();
        let rays: Vec<Ray> = leaving
            .iter()
            .map(|(hit, direction)| {
                Ray::new(scene.surface_point(hit).origin_towards(*direction), *direction)
            })
            .collect();
        let found = scene.intersect(&rays);
        counts.seconds += start.elapsed().as_secs_f64();
        for ((ray, found), (hit, _)) in rays.iter().zip(found).zip(&leaving) {
            let corners = scene.mesh().corners(hit.face);
            let meets = PreparedRay::new(ray).is_none_or(|ray| ray.meet(corners).is_some());
            counts.from_offset += usize::from(meets || found.face == hit.face);
        }

        // Cast them from the points. Only what is found first counts.
        let self_hits = |round: fn(f64) -> f64| {
            let rays: Vec<Ray> = leaving
                .iter()
                .map(|(hit, direction)| {
                    let point = scene.surface_point(hit).point;
                    Ray::new(Vec3::from(point.to_array().map(round)), *direction)
                })
                .collect();
            let found = scene.intersect(&rays);
            found.iter().zip(&leaving).filter(|(found, (hit, _))| found.face == hit.face).count()
        };
        counts.from_double += self_hits(|x| x);
        counts.from_single += self_hits(|x| f64::from(x as f32));
    }
    Ok(counts)
}

/// From around the mesh to within its box.
fn primary_ray(bounds: &Aabb, random: &mut Random) -> Ray {
    let size = bounds.extent().max_element();
    let from = bounds.center() + random.on_sphere() * (2.0 * size);
    let inside = Vec3::from([random.signed(), random.signed(), random.signed()]);
    let to = bounds.center() + bounds.extent() * inside * 0.5;
    Ray::new(from, (to - from).normalized())
}

/// A small generator of numbers (SplitMix64), so that every run is the same.
struct Random(u64);

impl Random {
    fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A unit vector, all equally likely (Archimedes).
    fn on_sphere(&mut self) -> Vec3 {
        let (z, angle) = (self.signed(), std::f64::consts::PI * self.signed());
        let radius = (1.0 - z * z).sqrt();
        Vec3::from([radius * angle.cos(), radius * angle.sin(), z])
    }

    /// A direction on the normal's side, as often as a matte surface reflects there: the normal and
    /// a unit vector.
    fn cosine_distributed(&mut self, normal: Vec3) -> Vec3 {
        let sum = normal + self.on_sphere();
        if sum == Vec3::ZERO { normal } else { sum.normalized() }
    }

    /// A direction at an angle to the surface of 1 to 10^-16, all magnitudes equally likely.
    fn grazing(&mut self, normal: Vec3) -> Vec3 {
        let across = normal.cross(self.on_sphere()).normalized();
        across + normal * 10f64.powf(8.0 * self.signed() - 8.0)
    }
}
