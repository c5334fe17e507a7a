//! Haines's tetrahedral pyramid (after Glassner 1984): Sierpinski's tetrahedron in the cube from
//! -1 to 1.

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::View;
use super::assembly::{Assembly, Shape, haines_material};
use halfline::progress::SharedProgress;

/// The camera of the Standard Procedural Databases.
pub const VIEW: View = View {
    from: vec3(1.022846, -3.177154, -2.174512),
    at: vec3(-0.004103, -0.004103, 0.216539),
    up: vec3(-0.816497, -0.816497, 0.816497),
    angle_degrees: 45.0,
};

/// Every second corner of the cube.
const CORNERS: [Vec3; 4] =
    [vec3(-1.0, -1.0, 1.0), vec3(-1.0, 1.0, -1.0), vec3(1.0, -1.0, -1.0), vec3(1.0, 1.0, 1.0)];

/// A mesh of the kind [`Kind::Tetra`](super::Kind::Tetra).
pub fn tetra(triangles: usize, progress: &SharedProgress) -> Result<Mesh> {
    // The nearest power of four: 4^k is nearer than 4^(k + 1) up to their geometric mean.
    let mut size_factor = 1;
    while triangles > 2 << (2 * size_factor) {
        size_factor += 1;
    }
    let total = 1usize << (2 * size_factor);
    let mut scene = Assembly::new(total, total)?;
    let red = scene.material(haines_material([1.0, 0.2, 0.2], 1.0, 0.0, 0.0, 1.5));
    let tetrahedron = Shape {
        positions: CORNERS.to_vec(),
        triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]],
    };
    divide(&mut scene, &tetrahedron, size_factor, Vec3::ZERO, 1.0, red, progress)?;
    scene.finish()
}

fn divide(
    scene: &mut Assembly,
    tetrahedron: &Shape,
    depth: u32,
    center: Vec3,
    size: f64,
    material: u32,
    progress: &SharedProgress,
) -> Result<()> {
    if depth <= 1 {
        scene.shape(tetrahedron, material, |p| center + p * size);
        return Ok(());
    }
    progress.check()?;
    for corner in CORNERS {
        let half = size / 2.0;
        divide(scene, tetrahedron, depth - 1, center + corner * half, half, material, progress)?;
    }
    Ok(())
}
