//! Winding numbers and what is inside, against the judge.

use halfline::columns::Column;
use halfline::mesh::Positions;
use halfline::progress::NoProgress;
use halfline::{Inside, Mesh, Scene, Vec3, vec3};

use crate::cases::{self, direction, point, triangles};
use crate::judge::winding_number;
use crate::random::Random;
use crate::shapes::{soup, sphere};

/// Points of a mesh that are off its surface.
fn points_off(scene: &Scene, random: &mut Random, count: usize) -> Vec<Vec3> {
    let finite = |corners: &[Vec3; 3]| corners.iter().all(|corner| corner.is_finite());
    let corners: Vec<_> = triangles(scene.mesh()).into_iter().filter(finite).collect();
    let along = direction();
    let mut points = Vec::with_capacity(count);
    while points.len() < count {
        let point = point(random, &corners, along);
        if !scene.explain_winding(point).is_on_surface {
            points.push(point);
        }
    }
    points
}

/// Holds a scene's answers against the judge's.
fn check(name: &str, scene: &Scene, points: &[Vec3]) {
    let is_closed = scene.boundary().edge_count() == 0;
    let numbers = scene.winding_numbers(points);
    let inside = scene.contains(points);
    for (i, point) in points.iter().enumerate() {
        let expected = winding_number(scene.mesh(), *point);
        let number = numbers[i];
        if is_closed {
            assert_eq!(number, expected.round(), "{name}: {point:?} {expected}");
        }
        assert!((number - expected).abs() <= 1e-9, "{name}: {number} {expected} {point:?}");
        if (expected - 0.5).abs() > 1e-9 {
            assert_eq!(inside[i], expected > 0.5, "{name}: {point:?} {expected}");
        }
        let parts = scene.explain_winding(*point);
        assert_eq!(parts.winding_number.to_bits(), number.to_bits());
        assert!(parts.boundary_error <= 1e-9 && (parts.boundary_error == 0.0) == is_closed);
    }
}

#[test]
fn closed_surfaces_have_exact_integers() {
    let mut random = Random(21);
    let meshes = cases::closed(&mut random);
    let count = cases::points(0.03) / meshes.len();
    for (i, mesh) in meshes.into_iter().enumerate() {
        let scene = Scene::new(mesh).unwrap();
        assert_eq!(scene.boundary().edge_count(), 0, "{i}");
        let points = points_off(&scene, &mut random, count);
        check(&format!("closed {i}"), &scene, &points);
    }
}

#[test]
fn open_surfaces_have_the_sum_of_solid_angles() {
    let mut random = Random(22);
    let meshes = cases::open(&mut random);
    let count = cases::points(0.03) / meshes.len();
    for (i, mesh) in meshes.into_iter().enumerate() {
        let scene = Scene::new(mesh).unwrap();
        assert!(scene.boundary().edge_count() > 0, "{i}");
        let points = points_off(&scene, &mut random, count);
        check(&format!("open {i}"), &scene, &points);
    }
}

/// The same shapes small, large, and far away: there the points are on no surface for certain but in general.
#[test]
fn neither_size_nor_place_matters() {
    let mut random = Random(23);
    let moves: [(f64, Vec3); 5] = [
        (1e30, Vec3::ZERO),
        (1e-30, Vec3::ZERO),
        (2.0_f64.powi(-300), Vec3::ZERO),
        (2.0_f64.powi(300), Vec3::ZERO),
        (1.0, vec3(432_100.25, 5_412_345.5, 312.125)),
    ];
    let meshes = [cases::closed(&mut random), cases::open(&mut random)].concat();
    let count = cases::points(0.03) / (meshes.len() * moves.len());
    for (i, mesh) in meshes.iter().enumerate() {
        let original = Scene::new(mesh.clone()).unwrap();
        for (scale, offset) in moves {
            let to = |p: Vec3| p * scale + offset;
            let moved = soup(triangles(mesh).into_iter().map(|corners| corners.map(to)));
            let scene = Scene::new(moved).unwrap();
            let points = points_off(&original, &mut random, count);
            let points: Vec<Vec3> = points.into_iter().map(to).collect();
            let off = |p: &Vec3| !scene.explain_winding(*p).is_on_surface;
            let points: Vec<Vec3> = points.into_iter().filter(off).collect();
            // Rounded squares are no longer flat, so only what is closed by its coordinates is.
            check(&format!("{i} times {scale} at {offset:?}"), &scene, &points);
        }
    }
}

/// Long boundaries are mostly seen from afar.
#[test]
fn hierarchies_of_edges_are_within_their_bounds() {
    let mut random = Random(24);
    let all = triangles(&sphere(5, vec3(0.3, -0.2, 0.1), 1.0));
    let holes = all.iter().copied().filter(|_| random.below(8) != 0).collect::<Vec<_>>();
    let half = all.iter().copied().filter(|t| t[0].x + t[1].y > t[2].z * 0.3).collect::<Vec<_>>();
    let noisy = half.iter().map(|t| t.map(|p| p + vec3(0.0, 0.0, (p.x * 70.0).sin() * 0.05)));
    let noisy = noisy.collect::<Vec<_>>();
    let count = cases::points(0.0004);
    for (name, part) in [("holes", holes), ("half", half), ("noisy", noisy)] {
        let mesh = soup(part);
        let scene = Scene::new(mesh).unwrap();
        let mut points = points_off(&scene, &mut random, count);
        points.extend((0..count).map(|_| random.point() * 1.5));
        points.extend((0..count).map(|i| random.point() * 2.0_f64.powi(i as i32 % 30)));
        check(name, &scene, &points);
    }
}

