//! What scenes offer for batches: answers into memory that is there, and what they cost.

use crate::common::{Random, meshes, nasty_ray, sphere};
use halfline::inspect::WorkCounts;
use halfline::progress::NoProgress;
use halfline::{Hit, HitF32, Ray, RayF32, Scene, Vec3, inspect};

fn single(ray: &Ray) -> RayF32 {
    let numbers = |v: Vec3| v.to_array().map(|x| x as f32);
    RayF32 {
        origin: numbers(ray.origin),
        t_min: ray.t_min as f32,
        direction: numbers(ray.direction),
        t_max: ray.t_max as f32,
    }
}

/// What a place holds before there is an answer: nothing that any ray could have.
const BEFORE: Hit = Hit { t: -77.0, face: 0xdead, u: 5.0, v: 6.0 };
const BEFORE_SINGLE: HitF32 = HitF32 { t: -77.0, face: 0xdead };

#[test]
fn answers_into_given_memory_are_those_of_new_memory() {
    let mut random = Random(41);
    for (name, mesh) in meshes() {
        let scene = Scene::new(mesh).expect("builds");
        for count in [0, 1, 7, 64, 500] {
            let rays: Vec<Ray> =
                (0..count).map(|_| nasty_ray(scene.mesh(), &[], &mut random)).collect();
            let singles: Vec<RayF32> = rays.iter().map(single).collect();

            let mut hits = vec![BEFORE; count];
            scene.observed(&NoProgress).intersect_into(&rays, &mut hits).expect("casts");
            assert_eq!(hits, scene.intersect(&rays), "{name}");

            let mut hits = vec![BEFORE_SINGLE; count];
            scene.observed(&NoProgress).intersect_f32_into(&singles, &mut hits).expect("casts");
            assert_eq!(hits, scene.intersect_f32(&singles), "{name}");

            // Whatever was there.
            for before in [false, true] {
                let mut flags = vec![before; count];
                scene.observed(&NoProgress).occluded_into(&rays, &mut flags).expect("casts");
                assert_eq!(flags, scene.occluded(&rays), "{name}");
                let mut flags = vec![before; count];
                scene.observed(&NoProgress).occluded_into(&singles, &mut flags).expect("casts");
                assert_eq!(flags, scene.occluded(&singles), "{name}");
            }
        }
    }
}

#[test]
fn misses_are_written_too() {
    let scene = Scene::new(sphere(2, Vec3::ZERO, 1.0)).expect("builds");
    let past = Ray::new(Vec3::from([0.0, 0.0, 5.0]), Vec3::from([0.0, 0.1, 1.0]));
    let mut rays = vec![past; 100];
    rays[50].direction = Vec3::ZERO;
    let singles: Vec<RayF32> = rays.iter().map(single).collect();
    let (mut hits, mut single_hits) = (vec![BEFORE; 100], vec![BEFORE_SINGLE; 100]);
    let mut flags = vec![true; 100];
    scene.observed(&NoProgress).intersect_into(&rays, &mut hits).expect("casts");
    scene.observed(&NoProgress).intersect_f32_into(&singles, &mut single_hits).expect("casts");
    scene.observed(&NoProgress).occluded_into(&rays, &mut flags).expect("casts");
    assert_eq!(hits, vec![Hit::MISS; 100]);
    assert_eq!(single_hits, vec![HitF32::MISS; 100]);
    assert_eq!(flags, vec![false; 100]);
}

const RAYS: [Ray; 3] =
    [Ray { origin: Vec3::ZERO, direction: Vec3::splat(1.0), t_min: 0.0, t_max: f64::INFINITY }; 3];

fn a_sphere() -> Scene {
    Scene::new(sphere(1, Vec3::ZERO, 1.0)).expect("builds")
}

#[test]
#[should_panic(expected = "a place for the answer of each ray")]
fn there_cannot_be_fewer_hits_than_rays() {
    a_sphere().observed(&NoProgress).intersect_into(&RAYS, &mut [Hit::MISS; 2]).expect("casts");
}

#[test]
#[should_panic(expected = "a place for the answer of each ray")]
fn there_cannot_be_more_single_hits_than_rays() {
    a_sphere()
        .observed(&NoProgress)
        .intersect_f32_into(&RAYS.map(|ray| single(&ray)), &mut [HitF32::MISS; 4])
        .expect("casts");
}

