//! Haines's sphereflake, tessellated: each sphere carries nine of a third of its radius, six
//! around its equator and three above, where "up" is the direction in which it grew itself.
//!
//! The spheres of one generation have the square root of three times as many meridians as those
//! of the next, which spends the triangles where they are seen.

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::View;
use super::assembly::{Assembly, Shape, haines_material, nearest_tessellation};
use halfline::progress::SharedProgress;

/// The camera of the Standard Procedural Databases.
pub const VIEW: View = View {
    from: vec3(2.1, 1.3, 1.7),
    at: Vec3::ZERO,
    up: vec3(0.0, 0.0, 1.0),
    angle_degrees: 45.0,
};

/// Half the side of the square floor, and the radius of the first sphere, on the floor.
const FLOOR: f64 = 12.0;
const RADIUS: f64 = 0.5;

/// A direction this near to straight down (in 1 + cosine) counts as straight down, since the
/// axis about which up is turned to it would be made of rounding errors alone: they are about
/// 1e-16 against an axis of length sqrt(2e-12).
const DOWNWARDS: f64 = 1e-12;

/// The smallest spheres have at least this many meridians before another generation is added.
const MERIDIANS: usize = 8;

/// A mesh of the kind [`Kind::Balls`](super::Kind::Balls).
pub fn balls(triangles: usize, progress: &SharedProgress) -> Result<Mesh> {
    let wanted = triangles.saturating_sub(2);
    let mut generations = 1;
    while count(generations + 1, MERIDIANS, MERIDIANS / 2) <= wanted {
        generations += 1;
    }
    let (segments, stacks) = nearest_tessellation(wanted, 4, |a, b| count(generations, a, b));
    let spheres: Vec<Shape> = (0..=generations)
        .map(|generation| {
            let (segments, stacks) = finer(segments, stacks, generations - generation);
            Shape::sphere(segments, stacks)
        })
        .collect();

    let total = count(generations, segments, stacks) + 2;
    let mut scene = Assembly::new(total / 2 + 2 * ball_count(generations) + 4, total)?;
    let floor = scene.material(haines_material([1.0, 0.75, 0.33], 0.8, 0.0, 0.0, 1.5));
    let mirror = scene.material(haines_material([1.0, 0.9, 0.7], 0.5, 0.5, 0.0, 1.5));
    let corner = |x: f64, y: f64| vec3(FLOOR * x, FLOOR * y, -RADIUS);
    scene.quad([corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)], floor);
    let flake = Flake { spheres, nine: nine(), mirror };
    flake.grow(&mut scene, 0, Vec3::ZERO, RADIUS, vec3(0.0, 0.0, 1.0), progress)?;
    scene.finish()
}

/// The meridians and bands of a sphere, given those of one `generations` younger.
fn finer(segments: usize, stacks: usize, generations: u32) -> (usize, usize) {
    let power = 3usize.pow(generations / 2);
    let scale = |n: usize| {
        // 97 / 56 is the square root of three to four digits.
        if generations.is_multiple_of(2) { n * power } else { (n * power * 97).div_ceil(56) }
    };
    (scale(segments), scale(stacks))
}

/// Number of spheres.
fn ball_count(generations: u32) -> usize {
    (9usize.pow(generations + 1) - 1) / 8
}

/// Number of the spheres' triangles.
fn count(generations: u32, segments: usize, stacks: usize) -> usize {
    (0..=generations)
        .map(|generation| {
            let (segments, stacks) = finer(segments, stacks, generations - generation);
            9usize.pow(generation) * Shape::sphere_triangles(segments, stacks)
        })
        .sum()
}

/// The directions of the nine children of a sphere that grew upwards: those of the neighbours in
/// a closest packing whose layers are horizontal, without the three below.
fn nine() -> [Vec3; 9] {
    // In the packing of points with integer coordinates of even sum the layers are across
    // (1, 1, 1); turn that upwards, about (1, -1, 0).
    let half = 0.5f64.sqrt();
    let axis = vec3(half, -half, 0.0);
    let (sine, cosine) = ((2.0f64 / 3.0).sqrt(), (1.0f64 / 3.0).sqrt());
    let trio = [vec3(half, half, 0.0), vec3(half, 0.0, -half), vec3(0.0, half, -half)]
        .map(|v| v * cosine + axis.cross(v) * sine + axis * (axis.dot(v) * (1.0 - cosine)));
    // And by thirds of a turn about the vertical.
    let third = |v: Vec3| {
        let s = 0.75f64.sqrt();
        vec3(-0.5 * v.x - s * v.y, s * v.x - 0.5 * v.y, v.z)
    };
    let mut nine = [Vec3::ZERO; 9];
    for (i, v) in trio.into_iter().enumerate() {
        nine[i] = v;
        nine[3 + i] = third(v);
        nine[6 + i] = third(third(v));
    }
    nine
}

/// `v`, turned as the shortest turn from upwards to the unit vector `to` turns.
fn turn_up_to(to: Vec3, v: Vec3) -> Vec3 {
    if 1.0 + to.z < DOWNWARDS {
        return vec3(-v.x, v.y, -v.z);
    }
    let axis = vec3(-to.y, to.x, 0.0);
    v * to.z + axis.cross(v) + axis * (axis.dot(v) / (1.0 + to.z))
}

struct Flake {
    /// The spheres of each generation.
    spheres: Vec<Shape>,
    nine: [Vec3; 9],
    mirror: u32,
}

impl Flake {
    fn grow(
        &self,
        scene: &mut Assembly,
        generation: usize,
        center: Vec3,
        radius: f64,
        up: Vec3,
        progress: &SharedProgress,
    ) -> Result<()> {
        let Some(sphere) = self.spheres.get(generation) else { return Ok(()) };
        progress.check()?;
        scene.shape(sphere, self.mirror, |p| center + p * radius);
        for child in self.nine {
            let direction = turn_up_to(up, child);
            // Rounding must not make the directions longer from one generation to the next.
            let direction = direction.normalized();
            let distance = radius * (1.0 + 1.0 / 3.0);
            self.grow(
                scene,
                generation + 1,
                center + direction * distance,
                radius / 3.0,
                direction,
                progress,
            )?;
        }
        Ok(())
    }
}
