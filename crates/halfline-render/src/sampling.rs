//! Random numbers that fill their range evenly: the first two dimensions of the Sobol' sequence
//! with hash-based Owen scrambling.
//!
//! B. Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020, with the constants of
//! pbrt-v4 (Pharr, Jakob, Humphreys 2023, section 8.7.2). As in pbrt's padded sampler, each use
//! of random numbers at a pixel (a dimension) has its own shuffle and scramble of the same
//! two-dimensional sequence, so that it is stratified in itself and independent of the others.
//!
//! A value depends on (seed, pixel, dimension, index) alone: not on threads, nor on what was
//! drawn before.

use std::f64::consts::{PI, TAU};

use halfline::geometry::{Vec3, vec3};

/// 2^-32
const UNIT: f64 = 1.0 / 4_294_967_296.0;

/// The largest `f64` below 1.
const ONE_MINUS: f64 = 1.0 - f64::EPSILON / 2.0;

/// The random numbers of one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampler {
    pixel_key: u64,
    /// Which of the pixel's samples is drawn for.
    pub(crate) sample: u32,
}

impl Sampler {
    pub(crate) fn new(seed: u64, x: u32, y: u32) -> Sampler {
        let pixel = u64::from(y) << 32 | u64::from(x);
        Sampler { pixel_key: hash(pixel ^ hash(seed)), sample: 0 }
    }

