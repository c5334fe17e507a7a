//! What must not change the answers: powers of two, translations, precision, the order of faces.

use crate::common::contact::{Answers, Case};
use crate::common::engines::{build_variants, by_brute_force, by_engine, engine_planes};
use crate::common::grid::{LINES, aimed_at, judged, plates, soups, stacks};
use crate::common::proof::{Share, prove, report};
use crate::common::{Random, in_double_precision, in_single_precision, meshes, nasty_ray, soup};
use halfline::mesh::Positions;
use halfline::progress::NoProgress;
use halfline::{BuildParameters, Hit, Mesh, Ray, Scene, Vec3};
use proptest::prelude::*;

/// The meshes of the table that are of ordinary size, so that there is room to scale them.
fn ordinary_meshes() -> impl Iterator<Item = (&'static str, Mesh)> {
    meshes().into_iter().filter(|(name, _)| !["tiny sphere", "huge sphere"].contains(name))
}

fn build(mesh: &Mesh, parameters: &BuildParameters) -> Scene {
    Scene::builder(mesh.clone())
        .parameters(*parameters)
        .observer(&NoProgress)
        .build()
        .expect("builds")
}

/// `x * 2^exponent`, or `None` if that loses a bit.
fn exactly_scaled(x: f64, exponent: i32) -> Option<f64> {
    let scaled = x * 2f64.powi(exponent);
    (scaled * 2f64.powi(-exponent) == x).then_some(scaled)
}

fn exactly_scaled_vector(v: Vec3, exponent: i32) -> Option<Vec3> {
    let [x, y, z] = v.to_array().map(|x| exactly_scaled(x, exponent));
    Some(Vec3::from([x?, y?, z?]))
}

/// The mesh times 2^exponent, in its own precision, or `None` if that loses a bit.
fn scaled_mesh(mesh: &Mesh, exponent: i32) -> Option<Mesh> {
    let scale = |x: f64| if x.is_finite() { exactly_scaled(x, exponent) } else { Some(x) };
    let positions = match mesh.positions() {
        Positions::F64(positions) => {
            let positions =
                positions.iter().map(|&[x, y, z]| Some([scale(x)?, scale(y)?, scale(z)?]));
            Positions::F64(positions.collect::<Option<_>>()?)
        }
        Positions::F32(positions) => {
            let scale = |x: f32| {
                let scaled = scale(f64::from(x))?;
                (f64::from(scaled as f32) == scaled).then_some(scaled as f32)
            };
            let positions =
                positions.iter().map(|&[x, y, z]| Some([scale(x)?, scale(y)?, scale(z)?]));
            Positions::F32(positions.collect::<Option<_>>()?)
        }
    };
    Some(Mesh::new(positions, mesh.triangles().to_vec()).expect("as valid as the mesh"))
}

/// The ray in a world 2^size times as large, with a direction 2^speed times as long.
fn scaled_ray(ray: &Ray, size: i32, speed: i32) -> Option<Ray> {
    Some(Ray {
        origin: exactly_scaled_vector(ray.origin, size)?,
        direction: exactly_scaled_vector(ray.direction, speed)?,
        t_min: exactly_scaled(ray.t_min, size - speed)?,
        t_max: exactly_scaled(ray.t_max, size - speed)?,
    })
}

/// `answers` with t times 2^exponent.
fn scaled_answers(answers: &Answers, exponent: i32) -> Option<Answers> {
    let scaled = |hit: &Hit| Some(Hit { t: exactly_scaled(hit.t, exponent)?, ..*hit });
    Some(Answers {
        closest: scaled(&answers.closest)?,
        any: answers.any,
        all: answers.all.iter().map(scaled).collect::<Option<_>>()?,
    })
}

/// By 2^±100, which is 1e±30, and less; the same faces, u and v to the bit, and t in proportion:
/// unchanged where origin and direction scale together.
#[test]
fn powers_of_two_change_nothing() {
    let variants = build_variants();
    let mut sent = 0;
    for (seed, (name, mesh)) in ordinary_meshes().enumerate() {
        let sizes = [-100, -99, -37, -1, 0, 1, 52, 99, 100];
        let mut scaled_at_all = 0;
        for (i, size) in sizes.into_iter().enumerate() {
            let Some(large) = scaled_mesh(&mesh, size) else { continue };
            scaled_at_all += 1;
            let parameters = &variants[i % variants.len()];
            let (plain, large) = (build(&mesh, parameters), build(&large, parameters));
            let planes = engine_planes(&plain);
            let mut random = Random((seed * sizes.len() + i) as u64);
            for _ in 0..150 {
                let ray = nasty_ray(&mesh, &planes, &mut random);
                let speed =
                    if random.below(2) == 0 { size } else { random.below(401) as i32 - 200 };
                let scaled = scaled_ray(&ray, size, speed);
                let expected = scaled_answers(&by_engine(&plain, &ray), size - speed);
                let (Some(scaled), Some(expected)) = (scaled, expected) else { continue };
                let answers = by_engine(&large, &scaled);
                assert_eq!(answers, expected, "{name} times 2^{size}: {ray:?} as {scaled:?}");
                sent += 1;
            }
        }
        assert!(scaled_at_all >= 3, "{name} has room to be scaled");
    }
    assert!(sent > 10_000, "only {sent} rays could be scaled");
    report("engine in worlds of other sizes", sent);
}

