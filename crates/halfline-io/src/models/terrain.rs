//! An eroded mountain range: a fractal sum of gradient noise in which steep places get less of
//! the finer noise, folded into ridges (Musgrave, Kolb and Mace, "The Synthesis and Rendering of
//! Eroded Fractal Terrains", SIGGRAPH 1989), with gullies that run down the slope.
//!
//! The gullies stand in for the erosion that Musgrave simulates, which would make each point
//! depend on all others: they are stripes across the contour lines, blended from cell to cell,
//! finer ones following the slopes that the coarser ones made.

use halfline::error::Result;
use halfline::geometry::vec3;
use halfline::mesh::{Mesh, Positions};

use super::View;
use super::fill::{fill, single};
use super::noise::{Noise, smooth_step};
use halfline::progress::SharedProgress;

/// Over the foothills towards the peaks.
pub const VIEW: View = View {
    from: vec3(-1.1, -1.6, 0.95),
    at: vec3(0.0, -0.1, 0.08),
    up: vec3(0.0, 0.0, 1.0),
    angle_degrees: 40.0,
};

/// A mesh of the kind [`Kind::Terrain`](super::Kind::Terrain).
pub fn terrain(triangles: usize, seed: u64, progress: &SharedProgress) -> Result<Mesh> {
    let (columns, rows) = sides(triangles);
    let shape = Shape::new(seed, 2.0 / columns as f64);
    let positions = fill((columns + 1) * (rows + 1), triangles / 10 * 9, progress, |i| {
        let x = 2.0 * (i % (columns + 1)) as f64 / columns as f64 - 1.0;
        let y = 2.0 * (i / (columns + 1)) as f64 / rows as f64 - 1.0;
        single(vec3(x, y, shape.height(x, y)))
    })?;
    let indices = fill(2 * columns * rows, triangles / 10, progress, |i| {
        let (cell, row) = (i / 2, columns + 1);
        let (x, y) = (cell % columns, cell / columns);
        let a = y * row + x;
        // Diagonals alternate, so that none of their directions shows.
        let corners = match (i % 2, (x + y) % 2) {
            (0, 0) => [a, a + 1, a + row + 1],
            (1, 0) => [a, a + row + 1, a + row],
            (0, _) => [a, a + 1, a + row],
            _ => [a + 1, a + row + 1, a + row],
        };
        corners.map(|v| v as u32)
    })?;
    Mesh::new(Positions::F32(positions.into()), indices)
}

/// Columns and rows of a grid that is square but for a tenth, with two triangles to a cell, and
/// their number as near as can be.
fn sides(triangles: usize) -> (usize, usize) {
    let cells = (triangles / 2).max(1);
    let side = ((cells as f64).sqrt().round() as usize).max(1);
    let rows = |columns: usize| ((cells + columns / 2) / columns).max(1);
    let off = |columns: usize| (columns * rows(columns)).abs_diff(cells);
    let columns = (side - side / 10..=side).rev().min_by_key(|&columns| off(columns));
    let columns = columns.unwrap_or(side);
    (columns, rows(columns))
}

/// Octaves of noise, and how many of them the gullies see.
const OCTAVES: usize = 11;
const COARSE_OCTAVES: usize = 4;

/// Octaves of gullies.
const GULLIES: usize = 5;

/// Noise lattice cells across a unit of the plane.
const FREQUENCY: f64 = 1.15;

/// The height of the highest peaks, about.
const HEIGHT: f64 = 0.55;

struct Shape {
    noise: [Noise; OCTAVES],
    warp: [Noise; 2],
    gullies: Noise,
    /// Distance of the grid's lines. Finer features than it can carry are left out.
    cell: f64,
}

impl Shape {
    fn new(seed: u64, cell: f64) -> Shape {
        Shape {
            noise: std::array::from_fn(|i| Noise::new(seed, i as u64)),
            warp: [Noise::new(seed, 100), Noise::new(seed, 101)],
            gullies: Noise::new(seed, 102),
            cell,
        }
    }

    /// How much of a feature of the given size the grid can carry.
    fn carried(&self, size: f64) -> f64 {
        smooth_step(1.5, 3.0, size / self.cell)
    }

