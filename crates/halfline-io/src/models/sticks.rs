//! Long thin sticks that cross the unit cube in all directions.
//!
//! A cell of side h holds about n h^2 of them, where it holds n h^3 small triangles: planes hardly
//! get them apart, and each plane cuts many.

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::fill::separate_triangles;
use halfline::geometry::random::Random;
use halfline::progress::SharedProgress;

/// The width of all sticks side by side, so that a half-line goes about as far as the cube is wide
/// before it hits one, however many there are.
const TOTAL_WIDTH: f64 = 2.0;

/// No stick is wider, for few should be thin as well; nor thinner, for single precision to hold it.
const WIDTHS: [f64; 2] = [1.0 / (1 << 21) as f64, 0.05];

/// Sticks that only cut a corner of the cube are drawn again.
const SHORTEST: f64 = 0.3;

/// So are those of which rounding would decide how they are turned about themselves.
const SMALLEST_SINE: f64 = 0.1;

/// A mesh of the kind [`Kind::Sticks`](super::Kind::Sticks).
pub fn sticks(triangles: usize, seed: u64, progress: &SharedProgress) -> Result<Mesh> {
    let width = (TOTAL_WIDTH / triangles.div_ceil(2) as f64).clamp(WIDTHS[0], WIDTHS[1]);
    separate_triangles(triangles, progress, |index| {
        let [a, b, c, d] = stick(seed, (index / 2) as u64, width);
        if index % 2 == 0 { [a, b, c] } else { [a, c, d] }
    })
}

/// The corners of stick `index`, a rectangle from wall to wall through a random point.
fn stick(seed: u64, index: u64, width: f64) -> [Vec3; 4] {
    let mut random = Random::new(seed, index);
    loop {
        // Leave room for the width at the walls.
        let inside = vec3(random.unit(), random.unit(), random.unit()) * (1.0 - 2.0 * width)
            + Vec3::splat(width);
        let along = random.direction();
        let aside = along.cross(random.direction());
        let [start, end] =
            [-1.0, 1.0].map(|way| inside + along * to_wall(inside, along * way, width) * way);
        if (end - start).length() >= SHORTEST && aside.length() >= SMALLEST_SINE {
            let half = aside.normalized() * (width / 2.0);
            return [start - half, end - half, end + half, start + half];
        }
    }
}

/// How far it is from a point along a unit vector to the first of the cube's walls, less `room`.
fn to_wall(point: Vec3, along: Vec3, room: f64) -> f64 {
    let distance = |axis: usize| match along[axis] {
        0.0 => f64::INFINITY,
        up if up > 0.0 => (1.0 - room - point[axis]) / up,
        down => (room - point[axis]) / down,
    };
    distance(0).min(distance(1)).min(distance(2))
}

#[cfg(test)]
mod tests {
    use crate::models::{Kind, generate};
    use halfline::geometry::Vec3;
    use halfline::progress::NoProgress;

    #[test]
    fn sticks_go_from_wall_to_wall() {
        for wanted in [10, 3000, 200_000] {
            let mesh = generate(Kind::Sticks, wanted, 3, &NoProgress).unwrap();
            let width = (2.0 / wanted.div_ceil(2) as f64).min(0.05);
            for t in (0..mesh.triangle_count() as u32).step_by(2) {
                let [a, b, c] = mesh.corners(t);
                assert!((b - a).length() > 0.29, "{t}: {a:?} {b:?}");
                assert!(((c - b).length() / width - 1.0).abs() < 0.05, "{t}: {b:?} {c:?}");
                for end in [a, b] {
                    let to_wall =
                        end.min(Vec3::splat(1.0) - end).to_array().into_iter().fold(1.0, f64::min);
                    assert!(to_wall <= 1.6 * width, "{t}: {end:?}");
                }
            }
        }
    }
}
