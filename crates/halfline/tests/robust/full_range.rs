//! The engine over the whole range of doubles: scenes and rays of sizes that have nothing to do
//! with each other, and the textbook's tree, against brute force.

use crate::common::engines::{by_batch, by_brute_force, by_engine};
use crate::common::{Random, grid_cube};
use halfline::mesh::Positions;
use halfline::textbook::{KdTree, Middle, Termination};
use halfline::{Mesh, Ray, Scene, Vec3};

/// The grid cube, 2^exponent times as large.
fn cube(exponent: i32) -> Mesh {
    let mesh = grid_cube(2);
    let scale = 2f64.powi(exponent / 2) * 2f64.powi(exponent % 2);
    let Positions::F64(positions) = mesh.positions() else { panic!("double precision") };
    let scaled = positions.iter().map(|p| p.map(|x| x * scale * 2f64.powi(exponent / 2)));
    Mesh::new(Positions::F64(scaled.collect()), mesh.triangles().to_vec()).expect("a valid mesh")
}

/// Along an axis, so that even from afar the ray comes where it is aimed at; or between two grid
/// points.
fn ray(random: &mut Random, exponents: [i32; 2]) -> Ray {
    let mut size = || {
        let exponent = exponents[random.below(2)];
        let half = exponent / 2;
        (random.below(9) as f64 - 4.0) * 2f64.powi(half) * 2f64.powi(exponent - half)
    };
    let [from, to] = [0; 2].map(|_| Vec3::from([size(), size(), size()]));
    let mut direction = to - from;
    if random.below(2) == 0 {
        let axis = random.below(3);
        let along = if direction[axis] == 0.0 { 1.0 } else { direction[axis] };
        direction = Vec3::ZERO;
        direction[axis] = along;
    }
    Ray::with_range(from, direction, [0.0, f64::NEG_INFINITY][random.below(2)], f64::INFINITY)
}

#[test]
fn scenes_and_rays_of_any_size() {
    let mut random = Random(1);
    let mut hits = 0;
    for scene_exponent in [-1074, -1000, -500, -100, 0, 100, 500, 1018] {
        let mesh = cube(scene_exponent);
        let mut scene = Scene::new(mesh.clone()).expect("builds");
        assert_eq!(scene.tree().skipped_zero_area, 0);
        let textbook = KdTree::init_kd_tree(&mesh, &Middle, &Termination::automatic(100));
        // Far and near rays side by side, since batches prepare eight at a time.
        let ray_exponents = [-1074, -900, -300, 0, 100, 130, 300, 900, 1018];
        let rays: Vec<Ray> = (0..12 * ray_exponents.len())
            .map(|i| ray(&mut random, [scene_exponent, ray_exponents[i % ray_exponents.len()]]))
            .collect();
        for (ray, answers) in rays.iter().zip(by_batch(&mut scene, &rays)) {
            let expected = by_brute_force(&mesh, ray);
            assert_eq!(answers, expected, "batch: {ray:?}");
            assert_eq!(by_engine(&scene, ray), expected, "{ray:?}");
            assert_eq!(textbook.ray_tree_intersection(ray), expected.closest, "{ray:?}");
            hits += usize::from(expected.closest.is_hit());
        }
    }
    assert!(hits > 150, "{hits}");
}
