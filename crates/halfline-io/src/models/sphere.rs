//! The unit sphere.

use halfline::error::Result;
use halfline::mesh::{Mesh, Positions};

use super::cube_sphere::{CubeSphere, Order};
use super::fill::{fill, single};
use halfline::progress::SharedProgress;

/// A mesh of the kind [`Kind::Sphere`](super::Kind::Sphere).
pub fn sphere(triangles: usize, progress: &SharedProgress) -> Result<Mesh> {
    let grid = CubeSphere::new(triangles, Order::Strips);
    let positions = fill(grid.vertex_count(), triangles, progress, |i| single(grid.direction(i)))?;
    Mesh::new(Positions::F32(positions.into()), grid.triangles(|_| true)?)
}
