//! Unconnected random triangles.

use crate::error::Result;
use crate::geometry::{Vec3, vec3};
use crate::mesh::{Mesh, Positions};

use super::fill::{fill, single};
use super::random::Random;
use crate::progress::SharedProgress;

/// Of two of a triangle's edges the sine of the angle between them is at least this, so that no
/// triangle vanishes in single precision.
const SMALLEST_SINE: f64 = 0.1;

/// See [`Kind::Soup`](super::Kind::Soup).
pub fn soup(triangles: usize, seed: u64, progress: &SharedProgress) -> Result<Mesh> {
    let edge = libm::cbrt(1.0 / triangles as f64).min(0.5);
    let positions = fill(3 * triangles, 3 * triangles / 4, progress, |i| {
        single(triangle(seed, (i / 3) as u64, edge)[i % 3])
    })?;
    let indices = fill(triangles, triangles / 4, progress, |i| {
        let first = 3 * i as u32;
        [first, first + 1, first + 2]
    })?;
    Mesh::new(Positions::F32(positions.into()), indices)
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