    /// A point of the unit square, both coordinates from 0 to below 1: number `part` of the
    /// `parts` that each of the pixel's samples uses of this dimension.
    pub(crate) fn square(&self, dimension: u32, part: u32, parts: u32) -> [f64; 2] {
        let key = hash(self.pixel_key ^ u64::from(dimension).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        // Wrapping only repeats the sequence, after 2^32 points.
        let index = self.sample.wrapping_mul(parts).wrapping_add(part);
        let index = owen_scramble(index, key as u32);
        let scramble = hash(key);
        let x = owen_scramble(index.reverse_bits(), scramble as u32);
        let y = owen_scramble(sobol_second(index), (scramble >> 32) as u32);
        [f64::from(x) * UNIT, f64::from(y) * UNIT]
    }
}

/// Sobol's second dimension: the columns of Pascal's triangle modulo 2. Row j has a one in column k if
/// all bits of k are bits of j (Lucas 1878), so a bit of the result is the sum of those bits of the
/// index whose numbers contain its own: five steps, one for each bit of a number.
fn sobol_second(index: u32) -> u32 {
    let mut v = index;
    v ^= v >> 1 & 0x5555_5555;
    v ^= v >> 2 & 0x3333_3333;
    v ^= v >> 4 & 0x0f0f_0f0f;
    v ^= v >> 8 & 0x00ff_00ff;
    v ^= v >> 16 & 0x0000_ffff;
    v.reverse_bits()
}

/// Nested uniform scrambling: whether a bit flips depends on all bits above it.
fn owen_scramble(value: u32, seed: u32) -> u32 {
    let mut v = value.reverse_bits();
    v ^= v.wrapping_mul(0x3d20_adea);
    v = v.wrapping_add(seed);
    v = v.wrapping_mul((seed >> 16) | 1);
    v ^= v.wrapping_mul(0x0552_6c56);
    v ^= v.wrapping_mul(0x53a2_2864);
    v.reverse_bits()
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): every bit depends on every bit.
pub(crate) fn hash(mut v: u64) -> u64 {
    v = v.wrapping_add(0x9e37_79b9_7f4a_7c15);
    v = (v ^ (v >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    v = (v ^ (v >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    v ^ (v >> 31)
}

/// Two unit vectors that form a right-handed frame with the unit vector `n`: x × y = n.
///
/// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
pub(crate) fn frame(n: Vec3) -> [Vec3; 2] {
    let sign = 1.0_f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), vec3(b, sign + n.y * n.y * a, -n.y)]
}

/// A direction around the unit vector `n`, chosen in proportion to the cosine between them
/// (Malley's method).
pub(crate) fn cosine_hemisphere(n: Vec3, sample: [f64; 2]) -> Vec3 {
    let [x, y] = disc(sample);
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let [tangent, bitangent] = frame(n);
    tangent * x + bitangent * y + n * z
}

/// A direction inside the cone around the unit vector `axis`, each as likely as any other.
/// A `cos_angle` of 1 gives the axis itself.
pub(crate) fn uniform_cone(axis: Vec3, cos_angle: f64, sample: [f64; 2]) -> Vec3 {
    let z = 1.0 - sample[0] * (1.0 - cos_angle);
    let r = (1.0 - z * z).max(0.0).sqrt();
    let [tangent, bitangent] = frame(axis);
    let (sin, cos) = (TAU * sample[1]).sin_cos();
    tangent * (r * cos) + bitangent * (r * sin) + axis * z
}

/// A point of the unit disc, each as likely as any other.
///
/// Shirley and Chiu, "A Low Distortion Map Between Disk and Square", 1997: neighbours in the
/// square stay neighbours, which keeps the stratification.
pub(crate) fn disc(sample: [f64; 2]) -> [f64; 2] {
    let [a, b] = sample.map(|s| 2.0 * s - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0];
    }
    let (r, angle) = if a.abs() > b.abs() {
        (a, PI / 4.0 * (b / a))
    } else {
        (b, PI / 2.0 - PI / 4.0 * (a / b))
    };
    let r = r.clamp(-ONE_MINUS, ONE_MINUS);
    let (sin, cos) = angle.sin_cos();
    [r * cos, r * sin]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sobol's first two dimensions are a (0, 2)-sequence: every run of 2^k points that starts
    /// at a multiple of 2^k puts one point in each cell of each dyadic grid of 2^k cells.
    #[test]
    fn every_dyadic_cell_gets_one_point() {
        for dimension in 0..4 {
            let mut sampler = Sampler::new(7, 3, 9);
            let points: Vec<[f64; 2]> = (0..64)
                .map(|i| {
                    sampler.sample = i / 4;
                    sampler.square(dimension, i % 4, 4)
                })
                .collect();
            for columns_log2 in 0..=6 {
                let (columns, rows) = (1 << columns_log2, 64 >> columns_log2);
                let mut seen = vec![0; 64];
                for [x, y] in &points {
                    let (cx, cy) = ((x * columns as f64) as usize, (y * rows as f64) as usize);
                    seen[cy * columns + cx] += 1;
                }
                assert!(seen.iter().all(|&n| n == 1), "{columns} x {rows}: {seen:?}");
            }
        }
    }

    #[test]
    fn sobol_s_second_dimension_is_pascal_s_triangle() {
        let by_columns = |mut index: u32| {
            let (mut result, mut column) = (0, 1_u32 << 31);
            while index != 0 {
                result ^= if index & 1 != 0 { column } else { 0 };
                index >>= 1;
                column ^= column >> 1;
            }
            result
        };
        for i in 0..1000 {
            let index = hash(i) as u32 >> (i % 32);
            assert_eq!(sobol_second(index), by_columns(index), "{index}");
        }
    }

    #[test]
    fn pixels_dimensions_and_seeds_differ() {
        let at = |seed, x, y, dimension| Sampler::new(seed, x, y).square(dimension, 0, 1);
        let base = at(0, 1, 2, 0);
        for other in [at(1, 1, 2, 0), at(0, 2, 1, 0), at(0, 2, 2, 0), at(0, 1, 2, 1)] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn the_frame_is_right_handed_and_orthonormal() {
        for n in [
            vec3(0.0, 0.0, 1.0),
            vec3(0.0, 0.0, -1.0),
            vec3(0.6, -0.8, 0.0),
            vec3(-0.3, 0.2, -0.9).normalized(),
        ] {
            let [x, y] = frame(n);
            assert!((x.cross(y) - n).length() < 1e-15);
            assert!(x.dot(y).abs() < 1e-15 && x.dot(n).abs() < 1e-15);
        }
    }

    #[test]
    fn cosine_directions_have_the_mean_cosine_of_two_thirds() {
        let n = vec3(0.48, -0.6, 0.64);
        let sampler = Sampler::new(0, 0, 0);
        let count = 4096;
        let mean = (0..count)
            .map(|i| {
                let d = cosine_hemisphere(n, sampler.square(0, i, count));
                assert!((d.length() - 1.0).abs() < 1e-12 && d.dot(n) >= 0.0);
                d.dot(n)
            })
            .sum::<f64>()
            / f64::from(count);
        assert!((mean - 2.0 / 3.0).abs() < 1e-3, "{mean}");
    }

    #[test]
    fn cone_directions_stay_in_the_cone_and_fill_it() {
        let axis = vec3(0.0, 1.0, 0.0);
        let cos_angle = 0.9;
        let sampler = Sampler::new(0, 0, 0);
        let cosines: Vec<f64> = (0..256)
            .map(|i| uniform_cone(axis, cos_angle, sampler.square(0, i, 256)).dot(axis))
            .collect();
        assert!(cosines.iter().all(|&c| c >= cos_angle - 1e-12));
        let mean = cosines.iter().sum::<f64>() / 256.0;
        assert!((mean - 0.95).abs() < 1e-3, "{mean}");
    }
}
