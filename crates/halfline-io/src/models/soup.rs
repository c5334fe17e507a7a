//! Unconnected random triangles.

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::fill::separate_triangles;
use halfline::geometry::random::Random;
use halfline::progress::SharedProgress;

/// Of two of a triangle's edges the sine of the angle between them is at least this, so that no
/// triangle vanishes in single precision.
const SMALLEST_SINE: f64 = 0.1;

/// A mesh of the kind [`Kind::Soup`](super::Kind::Soup).
pub fn soup(triangles: usize, seed: u64, progress: &SharedProgress) -> Result<Mesh> {
    let edge = libm::cbrt(1.0 / triangles as f64).min(0.5);
    separate_triangles(triangles, progress, |index| triangle(seed, index as u64, edge))
}

/// Triangle `index`, within the unit cube, its edges about `edge` long.
fn triangle(seed: u64, index: u64, edge: f64) -> [Vec3; 3] {
    let mut random = Random::new(seed, index);
    let first = random.direction();
    let second = loop {
        let direction = random.direction();
        if direction.cross(first).length() >= SMALLEST_SINE {
            break direction;
        }
    };
    let corners = [
        Vec3::ZERO,
        first * (edge * (0.5 + random.unit())),
        second * (edge * (0.5 + random.unit())),
    ];
    // Place it so that its box lies anywhere within the cube.
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    let room = Vec3::splat(1.0) - (high - low);
    let place = vec3(random.unit(), random.unit(), random.unit()) * room - low;
    corners.map(|p| p + place)
}
