//! Closest points against an exact judge that shares no code with them.

#[path = "../common/mod.rs"]
mod common;
mod judge;
mod meshes;

use std::sync::atomic::{AtomicIsize, Ordering};

use common::engines::in_both_precisions;
use common::proof::{ray_budget, report};
use common::{Random, soup};
use halfline::columns::{ClosestPointColumns, Scalars, Vectors};
use halfline::progress::NoProgress;
use halfline::{
    BuildParameters, ClosestPoint, Error, Level, Mesh, Observer, Preset, Scene, Vec3, brute_force,
    vec3,
};
use meshes::{families, points_for};

/// Every number of an answer.
fn bits(answer: &ClosestPoint) -> [u64; 8] {
    let ClosestPoint { distance, point, face, u, v, feature } = *answer;
    let numbers = [distance, point.x, point.y, point.z, u, v].map(f64::to_bits);
    let [d, x, y, z, u, v] = numbers;
    [d, x, y, z, u, v, face.into(), feature as u64]
}

fn all_bits(answers: &[ClosestPoint]) -> Vec<[u64; 8]> {
    answers.iter().map(bits).collect()
}

/// The answers in columns, as rows.
fn by_columns(
    scene: &Scene,
    points: Vectors,
    max_distance: Scalars,
    count: usize,
) -> Vec<[u64; 8]> {
    let (mut distance, mut point) = (vec![0.0; count], vec![[0.0; 3]; count]);
    let (mut face, mut uv, mut feature) = (vec![0; count], vec![[0.0; 2]; count], vec![9; count]);
    let columns = ClosestPointColumns {
        distance: &mut distance,
        point: &mut point,
        face: &mut face,
        uv: &mut uv,
        feature: &mut feature,
    };
    scene.observed(&NoProgress).closest_points_columns(points, max_distance, columns).unwrap();
    let row = |i: usize| {
        let face = if face[i] < 0 { u64::from(u32::MAX) } else { face[i] as u64 };
        let [x, y, z] = point[i];
        let [d, x, y, z, u, v] = [distance[i], x, y, z, uv[i][0], uv[i][1]].map(f64::to_bits);
        [d, x, y, z, u, v, face, u64::from(feature[i])]
    };
    (0..count).map(row).collect()
}

/// Holds every way to ask against the judge, or against a way that was.
fn check(name: &str, mesh: &Mesh, points: &[Vec3]) {
    let brute = brute_force::closest_points(mesh, points, f64::INFINITY);
    for (point, answer) in points.iter().zip(&brute) {
        let complaint = match judge::closest_point(mesh, *point) {
            Some(expected) => expected.complaint(answer),
            None => answer.is_found().then(|| "found".to_string()),
        };
        if let Some(complaint) = complaint {
            panic!("{name}: {complaint}\nfor {point:?}: {answer:?}\nin {mesh:?}");
        }
    }
    let expected = all_bits(&brute);
    for preset in Preset::ALL {
        let builder = Scene::builder(mesh.clone()).parameters(BuildParameters::preset(preset));
        let mut scene = builder.build().unwrap();
        for level in Level::available() {
            scene.set_simd_level(level);
            let answers = scene.closest_points(points);
            for (i, point) in points.iter().enumerate() {
                let (found, wanted) = (bits(&answers[i]), expected[i]);
                let what = format!("{name}, {preset:?}, {level}, {point:?}");
                assert_eq!(found, wanted, "{what}: {:?}, {:?}\n{mesh:?}", answers[i], brute[i]);
            }
            let alone = points.iter().map(|&point| scene.closest_points(&[point])[0]);
            assert_eq!(all_bits(&alone.collect::<Vec<_>>()), expected, "{name}: one by one");
        }
        let rows: Vec<[f64; 3]> = points.iter().map(|point| point.to_array()).collect();
        let columns =
            by_columns(&scene, Vectors::F64(&rows), Scalars::Same(f64::INFINITY), rows.len());
        assert_eq!(columns, expected, "{name}: in columns");
    }
}

/// How many points there are for the judge: a rational takes a thousand times as long as a ray.
fn points_to_judge() -> usize {
    ray_budget() / 500
}

