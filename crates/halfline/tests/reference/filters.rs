//! The single-precision filter of the leaves: it may pass over what the exact test misses, and
//! nothing else.

use crate::common::engines::{by_batch, by_engine};
use crate::common::{Random, meshes, nasty_ray};
use halfline::geometry::NO_FACE;
use halfline::numeric::{PreparedRay, Touched};
use halfline::progress::NoProgress;
use halfline::{BuildParameters, Level, Ray, Scene, Vec3, inspect};

/// Holds `ray` against every leaf of the scene, and counts the triangles, those that the filter
/// kept, and those that the ray's line meets.
fn check(name: &str, scene: &Scene, ray: &Ray) -> [u64; 3] {
    let tree = scene.tree();
    let line = Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..*ray };
    let Some(prepared) = PreparedRay::new(&line) else { return [0; 3] };
    let mut counts = [0; 3];
    for block in &tree.leaves.blocks {
        let verdict = inspect::leaf_verdict(scene, &line, block);
        let candidates = verdict.map_or(0, |verdict| verdict.candidates);
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

/// Holds `ray` against every leaf as batches do, by every instruction set: no hit within its range is
/// passed over, what is certain is true, and t is where it is said to be. Counts the triangles that
/// the ray hits, those of which that was certain, and those that were left open.
fn check_verdicts(name: &str, scene: &mut Scene, ray: &Ray) -> [u64; 3] {
    let mut counts = [0; 3];
    let line = Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..*ray };
    let (Some(prepared), Some(line)) = (PreparedRay::new(ray), PreparedRay::new(&line)) else {
        return counts;
    };
    for level in Level::available() {
        scene.set_simd_level(level);
        for block in &scene.tree().leaves.blocks {
            let Some(verdict) = inspect::leaf_verdict(scene, ray, block) else { continue };
            for (lane, &face) in
                block.faces.iter().enumerate().filter(|(_, face)| **face != NO_FACE)
            {
                let corners = scene.mesh().corners(face);
                let (is_candidate, is_certain) =
                    (verdict.candidates >> lane & 1 == 1, verdict.certain >> lane & 1 == 1);
                let hit = prepared.meet(corners);
                let place = || format!("{name}, {}: {ray:?} and {face}, {corners:?}", level.name());
                assert!(is_candidate || hit.is_none(), "{}", place());
                assert!(is_candidate || !is_certain, "{}", place());
                let is_inside = hit.is_some_and(|hit| hit.touched == Touched::Inside);
                assert!(is_inside || !is_certain, "certain, but not hit: {}", place());
                let Some(contact) = line.meet(corners) else { continue };
                let [low, high] = verdict.bounds[lane];
                assert!(low <= contact.t && contact.t <= high, "{low} {high}, {}", place());
                counts[0] += u64::from(hit.is_some());
                counts[1] += u64::from(is_certain);
                counts[2] += u64::from(is_candidate && !is_certain);
            }
        }
    }
    counts
}

#[test]
fn verdicts_of_batches_are_true() {
    let mut random = Random(15);
    for (name, mut scene) in scenes() {
        let mut total = [0; 3];
        for _ in 0..300 {
            let ray = nasty_ray(scene.mesh(), &[], &mut random);
            let counts = check_verdicts(name, &mut scene, &ray);
            total = [0, 1, 2].map(|i| total[i] + counts[i]);
        }
        let is_empty = scene.mesh().triangle_count() == 0;
        assert!(is_empty || total[0] > 0, "{name}: {total:?}");
    }
}

/// Triangles so small, or so thin, that single precision hardly knows them from points and lines, all of
/// one depth: here the place of a hit would be found from weights that are nothing but errors.
#[test]
fn crumbs_are_where_they_are() {
    let mut random = Random(17);
    let mut corners = Vec::new();
    let crumbs = (0..1200).map(|i| {
        let size = 2f64.powi(-(i % 3) * 7 - random.below(14) as i32);
        let center = random.point();
        let at = |random: &mut Random| {
            center + Vec3::from([random.signed() * size, random.signed() * size, 0.0])
        };
        let (a, b) = (at(&mut random), at(&mut random));
        let share = random.unit();
        let thin = Vec3::from([random.signed(), random.signed(), 0.0]) * (size * 1e-9);
        let c = if i % 2 == 0 { at(&mut random) } else { a * share + b * (1.0 - share) + thin };
        corners.push([a, b, c]);
        [a, b, c]
    });
    let mesh = crate::common::soup(crumbs.collect::<Vec<_>>());
    let few_in_a_cell =
        BuildParameters::default().with_spatial_split_min_triangles(8).with_duplication_budget(8.0);
    let mut scene = Scene::builder(mesh)
        .parameters(few_in_a_cell)
        .observer(&NoProgress)
        .build()
        .expect("builds");
    let mut rays = Vec::new();
    for [a, b, c] in corners {
        for _ in 0..4 {
            let aim = [a, c, a * 0.3 + b * 0.3 + c * 0.4][random.below(3)];
            let slant = Vec3::from([random.signed() * 0.9, random.signed() * 0.9, 1.0]);
            let way = 2f64.powi(random.below(8) as i32 - 4);
            rays.push(Ray::new(aim - slant * way, slant));
        }
    }
    let mut total = 0;
    for ray in rays.iter().step_by(8) {
        total += check_verdicts("crumbs", &mut scene, ray)[0];
    }
    assert!(total > 100, "{total}");
    for (ray, answers) in rays.iter().zip(by_batch(&mut scene, &rays)) {
        assert_eq!(answers, by_engine(&scene, ray), "{ray:?}");
    }
}

/// Hits that are plain are certain, so that batches need no exact test for them.
#[test]
fn plain_hits_are_certain() {
    let mut random = Random(16);
    for (name, mut scene) in scenes().into_iter().filter(|(name, _)| name.contains("sphere")) {
        let bounds = scene.mesh().bounds();
        let mut total = [0; 3];
        for _ in 0..300 {
            let size = bounds.extent().max_element();
            let [from, to] = [0; 2].map(|_| bounds.center() + random.point() * size);
            let counts = check_verdicts(name, &mut scene, &Ray::new(from, to - from));
            total = [0, 1, 2].map(|i| total[i] + counts[i]);
        }
        let [hit, certain, _] = total;
        assert!(hit > 100 && certain * 100 >= hit * 99, "{name}: {total:?}");
    }
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let few_in_a_cell =
        BuildParameters::default().with_spatial_split_min_triangles(8).with_duplication_budget(8.0);
    meshes()
        .into_iter()
        .map(|(name, mesh)| {
            (
                name,
                Scene::builder(mesh)
                    .parameters(few_in_a_cell)
                    .observer(&NoProgress)
                    .build()
                    .expect("builds"),
            )
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
