//! Polygons are cut into triangles that cover them once, keep every corner, and turn their way.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use halfline::geometry::random::Random;
use halfline::geometry::{Vec3, vec3};
use halfline_io::triangulate::{Triangulator, triangulate};
use proptest::prelude::*;
use robust::{Coord, orient2d};

fn cut(corners: &[Vec3]) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    triangulate(corners, |t| triangles.push(t));
    triangles
}

fn flat(points: &[(f64, f64)]) -> Vec<Vec3> {
    points.iter().map(|&(x, y)| vec3(x, y, 0.0)).collect()
}

fn area(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c) / 2.0
}

fn polygon_area(corners: &[Vec3]) -> f64 {
    let mut sum = 0.0;
    for i in 1..corners.len() - 1 {
        sum += area(corners[0], corners[i], corners[i + 1]);
    }
    sum
}

fn total_area(corners: &[Vec3], triangles: &[[usize; 3]]) -> f64 {
    triangles.iter().map(|&[a, b, c]| area(corners[a], corners[b], corners[c])).sum()
}

/// Every edge of the polygon bounds one triangle, every other edge two, in opposite directions.
fn assert_edges_match(count: usize, triangles: &[[usize; 3]], name: &str) {
    let mut edges = HashMap::new();
    for &[a, b, c] in triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            assert!(edges.insert(edge, ()).is_none(), "{name}: edge {edge:?} twice");
        }
    }
    for i in 0..count {
        let rim = (i, (i + 1) % count);
        assert!(edges.remove(&rim).is_some(), "{name}: rim {rim:?} is missing");
    }
    for &(a, b) in edges.keys() {
        assert!(edges.contains_key(&(b, a)), "{name}: ({a}, {b}) has no partner");
    }
}

/// The triangles of a simple polygon in the plane z = 0, turning to the left: right if they have
/// the right edges, none is turned over, and together they have the polygon's area.
fn assert_cuts_simple_polygon(corners: &[Vec3], name: &str) {
    let triangles = cut(corners);
    assert_eq!(triangles.len(), corners.len() - 2, "{name}: number of triangles");
    assert_edges_match(corners.len(), &triangles, name);
    let mut sum = 0.0;
    for t in &triangles {
        let [a, b, c] = t.map(|i| corners[i]);
        assert!(area(a, b, c) >= 0.0, "{name}: triangle {t:?} is turned over");
        sum += area(a, b, c);
    }
    let whole = polygon_area(corners);
    assert!((sum - whole).abs() <= 1e-9 * whole, "{name}: area {sum}, not {whole}");
}

fn star(points: usize, inner: f64) -> Vec<Vec3> {
    (0..2 * points)
        .map(|i| {
            let radius = if i % 2 == 0 { 1.0 } else { inner };
            let angle = i as f64 / (2 * points) as f64 * TAU;
            vec3(radius * angle.cos(), radius * angle.sin(), 0.0)
        })
        .collect()
}

fn comb(teeth: usize) -> Vec<Vec3> {
    let mut corners = flat(&[(0.0, -1.0), (teeth as f64, -1.0)]);
    for i in (0..teeth).rev() {
        corners.push(vec3(i as f64 + 0.75, 1000.0, 0.0));
        corners.push(vec3(i as f64 + 0.5, 0.0, 0.0));
    }
    corners
}

fn spiral(steps: usize) -> Vec<Vec3> {
    let turns = (steps as f64).sqrt() / 4.0;
    let at = |i: usize, radius: f64| {
        let share = i as f64 / steps as f64;
        let (r, angle) = (radius + share * turns, share * turns * TAU);
        vec3(r * angle.cos(), r * angle.sin(), 0.0)
    };
    let outwards = (0..steps).map(|i| at(i, 1.4));
    outwards.chain((0..steps).rev().map(|i| at(i, 1.0))).collect()
}

