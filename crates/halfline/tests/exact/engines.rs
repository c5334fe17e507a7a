//! Every engine against exact judges of whole meshes, which share no code with any of them: integer
//! arithmetic where vertices, planes and rays lie on a coarse grid and coincide, and rational
//! arithmetic for all other coordinates.

use crate::common::contact::{Case, Range};
use crate::common::engines::check_engines;
use crate::common::grid::{
    LINES, aimed_at, fans, judged, needles, plates, range, sides, soups, stacks, tetrahedra,
};
use crate::common::integer::{GridLine, GridMesh, Point};
use crate::common::proof::{Share, prove};
use crate::common::{exact, grid_cube, nudge, soup};
use halfline::{Mesh, Ray, Vec3};
use proptest::prelude::*;

/// Six tests send the rays for the integer judge.
fn prove_on_grid(what: &str, faces: impl Strategy<Value = Vec<[Point; 3]>>) {
    let what = format!("engines against integers, {what}");
    prove(&what, Share::INTEGERS.rays().div_ceil(6), LINES, aimed_at(faces), judged);
}

#[test]
fn coarse_grids() {
    prove_on_grid("coarse grids", soups());
}

#[test]
fn faces_in_splitting_planes() {
    prove_on_grid("faces across the axes", plates());
}

#[test]
fn fans_around_a_vertex() {
    prove_on_grid("fans", fans());
}

#[test]
fn stacks_of_coplanar_copies() {
    prove_on_grid("coplanar copies", stacks());
}

#[test]
fn needles_on_a_grid() {
    prove_on_grid("needles", needles());
}

#[test]
fn tetrahedra_through_each_other() {
    prove_on_grid("tetrahedra", tetrahedra().prop_map(|all| sides(&all)));
}

/// A point with coordinates of 50 bits. The difference of two is exact, so a ray aimed from one at
/// another, or at the middle between two others, passes through it exactly.
fn any_point() -> impl Strategy<Value = Vec3> {
    let fraction = (-(1i64 << 50)..1i64 << 50).prop_map(|x| x as f64 * 2f64.powi(-50));
    prop::array::uniform3(fraction).prop_map(Vec3::from)
}

/// A weight for corners: often zero, so that aimed rays pass through edges and vertices.
fn weight() -> impl Strategy<Value = f64> {
    prop_oneof![2 => Just(0.0), 1 => Just(0.5), 1 => Just(1.0), 2 => 0.0..1.0]
}

/// A ray from near a point to a point of a face, and how many units in the last place its origin
/// and direction are beside that.
#[derive(Clone, Debug)]
struct Shot {
    origin: Vec3,
    face: usize,
    weights: [f64; 3],
    origin_steps: [i32; 3],
    direction_steps: [i32; 3],
    range: Range,
}

fn shot() -> impl Strategy<Value = Shot> {
    let steps = || prop_oneof![Just([0; 3]), prop::array::uniform3(-4..=4i32)];
    let weights = prop::array::uniform3(weight());
    (any_point(), 0..100usize, weights, steps(), steps(), range()).prop_map(
        |(origin, face, weights, origin_steps, direction_steps, range)| Shot {
            origin,
            face,
            weights,
            origin_steps,
            direction_steps,
            range,
        },
    )
}

/// The shots at a mesh that lies around `center`, with what the rational judge says of them.
fn shoot(mesh: Mesh, center: Vec3, shots: &[Shot]) -> (Mesh, Vec<Case>) {
    let nudged = |v: Vec3, steps: [i32; 3]| Vec3::from([0, 1, 2].map(|i| nudge(v[i], steps[i])));
    let case = |shot: &Shot| {
        let [a, b, c] = mesh.corners((shot.face % mesh.triangle_count()) as u32);
        let sum = shot.weights.iter().sum::<f64>().max(0.5);
        let [p, q, r] = shot.weights.map(|weight| weight / sum);
        let origin = nudged(shot.origin + center, shot.origin_steps);
        let direction = nudged(a * p + b * q + c * r - origin, shot.direction_steps);
        let line = Ray::new(origin, direction);
        Case::new(line, exact::contacts(&mesh, &line), shot.range)
    };
    let cases = shots.iter().map(case).collect();
    (mesh, cases)
}

