//! Closed surfaces, which need no judge: a ray from inside hits, and crosses an odd number of
//! times; from outside the number is even.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::grid::{LINES, aimed_at, judged, sides, tetrahedra};
use crate::common::integer::is_inside;
use crate::common::proof::{Share, prove, report};
use crate::common::{Random, grid_cube, in_single_precision, nudge, soup, sphere};
use halfline::{Level, Mesh, Ray, Scene, Vec3};
use proptest::prelude::*;
use rayon::prelude::*;

/// A surface with what is known of it.
struct Surface {
    name: &'static str,
    mesh: Mesh,
    center: Vec3,
    /// All points nearer to the centre are inside.
    inner_radius: f64,
    /// All points farther from the centre are outside.
    outer_radius: f64,
}

/// A sphere with bumps and dents, which a ray from inside may leave and enter again.
fn bumpy_sphere(levels: u32) -> Mesh {
    let round = sphere(levels, Vec3::ZERO, 1.0);
    let bumpy = |p: Vec3| p * (1.0 + 0.3 * (9.0 * p.x).sin() * (7.0 * p.y + 8.0 * p.z).cos());
    soup((0..round.triangle_count() as u32).map(|face| round.corners(face).map(bumpy)))
}

/// Surfaces of thousands of triangles. Rounding moves all triangles around a vertex alike, so they
/// stay closed, and the radii leave room for it.
fn surfaces() -> Vec<Surface> {
    let surface = |name, mesh, center, inner_radius, outer_radius| Surface {
        name,
        mesh,
        center,
        inner_radius,
        outer_radius,
    };
    let far = Vec3::from([500_000.0, 5_400_000.0, 12.0]);
    let bumpy = bumpy_sphere(6);
    let single = in_single_precision(&bumpy);
    vec![
        surface("sphere", sphere(6, Vec3::ZERO, 1.0), Vec3::ZERO, 0.99, 1.01),
        surface("sphere in map coordinates", sphere(5, far, 2.0), far, 1.9, 2.1),
        surface("bumpy sphere", bumpy, Vec3::ZERO, 0.65, 1.35),
        surface("bumpy sphere in single precision", single, Vec3::ZERO, 0.65, 1.35),
        surface("grid cube", grid_cube(16), Vec3::ZERO, 16.0, 28.0),
        surface("tiny sphere", sphere(4, Vec3::ZERO, 1e-30), Vec3::ZERO, 0.95e-30, 1.01e-30),
        surface("huge sphere", sphere(4, Vec3::ZERO, 1e30), Vec3::ZERO, 0.95e30, 1.01e30),
    ]
}

/// A ray from a random point at `distance` from the centre: at a vertex, at an edge, at a face,
/// within four units in the last place of that, or anywhere.
fn aimed_ray(surface: &Surface, distance: f64, random: &mut Random) -> Ray {
    let mut origin = surface.center + random.point().normalized() * distance;
    if random.below(4) == 0 {
        // A point of a lattice, where the mesh is grid-aligned in the plane of many edges.
        let toward = (origin - surface.center) * (1.0 / distance);
        let rounded = toward.to_array().map(|x| if x.abs() < 0.5 { 0.0 } else { x });
        origin = surface.center + Vec3::from(rounded).normalized() * distance;
    }
    let [a, b, c] = surface.mesh.corners(random.below(surface.mesh.triangle_count()) as u32);
    let share = random.unit();
    let aim = match random.below(6) {
        0 => a,
        1 => a * 0.5 + b * 0.5,
        2 => a * share + b * (1.0 - share),
        3 => a * (share * 0.5) + b * (0.5 - share * 0.5) + c * 0.5,
        4 => a + (b - a) * random.signed() * 1e-9,
        _ => surface.center + random.point() * surface.outer_radius,
    };
    let mut direction = aim - origin;
    if random.below(2) == 0 {
        for axis in 0..3 {
            direction[axis] = nudge(direction[axis], random.below(9) as i32 - 4);
        }
    }
    if random.below(8) == 0 {
        // Along an axis, past the coordinates of what was aimed at.
        let axis = random.below(3);
        let along = if random.below(2) == 0 { surface.outer_radius } else { -surface.outer_radius };
        direction = Vec3::splat(if random.below(2) == 0 { -0.0 } else { 0.0 });
        direction[axis] = along;
    }
    Ray::new(origin, direction)
}

