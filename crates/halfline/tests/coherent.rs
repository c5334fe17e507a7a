//! Rays that are alike, which batches cast as bundles: each has the answers that it has alone.

mod common;

use common::engines::{bits, by_batch, by_brute_force, by_engine};
use common::{Random, meshes, target};
use halfline::{Ray, Scene, Vec3};

/// Rays of a bundle, at least.
const GROUP: usize = 16;

/// Pixels of a picture, a tile of four by four after the other, from `eye` at what is around `aim`.
fn camera(eye: Vec3, aim: Vec3, width: f64, side: usize) -> Vec<Ray> {
    let forward = aim - eye;
    let right = forward.cross(Vec3::from([0.3, -0.2, 1.0])).normalized() * width;
    let up = forward.cross(right).normalized() * width;
    let mut rays = Vec::new();
    for tile in 0..(side / 4) * (side / 4) {
        for pixel in 0..GROUP {
            let x = (tile % (side / 4)) * 4 + pixel % 4;
            let y = (tile / (side / 4)) * 4 + pixel / 4;
            let [x, y] = [x, y].map(|i| i as f64 / side as f64 - 0.5);
            rays.push(Ray::new(eye, forward + right * x + up * y));
        }
    }
    rays
}

/// Groups of rays that are alike, and hard: from one point at an edge, a corner and what is near them;
/// beside each other along an axis; towards one light from a surface; with ranges of their own.
fn groups(scene: &Scene, random: &mut Random) -> Vec<Ray> {
    let mesh = scene.mesh();
    let bounds = mesh.bounds();
    if bounds.is_empty() {
        return (0..GROUP).map(|_| Ray::new(random.point(), random.point())).collect();
    }
    let size = bounds.extent().max_element();
    let eye = bounds.center() + random.point() * (size * [0.2, 1.0, 5.0, 1e4][random.below(4)]);
    let mut rays = camera(eye, bounds.center(), size * [0.02, 0.2, 1.5][random.below(3)], 12);
    for _ in 0..6 {
        let face = random.below(mesh.triangle_count()) as u32;
        let Some(aim) = target(mesh, face, random) else { continue };
        let near = size * [0.0, 1e-9, 1e-4, 1e-2][random.below(4)];
        let kind = random.below(4);
        let axis = random.below(3);
        for i in 0..GROUP {
            let at = target(mesh, face, random).filter(|_| i % 4 == 0).unwrap_or(aim);
            let at = at + random.point() * near;
            let mut ray = match kind {
                0 => Ray::new(eye, at - eye),
                1 => {
                    let mut along = Vec3::ZERO;
                    along[axis] = size;
                    Ray::new(at - along * 2.0, along)
                }
                2 => Ray::with_range(at, eye - at, 0.0, 1.0),
                _ => Ray::new(at, eye - at),
            };
            if random.below(4) == 0 {
                ray.t_max = random.unit() * 2.0;
            }
            if random.below(8) == 0 {
                ray.t_min = random.signed();
            }
            // The same in single precision, so that the quickest way has its share.
            if random.below(2) == 0 {
                let single = |v: Vec3| Vec3::from(v.to_array().map(|x| f64::from(x as f32)));
                ray = Ray::with_range(single(ray.origin), single(ray.direction), 0.0, 2.0);
            }
            rays.push(ray);
        }
    }
    rays
}

#[test]
fn rays_that_are_alike_are_cast_as_if_alone() {
    let mut random = Random(21);
    for (name, mesh) in meshes() {
        let mut scene = Scene::new(mesh).expect("builds");
        for _ in 0..12 {
            let rays = groups(&scene, &mut random);
            let answers = by_batch(&mut scene, &rays);
            for (ray, answer) in rays.iter().zip(&answers) {
                assert_eq!(*answer, by_engine(&scene, ray), "{name}: {ray:?}");
            }
            // Every few of them by the judge as well.
            for (ray, answer) in rays.iter().zip(&answers).step_by(29) {
                assert_eq!(*answer, by_brute_force(scene.mesh(), ray), "{name}: {ray:?}");
            }
        }
    }
}

/// A bundle that falls apart, and groups of which only some are alike: the order does not matter.
#[test]
fn the_company_of_a_ray_does_not_matter() {
    let mut random = Random(22);
    for (name, mesh) in meshes() {
        let mut scene = Scene::new(mesh).expect("builds");
        let rays: Vec<Ray> = (0..4).flat_map(|_| groups(&scene, &mut random)).collect();
        let answers = by_batch(&mut scene, &rays);
        let mut order: Vec<usize> = (0..rays.len()).collect();
        for chunk in order.chunks_mut(40) {
            chunk.reverse();
        }
        let others: Vec<Ray> = order.iter().map(|&i| rays[i]).collect();
        let others = by_batch(&mut scene, &others);
        for (&i, other) in order.iter().zip(&others) {
            assert!(bits(&answers[i]) == bits(other), "{name}: {:?}", rays[i]);
        }
    }
}