/// Triangles that share their corners, in doubles or rounded to single precision.
fn float_mesh(triangles: Vec<[Vec3; 3]>, center: Vec3, is_single: bool) -> Mesh {
    let round = |x: f64| if is_single { f64::from(x as f32) } else { x };
    soup(triangles.into_iter().map(|t| t.map(|p| Vec3::from((p + center).to_array().map(round)))))
}

/// How far from the origin a mesh of size one lies.
fn distance() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(500_000.0), Just(1e7)]
}

/// Few rays, which count for nothing in the budget: the rational judge takes a hundred times as long
/// as the engines.
fn rational_budget() -> usize {
    Share(0.002).rays()
}

#[test]
fn within_four_units_in_the_last_place_of_edges() {
    let strip = prop::collection::vec(any_point(), 4..12);
    let shots = prop::collection::vec(shot(), 6);
    let inputs = (strip, distance(), any::<bool>(), shots);
    prove(
        "engines against rationals, beside edges",
        rational_budget(),
        6,
        inputs,
        |(strip, distance, is_single, shots)| {
            // A strip, and a fan around its first vertex, over the same edges.
            let center = Vec3::splat(*distance);
            let triangles = strip.windows(3).map(|w| [w[0], w[1], w[2]]);
            let fan = strip.windows(2).skip(1).map(|w| [strip[0], w[1], w[0]]);
            shoot(float_mesh(triangles.chain(fan).collect(), center, *is_single), center, shots)
        },
    );
}

#[test]
fn slivers() {
    let sliver = (any_point(), any_point(), any_point(), -0.5..1.5f64, -15.0..-6.0f64);
    let slivers = prop::collection::vec(sliver, 1..6);
    let shots = prop::collection::vec(shot(), 6);
    let inputs = (slivers, distance(), any::<bool>(), shots);
    prove(
        "engines against rationals, slivers",
        rational_budget(),
        6,
        inputs,
        |(slivers, distance, is_single, shots)| {
            // Two slivers over the same long edge, and a needle with a short one.
            let center = Vec3::splat(*distance);
            let triangles = slivers.iter().flat_map(|&(a, b, off, along, thinness)| {
                let on_edge = a * (1.0 - along) + b * along;
                let off = off * 10f64.powf(thinness);
                [[a, b, on_edge + off], [b, a, on_edge - off], [a, b, b + off]]
            });
            shoot(float_mesh(triangles.collect(), center, *is_single), center, shots)
        },
    );
}

#[test]
fn directions_with_denormal_components() {
    // So near that even the smallest direction reaches it at a t that a double can hold.
    let component = || prop_oneof![Just(0.0), Just(-0.0), Just(5e-324), Just(-1e-310), Just(1.0)];
    let direction = prop::array::uniform3(component());
    let unit = 1e-20;
    let origin = prop::array::uniform3((-1..=1i32).prop_map(move |x| f64::from(x) * unit));
    let rays = prop::collection::vec((origin, direction, range()), 8);
    let corner =
        || prop::array::uniform3(-2..=2i32).prop_map(move |p| p.map(|x| f64::from(x) * unit));
    let faces = prop::collection::vec(prop::array::uniform3(corner()), 1..12);
    prove(
        "engines against rationals, denormal directions",
        rational_budget(),
        8,
        (faces, rays),
        |(faces, rays)| {
            let mesh = soup(faces.iter().map(|corners| corners.map(Vec3::from)));
            let case = |&(origin, direction, range): &([f64; 3], [f64; 3], Range)| {
                let line = Ray::new(origin.into(), direction.into());
                Case::new(line, exact::contacts(&mesh, &line), range)
            };
            let cases = rays.iter().map(case).collect();
            (mesh, cases)
        },
    );
}

