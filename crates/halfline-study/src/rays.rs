//! Chords: the rays that every engine is asked about.

use halfline::geometry::random::Random;
use halfline::geometry::{Aabb, Ray, vec3};

/// A constant seed, so that a box always gets the same rays, whatever else is measured.
const SEED: u64 = 1;

/// `count` half-lines that know nothing of each other. Each starts at a random point of the sphere
/// around the box (through its corners) and is aimed at a random point of the box; both are uniform.
pub fn chords(bounds: &Aabb, count: usize) -> Vec<Ray> {
    let (center, extent) = (bounds.center(), bounds.extent());
    let radius = extent.length() / 2.0;
    let chord = |index| {
        let mut random = Random::new(SEED, index);
        let start = center + random.direction() * radius;
        let target = bounds.min + extent * vec3(random.unit(), random.unit(), random.unit());
        Ray::new(start, target - start)
    };
    (0..count as u64).map(chord).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::geometry::Vec3;

    #[test]
    fn chords_come_from_the_sphere_and_go_through_the_box() {
        let bounds = Aabb { min: vec3(-3.0, 1.0, 5.0), max: vec3(1.0, 4.0, 6.0) };
        let rays = chords(&bounds, 1000);
        let mut mean = Vec3::ZERO;
        for ray in &rays {
            let radius = (ray.origin - bounds.center()).length();
            assert!((radius - 26f64.sqrt() / 2.0).abs() < 1e-12, "{radius}");
            let target = ray.at(1.0);
            for axis in 0..3 {
                assert!(
                    (bounds.min[axis] - 1e-9..=bounds.max[axis] + 1e-9).contains(&target[axis])
                );
            }
            mean += (target - bounds.center()) / 1000.0;
        }
        // The mean of a thousand numbers from -2 to 2 deviates by 0.04.
        assert!(mean.length() < 0.2, "{mean:?}");
        assert_eq!(chords(&bounds, 10), rays[..10]);
    }
}
