//! Meshes on which ties and rounding hurt, and points for them.

use halfline::{Mesh, Vec3, vec3};

use crate::common::{Random, grid_cube, nudge, soup, sphere, target};

/// Makes a mesh at random.
pub type Family = Box<dyn Fn(&mut Random) -> Mesh>;

fn integer(random: &mut Random, n: usize) -> Vec3 {
    vec3(random.below(n) as f64, random.below(n) as f64, random.below(n) as f64)
}

/// Triangles with corners on a coarse grid, some of them segments or points, some twice.
fn grid_soup(random: &mut Random) -> Vec<[Vec3; 3]> {
    let mut triangles: Vec<[Vec3; 3]> = Vec::new();
    for _ in 0..2 + random.below(12) {
        let again = (!triangles.is_empty() && random.below(4) == 0)
            .then(|| triangles[random.below(triangles.len().max(1))]);
        let [a, b, c] = again.unwrap_or_else(|| [(); 3].map(|()| integer(random, 4)));
        triangles.push([[a, b, c], [b, c, a], [c, b, a]][random.below(3)]);
    }
    triangles
}

fn random_soup(random: &mut Random) -> Vec<[Vec3; 3]> {
    (0..12)
        .map(|_| {
            let p = random.point();
            let size = [0.01, 0.3, 1.0][random.below(3)];
            [p, p + random.point() * size, p + random.point() * size]
        })
        .collect()
}

fn slivers(random: &mut Random) -> Vec<[Vec3; 3]> {
    (0..12)
        .map(|_| {
            let (a, b, share) = (random.point(), random.point(), random.unit());
            let off = [0.0, 1e-16, 1e-12, 1e-9, 1e-5][random.below(5)];
            [a, b, a * share + b * (1.0 - share) + random.point() * off]
        })
        .collect()
}

fn without_area(random: &mut Random) -> Vec<[Vec3; 3]> {
    let nan = vec3(f64::NAN, 0.0, 1.0);
    (0..40)
        .map(|i| {
            let (a, b) = (integer(random, 6), integer(random, 6));
            let step = integer(random, 3);
            match i % 6 {
                0 => [a, a, a],
                1 => [a, a, b],
                2 => [a, b, a],
                3 => [a, a + step * 2.0, a + step],
                4 => [a, b, nan],
                _ => [a, b, integer(random, 6)],
            }
        })
        .collect()
}

/// Triangles so small that single precision in the frame of the large one cannot tell their corners apart.
fn small_among_large(random: &mut Random) -> Vec<[Vec3; 3]> {
    let size = [1e-9, 1e-7, 1e-5][random.below(3)];
    let at = random.point();
    let small = (0..16).map(|_| [(); 3].map(|()| at + random.point() * size));
    let small: Vec<[Vec3; 3]> = small.collect();
    small.into_iter().chain([[(); 3].map(|()| random.point() * 2.0)]).collect()
}

/// The corners of a triangle by all symmetries of a cube: all are equally far from the centre.
fn symmetric(random: &mut Random) -> Vec<[Vec3; 3]> {
    let corners = [(); 3].map(|()| integer(random, 5) + Vec3::splat(0.25));
    let mut triangles = Vec::new();
    for signs in 0..8 {
        for turn in 0..3 {
            triangles.push(corners.map(|corner| {
                let mut turned = Vec3::ZERO;
                for axis in 0..3 {
                    let sign = if signs >> axis & 1 == 0 { 1.0 } else { -1.0 };
                    turned[axis] = sign * corner[(axis + turn) % 3];
                }
                turned
            }));
        }
    }
    triangles
}

fn map_coordinates(random: &mut Random) -> Vec<[Vec3; 3]> {
    (0..12)
        .map(|_| {
            let mut corner = || {
                let millimetres = random.point() * 3000.0;
                let rounded = millimetres.to_array().map(f64::round);
                vec3(5e5, 5e6, 100.0) + Vec3::from(rounded) * 1e-3
            };
            [corner(), corner(), corner()]
        })
        .collect()
}

fn scaled(triangles: Vec<[Vec3; 3]>, scale: f64) -> Mesh {
    soup(triangles.into_iter().map(|corners| corners.map(|corner| corner * scale)))
}