fn snowflake(depth: u32) -> Vec<Vec3> {
    let mut ring = vec![(0.0, 0.0), (1.0, 0.0), (0.5, 0.75_f64.sqrt())];
    for _ in 0..depth {
        let mut finer = Vec::new();
        for i in 0..ring.len() {
            let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
            let (dx, dy) = ((b.0 - a.0) / 3.0, (b.1 - a.1) / 3.0);
            let (s, c) = (-(60.0_f64.to_radians()).sin(), 60.0_f64.to_radians().cos());
            let third = (a.0 + dx, a.1 + dy);
            let tip = (third.0 + c * dx - s * dy, third.1 + s * dx + c * dy);
            finer.extend([a, third, tip, (a.0 + 2.0 * dx, a.1 + 2.0 * dy)]);
        }
        ring = finer;
    }
    flat(&ring)
}

/// A square grid of notches: many corners in straight lines, touching none.
fn saw_in_lines(notches: usize) -> Vec<Vec3> {
    let mut corners = flat(&[(0.0, 0.0), (notches as f64 * 2.0, 0.0)]);
    for i in (0..notches).rev() {
        let x = 2.0 * i as f64;
        corners.extend(flat(&[(x + 2.0, 2.0), (x + 1.0, 2.0), (x + 1.0, 1.0), (x, 1.0)]));
    }
    corners
}

#[test]
fn simple_polygons_are_covered_exactly() {
    let square_with_straight_corners = flat(&[
        (0.0, 0.0),
        (1.0, 0.0),
        (2.0, 0.0),
        (3.0, 0.0),
        (3.0, 1.0),
        (3.0, 3.0),
        (2.0, 3.0),
        (1.0, 3.0),
        (0.0, 3.0),
        (0.0, 2.0),
    ]);
    let triangle_with_straight_side =
        flat(&[(0.0, 0.0), (3.0, 0.0), (0.0, 3.0), (0.0, 2.0), (0.0, 1.0)]);
    for (name, corners) in [
        ("pentagon with a dent", flat(&[(0., 0.), (4., 0.), (4., 4.), (2., 1.), (0., 4.)])),
        ("L", flat(&[(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)])),
        ("square with straight corners", square_with_straight_corners),
        ("triangle with a straight side", triangle_with_straight_side),
        ("star of 5", star(5, 0.2)),
        ("star of 50", star(50, 0.99)),
        ("comb of 3", comb(3)),
        ("comb of 100", comb(100)),
        ("spiral", spiral(300)),
        ("snowflake", snowflake(4)),
        ("saw", saw_in_lines(40)),
        ("round", star(100, 1.0)),
    ] {
        assert!(polygon_area(&corners) > 0.0, "{name} must turn to the left");
        assert_cuts_simple_polygon(&corners, name);
        for start in 1..corners.len().min(12) {
            let mut turned = corners.clone();
            turned.rotate_left(start);
            assert_cuts_simple_polygon(&turned, &format!("{name} from corner {start}"));
        }
    }
}

#[test]
fn a_hole_joined_by_a_cut_stays_a_hole() {
    // A square with a square hole, joined from (0, 0) to (1, 1) and back.
    let corners = flat(&[
        (0., 0.),
        (3., 0.),
        (3., 3.),
        (0., 3.),
        (0., 0.),
        (1., 1.),
        (1., 2.),
        (2., 2.),
        (2., 1.),
        (1., 1.),
    ]);
    for start in 0..corners.len() {
        let mut turned = corners.clone();
        turned.rotate_left(start);
        assert_cuts_simple_polygon(&turned, &format!("square with a hole from corner {start}"));
    }
    // Two holes that touch the rim at one corner, and each other.
    let corners = flat(&[
        (0., 0.),
        (6., 0.),
        (6., 6.),
        (0., 6.),
        (0., 0.),
        (1., 2.),
        (2., 2.),
        (2., 1.),
        (0., 0.),
        (2., 1.),
        (3., 3.),
        (3., 2.),
        (2., 1.),
    ]);
    let triangles = cut(&corners);
    let sum = total_area(&corners, &triangles);
    assert!((sum - polygon_area(&corners)).abs() < 1e-12);
}

