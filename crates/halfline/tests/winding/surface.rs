//! Points on the surface: contained, told, and with a number.

use halfline::{Scene, Vec3, vec3};

use crate::cases::direction;
use crate::random::Random;
use crate::shapes::{grid_cube, soup, sphere};

fn check_on_surface(scene: &Scene, points: &[Vec3]) {
    let numbers = scene.winding_numbers(points);
    for (i, is_inside) in scene.contains(points).into_iter().enumerate() {
        let parts = scene.explain_winding(points[i]);
        assert!(is_inside && parts.is_on_surface && numbers[i].is_finite(), "{:?}", points[i]);
    }
}

#[test]
fn points_on_faces_edges_and_vertices_are_contained() {
    let mut random = Random(31);
    let cube = Scene::new(grid_cube(2)).unwrap();
    let points: Vec<Vec3> = (0..2000)
        .map(|i| {
            let mut point = Vec3::from([0, 1, 2].map(|_| random.below(17) as f64 * 0.25 - 2.0));
            point[i % 3] = if random.below(2) == 0 { 2.0 } else { -2.0 };
            point
        })
        .collect();
    check_on_surface(&cube, &points);
    let numbers = cube.winding_numbers(&points);
    assert!(numbers.iter().all(|&number| number == 0.0 || number == 1.0));

    let ball = Scene::new(sphere(3, vec3(0.1, 0.2, 0.3), 1.7)).unwrap();
    let corners = (0..ball.mesh().triangle_count() as u32).map(|face| ball.mesh().corners(face));
    let points: Vec<Vec3> = corners.flatten().collect();
    check_on_surface(&ball, &points);
    // Half of it, with a border.
    let half = (0..ball.mesh().triangle_count() as u32).map(|face| ball.mesh().corners(face));
    let half = Scene::new(soup(half.filter(|t| t[0].z > 0.4))).unwrap();
    let corners = (0..half.mesh().triangle_count() as u32).map(|face| half.mesh().corners(face));
    check_on_surface(&half, &corners.flatten().collect::<Vec<_>>());
}

/// The ray lies within the triangle, which it so does not meet.
#[test]
fn points_on_a_triangle_along_the_ray_are_contained() {
    let along = direction();
    let corner = vec3(1.0, -1.0, 2.0);
    let side = vec3(0.0, 4.0, 0.0);
    let scene = Scene::new(soup([[corner, corner + along, corner + side]])).unwrap();
    let middle = corner + along * 0.25 + side * 0.25;
    let points = [corner, corner + along, corner + along * 0.5, corner + side, middle];
    check_on_surface(&scene, &points);
    let off = [corner - along, corner + along * 2.0, corner - side, middle + vec3(0.5, 0.0, 0.0)];
    for point in off {
        let parts = scene.explain_winding(point);
        assert!(!parts.is_on_surface && parts.winding_number.abs() < 0.5, "{parts:?}");
    }
}

/// Next to a surface by the last digit: never on it, and on the right side.
#[test]
fn neighbours_of_the_surface_are_on_their_sides() {
    let mut random = Random(32);
    let cube = Scene::new(grid_cube(2)).unwrap();
    let mut points = Vec::new();
    let mut expected = Vec::new();
    for i in 0..2000 {
        let mut point = random.point() * 1.9;
        let is_inside = i % 2 == 0;
        point[i % 3] = if is_inside { 2.0_f64.next_down() } else { 2.0_f64.next_up() };
        points.push(point);
        expected.push(is_inside);
    }
    assert_eq!(cube.contains(&points), expected);
    assert!(points.iter().all(|point| !cube.explain_winding(*point).is_on_surface));
}

/// So small that t rounds to zero: sides are told exactly nevertheless.
#[test]
fn the_smallest_distances_are_told() {
    let tiny = f64::from_bits(1);
    let corners = [vec3(-1., -1., 0.), vec3(1., -1., 0.), vec3(0., 1., 0.)];
    let tip = vec3(0.0, 0.0, 1.0);
    let [a, b, c] = corners;
    let scene = Scene::new(soup([[a, c, b], [a, b, tip], [b, c, tip], [c, a, tip]])).unwrap();
    let points = [vec3(0.0, 0.0, tiny), vec3(0.0, 0.0, 0.0), vec3(0.0, 0.0, -tiny)];
    assert_eq!(scene.contains(&points), [true, true, false]);
    let numbers = scene.winding_numbers(&points);
    assert_eq!((numbers[0], numbers[2]), (1.0, 0.0));
    assert_eq!(points.map(|p| scene.explain_winding(p).is_on_surface), [false, true, false]);
}
