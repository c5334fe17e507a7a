//! A mesh like one from a laser scanner: one closed surface, fine triangles of even size and no
//! pattern, in strips whose blocks have changed places, and noise on every vertex.

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::{Mesh, Positions};

use super::View;
use super::cube_sphere::{CubeSphere, Order};
use super::echinoid::Echinoid;
use super::fill::{fill, single};
use halfline::geometry::random::{Random, mix};
use halfline::progress::SharedProgress;

/// From above and aside, so that plates, apex and the shell's edge are seen.
pub const VIEW: View = View {
    from: vec3(1.75, -2.05, 2.25),
    at: vec3(0.0, 0.0, 0.03),
    up: vec3(0.0, 0.0, 1.0),
    angle_degrees: 35.0,
};

/// By how much of an edge's length vertices are moved along the sphere, so that no grid shows.
/// Two neighbours can come nearer by at most twice as much, which leaves every triangle its
/// orientation.
const JITTER: f64 = 0.16;

/// The scanner's error, as the standard deviation along the ray in edge lengths.
const SCANNER_NOISE: f64 = 0.03;

/// A mesh of the kind [`Kind::Scan`](super::Kind::Scan).
pub fn scan(triangles: usize, seed: u64, progress: &SharedProgress) -> Result<Mesh> {
    let (positions, triangles) = scanned(triangles, seed, progress)?;
    Mesh::new(Positions::F32(positions.into()), triangles)
}

/// Vertices, and triangles that point into them.
pub type Surface = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// The scan's vertices and triangles.
pub fn scanned(triangles: usize, seed: u64, progress: &SharedProgress) -> Result<Surface> {
    let grid = CubeSphere::new(triangles, Order::Shuffled(seed));
    let edge = grid.mean_edge();
    let shape = Echinoid::new(seed, edge);
    // The largest of these meshes would be turned inside out by noise in proportion.
    let noise = SCANNER_NOISE * edge.min(0.05);
    let positions = fill(grid.vertex_count(), triangles, progress, |i| {
        let mut random = Random::new(mix(seed), i as u64);
        let aside = random.direction() * (JITTER * edge.min(0.5));
        let direction = (grid.direction(i) + aside).normalized();
        single(shape.point(direction) + direction * (noise * random.normal()))
    })?;
    let point = |v: u32| Vec3::from(positions[v as usize]);
    let triangles = grid.triangles(|[a, b, c, d]| {
        let (first, second) = (point(a) - point(c), point(b) - point(d));
        first.dot(first) <= second.dot(second)
    })?;
    Ok((positions, triangles))
}