#[test]
fn orientation_is_kept_in_every_plane() {
    let l = [(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)];
    let planes: [fn(f64, f64) -> Vec3; 4] = [
        |u, v| vec3(u, v, 5.0),
        |u, v| vec3(5.0, u, v),
        |u, v| vec3(v, 5.0, u),
        |u, v| vec3(u + v, v - u, 0.25 * u * v + 0.1 * v),
    ];
    for (number, plane) in planes.iter().enumerate() {
        for reversed in [false, true] {
            let mut corners: Vec<Vec3> = l.iter().map(|&(u, v)| plane(u, v)).collect();
            if reversed {
                corners.reverse();
            }
            let whole = (1..5).fold(Vec3::ZERO, |sum, i| {
                sum + (corners[i] - corners[0]).cross(corners[i + 1] - corners[0])
            });
            let triangles = cut(&corners);
            assert_eq!(triangles.len(), 4);
            assert_edges_match(6, &triangles, "L");
            for t in triangles {
                let [a, b, c] = t.map(|i| corners[i]);
                let normal = (b - a).cross(c - a);
                assert!(normal.dot(whole) > 0.0, "plane {number}, reversed {reversed}, {t:?}");
            }
        }
    }
}

#[test]
fn quads_take_the_diagonal_inside_or_the_shorter_one() {
    let along_02 = vec![[0, 1, 2], [0, 2, 3]];
    let along_13 = vec![[0, 1, 3], [1, 2, 3]];
    let square = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];
    let dart = [(0., 0.), (4., -2.), (1., 0.), (4., 2.)];
    let kite = [(0., 0.), (1., -0.5), (3., 0.), (1., 0.5)];
    let straight = [(0., 0.), (1., 0.), (2., 0.), (2., 5.)];
    for (name, points, expected) in [
        ("square", square, &along_02),
        ("kite", kite, &along_13),
        ("dart", dart, &along_02),
        ("corner 1 straight", straight, &along_13),
    ] {
        let mut corners = flat(&points);
        let mirrored: Vec<Vec3> = corners.iter().map(|p| vec3(-p.x, p.y, p.z)).collect();
        for (scale, offset) in [(1.0, 0.0), (1e-150, 0.0), (1e150, 0.0), (1.0, 4e6), (0.5, -3e14)] {
            for shape in [&corners, &mirrored] {
                let placed: Vec<Vec3> =
                    shape.iter().map(|&p| p * scale + Vec3::splat(offset)).collect();
                assert_eq!(&cut(&placed), expected, "{name} times {scale} at {offset}");
            }
        }
        corners.rotate_left(1);
        let other = if *expected == along_02 { &along_13 } else { &along_02 };
        if name != "square" {
            assert_eq!(&cut(&corners), other, "{name}, one corner on");
        }
    }
}

#[test]
fn far_away_polygons_are_cut_as_near_ones() {
    let near: Vec<Vec3> = star(7, 0.25).iter().map(|p| vec3(p.x, p.y, 0.5 * p.x)).collect();
    // Multiples of 2^-20 survive the move by 2^30 without rounding.
    let near: Vec<Vec3> = near
        .iter()
        .map(|p| {
            vec3((p.x * 1048576.0).round(), (p.y * 1048576.0).round(), (p.z * 1048576.0).round())
                * (1.0 / 1048576.0)
        })
        .collect();
    let far: Vec<Vec3> = near.iter().map(|&p| p + Vec3::splat(1073741824.0)).collect();
    assert_eq!(cut(&near), cut(&far));
    for scale in [2.0_f64.powi(-600), 2.0_f64.powi(600)] {
        let scaled: Vec<Vec3> = near.iter().map(|&p| p * scale).collect();
        assert_eq!(cut(&near), cut(&scaled), "scale {scale:e}");
    }
}

#[test]
fn repeated_corners_make_fewer_triangles() {
    let square = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];
    for repeated in 0..4 {
        let mut points = Vec::new();
        for (i, &p) in square.iter().enumerate() {
            points.push(p);
            if i == repeated {
                points.extend([p, p]);
            }
        }
        let corners = flat(&points);
        let triangles = cut(&corners);
        assert_eq!(triangles.len(), 2, "corner {repeated} thrice: {triangles:?}");
        let sum = total_area(&corners, &triangles);
        assert_eq!(sum, 1.0);
    }
    assert_eq!(cut(&flat(&[(0., 0.), (1., 0.), (1., 1.), (1., 1.)])).len(), 1);
    assert_eq!(cut(&flat(&[(0., 0.), (1., 0.), (1., 0.)])), [[0, 1, 2]], "triangles are kept");
    assert_eq!(cut(&flat(&[(1., 1.); 9])).len(), 0);
}

