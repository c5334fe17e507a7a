//! The judge must see every way in which a ray goes wrong.

use super::*;
use crate::topology::examine;
use halfline::geometry::{Hit, vec3};
use halfline::mesh::{Mesh, Positions};
use halfline::progress::NoProgress;
use halfline_io::models::{Kind, generate};

fn hit(t: f64) -> Hit {
    Hit { t, face: 0, u: 0.0, v: 0.0 }
}

#[test]
fn every_wrong_answer_is_seen() {
    let right = Wrong::default();
    let leak = Wrong { leak: true, ..right };
    let parity = Wrong { parity: true, ..right };
    let late = Wrong { late: true, ..right };
    let miss = Hit::MISS;
    let hits = [hit(1.0), hit(2.0), hit(3.0)];
    for (inside, certain, closest, crossings, expected) in [
        (true, true, hit(1.0), &hits[..1], right),
        (true, false, hit(1.5), &hits[1..2], right),
        (true, false, hit(0.5), &hits[..], right),
        (true, false, hit(1.0), &hits[..2], parity),
        (true, false, hit(1.0), &[], parity),
        (true, false, miss, &[], Wrong { leak: true, parity: true, late: false }),
        (true, false, miss, &hits[..1], leak),
        (true, false, hit(2.0), &hits[..1], late),
        (true, true, hit(2.0), &hits[1..2], late),
        (false, true, hit(1.0), &[], right),
        (false, true, hit(1.0), &hits[..2], right),
        (false, true, miss, &[], leak),
        (false, true, hit(1.0 + f64::EPSILON), &[], late),
        (false, false, miss, &[], right),
        (false, false, hit(7.0), &[], right),
        (false, false, miss, &hits[..1], leak),
    ] {
        let found = judge(inside, certain, &closest, crossings);
        assert_eq!(found, expected, "{inside} {certain} {closest:?} {crossings:?}");
    }
}

#[test]
fn certain_are_rays_without_rounding_off_the_plane() {
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.1]];
    let mesh = Mesh::new(Positions::F64(corners.into()), vec![[0, 1, 2]]).unwrap();
    let vertex = |corner| Target::Vertex { face: 0, corner };
    let edge = |edge| Target::EdgeMidpoint { face: 0, edge };
    let above = vec3(0.25, 0.25, 4.0);
    for (target, origin, expected) in [
        (vertex(0), above, true),
        // 0.1 - 4 is no double, but 0.1 - 0.125 is.
        (vertex(2), above, false),
        (vertex(2), vec3(0.25, 0.25, 0.125), true),
        (edge(0), above, true),
        (edge(1), above, false),
        (vertex(1), vec3(3.0, 0.0, 0.0), false),
        (vertex(1), vec3(3.0, 1e-300, 0.0), false),
        (edge(0), vec3(1e-3, 0.25, 4.0), false),
    ] {
        let ray = Ray::new(origin, target.position(&mesh) - origin);
        assert_eq!(certainly_meets(&ray, target, &mesh), expected, "{target:?} {origin:?}");
    }
    let ray = Ray::new(above, vec3(0.0, 0.0, -1.0));
    assert!(!certainly_meets(&ray, vertex(0), &mesh), "it is not aimed there");
}

#[test]
fn rays_are_shared_out() {
    assert_eq!(shares(100, 40, 4), [40, 20, 20, 20]);
    assert_eq!(shares(1000, 40, 4), [40, 40, 40, 40]);
    assert_eq!(shares(42, 40, 4), [40, 1, 1, 0]);
    assert_eq!(shares(10, 40, 4), [3, 3, 2, 2]);
    assert_eq!(shares(10, 40, 1), [10]);
    assert_eq!(shares(100, 40, 1), [40]);
}

#[test]
fn targets_are_spread_evenly() {
    for (count, total) in [(1, 1), (7, 7), (3, 10), (999, 1000), (5, 1_000_003)] {
        let chosen: Vec<usize> = (0..count).map(|i| stratum(i, count, total, 5)).collect();
        for (i, &target) in chosen.iter().enumerate() {
            assert!((i * total / count..(i + 1) * total / count).contains(&target));
        }
    }
    assert_ne!(stratum(2, 5, 1_000_003, 5), stratum(2, 5, 1_000_003, 6));
}

fn aimed(mesh: Mesh, rays: usize) -> LeakReport {
    let topology = examine(&mesh, &NoProgress).unwrap();
    let scene = Scene::new(mesh).unwrap();
    aim(&scene, &topology, &Options { rays, seed: 3 }, &NoProgress).unwrap()
}

#[test]
fn a_sphere_is_aimed_at_from_four_points_inside() {
    let sphere = generate(Kind::Sphere, 1200, 0, &NoProgress).unwrap();
    // 602 vertices and 1,800 edges.
    let report = aimed(sphere, 10_000);
    assert!(report.from_inside && report.is_clean(), "{report:?}");
    assert_eq!((report.targets, report.rays), (2402, 4 * 2402));
    assert_eq!(report.origins.len(), 4);
    assert_eq!(report.origins[0], Vec3::ZERO);
    assert!(report.origins.iter().all(|o| o.length() < 1.0));
    // A sphere is crossed once from inside.
    assert_eq!(report.crossings, report.rays);
    assert!(report.certain_rays > report.rays / 2, "{report:?}");
}