/// Points whose winding number is as near to one half as bisection finds them: a coarse sum is not enough there.
#[test]
fn what_is_inside_is_decided_with_certainty() {
    let mut random = Random(27);
    let all = triangles(&sphere(5, Vec3::ZERO, 1.0));
    let half = all.into_iter().filter(|t| t[0].z + t[1].z + t[2].z > 0.1 * t[0].x);
    let scene = Scene::new(soup(half)).unwrap();
    for turn in 0..24 {
        let mut outside = vec3(random.signed() * 0.5, random.signed() * 0.5, -0.7);
        let mut inside = vec3(outside.x, outside.y, 0.6);
        for _ in 0..14 + turn {
            let middle = (outside + inside) * 0.5;
            let number = scene.winding_numbers(&[middle])[0];
            *(if number > 0.5 { &mut inside } else { &mut outside }) = middle;
        }
        let points = [outside, inside];
        let expected = points.map(|point| winding_number(scene.mesh(), point));
        for (i, is_inside) in scene.contains(&points).into_iter().enumerate() {
            if (expected[i] - 0.5).abs() > 1e-9 {
                assert_eq!(is_inside, expected[i] > 0.5, "{turn}: {} {:?}", expected[i], points[i]);
            }
        }
    }
}

#[test]
fn parts_of_a_closed_surface_add_up() {
    let mut random = Random(25);
    for turn in 0..4 {
        let all = triangles(&sphere(4, Vec3::ZERO, 2.0));
        let side = |t: &[Vec3; 3], random: &mut Random| match turn {
            0 => random.below(2) == 0,
            1 => t[0].x > 0.3,
            2 => t[0].x * t[0].y > t[0].z,
            _ => random.below(100) == 0,
        };
        let (first, second): (Vec<_>, Vec<_>) = all.into_iter().partition(|t| side(t, &mut random));
        let whole = Scene::new(soup(first.iter().chain(&second).copied())).unwrap();
        let points = points_off(&whole, &mut random, cases::points(0.005));
        let [first, second, whole] =
            [Scene::new(soup(first)).unwrap(), Scene::new(soup(second)).unwrap(), whole]
                .map(|scene| scene.winding_numbers(&points));
        for i in 0..points.len() {
            let sum = first[i] + second[i];
            assert!((sum - whole[i]).abs() <= 2e-9, "{turn}: {sum} {} {:?}", whole[i], points[i]);
        }
    }
}

/// Where triangles are turned over at random, only parity tells the inside.
#[test]
fn parity_needs_no_orientation() {
    let mut random = Random(26);
    let mut all = triangles(&sphere(3, Vec3::ZERO, 2.0));
    for triangle in &mut all {
        if random.below(2) == 0 {
            triangle.swap(1, 2);
        }
    }
    let scene = Scene::new(soup(all)).unwrap();
    let points = points_off(&scene, &mut random, cases::points(0.01));
    let rows: Vec<[f64; 3]> = points.iter().map(|point| point.to_array()).collect();
    let mut flags = vec![false; points.len()];
    let observed = scene.observed(&NoProgress);
    observed.contains_columns(Column::F64(&rows), Inside::Parity, &mut flags).unwrap();
    let whole = Scene::new(sphere(3, Vec3::ZERO, 2.0)).unwrap();
    assert_eq!(flags, whole.contains(&points));
}

/// Equal places are one vertex, however their zeros are signed and whatever their numbers.
#[test]
fn vertices_are_one_by_place() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let again = corners.map(|corner| corner.map(|x| -x)).map(|corner| corner.map(|x| -x));
    let mut vertices: Vec<[f64; 3]> = corners.to_vec();
    vertices.extend(again.map(|corner| corner.map(|x| if x == 0.0 { -0.0 } else { x })));
    let faces = vec![[0, 6, 1], [4, 1, 7], [0, 3, 2], [5, 2, 3]];
    let scene = Scene::new(Mesh::new(Positions::F64(vertices.into()), faces).unwrap()).unwrap();
    assert_eq!(scene.boundary().edge_count(), 0);
    assert_eq!(scene.winding_numbers(&[vec3(0.1, 0.1, 0.1)]), [1.0]);
}

#[test]
fn points_that_are_not_finite_are_nowhere() {
    let scene = Scene::new(sphere(1, Vec3::ZERO, 1.0)).unwrap();
    let points = [vec3(f64::NAN, 0.0, 0.0), vec3(0.0, f64::INFINITY, 0.0), Vec3::ZERO];
    let numbers = scene.winding_numbers(&points);
    assert!(numbers[0].is_nan() && numbers[1].is_nan() && numbers[2] == 1.0);
    assert_eq!(scene.contains(&points), [false, false, true]);
    let empty = Scene::new(Mesh::new(Vec::<[f64; 3]>::new(), Vec::new()).unwrap()).unwrap();
    assert_eq!(empty.winding_numbers(&points[2..]), [0.0]);
}
