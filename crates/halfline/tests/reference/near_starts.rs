//! Rays that start and end on surfaces, or nearly: the commonest rays there are, and those about which single
//! precision knows least. In batches, where what it leaves open waits for others; against brute force.

use halfline::{Hit, Mesh, Ray, Scene, Vec3, brute_force};

use crate::common::engines::{by_batch, by_brute_force};
use crate::common::{Random, meshes, soup, stairs};

/// Planks side by side and on top of each other in one plane, some of them twice, above a floor of two
/// triangles, and beams as long as all of it.
fn planks() -> Mesh {
    let mut triangles = Vec::new();
    let mut square = |x: [f64; 2], y: [f64; 2], z: f64| {
        let p = |i: usize, j: usize| Vec3::from([x[i], y[j], z]);
        triangles.extend([[p(0, 0), p(1, 0), p(1, 1)], [p(0, 0), p(1, 1), p(0, 1)]]);
    };
    square([-20.0, 20.0], [-10.0, 10.0], 0.0);
    for i in 0..60 {
        let x = f64::from(i) * 0.25 - 7.5;
        square([x, x + 0.25], [-5.0, 5.0], if i % 3 == 0 { 0.0 } else { 0.015 });
        if i % 7 == 0 {
            square([x, x + 0.3], [-5.0, 4.0], 0.0);
        }
    }
    for i in 0..20 {
        let y = f64::from(i) * 0.5 - 5.0;
        square([-20.0, 20.0], [y, y + 0.01], 3.0);
    }
    soup(triangles)
}

/// How far off the surface rays start, in terms of the scene's size: a rounding or less, to where single precision
/// tells.
const OFFSETS: [f64; 7] = [0.0, 1e-16, -1e-16, 1e-12, 3e-8, 1e-6, 2e-5];

/// Some faces of the mesh, and points on them: inside, on an edge, at a corner.
fn surface_hits(mesh: &Mesh, count: usize, random: &mut Random) -> Vec<Hit> {
    let weights = [[0.3, 0.4], [0.5, 0.5], [0.0, 0.25], [1.0, 0.0], [0.1, 0.1]];
    let hit = |i: usize| {
        let [u, v] = weights[i % weights.len()];
        Hit { t: 1.0, face: random.below(mesh.triangle_count()) as u32, u, v }
    };
    (0..count).map(hit).collect()
}

/// Rays from one place after the other, in all directions, and to other places.
fn rays_at(scene: &Scene, random: &mut Random) -> Vec<Ray> {
    let mesh = scene.mesh();
    let size = mesh.bounds().extent().length();
    let hits = surface_hits(mesh, 6, random);
    let mut rays = Vec::new();
    for (i, hit) in hits.iter().enumerate() {
        let surface = scene.surface_point(hit);
        for offset in OFFSETS {
            let start = surface.point + surface.normal * (offset * size);
            for j in 0..4 {
                let direction = random.point();
                let other = scene.surface_point(&hits[(i + j + 1) % hits.len()]);
                rays.push(Ray::new(start, direction));
                // To where it ends on the surface, as a shadow ray to a light on it does.
                rays.push(Ray { t_max: 1.0, ..Ray::new(start, other.point - start) });
                rays.push(Ray::new(surface.origin_towards(direction), direction));
            }
        }
        // And from afar to the surface, where the range ends or begins with it.
        let from = surface.point + random.point() * size;
        let along = surface.point - from;
        for step in [1.0, 1.0 - f64::EPSILON, 1.0 + f64::EPSILON, 1.0 - 1e-7] {
            rays.push(Ray { t_max: step, ..Ray::new(from, along) });
            rays.push(Ray { t_min: step, ..Ray::new(from, along) });
        }
    }
    rays.retain(Ray::is_valid);
    rays
}

#[test]
fn rays_that_start_on_surfaces_are_answered_as_by_brute_force() {
    let mut all = meshes();
    all.push(("planks", planks()));
    all.push(("stairs", stairs(8)));
    let mut random = Random(16);
    let (mut count, mut starts_behind) = (0, 0);
    for (name, mesh) in all {
        if !(1..=1200).contains(&mesh.triangle_count()) {
            continue;
        }
        let mut scene = Scene::new(mesh.clone()).expect("builds");
        let rays = rays_at(&scene, &mut random);
        for (ray, answers) in rays.iter().zip(by_batch(&mut scene, &rays)) {
            assert_eq!(answers, by_brute_force(&mesh, ray), "{name}: {ray:?}");
            // Where the line meets the mesh just before the ray's start, single precision cannot tell.
            let line = Ray { t_min: -1e-3, ..*ray };
            starts_behind += usize::from(brute_force::closest(&mesh, &line) != answers.closest);
            count += 1;
        }
    }
    assert!(count > 5_000, "only {count} rays");
    assert!(starts_behind > count / 10, "only {starts_behind} of {count} say anything");
}
