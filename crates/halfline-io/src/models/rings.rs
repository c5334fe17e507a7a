//! Haines's rings: six pentagonal rings, each through the middles of edges of a dodecahedron, are
//! one object; objects stand in layers of 1, 4, 9, ... before a wall, and the viewer looks at the
//! pyramid's tip. A ring's sides are cylinders, its corners spheres.
//!
//! Cylinders are closed with discs, which the spheres hide.

use libm::{acos, cos, sin, tan};
use std::f64::consts::PI;

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::View;
use super::assembly::{Assembly, Shape, haines_material, nearest_tessellation};
use halfline::progress::SharedProgress;

/// Radius of cylinders and spheres, with which the rings of an object just touch.
const RADIUS: f64 = 0.07412;

/// The colour of each of the six rings of an object.
const COLORS: [[f32; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
];

/// Cylinders have at least this many sides before another layer is added.
const SIDES: usize = 8;

/// The distance between layers, and of the viewer from the origin.
fn spread() -> f64 {
    1.0 / sin(PI / 8.0)
}

/// The camera of the Standard Procedural Databases.
pub fn view() -> View {
    let from = vec3(-1.0, -spread(), 0.5);
    View { from, at: from + vec3(0.0, 1.0, 0.0), up: vec3(0.0, 0.0, 1.0), angle_degrees: 45.0 }
}

/// A mesh of the kind [`Kind::Rings`](super::Kind::Rings).
pub fn rings(triangles: usize, progress: &SharedProgress) -> Result<Mesh> {
    let wanted = triangles.saturating_sub(2);
    let mut layers = 1;
    while count(layers + 1, SIDES, SIDES / 2) <= wanted {
        layers += 1;
    }
    let (segments, stacks) = nearest_tessellation(wanted, 3, |a, b| count(layers, a, b));
    let (cylinder, sphere) = (Shape::cylinder(segments), Shape::sphere(segments, stacks));

    let total = count(layers, segments, stacks) + 2;
    let parts = 30 * layers * (layers + 1) * (2 * layers + 1) / 6;
    let vertices = cylinder.positions.len() + sphere.positions.len();
    let mut scene = Assembly::new(parts * vertices + 4, total)?;
    let white = scene.material(haines_material([1.0; 3], 1.0, 0.0, 0.0, 1.5));
    let colors = COLORS.map(|color| scene.material(haines_material(color, 0.5, 0.2, 0.0, 1.5)));

    // The wall just fills the picture.
    let eye = view().from;
    let depth = spread() * (layers + 1) as f64;
    let half = 1.01 * (depth - eye.y) * tan(PI / 8.0);
    let corner = |x: f64, z: f64| vec3(eye.x + half * x, depth, eye.z + half * z);
    scene.quad([corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)], white);

    let corners = dodecahedral_rings();
    for layer in 0..layers {
        for z in 0..=layer {
            progress.check()?;
            for x in 0..=layer {
                let place = vec3(
                    2.0 * x as f64 - layer as f64,
                    spread() * (layer + 1) as f64,
                    2.0 * z as f64 - layer as f64,
                );
                for (ring, color) in corners.iter().zip(colors) {
                    for i in 0..5 {
                        let (base, apex) = (place + ring[i], place + ring[(i + 4) % 5]);
                        scene.along(&cylinder, (base, RADIUS), (apex, RADIUS), color);
                        scene.shape(&sphere, color, |p| base + p * RADIUS);
                    }
                }
            }
        }
    }
    scene.finish()
}

/// Number of the rings' triangles.
fn count(layers: usize, segments: usize, stacks: usize) -> usize {
    let part = Shape::cylinder_triangles(segments) + Shape::sphere_triangles(segments, stacks);
    30 * part * layers * (layers + 1) * (2 * layers + 1) / 6
}

/// The corners of six pentagons which meet in the middles of the edges of a dodecahedron, such
/// that the rings around them fit in the unit sphere.
fn dodecahedral_rings() -> [[Vec3; 5]; 6] {
    let scale = 1.0 / (1.0 + RADIUS);
    let flat: [Vec3; 5] = std::array::from_fn(|i| {
        let angle = i as f64 * 2.0 * PI / 5.0;
        vec3(scale * cos(angle), scale * sin(angle), 0.0)
    });
    // The first lies flat; each of the others is tilted by the dihedral angle of the
    // dodecahedron, then turned.
    let tilt = 2.0 * acos(0.5 / sin(PI / 5.0));
    let (st, ct) = (sin(tilt), cos(tilt));
    std::array::from_fn(|ring| {
        if ring == 0 {
            return flat;
        }
        let turn = PI * (2 * ring - 1) as f64 / 5.0;
        let (sz, cz) = (sin(turn), cos(turn));
        flat.map(|v| {
            let (y, z) = (ct * v.y - st * v.z, st * v.y + ct * v.z);
            vec3(cz * v.x - sz * y, sz * v.x + cz * y, z)
        })
    })
}