#[test]
fn closest_points_are_those_of_rational_arithmetic() {
    let mut random = Random(17);
    let families = families();
    let mut judged = 0;
    let mut turn = 0;
    while judged < points_to_judge() {
        let (name, family) = &families[turn % families.len()];
        turn += 1;
        let mesh = family(&mut random);
        let points = points_for(&mesh, &mut random, 14);
        for mesh in in_both_precisions(&mesh) {
            check(name, &mesh, &points);
        }
        judged += points.len();
    }
    report("closest points against rationals", judged);
}

#[test]
fn threads_and_chunks_do_not_matter() {
    let mesh = common::sphere(5, Vec3::ZERO, 1.0);
    let mut random = Random(3);
    let points: Vec<Vec3> =
        (0..10_000).map(|i| random.point() * if i % 3 == 0 { 3.0 } else { 1.1 }).collect();
    let scene = Scene::new(mesh.clone()).unwrap();
    let by_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        all_bits(&pool.install(|| scene.closest_points(&points)))
    };
    let one = by_threads(1);
    assert!(one == by_threads(2), "two threads");
    let few: Vec<Vec3> = points.iter().copied().step_by(97).collect();
    let expected = all_bits(&brute_force::closest_points(&mesh, &few, f64::INFINITY));
    assert!(expected.iter().eq(one.iter().step_by(97)), "brute force");
    assert!(all_bits(&scene.closest_points(&few)) == expected, "fewer");
}

/// Where the corner's part ends and the edge's begins a sign is zero but for rounding, and the feature depends on it.
#[test]
fn corners_and_edges_are_told_apart_exactly() {
    let mut random = Random(29);
    for turn in 0..100 {
        let [a, b, c] = [(); 3].map(|()| random.point() + vec3(5.0, 50.0, 0.5));
        let mesh = soup([[[a, b, c], [c, a, b], [b, c, a]][turn % 3]]);
        for _ in 0..20 {
            // Across the edge and away from the third corner.
            let away = (b - a).cross(random.point());
            let point = a + if away.dot(c - a) < 0.0 { away } else { -away };
            let answer = brute_force::closest_points(&mesh, &[point], f64::INFINITY)[0];
            let expected = judge::closest_point(&mesh, point).unwrap();
            assert_eq!(expected.complaint(&answer), None, "{point:?} in {mesh:?}");
        }
    }
}

/// Answers come eight at a time where there are so many; where doubles nearly cancel, that must not be seen.
#[test]
fn many_points_near_the_surface_have_the_answers_of_each() {
    let mut random = Random(23);
    for center in [Vec3::ZERO, vec3(5e5, 5e6, 12.0)] {
        let mesh = common::sphere(2, center, 1.0);
        let offs = [0.0, 1e-18, 1e-16, 1e-14, 1e-12, 1e-6, 1e-2];
        let points: Vec<Vec3> = (0..2_100)
            .map(|i| {
                let face = random.below(mesh.triangle_count()) as u32;
                let on = common::target(&mesh, face, &mut random).unwrap();
                on + random.point() * offs[i % offs.len()]
            })
            .collect();
        let expected = all_bits(&brute_force::closest_points(&mesh, &points, f64::INFINITY));
        let mut scene = Scene::new(mesh).unwrap();
        for level in Level::available() {
            scene.set_simd_level(level);
            let found = all_bits(&scene.closest_points(&points));
            let wrong = (0..points.len()).find(|&i| found[i] != expected[i]);
            assert_eq!(wrong.map(|i| points[i]), None, "{level}");
        }
    }
}

