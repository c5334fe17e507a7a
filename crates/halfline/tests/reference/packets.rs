//! Rays that are alike, which batches cast as packets: each has the answers that it has alone.

use crate::common::engines::{bits, by_batch, by_brute_force, by_engine};
use crate::common::{Random, in_single_precision, meshes, soup, sphere, target};
use halfline::numeric::PreparedRay;
use halfline::progress::NoProgress;
use halfline::{BuildParameters, Mesh, Ray, Scene, Vec3};

/// Rays of a packet, at least and at most.
const GROUPS: [usize; 2] = [16, 64];

/// Pixels of a picture, a tile of so many by so many after the other, from `eye` at what is around `aim`.
fn camera(eye: Vec3, aim: Vec3, width: f64, side: usize, tile: usize) -> Vec<Ray> {
    let forward = aim - eye;
    let right = forward.cross(Vec3::from([0.3, -0.2, 1.0])).normalized() * width;
    let up = forward.cross(right).normalized() * width;
    let mut rays = Vec::new();
    for number in 0..(side / tile) * (side / tile) {
        for pixel in 0..tile * tile {
            let x = (number % (side / tile)) * tile + pixel % tile;
            let y = (number / (side / tile)) * tile + pixel / tile;
            let [x, y] = [x, y].map(|i| i as f64 / side as f64 - 0.5);
            rays.push(Ray::new(eye, forward + right * x + up * y));
        }
    }
    rays
}

