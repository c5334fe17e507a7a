//! What "closed triangles" means for all hits: one at the border of an open surface, and still the
//! right parity where surfaces are closed.

use crate::common::contact::{Answers, Case, Range};
use crate::common::engines::{build_variants, by_batch, by_brute_force, by_engine, by_textbook};
use crate::common::{grid_cube, in_single_precision, soup};
use halfline::mesh::Positions;
use halfline::progress::NoProgress;
use halfline::textbook::{KdTree, Middle, Termination};
use halfline::{Mesh, Ray, Scene, Vec3};

type Triangle = [[f64; 3]; 3];

/// Triangles that share no vertex, so that edges are known by their places alone.
fn mesh(triangles: &[Triangle]) -> Mesh {
    soup(triangles.iter().map(|corners| corners.map(Vec3::from)))
}

/// What all engines say of each ray; they and the rational judge must agree.
fn answers(mesh: &Mesh, rays: &[Ray]) -> Vec<Answers> {
    let expected: Vec<Answers> = rays.iter().map(|ray| by_brute_force(mesh, ray)).collect();
    for (ray, answers) in rays.iter().zip(&expected) {
        let contacts = crate::common::exact::contacts(mesh, ray);
        let case = Case::new(*ray, contacts, Range::Fixed(ray.t_min, ray.t_max));
        assert!(answers.are_right(&case.contacts), "{answers:?} for {case:?}");
    }
    let textbook = KdTree::init_kd_tree(mesh, &Middle, &Termination::automatic(40));
    for (ray, expected) in rays.iter().zip(&expected) {
        assert_eq!(by_textbook(&textbook, ray), *expected, "textbook, {ray:?}");
    }
    for parameters in build_variants() {
        for mesh in [mesh.clone(), in_single_precision(mesh)] {
            let mut scene = Scene::builder(mesh)
                .parameters(parameters)
                .observer(&NoProgress)
                .build()
                .expect("builds");
            assert!(by_batch(&mut scene, rays) == expected, "batch, {parameters:?}");
            for (ray, expected) in rays.iter().zip(&expected) {
                assert_eq!(by_engine(&scene, ray), *expected, "{parameters:?}, {ray:?}");
            }
        }
    }
    expected
}

/// Rays through each of the points, from both ends of each direction. All numbers are few bits long,
/// so that they pass through the points exactly.
fn rays_through(points: &[[f64; 3]], directions: &[[f64; 3]]) -> Vec<Ray> {
    let mut rays = Vec::new();
    for (&point, &direction) in points.iter().flat_map(|p| directions.iter().map(move |d| (p, d))) {
        let (point, direction) = (Vec3::from(point), Vec3::from(direction));
        rays.push(Ray::new(point - direction * 4.0, direction));
        rays.push(Ray::new(point + direction * 4.0, -direction));
    }
    rays
}

/// Upright and slanted, none of them within a plane z = const.
const DIRECTIONS: [[f64; 3]; 7] = [
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 2.0],
    [0.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 4.0],
    [-2.0, -1.0, 1.0],
    [0.25, -0.5, 1.0],
];

/// Each ray hits once: closest, any and all agree.
fn assert_one_hit(mesh: &Mesh, rays: &[Ray]) {
    for (ray, answers) in rays.iter().zip(answers(mesh, rays)) {
        assert!(answers.any, "{ray:?}");
        assert_eq!(answers.all.len(), 1, "{ray:?} hits {:?}", answers.all);
        assert_eq!(answers.all[0].t, answers.closest.t, "{ray:?}");
    }
}

fn assert_no_hit(mesh: &Mesh, rays: &[Ray]) {
    for (ray, answers) in rays.iter().zip(answers(mesh, rays)) {
        assert!(!answers.any && answers.all.is_empty(), "{ray:?} hits {answers:?}");
    }
}

/// A sheet of squares, each cut in two, with corners at whole x and y up to `n`.
fn sheet(n: i32, z: f64) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let p = |di: i32, dj: i32| [f64::from(i + di), f64::from(j + dj), z];
        triangles.push([p(0, 0), p(1, 0), p(1, 1)]);
        triangles.push([p(0, 0), p(1, 1), p(0, 1)]);
    }
    triangles
}

/// Each quarter of a unit from `from` to `to` in both coordinates.
fn lattice(from: i32, to: i32, z: f64) -> Vec<[f64; 3]> {
    let range = || 4 * from..=4 * to;
    range()
        .flat_map(|x| range().map(move |y| [f64::from(x) / 4.0, f64::from(y) / 4.0, z]))
        .collect()
}