#[test]
fn the_largest_distance_counts_itself() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let scene = Scene::new(Mesh::new(square, [[0, 1, 2], [0, 2, 3]]).unwrap()).unwrap();
    let point = [vec3(4.0, 5.0, 0.0)];
    let ask = |most: f64| scene.observed(&NoProgress).closest_points(&point, most).unwrap()[0];
    assert_eq!(ask(5.0).distance, 5.0);
    for most in [5.0f64.next_down(), 0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        assert!(!ask(most).is_found(), "{most}");
    }
    // A point on the surface counts for zero, and its distance is zero.
    let on = [vec3(0.5, 0.5, 0.0), vec3(0.25, 0.125, 0.0), vec3(1.0, 0.0, 0.0)];
    let found = scene.observed(&NoProgress).closest_points(&on, 0.0).unwrap();
    assert!(found.iter().zip(on).all(|(found, on)| found.distance == 0.0 && found.point == on));
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(!scene.closest_points(&[vec3(0.0, bad, 0.0)])[0].is_found());
    }
    // Random distances are told apart as they are rounded.
    let mut random = Random(5);
    let mesh = common::sphere(2, Vec3::ZERO, 1.0);
    let scene = Scene::new(mesh.clone()).unwrap();
    let points: Vec<Vec3> = (0..200).map(|_| random.point() * 2.0).collect();
    let rows: Vec<[f64; 3]> = points.iter().map(|point| point.to_array()).collect();
    let all = scene.closest_points(&points);
    let at: Vec<f64> = all.iter().map(|found| found.distance).collect();
    let below: Vec<f64> = at.iter().map(|distance| distance.next_down()).collect();
    let found = by_columns(&scene, Vectors::F64(&rows), Scalars::F64(&at), rows.len());
    assert_eq!(found, all_bits(&all));
    let found = by_columns(&scene, Vectors::F64(&rows), Scalars::F64(&below), rows.len());
    assert!(found.iter().all(|found| found[6] == u64::from(u32::MAX)));
    let singles: Vec<[f32; 3]> = rows.iter().map(|row| row.map(|x| x as f32)).collect();
    let doubles: Vec<Vec3> = singles.iter().map(|&row| row.into()).collect();
    let found = by_columns(&scene, Vectors::F32(&singles), Scalars::Same(1.5), rows.len());
    assert_eq!(found, all_bits(&brute_force::closest_points(&mesh, &doubles, 1.5)));
}

#[test]
fn columns_of_other_lengths_are_refused() {
    let scene = Scene::new(soup([[Vec3::ZERO, vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)]])).unwrap();
    let ask = |points: Vectors, most: Scalars| {
        let (mut distance, mut point, mut face) = ([0.0; 2], [[0.0; 3]; 2], [0; 2]);
        let (mut uv, mut feature) = ([[0.0; 2]; 2], [0; 2]);
        let columns = ClosestPointColumns {
            distance: &mut distance,
            point: &mut point,
            face: &mut face,
            uv: &mut uv,
            feature: &mut feature,
        };
        scene.observed(&NoProgress).closest_points_columns(points, most, columns)
    };
    let most = Scalars::Same(1.0);
    assert!(ask(Vectors::F64(&[[0.0; 3]; 2]), most).is_ok());
    assert!(matches!(ask(Vectors::F64(&[[0.0; 3]; 3]), most), Err(Error::Invalid { .. })));
    let most = Scalars::F32(&[1.0]);
    assert!(matches!(ask(Vectors::Same([0.0; 3]), most), Err(Error::Invalid { .. })));
}

/// Wants the end after so many questions.
struct Impatient(AtomicIsize);

impl Observer for Impatient {
    fn cancelled(&self) -> bool {
        self.0.fetch_sub(1, Ordering::Relaxed) <= 0
    }
}

/// Triangles of one plane above which a point lies: all of them are equally near, and no two by the same part.
fn equally_near(count: i32) -> Mesh {
    soup((0..count).map(|i| {
        let x = f64::from(i) * 1e-3 + 1.0;
        [vec3(-x, -1.0, 1.0), vec3(x, -1.0 - x, 1.0), vec3(0.5, 3.0 + x, 1.0)]
    }))
}

#[test]
fn a_huge_tie_ends_and_can_be_interrupted() {
    let scene = Scene::new(equally_near(20_000)).unwrap();
    let answer = scene.closest_points(&[Vec3::ZERO])[0];
    assert_eq!((answer.face, answer.distance, answer.point), (0, 1.0, vec3(0.0, 0.0, 1.0)));
    // One is asked before the batch, and one within the query.
    let observer = Impatient(1.into());
    let interrupted = scene.observed(&observer).closest_points(&[Vec3::ZERO], f64::INFINITY);
    assert!(matches!(interrupted, Err(Error::Interrupted)));
    // Before the batch, within the query, and after what is left of it.
    assert!(observer.0.load(Ordering::Relaxed) <= -2, "the query did not ask");
    let sphere = Scene::new(common::sphere(6, Vec3::ZERO, 1.0)).unwrap();
    let expected = brute_force::closest_points(sphere.mesh(), &[Vec3::ZERO], f64::INFINITY);
    assert_eq!(all_bits(&sphere.closest_points(&[Vec3::ZERO])), all_bits(&expected));
}
