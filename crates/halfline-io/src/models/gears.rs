//! Haines's block of gears: size_factor^3 gears of 36 teeth that turn in each other, every fifth
//! of glass, above a mirror. Each is a prism over a concave polygon of 144 corners.

use libm::{cos, sin};

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::View;
use super::assembly::{Assembly, Shape, haines_material};
use halfline::progress::SharedProgress;

/// The camera of the Standard Procedural Databases.
pub const VIEW: View = View {
    from: vec3(-1.1, -2.1, 2.6),
    at: Vec3::ZERO,
    up: vec3(0.0, 0.0, 1.0),
    angle_degrees: 45.0,
};

const TEETH: usize = 36;

/// Radius of the gaps between teeth and of the teeth's tips, in shares of the radius in which
/// gears mesh; tips are a little shorter than gaps are deep, so that no surfaces coincide.
const GAP_RATIO: f64 = 0.9;
const TIP_RATIO: f64 = 0.995;

/// Two ends of 142 triangles, 144 sides of two.
const TRIANGLES_PER_GEAR: usize = 2 * (4 * TEETH - 2) + 2 * 4 * TEETH;

/// A mesh of the kind [`Kind::Gears`](super::Kind::Gears).
pub fn gears(triangles: usize, progress: &SharedProgress) -> Result<Mesh> {
    let count = |size: usize| size * size * size * TRIANGLES_PER_GEAR + 2;
    let mut size = 1;
    while count(size + 1).abs_diff(triangles) < count(size).abs_diff(triangles) {
        size += 1;
    }
    let total = count(size);
    let mut scene = Assembly::new(4 + size * size * size * 8 * TEETH, total)?;
    let ground = scene.material(haines_material([1.0, 0.85, 0.7], 0.3, 0.6, 0.0, 1.5));
    let corner = |x: f64, y: f64| vec3(2.0 * x, 2.0 * y, 0.0);
    scene
        .quad([corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)], ground);

    let factor = size as f64;
    let depth = 1.0 - GAP_RATIO;
    let radius = 1.0 / (factor - (factor - 1.0) * depth / 2.0);
    let thickness = (1.0 / (2.0 * factor)).min(0.1);
    let spacing = radius * (2.0 - depth);
    // Gears whose coordinates add up to an odd number are turned by half a tooth.
    let shapes = [gear(0.0), gear(std::f64::consts::PI / TEETH as f64)];
    for z in 0..size {
        for y in 0..size {
            progress.check()?;
            for x in 0..size {
                let color = color(x, y, z);
                let material = if (4 * x + 2 * y + z) % 5 == 0 {
                    haines_material(color, 0.2, 0.0, 0.8, 1.1)
                } else {
                    haines_material(color, 1.0, 0.0, 0.0, 1.5)
                };
                let material = scene.material(material);
                let center = vec3(
                    radius - 1.0 + x as f64 * spacing,
                    radius - 1.0 + y as f64 * spacing,
                    1.0 - z as f64 / factor,
                );
                scene.shape(&shapes[(x + y + z) % 2], material, |p| {
                    center + vec3(radius * p.x, radius * p.y, thickness * p.z)
                });
            }
        }
    }
    scene.finish()
}

/// A colour from the place in the block, its strongest part 1.
fn color(x: usize, y: usize, z: usize) -> [f32; 3] {
    let part = |n: usize, factor: usize| 0.01 + (n * factor % 7) as f32 / 7.0;
    let color = [
        part(3 * x + 2 * y + z + 1, 5),
        part(3 * y + 2 * z + x + 1, 3),
        part(3 * z + 2 * x + y + 1, 2),
    ];
    let strongest = color[0].max(color[1]).max(color[2]);
    color.map(|c| c / strongest)
}

/// A gear of radius 1 between z = -1 and z = 0, turned by `angle`.
fn gear(angle: f64) -> Shape {
    let tooth = std::f64::consts::TAU / TEETH as f64;
    let outline: Vec<(f64, f64)> = (0..TEETH)
        .flat_map(|i| {
            let middle = angle + tooth * i as f64;
            [(-0.19, TIP_RATIO), (0.19, TIP_RATIO), (0.3, GAP_RATIO), (0.7, GAP_RATIO)].map(
                |(turn, radius)| {
                    let a = middle + turn * tooth;
                    (radius * cos(a), radius * sin(a))
                },
            )
        })
        .collect();
    let n = outline.len() as u32;
    let mut positions: Vec<Vec3> = outline.iter().map(|&(x, y)| vec3(x, y, 0.0)).collect();
    positions.extend(outline.iter().map(|&(x, y)| vec3(x, y, -1.0)));

    let mut face = Vec::with_capacity(n as usize - 2);
    let mut hub = Vec::with_capacity(2 * TEETH);
    for tip in (0..n).step_by(4) {
        let before = (tip + n - 1) % n;
        face.push([before, tip, tip + 1]);
        face.push([before, tip + 1, tip + 2]);
        hub.extend([before, tip + 2]);
    }
    halve(&hub, &mut face);

    let mut triangles = face.clone();
    triangles.extend(face.iter().map(|&[a, b, c]| [n + a, n + c, n + b]));
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.push([n + i, n + j, j]);
        triangles.push([n + i, j, i]);
    }
    Shape { positions, triangles }
}

/// Cuts a convex polygon into triangles by halving its chain of corners, which gives few thin
/// ones.
fn halve(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    if let [first, .., last] = *corners
        && corners.len() > 2
    {
        let middle = corners.len() / 2;
        triangles.push([first, corners[middle], last]);
        halve(&corners[..=middle], triangles);
        halve(&corners[middle..], triangles);
    }
}
