//! The Utah teapot (Newell 1975; Crow, "The Origins of the Teapot", IEEE CG&A 7(1), 1987) on a
//! checkerboard, as in Haines's databases: 32 bicubic Bezier patches with a bottom.
//!
//! Body and lid are surfaces of revolution but for Newell's approximate circles, handle and spout
//! are mirrored; so the patches are given here by their profiles. Patches that touch share their
//! vertices.

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::View;
use super::assembly::{Assembly, haines_material};
use halfline::progress::SharedProgress;

/// The camera of the Standard Procedural Databases.
pub const VIEW: View = View {
    from: vec3(4.86, 7.2, 5.4),
    at: Vec3::ZERO,
    up: vec3(0.0, 0.0, 1.0),
    angle_degrees: 45.0,
};

/// Half the side of the checkerboard.
const BOARD: f64 = 4.0;

/// The board keeps the squares of the databases' usual picture when it is cut more finely.
const SQUARES: usize = 12;

/// A point of a profile that is turned about the axis: its radius, the length of the Bezier
/// handles of the quarter circle there, and its height.
type Turned = (f64, f64, f64);

/// A point of a profile that is mirrored: x, z, and half the width along y.
type Mirrored = (f64, f64, f64);

/// Newell's circle: handles of 0.56 times the radius.
const fn turned(radius: f64, height: f64) -> Turned {
    (radius, 0.56 * radius, height)
}

/// From the inside of the rim over it, down the body, and to the middle of the bottom.
const BODY: [Turned; 13] = [
    turned(1.4, 2.4),
    turned(1.3375, 2.53125),
    turned(1.4375, 2.53125),
    turned(1.5, 2.4),
    turned(1.75, 1.875),
    turned(2.0, 1.35),
    turned(2.0, 0.9),
    turned(2.0, 0.45),
    turned(1.5, 0.225),
    turned(1.5, 0.15),
    turned(1.5, 0.075),
    turned(1.425, 0.0),
    turned(0.0, 0.0),
];

/// From the top of the knob to the edge of the lid. The knob's second circle is rounder.
const LID: [Turned; 7] = [
    turned(0.0, 3.15),
    (0.8, 0.45, 3.15),
    turned(0.0, 2.85),
    turned(0.2, 2.7),
    turned(0.4, 2.55),
    turned(1.3, 2.55),
    turned(1.3, 2.4),
];

/// The handle's inner and outer line, from the top down; its lower end is wider inside the body.
const HANDLE_INNER: [Mirrored; 7] = [
    (-1.6, 2.025, 0.3),
    (-2.3, 2.025, 0.3),
    (-2.7, 2.025, 0.3),
    (-2.7, 1.8, 0.3),
    (-2.7, 1.575, 0.3),
    (-2.5, 1.125, 0.3),
    (-2.0, 0.9, 0.3),
];
const HANDLE_OUTER: [Mirrored; 7] = [
    (-1.5, 2.25, 0.3),
    (-2.5, 2.25, 0.3),
    (-3.0, 2.25, 0.3),
    (-3.0, 1.8, 0.3),
    (-3.0, 1.35, 0.3),
    (-2.65, 0.9375, 0.3),
    (-1.9, 0.6, 0.3),
];

/// The spout's upper and lower line, from the body to the tip and a little way in again.
const SPOUT_UPPER: [Mirrored; 7] = [
    (1.7, 1.425, 0.66),
    (2.6, 1.425, 0.66),
    (2.3, 2.1, 0.25),
    (2.7, 2.4, 0.25),
    (2.8, 2.475, 0.25),
    (2.9, 2.475, 0.15),
    (2.8, 2.4, 0.15),
];
const SPOUT_LOWER: [Mirrored; 7] = [
    (1.7, 0.6, 0.66),
    (3.1, 0.825, 0.66),
    (2.4, 2.025, 0.25),
    (3.3, 2.4, 0.25),
    (3.525, 2.49375, 0.25),
    (3.45, 2.5125, 0.15),
    (3.2, 2.4, 0.15),
];

/// A mesh of the kind [`Kind::Teapot`](super::Kind::Teapot).
pub fn teapot(triangles: usize, progress: &SharedProgress) -> Result<Mesh> {
    let count = |cuts: usize| 66 * cuts * cuts - 8 * cuts;
    // With one cut, handle and spout would be flat.
    let mut cuts = 2;
    while count(cuts + 1).abs_diff(triangles) < count(cuts).abs_diff(triangles) {
        cuts += 1;
    }
    let mut scene = Assembly::new(36 * (cuts + 1) * (cuts + 1), count(cuts))?;
    board(&mut scene, cuts, progress)?;

    let china = scene.material(haines_material([1.0, 0.5, 0.1], 0.75, 0.25, 0.0, 1.5));
    let mut part = |rows, columns, point: &dyn Fn(f64, f64) -> Vec3| -> Result<()> {
        progress.check()?;
        tube(&mut scene, (rows, columns, cuts), point, china);
        Ok(())
    };
    part(4, 4, &|row, column| turned_point(&BODY, row, column))?;
    part(2, 4, &|row, column| turned_point(&LID, row, column))?;
    part(2, 2, &|row, column| mirrored_point(&HANDLE_OUTER, &HANDLE_INNER, row, column))?;
    part(2, 2, &|row, column| mirrored_point(&SPOUT_LOWER, &SPOUT_UPPER, row, column))?;
    scene.finish()
}