/// Groups of rays that are alike, and hard: from one point at an edge, a corner and what is near them;
/// beside each other along an axis; towards one light from a surface; with ranges of their own.
fn groups(scene: &Scene, count: usize, random: &mut Random) -> Vec<Ray> {
    let mesh = scene.mesh();
    let bounds = mesh.bounds();
    if bounds.is_empty() {
        return (0..count).map(|_| Ray::new(random.point(), random.point())).collect();
    }
    let size = bounds.extent().max_element();
    let eye = bounds.center() + random.point() * (size * [0.2, 1.0, 5.0, 1e4][random.below(4)]);
    let tile = if count == GROUPS[0] { 4 } else { 8 };
    let width = [0.02, 0.2, 1.5][random.below(3)];
    let mut rays = camera(eye, bounds.center(), size * width, 2 * tile, tile);
    for _ in 0..6 {
        let face = random.below(mesh.triangle_count()) as u32;
        let Some(aim) = target(mesh, face, random) else { continue };
        let near = size * [0.0, 1e-9, 1e-4, 1e-2][random.below(4)];
        let kind = random.below(4);
        let axis = random.below(3);
        // Sometimes all of them along one line, which leaves no room for any error.
        let is_line = random.below(3) == 0;
        for i in 0..count {
            let other = target(mesh, face, random).filter(|_| i % 4 == 0).unwrap_or(aim);
            let at = if is_line { aim } else { other + random.point() * near };
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
        // Some of them look away, or pass by the whole scene.
        if random.below(4) == 0 {
            for _ in 0..1 + random.below(count) {
                let place = rays.len() - 1 - random.below(count);
                let ray = &mut rays[place];
                if random.below(2) == 0 {
                    ray.direction = -ray.direction;
                } else {
                    ray.origin += Vec3::splat(size * 3.0);
                }
            }
        }
    }
    rays
}

/// Fails unless rays in this order, and out of it, have the answers that each has alone. Every few of them
/// the judge is asked as well.
fn check(name: &str, scene: &mut Scene, rays: &[Ray], few: usize) {
    let answers = by_batch(scene, rays);
    for (ray, answer) in rays.iter().zip(&answers) {
        assert_eq!(*answer, by_engine(scene, ray), "{name}: {ray:?}");
    }
    for (ray, answer) in rays.iter().zip(&answers).step_by(few) {
        assert_eq!(*answer, by_brute_force(scene.mesh(), ray), "{name}: {ray:?}");
    }
}

/// Rays in an order in which none is like those beside it.
fn shuffled(rays: &[Ray], random: &mut Random) -> Vec<Ray> {
    let mut rays = rays.to_vec();
    for i in (1..rays.len()).rev() {
        rays.swap(i, random.below(i + 1));
    }
    rays
}

#[test]
fn rays_that_are_alike_are_cast_as_if_alone() {
    let mut random = Random(21);
    for (name, mesh) in meshes() {
        let mut scene = Scene::new(mesh).expect("builds");
        for turn in 0..12 {
            let rays = groups(&scene, GROUPS[usize::from(turn % 3 == 0)], &mut random);
            check(name, &mut scene, &rays, 29);
        }
    }
}

/// A packet that falls apart, and groups of which only some are alike: the order does not matter.
#[test]
fn the_company_of_a_ray_does_not_matter() {
    let mut random = Random(22);
    for (name, mesh) in meshes() {
        let mut scene = Scene::new(mesh).expect("builds");
        let rays: Vec<Ray> =
            (0..4).flat_map(|i| groups(&scene, GROUPS[i % 2], &mut random)).collect();
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

/// A tree of small leaves, so that a few triangles are enough for several nodes.
fn scene_of_small_leaves(mesh: Mesh) -> Scene {
    let parameters =
        BuildParameters::default().with_spatial_split_min_triangles(1).with_duplication_budget(8.0);
    Scene::builder(mesh).parameters(parameters).observer(&NoProgress).build().expect("builds")
}

/// Pictures from near and far, whole and in part, also such of which a part shows nothing.
#[test]
fn pictures_show_what_rays_meet_alone() {
    let mut random = Random(23);
    for (name, mesh) in meshes() {
        let bounds = mesh.bounds();
        if bounds.is_empty() {
            continue;
        }
        let mut scene = scene_of_small_leaves(mesh);
        let size = bounds.extent().max_element();
        // Tiles that are narrow enough to be cast as one, and wider ones.
        for (i, width) in [0.01, 0.05, 0.1, 0.4, 3.0].into_iter().enumerate() {
            let away = random.point().normalized() * (size * [1.2, 4.0, 30.0][i % 3]);
            let aim = bounds.center() + random.point() * (size * 0.4);
            let rays = camera(bounds.center() + away, aim, size * width, 16, 8);
            check(name, &mut scene, &rays, 17);
        }
    }
}

/// Coordinates of which single precision has no more than a part.
#[test]
fn packets_know_triangles_from_their_own_corners() {
    let mut random = Random(24);
    let far = Vec3::from([500_000.1, 5_400_000.3, 12.7]);
    for (name, mesh) in [("near", sphere(4, Vec3::ZERO, 1.0 / 3.0)), ("far", sphere(4, far, 2.0))] {
        let mut scene = scene_of_small_leaves(mesh);
        assert!(!scene.tree().leaves.are_exact, "{name}");
        let bounds = scene.mesh().bounds();
        let size = bounds.extent().max_element();
        for way in [1e-3, 0.1, 1.0, 1e3] {
            // At what is around a vertex, within single precision and beyond it.
            let face = random.below(scene.mesh().triangle_count()) as u32;
            let aim = scene.mesh().corners(face)[0];
            let out = (aim - bounds.center()).normalized() + random.point() * 0.3;
            let eye = aim + out * (size * way);
            for width in [1e-9, 1e-7, 1e-5, 1e-2, 0.2] {
                let rays = camera(eye, aim, size * width, 16, 8);
                check(name, &mut scene, &rays, 61);
            }
        }
    }
}

/// Meshes in which many hits have the same t.
fn ties(random: &mut Random) -> Vec<(&'static str, Mesh)> {
    // Overlapping triangles in one slanted plane, with corners of small whole numbers.
    let mut slanted = || {
        let mut corner = || {
            let [x, y] = [0; 2].map(|_| random.below(33) as f64 - 16.0);
            Vec3::from([x, y, x + 2.0 * y])
        };
        [corner(), corner(), corner()]
    };
    let slanted: Vec<[Vec3; 3]> = (0..300).map(|_| slanted()).collect();
    // The same flat, at a height that single precision does not have.
    let flat = slanted.iter().map(|corners| {
        corners.map(|corner| Vec3::from([corner.x / 7.0, corner.y / 7.0, 1.0 / 3.0]))
    });
    let flat = soup(flat.collect::<Vec<_>>());
    // Triangles, each of them several times: turned and mirrored, far from each other in the list.
    let once: Vec<[Vec3; 3]> = (0..60)
        .map(|_| {
            let at = random.point() * 4.0;
            [0; 3].map(|_| at + random.point())
        })
        .collect();
    let again = (0..5).flat_map(|turn| {
        let once = &once;
        (0..once.len()).map(move |i| {
            let [a, b, c] = once[(i * 7 + turn * 13) % once.len()];
            [[a, b, c], [b, c, a], [c, b, a], [a, c, b], [c, a, b]][turn]
        })
    });
    let again = soup(again.collect::<Vec<_>>());
    vec![
        ("slanted, in single precision", in_single_precision(&soup(slanted.clone()))),
        ("slanted", soup(slanted)),
        ("flat", flat),
        ("copies, in single precision", in_single_precision(&again)),
        ("copies", again),
    ]
}

/// The face that a ray hits first, and how many it hits at that t.
fn first_of_all(mesh: &Mesh, ray: &Ray) -> Option<(u32, usize)> {
    let prepared = PreparedRay::new(ray)?;
    let meet = |face| prepared.meet(mesh.corners(face)).map(|contact| (contact.t, face));
    let hits: Vec<(f64, u32)> = (0..mesh.triangle_count() as u32).filter_map(meet).collect();
    let nearest = hits.iter().map(|(t, _)| *t).reduce(f64::min)?;
    let mut first = hits.iter().filter(|(t, _)| *t == nearest).map(|(_, face)| *face);
    Some((first.next()?, 1 + first.count()))
}

#[test]
fn of_equal_hits_the_lowest_face_counts() {
    let mut random = Random(25);
    for (name, mesh) in ties(&mut random) {
        let mut scene = scene_of_small_leaves(mesh);
        let bounds = scene.mesh().bounds();
        let size = bounds.extent().max_element();
        let (mut rays, mut tied) = (Vec::new(), 0);
        for width in [0.05, 0.1, 0.1, 0.2, 1.0] {
            // From a point that single precision has, so that the quickest way is tried as well.
            let away = Vec3::from([random.signed(), random.signed(), 3.0]) * (size * 0.7);
            let eye = (bounds.center() + away).to_array().map(|x| f64::from(x as f32));
            let mut picture = camera(Vec3::from(eye), bounds.center(), size * width, 16, 8);
            for ray in picture.iter_mut().skip(64) {
                let single = ray.direction.to_array().map(|x| f64::from(x as f32));
                ray.direction = Vec3::from(single);
            }
            rays.append(&mut picture);
        }
        for rays in [shuffled(&rays, &mut random), rays] {
            for (ray, answer) in rays.iter().zip(by_batch(&mut scene, &rays)) {
                let first = first_of_all(scene.mesh(), ray);
                let expected = first.map(|(face, _)| face);
                let found = answer.closest.is_hit().then_some(answer.closest.face);
                assert_eq!(found, expected, "{name}: {ray:?}");
                assert_eq!(
                    scene.caster().intersect(ray).unwrap_or(halfline::Hit::MISS),
                    answer.closest,
                    "{name}, alone: {ray:?}"
                );
                tied += usize::from(first.is_some_and(|(_, count)| count > 1));
            }
        }
        assert!(tied > 200, "{name}: only {tied}");
    }
}

/// A curtain whose edge rays touch, or nearly so, before they come to a wall, if their ranges go so far.
#[test]
fn what_was_decided_for_some_does_not_decide_for_others() {
    let mut random = Random(26);
    let strip = |x: [f64; 2], z: f64, n: usize| {
        (0..n).flat_map(move |i| {
            let [low, high] = [i, i + 1].map(|i| i as f64 * 4.0 / n as f64 - 2.0);
            let p = |side: usize, y: f64| Vec3::from([x[side], y, z]);
            let [a, b, c, d] = [p(0, low), p(1, low), p(1, high), p(0, high)];
            [[a, b, c], [a, c, d]]
        })
    };
    let triangles: Vec<[Vec3; 3]> =
        strip([1.0, 2.0], 1.0, 16).chain(strip([-4.0, 4.0], 3.0, 8)).collect();
    for mesh in [soup(triangles.clone()), in_single_precision(&soup(triangles))] {
        let mut scene = scene_of_small_leaves(mesh);
        let mut counts = [0; 3];
        for turn in 0..60 {
            let base = random.signed() * 0.5;
            let mut rays = Vec::new();
            for i in 0..64 {
                // Past the edge, through it, and clear of it.
                let beside = [-f64::EPSILON / 2.0, 0.0, f64::EPSILON, -1e-9, -0.02];
                let beside = beside[[random.below(5), i % 5][turn % 2]];
                let y = base + 0.05 * random.unit();
                let reach = [f64::INFINITY, 2.0, 4.0, 1.0][random.below(4)];
                let direction = Vec3::from([1.0 + beside, y, 1.0]);
                rays.push(Ray::with_range(Vec3::ZERO, direction, 0.0, reach));
                let expected = beside >= 0.0 || reach > 3.0;
                counts[usize::from(expected)] += 1;
                counts[2] += usize::from(beside < 0.0 && expected);
                let answer = by_brute_force(scene.mesh(), &rays[i]).any;
                assert_eq!(answer, expected, "{:?}", rays[i]);
            }
            check("a curtain", &mut scene, &rays, 1);
        }
        assert!(counts.into_iter().all(|count| count > 500), "{counts:?}");
    }
}