/// By up to 1e7 times the size, by whole units of the grid, which rounds nothing: so what is known
/// of the mesh where it lay must hold to the bit. Where a translation rounds coordinates the
/// rounded ones are the truth, on which `exact/engines.rs` has the judge.
#[test]
fn exact_translations_change_nothing() {
    let offset = prop::array::uniform3(prop_oneof![
        1 => Just(0.0),
        3 => (-500_000_000..=500_000_000i32).prop_map(f64::from),
    ]);
    let faces = prop_oneof![soups(), plates(), stacks()];
    let rays = Share(0.02).rays();
    prove("engines far away", rays, LINES, (aimed_at(faces), offset), |(input, offset)| {
        // On a grid of one unit and with directions of any length.
        let mut input = input.clone();
        input.0.unit = 0;
        let (mesh, cases) = judged(&input);
        let offset = Vec3::from(*offset);
        let corners = |face: u32| mesh.corners(face).map(|corner| corner + offset);
        let moved =
            |case: Case| Case { ray: Ray { origin: case.ray.origin + offset, ..case.ray }, ..case };
        let faces = 0..mesh.triangle_count() as u32;
        (soup(faces.map(corners)), cases.into_iter().map(moved).collect())
    });
}

#[test]
fn single_precision_answers_as_the_same_in_double() {
    let variants = build_variants();
    for (seed, (name, mesh)) in ordinary_meshes().enumerate() {
        let single = in_single_precision(&mesh);
        let double = in_double_precision(&single);
        for (i, parameters) in variants.iter().enumerate() {
            let (single, double) = (build(&single, parameters), build(&double, parameters));
            let planes = engine_planes(&single);
            let mut random = Random((seed * variants.len() + i) as u64);
            for _ in 0..400 {
                let ray = nasty_ray(single.mesh(), &planes, &mut random);
                assert_eq!(by_engine(&single, &ray), by_engine(&double, &ray), "{name}: {ray:?}");
            }
        }
    }
}

/// Every hit names the same triangle, wherever it stands in the list; of contacts at equal t of which
/// one is named, the closest and those at a border, the one that stands first.
#[test]
fn the_order_of_faces_changes_only_their_numbers() {
    let variants = build_variants();
    for (seed, (name, mesh)) in ordinary_meshes().enumerate() {
        let mut random = Random(seed as u64);
        let mut shuffled: Vec<u32> = (0..mesh.triangle_count() as u32).collect();
        shuffled.sort_by_cached_key(|_| random.below(1 << 30));
        let reversed = (0..mesh.triangle_count() as u32).rev().collect();
        for (i, old_of_new) in [shuffled, reversed].iter().enumerate() {
            let triangles: Vec<_> =
                old_of_new.iter().map(|&old| mesh.triangles()[old as usize]).collect();
            let other = Mesh::new(mesh.positions().clone(), triangles).expect("a valid mesh");
            let mut new_of_old = vec![0; old_of_new.len()];
            for (new, &old) in old_of_new.iter().enumerate() {
                new_of_old[old as usize] = new as u32;
            }
            let parameters = &variants[(seed + i) % variants.len()];
            let (plain, other) = (build(&mesh, parameters), build(&other, parameters));
            let planes = engine_planes(&plain);
            for _ in 0..400 {
                let ray = nasty_ray(&mesh, &planes, &mut random);
                let (before, after) = (by_engine(&plain, &ray), by_engine(&other, &ray));
                let key = |hit: &Hit| (hit.t.to_bits(), hit.face);
                let mut all = before.all.clone();
                all.iter_mut().for_each(|hit| hit.face = new_of_old[hit.face as usize]);
                all.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
                let differing = after.all.iter().zip(&all).filter(|(a, b)| key(a) != key(b));
                assert_eq!(after.all.len(), all.len(), "{name}: {ray:?}");
                for (new, old) in differing {
                    // On the border the first of the faces there is named.
                    let old_face = old_of_new[old.face as usize];
                    let is_first =
                        new.face <= old.face && old_face <= old_of_new[new.face as usize];
                    assert!(new.t == old.t && is_first, "{name}: {ray:?}: {new:?} {old:?}");
                }
                assert_eq!((after.any, after.closest.t), (before.any, before.closest.t), "{name}");
                if before.any {
                    // Each is the first in its own list of those at this t.
                    let (old, new) = (before.closest.face, after.closest.face);
                    let is_first =
                        new <= new_of_old[old as usize] && old <= old_of_new[new as usize];
                    assert!(is_first, "{name}: {ray:?}: {before:?} {after:?}");
                }
            }
        }
    }
}

/// A leaf's copy of a corner may have lost the sign of a zero; no answer shows it.
#[test]
fn negative_zeros_are_zeros() {
    let bits = |answers: &Answers| -> Vec<[u64; 3]> {
        std::iter::once(&answers.closest)
            .chain(&answers.all)
            .map(|hit| [hit.t, hit.u, hit.v].map(f64::to_bits))
            .collect()
    };
    for (seed, (name, mesh)) in ordinary_meshes().enumerate() {
        let mesh = in_single_precision(&mesh);
        let Positions::F32(positions) = mesh.positions() else { panic!("single precision") };
        let negative = |x: f32| if x == 0.0 { -0.0 } else { x };
        let positions = positions.iter().map(|p| p.map(negative));
        let other = Mesh::new(Positions::F32(positions.collect()), mesh.triangles().to_vec());
        let (plain, other) = (
            build(&mesh, &build_variants()[0]),
            build(&other.expect("a valid mesh"), &build_variants()[0]),
        );
        let mut random = Random(seed as u64);
        for _ in 0..400 {
            let ray = nasty_ray(&mesh, &[], &mut random);
            let answers = by_engine(&other, &ray);
            assert_eq!(bits(&answers), bits(&by_engine(&plain, &ray)), "{name}: {ray:?}");
            assert_eq!(
                bits(&answers),
                bits(&by_brute_force(other.mesh(), &ray)),
                "{name}: {ray:?}"
            );
        }
    }
}
