//! The single-precision filter of the leaves: it may pass over what the exact test misses, and
//! nothing else.

mod common;

use common::{Random, meshes, nasty_ray};
use halfline::build::BuildParameters;
use halfline::geometry::NO_FACE;
use halfline::numeric::{LeafFilter, PreparedRay};
use halfline::progress::Silent;
use halfline::{Ray, Scene, Vec3};

/// Holds `ray` against every leaf of the scene, and counts the triangles, those that the filter
/// kept, and those that the ray's line meets.
fn check(name: &str, scene: &Scene, ray: &Ray) -> [u64; 3] {
    let tree = scene.tree();
    let line = Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..*ray };
    let Some(prepared) = PreparedRay::new(&line) else { return [0; 3] };
    let filter = LeafFilter::new(&line, &tree.frame, tree.reach);
    let mut counts = [0; 3];
    for block in &tree.leaves.blocks {
        let candidates = filter.candidates(&block.corners);
        for (lane, &face) in block.faces.iter().enumerate() {
            let is_candidate = candidates >> lane & 1 == 1;
            if face == NO_FACE {
                continue;
            }
            let corners = scene.mesh().corners(face);
            let is_met = prepared.meet(corners).is_some();
            assert!(is_candidate || !is_met, "{name}: {ray:?} meets face {face}, {corners:?}");
            counts[0] += 1;
            counts[1] += u64::from(is_candidate);
            counts[2] += u64::from(is_met);
        }
    }
    counts
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let few_in_a_cell = BuildParameters { last_cell_triangles: 8, spare_references: 8.0 };
    meshes()
        .into_iter()
        .map(|(name, mesh)| {
            (name, Scene::build_with(mesh, &few_in_a_cell, &Silent).expect("builds"))
        })
        .collect()
}

#[test]
fn what_is_met_is_a_candidate() {
    let mut random = Random(5);
    for (name, scene) in scenes() {
        let mut total = [0; 3];
        for _ in 0..400 {
            let ray = nasty_ray(scene.mesh(), &[], &mut random);
            let counts = check(name, &scene, &ray);
            total = [0, 1, 2].map(|i| total[i] + counts[i]);
        }
        assert!(total[2] > 0 || total[0] == 0, "{name}: {total:?}");
    }
}

/// Rays past an edge at distances around what single precision can tell, from near and far: here
/// the filter is as wrong as it can be.
#[test]
fn rays_beside_edges() {
    let mut random = Random(6);
    for (name, scene) in scenes() {
        let mesh = scene.mesh();
        let size = mesh.bounds().extent().max_element();
        if mesh.triangle_count() == 0 || !size.is_finite() {
            continue;
        }
        for _ in 0..300 {
            let [a, b, c] = mesh.corners(random.below(mesh.triangle_count()) as u32);
            if ![a, b, c].into_iter().all(Vec3::is_finite) {
                continue;
            }
            let share = random.unit();
            let beside = random.point() * (size * 2f64.powi(-20 - random.below(10) as i32));
            let target = a * share + b * (1.0 - share) + beside;
            let distance = size * 2f64.powi(random.below(40) as i32 - 10);
            let origin = target + random.point() * distance;
            check(name, &scene, &Ray::new(origin, target - origin));
        }
    }
}

#[test]
fn few_candidates_are_missed() {
    let mut random = Random(7);
    for (name, scene) in scenes().into_iter().filter(|(name, _)| name.contains("sphere")) {
        let bounds = scene.mesh().bounds();
        let mut total = [0; 3];
        for _ in 0..1000 {
            let size = bounds.extent().max_element();
            let [from, to] = [0; 2].map(|_| bounds.center() + random.point() * size);
            let counts = check(name, &scene, &Ray::new(from, to - from));
            total = [0, 1, 2].map(|i| total[i] + counts[i]);
        }
        let [all, candidates, met] = total;
        assert!(met * 100 < all, "{name}: {total:?}");
        assert!(candidates - met <= all / 5000, "{name}: {total:?}");
    }
}
