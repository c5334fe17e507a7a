//! Meshes without and with a boundary, and points that are level with their vertices and edges, seen along the
//! direction in which crossings are counted as well.

use halfline::{Mesh, Scene, Vec3, vec3};

use crate::random::Random;
use crate::shapes::{grid_cube, soup, sphere};

/// A part of the points that all tests ask about; `make test-long` asks for more.
pub fn points(share: f64) -> usize {
    let all = std::env::var("HALFLINE_TEST_RAYS")
        .map_or(500_000, |rays| rays.parse().expect("HALFLINE_TEST_RAYS is a number of rays"));
    (f64::from(all) * share).ceil() as usize
}

pub fn triangles(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    (0..mesh.triangle_count() as u32).map(|face| mesh.corners(face)).collect()
}

/// A corner of a small grid.
fn corner(random: &mut Random, n: usize) -> Vec3 {
    Vec3::from([0, 1, 2].map(|_| random.below(n) as f64))
}

fn tetrahedron([a, b, c, d]: [Vec3; 4]) -> [[Vec3; 3]; 4] {
    [[a, c, b], [a, b, d], [b, c, d], [a, d, c]]
}

/// Closed surfaces that wind around points any number of times, in both senses.
pub fn closed(random: &mut Random) -> Vec<Mesh> {
    let grid = |random: &mut Random, count| {
        let solids = (0..count).flat_map(|_| tetrahedron([0; 4].map(|_| corner(random, 5))));
        soup(solids.collect::<Vec<_>>())
    };
    let free = (0..30).flat_map(|_| tetrahedron([0; 4].map(|_| random.point() * 4.0)));
    let free = soup(free.collect::<Vec<_>>());
    // Faces that are doubled and turned over cancel each other.
    let mut doubled = triangles(&grid_cube(1));
    let face = doubled[3];
    doubled.extend([face, [face[0], face[2], face[1]], face, [face[1], face[0], face[2]]]);
    // A T-junction that a triangle without area closes.
    let [a, b, c, d] = [vec3(0., 0., 0.), vec3(4., 0., 0.), vec3(0., 4., 0.), vec3(0., 0., 4.)];
    let m = vec3(2., 0., 0.);
    let junction = [[a, c, m], [m, c, b], [a, b, d], [a, m, b], [b, c, d], [a, d, c]];
    vec![
        grid_cube(2),
        sphere(2, vec3(1.0, 2.0, 3.0), 2.5),
        grid(random, 12),
        grid(random, 40),
        free,
        soup(doubled),
        soup(junction),
    ]
}

/// Surfaces with a net boundary.
pub fn open(random: &mut Random) -> Vec<Mesh> {
    let grid = (0..60).map(|_| [0; 3].map(|_| corner(random, 5))).collect::<Vec<_>>();
    let free = (0..80).map(|_| [0; 3].map(|_| random.point() * 4.0)).collect::<Vec<_>>();
    // Pages around one edge, in both senses, some of them twice.
    let (a, b) = (vec3(0.0, 0.0, 0.0), vec3(0.0, 0.0, 3.0));
    let page = |i: usize| {
        let tip = [vec3(2., 0., 1.), vec3(0., 2., 1.), vec3(-2., 0., 2.), vec3(0., -2., 0.)][i % 4];
        if i.is_multiple_of(3) { [a, b, tip] } else { [b, a, tip] }
    };
    let mut flipped = triangles(&grid_cube(2));
    for triangle in &mut flipped {
        if random.below(3) == 0 {
            triangle.swap(0, 1);
        }
    }
    let cut = triangles(&sphere(3, Vec3::ZERO, 3.0));
    let cut = cut.into_iter().filter(|_| random.below(5) != 0).collect::<Vec<_>>();
    let half = triangles(&sphere(3, Vec3::ZERO, 3.0));
    let half = half.into_iter().filter(|t| t[0].z + t[1].z + t[2].z > 0.4).collect::<Vec<_>>();
    let square = [vec3(0., 0., 0.), vec3(4., 0., 0.), vec3(4., 4., 0.), vec3(0., 4., 0.)];
    let mut broken = grid.clone();
    broken.push([vec3(f64::NAN, 0., 0.), vec3(1., 0., 0.), vec3(0., 1., 0.)]);
    broken.push([vec3(1., 1., 1.), vec3(1., 1., 1.), vec3(0., f64::INFINITY, 0.)]);
    broken.push([vec3(1., 1., 1.), vec3(1., 1., 1.), vec3(0., 1., 0.)]);
    broken.push([vec3(0., 0., 0.), vec3(2., 2., 2.), vec3(1., 1., 1.)]);
    vec![
        soup(grid),
        soup(free),
        soup((0..7).map(page)),
        soup(flipped),
        soup(cut),
        soup(half),
        soup([[square[0], square[1], square[2]], [square[0], square[2], square[3]]]),
        soup(broken),
    ]
}

/// The direction of the crossings. It has so few digits that a small grid's point less it is exact.
pub fn direction() -> Vec3 {
    let scene = Scene::new(soup([[Vec3::ZERO, vec3(1., 0., 0.), vec3(0., 1., 0.)]])).unwrap();
    scene.explain_winding(Vec3::ZERO).direction
}

/// A point: of a grid, at random, or one from which the ray passes through, or close to, a vertex or an edge. None is
/// nearer to an edge than 1e-13, where the judge's denominator, about the square of that, has few digits left.
pub fn point(random: &mut Random, corners: &[[Vec3; 3]], along: Vec3) -> Vec3 {
    let [a, b, c] = corners[random.below(corners.len())];
    let halves = |n: usize| n as f64 * 0.5 - 3.0;
    let place = match random.below(9) {
        0 => return Vec3::from([0, 1, 2].map(|_| halves(random.below(19)))),
        1 => return random.point() * 6.0,
        2 => return a + random.point() * 0.1_f64.powi(random.below(13) as i32),
        3 => {
            let middle = a + (b - a) * random.unit();
            return middle + random.point() * 0.1_f64.powi(random.below(13) as i32);
        }
        4 => (a + b + c) * 0.25,
        5 | 6 => a,
        7 => (a + b) * 0.5,
        _ => a + (b - a) * random.unit(),
    };
    let aimed = place - along * [0.25, 0.5, 1.0, 2.0][random.below(4)];
    match random.below(3) {
        0 => aimed + random.point() * 0.1_f64.powi(3 + random.below(14) as i32),
        _ => aimed,
    }
}