/// Fails if an engine is wrong, with each of what takes turns.
fn check_on_all_turns(mesh: &Mesh, cases: &[Case]) {
    for turn in [0, 5, 10] {
        check_engines(mesh, cases, turn).unwrap_or_else(|wrong| panic!("{wrong}"));
    }
}

/// Along every axis through every corner, middle and centre of a grid, zeros of either sign, and
/// t from one contact to the same one: what a proptest finds by chance, without chance.
#[test]
fn axis_parallel_rays_through_a_grid_of_faces() {
    let mut faces = Vec::new();
    for (axis, i, j, level) in (0..3)
        .flat_map(|axis| (0..2).map(move |i| (axis, i)))
        .flat_map(|(axis, i)| (0..2).map(move |j| (axis, i, j)))
        .flat_map(|(axis, i, j)| (0..3).map(move |level| (axis, i, j, level)))
    {
        let corner = |di: i128, dj: i128| {
            let mut p = [0; 3];
            p[axis] = 2 * level;
            p[(axis + 1) % 3] = 2 * (i + di);
            p[(axis + 2) % 3] = 2 * (j + dj);
            p
        };
        faces.push([corner(0, 0), corner(1, 0), corner(1, 1)]);
        faces.push([corner(0, 0), corner(1, 1), corner(0, 1)]);
    }
    for unit in [0, -60] {
        let grid = GridMesh { faces: faces.clone(), unit };
        let mut cases = Vec::new();
        let places = (0..5 * 5 * 5).map(|i| [i / 25, i / 5 % 5, i % 5]);
        for (origin, axis) in places.flat_map(|p| (0..3).map(move |axis| (p, axis))) {
            for (sign, has_negative_zeros) in [(1, false), (1, true), (-1, false), (-1, true)] {
                let mut direction = [0; 3];
                direction[axis] = sign;
                let line = GridLine { origin, direction, speed: 0, has_negative_zeros };
                let contacts = grid.contacts(&line);
                for range in [Range::HalfLine, Range::Line, Range::At(0), Range::At(7)] {
                    cases.push(Case::new(grid.to_ray(&line), contacts.clone(), range));
                }
            }
        }
        check_on_all_turns(&grid.to_mesh(), &cases);
    }
}

#[test]
fn invalid_rays_hit_nothing() {
    let (inside, up) = (Vec3::from([0.25, 0.5, 0.0]), Vec3::from([0.0, 0.0, 1.0]));
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    let whole = Ray::with_range(inside, up, -infinite, infinite);
    let with = |v: Vec3, axis: usize, x: f64| {
        let mut changed = v;
        changed[axis] = x;
        changed
    };
    let mut invalid = vec![
        Ray { direction: Vec3::ZERO, ..whole },
        Ray { direction: Vec3::splat(-0.0), ..whole },
        Ray { t_min: 2.0, t_max: 1.0, ..whole },
        Ray { t_min: infinite, t_max: -infinite, ..whole },
        Ray { t_min: nan, ..whole },
        Ray { t_max: nan, ..whole },
        Ray { t_min: nan, t_max: nan, ..whole },
    ];
    for (axis, x) in (0..3).flat_map(|axis| [nan, infinite, -infinite].map(|x| (axis, x))) {
        invalid.push(Ray { origin: with(inside, axis, x), ..whole });
        invalid.push(Ray { direction: with(up, axis, x), ..whole });
    }
    let mesh = grid_cube(2);
    assert_eq!(exact::contacts(&mesh, &whole).len(), 2, "the valid ray hits");
    let cases: Vec<Case> =
        invalid.into_iter().map(|ray| Case { ray, contacts: Vec::new() }).collect();
    check_on_all_turns(&mesh, &cases);
}