/// Two thirds of the rays from inside, the others from outside.
#[test]
fn parity_is_odd_from_inside_and_even_from_outside() {
    const BATCH: usize = 4096;
    let surfaces = surfaces();
    let batches = Share::CLOSED_SURFACES.rays().div_ceil(BATCH * surfaces.len());
    let (sent, crossed_again) = (AtomicUsize::new(0), AtomicUsize::new(0));
    for surface in surfaces {
        // By every instruction set in turn.
        let scenes: Vec<Scene> = Level::available()
            .into_iter()
            .map(|level| {
                let mut scene = Scene::new(surface.mesh.clone()).expect("builds");
                scene.set_simd_level(level);
                scene
            })
            .collect();
        (0..batches).into_par_iter().for_each(|batch| {
            let scene = &scenes[batch / 3 % scenes.len()];
            let mut random = Random(batch as u64 * 0x1_0000_0001);
            let is_inside = batch % 3 < 2;
            let rays: Vec<Ray> = (0..BATCH)
                .map(|_| {
                    let distance = if is_inside {
                        surface.inner_radius * 0.99 * random.unit()
                    } else {
                        surface.outer_radius * (1.01 + 3.0 * random.unit())
                    };
                    aimed_ray(&surface, distance, &mut random)
                })
                .collect();
            let all = scene.intersect_all(&rays);
            let closest = scene.intersect(&rays);
            let any = scene.occluded(&rays);
            for (i, ray) in rays.iter().enumerate() {
                let crossings = &all.hits[all.splits[i]..all.splits[i + 1]];
                let what = || format!("{}: {ray:?} crosses {crossings:?}", surface.name);
                assert_eq!(crossings.len() % 2 == 1, is_inside, "{}", what());
                assert!(any[i] || !is_inside, "{} leaks", what());
                assert_eq!(closest[i].is_hit(), any[i], "{}", what());
                // A crossing is a contact, so the closest contact is no farther.
                let first = crossings.first().map_or(f64::INFINITY, |hit| hit.t);
                assert!(closest[i].t <= first, "{} after {:?}", what(), closest[i]);
                let is_sorted = crossings.is_sorted_by(|a, b| (a.t, a.face) < (b.t, b.face));
                assert!(is_sorted, "{}", what());
                crossed_again.fetch_add(usize::from(crossings.len() > 2), Ordering::Relaxed);
            }
            sent.fetch_add(rays.len(), Ordering::Relaxed);
        });
    }
    let sent = sent.into_inner();
    assert!(crossed_again.into_inner() > sent / 200, "bumps are crossed");
    report("engine at closed surfaces", sent);
}

/// The parity of a point is that of the number of tetrahedra around it, whatever the direction:
/// they may lie through each other, share corners, edges and sides, and be copies.
#[test]
fn parity_counts_the_tetrahedra_around_a_point() {
    let strategy = tetrahedra().prop_flat_map(|all| {
        let faces = sides(&all);
        (Just(all), aimed_at(Just(faces)))
    });
    prove(
        "engines inside of tetrahedra",
        Share(0.005).rays(),
        LINES,
        strategy,
        |(tetrahedra, input)| {
            let (mesh, mut cases) = judged(input);
            let (grid, aims) = input;
            for (case, aim) in cases.iter_mut().zip(aims) {
                // The judge itself is on trial here: its crossings from t = 0 on must have the
                // parity of the tetrahedra around the origin.
                let line = aim.line(&grid.faces);
                let around: Option<Vec<bool>> =
                    tetrahedra.iter().map(|&corners| is_inside(line.origin, corners)).collect();
                let Some(around) = around.filter(|_| line.direction != [0; 3]) else { continue };
                let contacts = grid.contacts(&line);
                let crossings = contacts.iter().filter(|c| c.is_crossing && c.t > 0.0).count();
                let inside = around.into_iter().filter(|&is_inside| is_inside).count();
                assert_eq!(crossings % 2, inside % 2, "{line:?}");
                *case = crate::common::contact::Case::new(
                    grid.to_ray(&line),
                    contacts,
                    crate::common::contact::Range::HalfLine,
                );
            }
            (mesh, cases)
        },
    );
}