#[test]
fn hopeless_polygons_become_fans() {
    let nan = vec3(f64::NAN, 0.0, 0.0);
    let mut broken = star(4, 0.5);
    broken[3] = nan;
    let fan: Vec<[usize; 3]> = (2..8).map(|i| [0, i - 1, i]).collect();
    assert_eq!(cut(&broken), fan);
    broken[3] = vec3(0.0, f64::INFINITY, 0.0);
    assert_eq!(cut(&broken), fan);
    broken[3] = vec3(0.0, f64::MAX, 0.0);
    broken[5] = vec3(0.0, f64::MIN, 0.0);
    assert_eq!(cut(&broken).len(), 6, "huge, but finite");
    let line: Vec<Vec3> = (0..8).map(|i| vec3(i as f64, 2.0 * i as f64, 0.0)).collect();
    assert_eq!(cut(&line), fan);
    for few in 0..3 {
        assert!(cut(&line[..few]).is_empty());
    }
}

/// How long the processor has worked for this thread; where the system does not tell, the time that passed.
fn cpu_time() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    // Nanoseconds of work, nanoseconds of waiting for a processor, slices.
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let worked = statistics
        .split(' ')
        .next()
        .and_then(|word| word.parse().ok())
        .filter(|&worked| worked > 0);
    worked.map_or_else(|| START.elapsed(), Duration::from_nanos)
}

#[test]
fn large_polygons_end_in_time() {
    let random = |count: usize| -> Vec<Vec3> {
        let mut random = Random::new(1, 0);
        (0..count).map(|_| vec3(random.unit(), random.unit(), 0.0)).collect()
    };
    for (name, corners, simple) in [
        ("round", star(50_000, 1.0), true),
        ("star", star(50_000, 0.3), true),
        ("fine star", star(50_000, 0.999999), true),
        ("comb", comb(50_000), true),
        ("spiral", spiral(50_000), true),
        ("snowflake", snowflake(7), true),
        ("saw", saw_in_lines(25_000), true),
        ("crossing itself everywhere", random(100_000), false),
    ] {
        let start = cpu_time();
        if simple {
            assert_cuts_simple_polygon(&corners, name);
        } else {
            assert_eq!(cut(&corners).len(), corners.len() - 2, "{name}");
        }
        let took = cpu_time() - start;
        println!("{name}: {} corners in {took:?}", corners.len());
        assert!(took < Duration::from_secs(60), "{name} took {took:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn star_shaped_polygons_are_covered(radii in prop::collection::vec(0.01..1.0_f64, 5..200)) {
        let count = radii.len() as f64;
        let corners: Vec<Vec3> = radii.iter().enumerate().map(|(i, r)| {
            let angle = i as f64 / count * TAU;
            vec3(r * angle.cos(), r * angle.sin(), 0.0)
        }).collect();
        assert_cuts_simple_polygon(&corners, "star-shaped");
    }

    #[test]
    fn any_corners_give_valid_triangles(
        points in prop::collection::vec((0..5_i32, 0..5_i32, 0..2_i32), 0..40),
    ) {
        let corners: Vec<Vec3> =
            points.iter().map(|&(x, y, z)| vec3(x.into(), y.into(), z.into())).collect();
        let mut triangulator = Triangulator::new();
        let mut triangles = Vec::new();
        triangulator.triangulate(&corners, |t| triangles.push(t));
        prop_assert!(triangles.len() <= corners.len().saturating_sub(2));
        for t in &triangles {
            prop_assert!(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
            prop_assert!(t.iter().all(|&i| i < corners.len()));
        }
        let mut again = Vec::new();
        triangulator.triangulate(&corners, |t| again.push(t));
        prop_assert_eq!(triangles, again, "a used triangulator works as a fresh one");
    }
}