/// The checkerboard of `cuts` by `cuts` squares.
fn board(scene: &mut Assembly, cuts: usize, progress: &SharedProgress) -> Result<()> {
    let colors =
        [0.5, 1.0].map(|grey: f32| scene.material(haines_material([grey; 3], 0.5, 0.5, 0.0, 1.5)));
    let first = scene.vertex_count() as u32;
    let line = |i: usize| BOARD * (2.0 * i as f64 / cuts as f64 - 1.0);
    for j in 0..=cuts {
        for i in 0..=cuts {
            scene.vertex(vec3(line(i), line(j), 0.0));
        }
    }
    let squares = cuts.min(SQUARES);
    let row = cuts as u32 + 1;
    for j in 0..cuts {
        progress.check()?;
        for i in 0..cuts {
            let color = colors[(i * squares / cuts + j * squares / cuts) % 2];
            let a = first + j as u32 * row + i as u32;
            scene.triangle([a, a + 1, a + row + 1], color);
            scene.triangle([a, a + row + 1, a + row], color);
        }
    }
    Ok(())
}

/// Adds `rows` by `columns` patches, each cut `cuts` times each way, that close along columns.
/// `point(row, column)` counts in patches; its rows run downwards or outwards, and its columns
/// counter-clockwise as seen from the first row. Where a whole row is one point, so it is in the
/// mesh.
fn tube(
    scene: &mut Assembly,
    (rows, columns, cuts): (usize, usize, usize),
    point: &dyn Fn(f64, f64) -> Vec3,
    material: u32,
) {
    let around = columns * cuts;
    let at = |i: usize, j: usize| point(i as f64 / cuts as f64, j as f64 / cuts as f64);
    let lines: Vec<Vec<u32>> = (0..=rows * cuts)
        .map(|i| {
            if at(i, 0) == at(i, around / 2) {
                vec![scene.vertex(at(i, 0)); around]
            } else {
                (0..around).map(|j| scene.vertex(at(i, j))).collect()
            }
        })
        .collect();
    for pair in lines.windows(2) {
        for j in 0..around {
            let k = (j + 1) % around;
            let [a, b, c, d] = [pair[0][j], pair[1][j], pair[1][k], pair[0][k]];
            for triangle in [[a, b, c], [a, c, d]] {
                if triangle[0] != triangle[1]
                    && triangle[1] != triangle[2]
                    && triangle[2] != triangle[0]
                {
                    scene.triangle(triangle, material);
                }
            }
        }
    }
}

/// The values of the four cubic Bernstein polynomials.
fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// The point at `t`, counted in segments, of a chain of cubic Bezier curves.
fn chain<const N: usize>(points: &[[f64; N]], t: f64) -> [f64; N] {
    let segments = (points.len() - 1) / 3;
    let segment = (t as usize).min(segments - 1);
    let weights = bernstein(t - segment as f64);
    std::array::from_fn(|axis| (0..4).map(|i| weights[i] * points[3 * segment + i][axis]).sum())
}

/// A point of a surface of revolution, its column counted in quarter turns.
fn turned_point(profile: &[Turned], row: f64, column: f64) -> Vec3 {
    let points: Vec<[f64; 3]> = profile.iter().map(|&(r, k, z)| [r, k, z]).collect();
    let [radius, handle, height] = chain(&points, row);
    let quarter = column as usize;
    let weights = bernstein(column - quarter as f64);
    let along = weights[0] * radius + weights[1] * radius + weights[2] * handle;
    let aside = weights[1] * handle + weights[2] * radius + weights[3] * radius;
    match quarter % 4 {
        0 => vec3(along, aside, height),
        1 => vec3(-aside, along, height),
        2 => vec3(-along, -aside, height),
        _ => vec3(aside, -along, height),
    }
}

/// A point of a mirrored tube: column 0 is the line `first`, 1 is `second`, between them y runs
/// to the right of the way along and back on the other side.
fn mirrored_point(first: &[Mirrored], second: &[Mirrored], row: f64, column: f64) -> Vec3 {
    let points =
        |line: &[Mirrored]| -> Vec<[f64; 3]> { line.iter().map(|&(x, z, y)| [x, z, y]).collect() };
    let [fx, fz, fy] = chain(&points(first), row);
    let [sx, sz, sy] = chain(&points(second), row);
    let half = column as usize;
    let t = column - half as f64;
    let weights = bernstein(if half.is_multiple_of(2) { t } else { 1.0 - t });
    let side = if half.is_multiple_of(2) { -1.0 } else { 1.0 };
    let (begin, end) = (weights[0] + weights[1], weights[2] + weights[3]);
    vec3(begin * fx + end * sx, side * (weights[1] * fy + weights[2] * sy), begin * fz + end * sz)
}