#[test]
fn every_ray_through_a_hole_is_seen() {
    let sphere = generate(Kind::Sphere, 1200, 0, &NoProgress).unwrap();
    let topology = examine(&sphere, &NoProgress).unwrap();
    // Collapse the faces around a vertex, of which the topology does not know.
    let lost = 77;
    let mut triangles = sphere.triangles().to_vec();
    let around: Vec<_> = triangles.iter_mut().filter(|t| t.contains(&lost)).collect();
    let spokes = around.len() as u64;
    around.into_iter().for_each(|t| *t = [t[0]; 3]);
    let holed = Mesh::new(sphere.positions().clone(), triangles).unwrap();
    // A collapsed face has no middle of an edge to aim at, so aim by the whole one.
    let scene = Scene::new(holed).unwrap();
    let mut report = LeakReport { from_inside: true, ..LeakReport::default() };
    let targets: Vec<Target> = (0..topology.target_count()).map(|i| topology.target(i)).collect();
    let rays: Vec<Ray> =
        targets.iter().map(|t| Ray::new(Vec3::ZERO, t.position(&sphere))).collect();
    report.cast_rays(&scene, &rays, &targets, &NoProgress).unwrap();
    // The vertex and the middles of the edges at it are lost; those of the rim are touched.
    assert_eq!((report.leaks, report.late_hits), (1 + spokes, 0));
    assert!((1 + spokes..1 + 3 * spokes).contains(&report.wrong_parities), "{report:?}");
    assert_eq!(report.examples.len(), EXAMPLES);
    let leaks = report.examples.iter().filter(|e| e.wrong.leak);
    assert!(leaks.clone().count() > 0 && !report.is_clean());
    for leak in leaks {
        assert_eq!((leak.closest_t, leak.crossings), (f64::INFINITY, 0));
        assert!(!scene.caster().occluded(&leak.ray));
    }
}

#[test]
fn the_middle_of_a_torus_is_not_inside() {
    let torus = torus(24, 12);
    let report = aimed(torus, 100_000);
    assert!(report.from_inside && report.is_clean(), "{report:?}");
    assert_eq!(report.rays, 4 * (288 + 864));
    for o in &report.origins {
        let from_ring = vec3(o.x.hypot(o.y) - 2.0, 0.0, o.z).length();
        assert!(from_ring < 1.0, "{o:?}");
    }
}

/// A torus with radii 2 and 1 around the z axis.
fn torus(around: u32, through: u32) -> Mesh {
    let turn = std::f64::consts::TAU;
    let angle = |i: u32, n: u32| turn * f64::from(i) / f64::from(n);
    let vertices = (0..around * through).map(|i| {
        let (phi, theta) = (angle(i / through, around), angle(i % through, through));
        let r = 2.0 + theta.cos();
        [r * phi.cos(), r * phi.sin(), theta.sin()]
    });
    let vertex = |i: u32, j: u32| i % around * through + j % through;
    let triangles = (0..around * through).flat_map(|n| {
        let (i, j) = (n / through, n % through);
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    Mesh::new(Positions::F64(vertices.collect()), triangles.collect::<Vec<_>>()).unwrap()
}

#[test]
fn a_flat_sheet_is_aimed_at_from_off_its_plane() {
    let corners = vec![[0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [1.0, 1.0, 3.0], [0.0, 1.0, 3.0]];
    let mesh = Mesh::new(Positions::F32(corners.into()), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let report = aimed(mesh, 1000);
    assert!(!report.from_inside && report.is_clean(), "{report:?}");
    // From the middle all rays lie in the plane; from the three other origins all are certain.
    assert_eq!((report.rays, report.certain_rays), (4 * 9, 3 * 9));
}

#[test]
fn nothing_is_aimed_at_where_nothing_is() {
    let mesh = Mesh::new(Positions::F32(vec![[0.0; 3]; 3].into()), vec![[0, 1, 2]]).unwrap();
    let report = aimed(mesh, 1000);
    assert_eq!((report.targets, report.rays, report.origins.len()), (0, 0, 0));
    assert!(report.is_clean());
}

#[test]
fn a_closed_surface_without_an_inside_is_aimed_at_from_around() {
    let corners = vec![[0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [1.0, 1.0, 3.0]];
    let mesh = Mesh::new(Positions::F32(corners.into()), vec![[0, 1, 2], [0, 2, 1]]).unwrap();
    assert!(examine(&mesh, &NoProgress).unwrap().is_closed());
    let report = aimed(mesh, 1000);
    assert!(!report.from_inside && report.is_clean(), "{report:?}");
    assert!(report.certain_rays > 0);
}