#[test]
fn a_triangle_is_closed_at_its_edges_and_vertices() {
    let [a, b, c] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [1.0, 3.0, 0.0]];
    let met = [a, b, c, [2.0, 0.0, 0.0], [2.5, 1.5, 0.0], [0.5, 1.5, 0.0], [1.0, 1.0, 0.0]];
    let missed = [[-1.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 3.5, 0.0], [2.75, 1.5, 0.0]];
    for triangle in [[a, b, c], [b, c, a], [c, b, a]] {
        let mesh = mesh(&[triangle]);
        assert_one_hit(&mesh, &rays_through(&met, &DIRECTIONS));
        assert_no_hit(&mesh, &rays_through(&missed, &DIRECTIONS));
    }
}

#[test]
fn a_sheet_is_hit_once_everywhere_and_at_its_border() {
    let points = lattice(0, 3, 0.5);
    assert_one_hit(&mesh(&sheet(3, 0.5)), &rays_through(&points, &DIRECTIONS));
    let outside: Vec<[f64; 3]> = lattice(-1, 4, 0.5)
        .into_iter()
        .filter(|p| p[..2].iter().any(|x| !(0.0..=3.0).contains(x)))
        .collect();
    assert_no_hit(&mesh(&sheet(3, 0.5)), &rays_through(&outside, &DIRECTIONS));
}

#[test]
fn a_sheet_with_shared_vertices_is_the_same() {
    let vertices = (0..16).map(|i| [f64::from(i % 4), f64::from(i / 4), 0.5]);
    let cell = |i: u32| [[i, i + 1, i + 5], [i, i + 5, i + 4]];
    let faces: Vec<_> = [0, 1, 2, 4, 5, 6, 8, 9, 10].into_iter().flat_map(cell).collect();
    let mesh = Mesh::new(Positions::F64(vertices.collect()), faces).expect("a valid mesh");
    assert_one_hit(&mesh, &rays_through(&lattice(0, 3, 0.5), &DIRECTIONS));
}

#[test]
fn two_sheets_are_hit_twice() {
    let two = mesh(&[sheet(2, 0.0), sheet(2, 1.0)].concat());
    let upright = rays_through(&lattice(0, 2, 0.0), &DIRECTIONS[..1]);
    for (ray, answers) in upright.iter().zip(answers(&two, &upright)) {
        assert_eq!(answers.all.len(), 2, "{ray:?} hits {:?}", answers.all);
        assert!(answers.all[0].t < answers.all[1].t);
        assert_eq!(answers.all[0].t, answers.closest.t, "{ray:?}");
    }
    // Two sheets that only touch each other along a line are one.
    let mut moved = sheet(2, 0.0);
    moved.iter_mut().flatten().for_each(|p| p[0] -= 2.0);
    let one = mesh(&[sheet(2, 0.0), moved].concat());
    let points: Vec<[f64; 3]> = (0..=8).map(|y| [0.0, f64::from(y) / 4.0, 0.0]).collect();
    assert_one_hit(&one, &rays_through(&points, &DIRECTIONS));
}

#[test]
fn the_range_of_a_ray_may_end_at_the_border() {
    let triangle = mesh(&[[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [1.0, 3.0, 0.0]]]);
    let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [1.0, 3.0, 0.0], [2.0, 0.0, 0.0]];
    let whole = rays_through(&corners, &DIRECTIONS);
    let with = |t_min: f64, t_max: f64| -> Vec<Ray> {
        whole.iter().map(|ray| Ray { t_min, t_max, ..*ray }).collect()
    };
    for (t_min, t_max) in [(4.0, 4.0), (4.0, 9.0), (0.0, 4.0)] {
        assert_one_hit(&triangle, &with(t_min, t_max));
    }
    assert_no_hit(&triangle, &with(4.0f64.next_up(), 9.0));
    assert_no_hit(&triangle, &with(0.0, 4.0f64.next_down()));
}

/// A fan around the hub, open or closed, flat or pointed.
fn fan(rim: &[[f64; 3]], hub: [f64; 3], is_closed: bool) -> Vec<Triangle> {
    let count = if is_closed { rim.len() } else { rim.len() - 1 };
    (0..count).map(|i| [hub, rim[i], rim[(i + 1) % rim.len()]]).collect()
}

#[test]
fn fans_are_hit_once_at_rim_and_hub() {
    let rim = [
        [2.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 2.0, 0.0],
        [-2.0, 1.0, 0.0],
        [-1.0, -1.0, 0.0],
        [0.0, -2.0, 0.0],
    ];
    let middle = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|axis| (p[axis] + q[axis]) / 2.0);
    let hub = [0.0; 3];
    for is_closed in [false, true] {
        let mut points = rim.to_vec();
        points.push(hub);
        for [a, p, q] in fan(&rim, hub, is_closed) {
            points.extend([middle(p, q), middle(a, p), middle(a, q)]);
        }
        assert_one_hit(&mesh(&fan(&rim, hub, is_closed)), &rays_through(&points, &DIRECTIONS));
    }
}