fn in_singles(triangles: Vec<[Vec3; 3]>) -> Mesh {
    let single = |corner: Vec3| Vec3::from(corner.to_array().map(|x| f64::from(x as f32)));
    soup(triangles.into_iter().map(|corners| corners.map(single)))
}

/// All families by name.
pub fn families() -> Vec<(&'static str, Family)> {
    fn family(make: impl Fn(&mut Random) -> Mesh + 'static) -> Family {
        Box::new(make)
    }
    vec![
        ("grid", family(|random| soup(grid_soup(random)))),
        ("random", family(|random| soup(random_soup(random)))),
        ("random in single precision", family(|random| in_singles(random_soup(random)))),
        ("slivers", family(|random| soup(slivers(random)))),
        ("slivers in single precision", family(|random| in_singles(slivers(random)))),
        ("without area", family(|random| soup(without_area(random)))),
        ("symmetric", family(|random| soup(symmetric(random)))),
        ("small among large", family(|random| soup(small_among_large(random)))),
        ("map coordinates", family(|random| soup(map_coordinates(random)))),
        ("cube", family(|random| grid_cube(1 + random.below(2) as i32))),
        ("sphere", family(|_| sphere(1, Vec3::ZERO, 1.0))),
        ("sphere on the map", family(|_| sphere(1, vec3(5e5, 5e6, 12.0), 2.0))),
        ("tiny grid", family(|random| scaled(grid_soup(random), 1e-30))),
        ("huge grid", family(|random| scaled(grid_soup(random), 1e30))),
        ("tiny", family(|random| scaled(random_soup(random), 1e-30))),
        ("huge", family(|random| scaled(random_soup(random), 1e30))),
        ("tinier", family(|random| scaled(grid_soup(random), 1e-200))),
        ("huger", family(|random| scaled(random_soup(random), 1e200))),
        ("denormal", family(|random| scaled(grid_soup(random), 5e-324))),
        ("largest", family(|random| scaled(random_soup(random), f64::MAX / 4.0))),
        (
            "of many sizes",
            family(|random| {
                let mut all = random_soup(random);
                for triangle in &mut all {
                    let scale = [1e-30, 1e-10, 1.0, 1e30][random.below(4)];
                    *triangle = triangle.map(|corner| corner * scale);
                }
                soup(all)
            }),
        ),
        ("one triangle", family(|random| soup([[(); 3].map(|()| random.point())]))),
        ("nothing", family(|_| soup([]))),
    ]
}

/// Points near and far, on corners, edges and faces, on the grid, and beside them by some units in the last place.
pub fn points_for(mesh: &Mesh, random: &mut Random, count: usize) -> Vec<Vec3> {
    let bounds = mesh.bounds();
    if bounds.is_empty() {
        return (0..count).map(|_| random.point()).collect();
    }
    let size = (bounds.max * 0.5 - bounds.min * 0.5).max_element().max(f64::MIN_POSITIVE);
    let center = bounds.center();
    (0..count)
        .map(|i| {
            let face = random.below(mesh.triangle_count()) as u32;
            let on = target(mesh, face, random).unwrap_or(center);
            let [a, b, c] = mesh.corners(face);
            let point = match i % 14 {
                0 => center,
                1 => on,
                2 | 3 => on + random.point() * size * 0.1,
                4 => on + random.point() * size * 1e-9,
                5 => on + vec3(random.below(3) as f64, random.below(3) as f64, 1.0) * size * 0.25,
                6 => center + random.point() * size * [30.0, 300.0, 1e4][random.below(3)],
                7 => center + random.point() * 2.0 * size,
                8 => {
                    let mut beside = on;
                    let axis = random.below(3);
                    beside[axis] = nudge(beside[axis], random.below(7) as i32 - 3);
                    beside
                }
                9 => integer(random, 9) * 0.5 - Vec3::splat(0.5),
                10 => center + random.point() * size * 1e9,
                // Above the border of what is nearest to a corner and to an edge, up to rounding.
                11 => a + (b - a).cross(random.point()),
                12 => b + (b - a).cross(c - a).cross(b - a) * random.unit() + (b - a) * 1e-16,
                _ => (on + center) * 0.5,
            };
            if point.is_finite() { point } else { on }
        })
        .collect()
}