#[test]
#[should_panic(expected = "a place for the answer of each ray")]
fn there_cannot_be_more_flags_than_rays() {
    a_sphere().observed(&NoProgress).occluded_into(&RAYS, &mut [false; 4]).expect("casts");
}

/// The pixels of a picture of a sphere, tile by tile of 8 by 8.
fn picture(side: usize) -> Vec<RayF32> {
    let tiles = side / 8;
    let pixel = |number: usize| {
        let (tile, within) = (number / 64, number % 64);
        let (x, y) = (tile % tiles * 8 + within % 8, tile / tiles * 8 + within / 8);
        let [x, y] = [x, y].map(|i| (i as f64 + 0.5) / side as f64 - 0.5);
        single(&Ray::new(Vec3::from([0.1, 0.2, 3.0]), Vec3::from([x, y, -5.0])))
    };
    (0..side * side).map(pixel).collect()
}

fn shuffled(rays: &[RayF32]) -> Vec<RayF32> {
    let (mut rays, mut random) = (rays.to_vec(), Random(42));
    for i in (1..rays.len()).rev() {
        rays.swap(i, random.below(i + 1));
    }
    rays
}

#[test]
fn work_is_counted_for_each_ray() {
    let scene = Scene::new(sphere(4, Vec3::ZERO, 1.0)).expect("builds");
    let rays = picture(64);
    for is_any in [false, true] {
        // One ray alone that hits comes to at least a node and a leaf.
        for ray in rays.iter().step_by(97) {
            let work = inspect::count_work(&scene, std::slice::from_ref(ray), is_any);
            let is_hit = scene.caster().occluded(&Ray::from(*ray));
            assert_eq!(work.rays, 1);
            assert!(!is_hit || work.nodes > 0 && work.leaves > 0, "{work:?}, {ray:?}");
        }
        let work = inspect::count_work(&scene, &rays, is_any);
        assert_eq!(work.rays, rays.len() as u64);
        assert!(work.nodes > 0 && work.leaves > 0, "{work:?}");
        // Nearly all of this is plain.
        assert!(work.exact * 1000 < work.rays, "{work:?}");
        assert_eq!(inspect::count_work::<RayF32>(&scene, &[], is_any), WorkCounts::default());
        // The same rays in double precision take the same way.
        let doubles: Vec<Ray> = rays.iter().map(|&ray| Ray::from(ray)).collect();
        assert_eq!(inspect::count_work(&scene, &doubles, is_any), work);
    }
}

#[test]
fn rays_through_edges_are_decided_exactly() {
    let scene = Scene::new(sphere(4, Vec3::ZERO, 1.0)).expect("builds");
    let rays =
        vec![single(&Ray::new(Vec3::from([0.0, 0.0, 3.0]), Vec3::from([0.0, 0.0, -1.0]))); 64];
    for is_any in [false, true] {
        let work = inspect::count_work(&scene, &rays, is_any);
        assert!(work.exact >= 64, "{work:?}");
    }
}

#[test]
fn work_does_not_depend_on_threads() {
    let scene = Scene::new(sphere(4, Vec3::ZERO, 1.0)).expect("builds");
    let rays = picture(160);
    for is_any in [false, true] {
        let work = [1, 2, 5].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads").install(|| inspect::count_work(&scene, &rays, is_any))
        });
        assert_eq!(work[0], work[1]);
        assert_eq!(work[0], work[2]);
    }
}

#[test]
fn rays_that_are_alike_fetch_less_together() {
    let mut scene = Scene::new(sphere(4, Vec3::ZERO, 1.0)).expect("builds");
    let rays = picture(64);
    for level in halfline::Level::available() {
        scene.set_simd_level(level);
        for is_any in [false, true] {
            let together = inspect::count_work(&scene, &rays, is_any);
            let apart = inspect::count_work(&scene, &shuffled(&rays), is_any);
            assert!(together.nodes * 8 < apart.nodes, "{together:?} {apart:?}");
            assert!(together.leaves * 2 < apart.leaves, "{together:?} {apart:?}");
            assert!(together.cache_lines() * 3 < apart.cache_lines());
        }
    }
}