/// What passes a closed surface's edges and vertices on the outside crosses it never or twice, and
/// a pointed open fan's tip, where no edge is open, is no border either.
#[test]
fn silhouettes_touched_from_outside_stay_even() {
    let tent = |y: f64| {
        let rim = [[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0]];
        fan(&rim, [0.0, y, 2.0], true)
    };
    let across = [[1.0, 0.0, 0.0], [1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [-0.5, 1.0, 0.0]];
    for y in [0.0, 0.5] {
        let tip = mesh(&tent(y));
        let rays = rays_through(&[[0.0, y, 2.0]], &across);
        for (ray, answers) in rays.iter().zip(answers(&tip, &rays)) {
            assert!(answers.any, "{ray:?}");
            assert!(answers.all.len().is_multiple_of(2), "{ray:?} hits {:?}", answers.all);
        }
    }

    // Over the edges of a cube and its corners, at whole and half coordinates.
    let cube = grid_cube(1);
    let mut points = Vec::new();
    for (axis, step) in (0..3).flat_map(|axis| (-2..=2).map(move |step| (axis, step))) {
        for (p, q) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let mut point = [p; 3];
            point[axis] = f64::from(step) / 2.0;
            point[(axis + 1) % 3] = q;
            points.push(point);
        }
    }
    let steps = -2..=2;
    let directions: Vec<[f64; 3]> = steps
        .clone()
        .flat_map(|x| steps.clone().map(move |y| (x, y)))
        .flat_map(|(x, y)| (-2..=2).map(move |z| [x, y, z].map(f64::from)))
        .filter(|&d| d != [0.0; 3])
        .collect();
    let rays: Vec<Ray> = points
        .iter()
        .flat_map(|&p| directions.iter().map(move |&d| (Vec3::from(p), Vec3::from(d))))
        .map(|(p, d)| Ray::new(p - d * 4.0, d))
        .collect();
    // Enough for all variants in little time, and a step that no other here divides.
    let rays: Vec<Ray> = rays.into_iter().step_by(7).collect();
    let mut touched = 0;
    for (ray, answers) in rays.iter().zip(answers(&cube, &rays)) {
        assert!(answers.all.len().is_multiple_of(2), "{ray:?} hits {:?}", answers.all);
        touched += usize::from(answers.any && answers.all.is_empty());
    }
    assert!(touched > 20, "only {touched} rays touch and do not cross");
}

/// A tetrahedron one edge of which has a vertex in its middle on one side only: a triangle without
/// area closes the gap, and without it the edge is open.
#[test]
fn faces_without_area_close_t_junctions() {
    // The infinitesimal moves rays to one of the two sides: off the surface, or into it.
    for (side, crossings) in [(1.0, 2), (-1.0, 0)] {
        let [a, b, c, d] =
            [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0 * side, 0.0], [0.0, 0.0, 4.0]];
        let m = [2.0, 0.0, 0.0];
        let open = [[a, c, b], [a, m, d], [m, b, d], [b, c, d], [c, a, d]];
        let closed = [&open[..], &[[a, b, m]]].concat();
        let hits = |triangles: &[Triangle], rays: &[Ray]| -> Vec<usize> {
            answers(&mesh(triangles), rays).iter().map(|answers| answers.all.len()).collect()
        };

        // Past the edge from a to b, touching it without entering.
        let past = [[1.0, 1.0, 1.0], [0.0, 1.0, 1.0], [-1.0, 2.0, 1.0], [1.0, 1.0, 2.0]]
            .map(|[x, y, z]| [x, -y * side, z]);
        let on_edge = [m, [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        let rays = rays_through(&on_edge, &past);
        assert_eq!(hits(&closed, &rays), vec![crossings; rays.len()]);

        // From inside, through the same points, the number is odd.
        let inside = Vec3::from([0.5, 0.5 * side, 0.5]);
        let out = on_edge.map(|p| Ray::new(inside, Vec3::from(p) - inside));
        assert_eq!(hits(&closed, &out), [1, 1, 1]);

        // Without it the edges are open, and what only touches them hits.
        assert_eq!(hits(&open, &rays), vec![crossings.max(1); rays.len()]);
    }
}

/// A vertex of very many triangles, looked up once for all of them.
#[test]
fn a_hub_of_many_triangles_is_no_burden() {
    let count = 200_000;
    let rim = |i: usize| {
        let angle = (i % count) as f64 / count as f64 * std::f64::consts::TAU;
        [angle.cos(), angle.sin(), -1.0]
    };
    let tip = mesh(&(0..count).map(|i| [[0.0; 3], rim(i), rim(i + 1)]).collect::<Vec<_>>());
    let scene = Scene::new(tip).expect("builds");
    let past = Ray::new([-4.0, 0.0, 0.0].into(), [1.0, 0.0, 0.0].into());
    let answers = by_engine(&scene, &past);
    assert_eq!((answers.closest.t, answers.any), (4.0, true));
    assert!(answers.all.len().is_multiple_of(2), "{}", answers.all.len());
}
