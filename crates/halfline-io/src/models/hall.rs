//! A museum hall: what makes architecture hard to trace. Walls and floor are two triangles each,
//! tens of metres wide; beams and rails are as long and centimetres thin; hundreds of planks lie in
//! one plane, beside and upon each other; thousands of books, chairs and rivets stand close together;
//! the fossils on the plinths and the chandeliers hold most of the triangles, down to a fraction of a
//! millimetre.
//!
//! Units are metres. x runs along the hall, and the floor is z = 0.

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::View;
use super::assembly::Assembly;
use super::cube_sphere::CubeSphere;
use super::fill::single;
use super::hall_materials::Materials;
use super::hall_structure::{Detail, LEVELS, PLINTHS, build, plinth};
use super::scan::{Surface, scanned};
use halfline::geometry::random::mix;
use halfline::progress::SharedProgress;

/// From a visitor's eyes near one end, down the nave.
pub const VIEW: View = View {
    from: vec3(-21.6, 0.7, 1.75),
    at: vec3(6.0, -0.6, 4.9),
    up: vec3(0.0, 0.0, 1.0),
    angle_degrees: 62.0,
};

/// A fossil has at least this many triangles before the hall itself gets more detail.
const FOSSIL: usize = 12;

/// Share of the triangles, as a fraction of 8, that the exhibits have at least.
const EXHIBITS: usize = 4;

/// A mesh of the kind [`Kind::Hall`](super::Kind::Hall).
pub fn hall(triangles: usize, seed: u64, progress: &SharedProgress) -> Result<Mesh> {
    // The most detailed hall that leaves enough for the exhibits; the barest if none does.
    let mut chosen = None;
    for detail in LEVELS.iter().rev() {
        progress.check()?;
        let exhibits = if detail.exhibits { PLINTHS * FOSSIL } else { 0 };
        let size = built(detail, 0)?.0.triangle_count();
        if size + exhibits.max(triangles / 8 * EXHIBITS * usize::from(detail.exhibits)) <= triangles
        {
            chosen = Some((detail, size));
            break;
        }
    }
    let (detail, size) = match chosen {
        Some(chosen) => chosen,
        None => (&LEVELS[0], built(&LEVELS[0], 0)?.0.triangle_count()),
    };
    if !detail.exhibits {
        return built(detail, 0)?.0.finish();
    }

    let rest = triangles - size;
    let (mut scene, materials) = built(detail, rest)?;
    progress.advance(size)?;
    let mut left = rest;
    for index in 0..PLINTHS {
        let share = left / (PLINTHS - index);
        let (positions, triangles) = fossil(index, share, seed, progress)?;
        left -= triangles.len();
        scene.raw(&positions, &triangles, materials.fossil);
    }
    scene.finish()
}

/// The structure, with room for `more` triangles.
fn built(detail: &Detail, more: usize) -> Result<(Assembly, Materials)> {
    let mut scene = Assembly::new(more / 2 + 2 * PLINTHS, more)?;
    let materials = Materials::new(&mut scene);
    build(&mut scene, detail, &materials)?;
    Ok((scene, materials))
}

/// The fossil on plinth `index`, of at most `triangles`, no less than twelve.
fn fossil(index: usize, triangles: usize, seed: u64, progress: &SharedProgress) -> Result<Surface> {
    debug_assert!(triangles >= CubeSphere::SMALLEST);
    let (mut positions, triangles) =
        scanned(triangles, mix(seed.wrapping_add(index as u64)), progress)?;
    let (top, size) = plinth(index);
    // Each is turned about the vertical by 36 degrees more than the one before, and leans
    // towards the nave so that visitors see its plates.
    let (turn_sine, turn_cosine) =
        (libm::sin(0.628 * index as f64), libm::cos(0.628 * index as f64));
    let lean = if top.y > 0.0 { 0.6 } else { -0.6 };
    let (lean_sine, lean_cosine) = (libm::sin(lean), libm::cos(lean));
    let place = |p: Vec3| {
        let (x, y) = (turn_cosine * p.x - turn_sine * p.y, turn_sine * p.x + turn_cosine * p.y);
        let (y, z) = (lean_cosine * y - lean_sine * p.z, lean_sine * y + lean_cosine * p.z);
        top + vec3(x, y, z) * size
    };
    for p in &mut positions {
        *p = single(place((*p).into()));
    }
    // Let it down until its lowest vertex touches the plinth.
    let lowest = positions.iter().fold(f32::INFINITY, |low, p| low.min(p[2]));
    let lift = top.z as f32 - lowest;
    for p in &mut positions {
        p[2] += lift;
    }
    Ok((positions, triangles))
}