    fn height(&self, x: f64, y: f64) -> f64 {
        // Bend the plane, so that ridges wind.
        let (wx, _) = self.warp[0].planar(1.7 * x, 1.7 * y);
        let (wy, _) = self.warp[1].planar(1.7 * x, 1.7 * y);
        let (px, py) = (FREQUENCY * (x + 0.22 * wx), FREQUENCY * (y + 0.22 * wy));

        // Sum ridged octaves, each damped where those before are steep.
        let (mut frequency, mut amplitude) = (1.0, 1.0);
        let (mut height, mut slope, mut damping) = (0.0, [0.0; 2], [0.0; 2]);
        let (mut qx, mut qy) = (px, py);
        let (mut cosine, mut sine) = (1.0, 0.0);
        for octave in 0..OCTAVES {
            let weight = self.carried(1.0 / (FREQUENCY * frequency));
            if weight == 0.0 {
                break;
            }
            let (n, [du, dv]) = self.noise[octave].planar(qx * frequency, qy * frequency);
            let d = [cosine * du + sine * dv, cosine * dv - sine * du];
            // |n| with its crease rounded off where it is narrower than the octave's detail.
            let crease = (n * n + CREASE * CREASE).sqrt();
            let fold = n / crease;
            let ridge = if octave < COARSE_OCTAVES { 0.75 } else { 0.35 };
            let value = (1.0 - ridge) * n + ridge * (0.32 - 1.6 * crease);
            let factor = (1.0 - ridge) - 1.6 * ridge * fold;
            let damp = 1.0 + 1.1 * (damping[0] * damping[0] + damping[1] * damping[1]);
            height += weight * amplitude * value / damp;
            for axis in 0..2 {
                damping[axis] += amplitude * frequency * factor * d[axis] * 0.55;
            }
            if octave < COARSE_OCTAVES {
                // With wider creases, since gullies need room to turn where the slope does.
                let fold = n / (n * n + TURN * TURN).sqrt();
                let factor = (1.0 - ridge) - 1.6 * ridge * fold;
                for axis in 0..2 {
                    slope[axis] += weight * amplitude * frequency * factor * d[axis] / damp;
                }
            }
            // Turn by the angle of a 3-4-5 triangle, so that lattices do not line up.
            (qx, qy) = (0.8 * qx - 0.6 * qy + 5.2, 0.6 * qx + 0.8 * qy - 3.7);
            (cosine, sine) = (0.8 * cosine - 0.6 * sine, 0.6 * cosine + 0.8 * sine);
            frequency *= 2.0;
            amplitude *= 0.48;
        }

        // Raise the range out of its foothills, and flatten the valley floors.
        let massif = smooth_step(1.5, 0.2, (x * x + y * y).sqrt());
        let shaped = 0.36 + 0.85 * height;
        let floor = 0.08;
        let lifted =
            floor + (shaped - floor + ((shaped - floor) * (shaped - floor) + 0.004).sqrt()) / 2.0;
        let base = lifted * (0.4 + 0.6 * massif);

        // Cut gullies where it is steep.
        let steep = smooth_step(floor + 0.01, floor + 0.22, base);
        base * HEIGHT / 0.8 + 0.016 * steep * self.gullies(px, py, slope)
    }

    /// Stripes of -1 to 1 or so that run along `slope`.
    fn gullies(&self, x: f64, y: f64, slope: [f64; 2]) -> f64 {
        // About one stripe to a cell where it is steep, and none on the flat.
        let steep = (slope[0] * slope[0] + slope[1] * slope[1] + 0.3).sqrt();
        let mut direction = [-slope[1] / steep, slope[0] / steep];
        // They fade out towards crests and valley floors.
        let fading = direction[0] * direction[0] + direction[1] * direction[1];
        let (mut sum, mut amplitude, mut frequency) = (0.0, fading, 7.0);
        for octave in 0..GULLIES {
            let weight = self.carried(0.5 / (FREQUENCY * frequency));
            if weight == 0.0 {
                break;
            }
            let (value, change) =
                self.stripes(x * frequency, y * frequency, direction, octave as i64);
            sum += weight * amplitude * value;
            direction[0] -= amplitude * change[1] * 0.06;
            direction[1] += amplitude * change[0] * 0.06;
            amplitude *= 0.55;
            frequency *= 1.9;
        }
        sum
    }

    /// Stripes across `direction`, as many to a cell as it is long, and their derivative. Each
    /// cell has its own phase; a point sees the nine cells around it, weighted by distance.
    fn stripes(&self, x: f64, y: f64, direction: [f64; 2], octave: i64) -> (f64, [f64; 2]) {
        let (cx, cy) = (x.floor(), y.floor());
        let (mut value, mut change, mut total) = (0.0, [0.0; 2], 0.0);
        for j in -1..=1 {
            for i in -1..=1 {
                let (ix, iy) = (cx as i64 + i, cy as i64 + j);
                let [rx, ry] = self.gullies.cell_point(ix + 1000 * octave, iy);
                let dx = x - (ix as f64 + 0.25 + 0.5 * rx);
                let dy = y - (iy as f64 + 0.25 + 0.5 * ry);
                // Vanishes before the first cell that is not looked at.
                let near = (1.0 - (dx * dx + dy * dy) / 1.5625).max(0.0);
                let weight = near * near * near;
                let (wave, rate) = wave(dx * direction[0] + dy * direction[1]);
                value += weight * wave;
                change[0] += weight * rate * direction[0];
                change[1] += weight * rate * direction[1];
                total += weight;
            }
        }
        (value / total, [change[0] / total, change[1] / total])
    }
}

/// Half the width, in noise, of the crease of a ridge.
const CREASE: f64 = 0.02;

/// Half the width, in noise, of the turn of the slope that gullies follow.
const TURN: f64 = 0.16;

/// A smooth wave of period 1 from 1 at 0 to -1 at 1/2, and its derivative.
fn wave(t: f64) -> (f64, f64) {
    let s = 2.0 * (t - t.round());
    let a = s.abs();
    (1.0 - 2.0 * a * a * (3.0 - 2.0 * a), -24.0 * s * (1.0 - a))
}
