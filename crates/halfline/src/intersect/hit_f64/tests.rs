//! What eight lanes know is what the scalar way gives, and they know nearly all.

use super::*;
use crate::geometry::{Ray, Vec3, random::Random};
use crate::numeric::PreparedRay;
use crate::simd::{Job, Level};

/// Lines that meet triangles.
struct Find<'a>(&'a [(Ray, [Vec3; 3])]);

impl Job for Find<'_> {
    type Output = HitLanes;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> HitLanes {
        let wide = simd.doubles();
        let mut lanes = [[wide.splat(0.0); 3]; 5];
        for axis in 0..3 {
            let mut numbers = [[0.0; LANES]; 5];
            for (lane, (ray, [a, b, c])) in self.0.iter().enumerate() {
                for (part, vector) in [ray.origin, ray.direction, *a, *b, *c].iter().enumerate() {
                    numbers[part][lane] = vector[axis];
                }
            }
            for part in 0..5 {
                lanes[part][axis] = wide.set(numbers[part]);
            }
        }
        hit_f64x8(simd, &lanes)
    }
}

/// Holds what every instruction set knows of triangles of such a size, at such a distance from the starts and the
/// origin, against the scalar way. Returns the share of those whose t is known.
fn known_share(random: &mut Random, size: f64, distance: f64, place: f64) -> f64 {
    let (mut known, mut all) = (0, 0);
    for _ in 0..2000 {
        let mut pairs = [(Ray::new(Vec3::ZERO, Vec3::ZERO), [Vec3::ZERO; 3]); LANES];
        for pair in &mut pairs {
            let mut point = || Vec3::from([0; 3].map(|_| random.unit() * 2.0 - 1.0));
            let middle = point() * place;
            let corners = [(); 3].map(|()| middle + point() * size);
            let [a, b, c] = corners;
            let origin = middle + point() * distance;
            let (u, v) = (random.unit() * 0.5, random.unit() * 0.5);
            let target = a + (b - a) * u + (c - a) * v;
            *pair = (Ray::new(origin, (target - origin) * 0.37), corners);
        }
        for level in Level::available() {
            let hits = level.run(Find(&pairs));
            for (lane, (ray, corners)) in pairs.iter().enumerate() {
                let expected = PreparedRay::new(ray).expect("it is valid").hit(0, *corners);
                let place = || format!("{}: {ray:?} and {corners:?}", level.name());
                if hits.known >> lane & 1 == 1 {
                    assert_eq!(hits.t[lane].to_bits(), expected.t.to_bits(), "{}", place());
                }
                if hits.weights_known >> lane & 1 == 1 {
                    let weights = [hits.u[lane], hits.v[lane]].map(f64::to_bits);
                    assert_eq!(weights, [expected.u, expected.v].map(f64::to_bits), "{}", place());
                }
                known += hits.known >> lane & 1;
                all += 1;
            }
        }
    }
    f64::from(known) / f64::from(all)
}

#[test]
fn lanes_know_what_the_scalar_way_gives() {
    let mut random = Random::new(0x6a17, 0);
    for (size, distance, place) in [
        (1.0, 1.0, 0.0),
        (1.0, 1.0, 1.0),
        (1e-3, 1.0, 1.0),
        (1e-6, 1.0, 1.0),
        (10.0, 0.1, 1.0),
        (1.0, 100.0, 1e6),
        (0.01, 1.0, 1e6),
    ] {
        let share = known_share(&mut random, size, distance, place);
        assert!(share > 0.99, "{share} of size {size}, distance {distance}, place {place}");
    }
}
