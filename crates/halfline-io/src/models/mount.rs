//! Haines's fractal mountain by Carpenter's method (Fournier, Fussell and Carpenter, "Computer
//! Rendering of Stochastic Models", CACM 25(6), 1982), with a pyramid of four glass balls above.
//!
//! Haines's heights are seeded by a hash that repeats and that depends on the size factor. Here
//! they come from a good hash of the place, so that a finer mountain is the same mountain. A
//! number of triangles between two size factors samples the mountain of the larger one.

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::View;
use super::assembly::{Assembly, Shape, haines_material, nearest_tessellation};
use super::fill::reserved;
use super::noise::mix_linear;
use halfline::geometry::random::Random;
use halfline::progress::SharedProgress;

/// The camera of the Standard Procedural Databases.
pub const VIEW: View = View {
    from: vec3(-1.6, 1.6, 1.7),
    at: Vec3::ZERO,
    up: vec3(0.0, 0.0, 1.0),
    angle_degrees: 45.0,
};

/// The mountain stands on the square from -1 to 1.
const WIDTH: f64 = 2.0;

/// Between 2 (smooth) and 3 (filling space).
const FRACTAL_DIMENSION: f64 = 2.2;

/// Middle of the pyramid of balls, and a ball's radius.
const BALLS: Vec3 = vec3(-0.8, 0.8, 1.0);
const BALL_RADIUS: f64 = 0.17;

/// A mesh of the kind [`Kind::Mount`](super::Kind::Mount).
pub fn mount(triangles: usize, seed: u64, progress: &SharedProgress) -> Result<Mesh> {
    // A twentieth of the triangles is the balls', more if there are few.
    let share = (triangles / 20).max(800.min(triangles * 3 / 10));
    let (segments, stacks) = nearest_tessellation(share / 4, 3, Shape::sphere_triangles);
    let ball = Shape::sphere(segments, stacks);
    let rest = triangles.saturating_sub(4 * ball.triangles.len());
    let side = ((rest as f64 / 2.0).sqrt().round() as usize).max(1);

    let size = side.next_power_of_two();
    let heights = heights(size, seed, progress)?;
    let total = 2 * side * side + 4 * ball.triangles.len();
    let mut scene = Assembly::new((side + 1) * (side + 1) + 4 * ball.positions.len(), total)?;
    let glass = scene.material(haines_material([1.0; 3], 0.1, 0.1, 0.9, 1.5));
    let rock = scene.material(haines_material([0.5, 0.45, 0.35], 1.0, 0.0, 0.0, 1.5));
    for center in pyramid() {
        scene.shape(&ball, glass, |p| center + p * BALL_RADIUS);
    }

    let first = scene.vertex_count() as u32;
    for j in 0..=side {
        progress.check()?;
        for i in 0..=side {
            let (x, y) = (i as f64 / side as f64, j as f64 / side as f64);
            let z = sample(&heights, size, x, y);
            scene.vertex(vec3(WIDTH * x - 1.0, WIDTH * y - 1.0, z));
        }
    }
    let row = side as u32 + 1;
    for j in 0..side as u32 {
        for i in 0..side as u32 {
            let a = first + j * row + i;
            scene.triangle([a, a + 1, a + row + 1], rock);
            scene.triangle([a, a + row + 1, a + row], rock);
        }
    }
    scene.finish()
}

/// The centres of the balls: one above, three below, each touching the others.
fn pyramid() -> [Vec3; 4] {
    let distance = BALL_RADIUS * 1.5f64.sqrt();
    // The angle between two of the directions has cosine -1/3; the first of the lower three lies
    // towards (1, -1).
    let (sine, cosine) = ((8.0f64 / 9.0).sqrt(), -1.0 / 3.0);
    let low = vec3(sine * 0.5f64.sqrt(), -sine * 0.5f64.sqrt(), cosine);
    let third = |v: Vec3| {
        let s = 0.75f64.sqrt();
        vec3(-0.5 * v.x - s * v.y, s * v.x - 0.5 * v.y, v.z)
    };
    [vec3(0.0, 0.0, 1.0), low, third(low), third(third(low))].map(|v| BALLS + v * distance)
}

/// The heights of the (size + 1)^2 points of the grid, row by row; `size` is a power of two.
fn heights(size: usize, seed: u64, progress: &SharedProgress) -> Result<Vec<f32>> {
    let row = size + 1;
    let mut heights: Vec<f32> = reserved(row * row)?;
    heights.resize(row * row, 0.0);
    // Mandelbrot's scaling: halving the length multiplies the standard deviation by
    // 2^(dimension - 3), and this is what then keeps the slope's variance.
    let ratio = 2.0 / libm::exp2(1.0 / (FRACTAL_DIMENSION - 1.0));
    let roughness = (ratio * ratio - 1.0).sqrt();

    let mut width = size;
    let mut level = 0u64;
    while width > 1 {
        let half = width / 2;
        let rise = roughness * half as f64 * WIDTH / size as f64;
        for y in (0..=size).step_by(half) {
            progress.check()?;
            for x in (0..=size).step_by(half) {
                let (odd_x, odd_y) = (x / half % 2 == 1, y / half % 2 == 1);
                let at = |x: usize, y: usize| f64::from(heights[y * row + x]);
                // The mean of the neighbours that the level before has set.
                let (mean, rise) = match (odd_x, odd_y) {
                    (false, false) => continue,
                    (true, false) => ((at(x - half, y) + at(x + half, y)) / 2.0, rise),
                    (false, true) => ((at(x, y - half) + at(x, y + half)) / 2.0, rise),
                    (true, true) => {
                        let corners = at(x - half, y - half)
                            + at(x + half, y - half)
                            + at(x + half, y + half)
                            + at(x - half, y + half);
                        (corners / 4.0, rise * 2.0f64.sqrt())
                    }
                };
                let place = level << 58 | ((y / half) as u64) << 29 | (x / half) as u64;
                let height = mean + rise * Random::new(seed, place).normal();
                heights[y * row + x] = height as f32;
            }
        }
        width = half;
        level += 1;
    }
    Ok(heights)
}

/// The height at (x, y) of the unit square, bilinear between the grid's points.
fn sample(heights: &[f32], size: usize, x: f64, y: f64) -> f64 {
    let (x, y) = (x * size as f64, y * size as f64);
    let (i, j) = ((x as usize).min(size - 1), (y as usize).min(size - 1));
    let at = |i: usize, j: usize| f64::from(heights[j * (size + 1) + i]);
    let (u, v) = (x - i as f64, y - j as f64);
    mix_linear(
        mix_linear(at(i, j), at(i + 1, j), u),
        mix_linear(at(i, j + 1), at(i + 1, j + 1), u),
        v,
    )
}
