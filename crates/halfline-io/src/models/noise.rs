//! Gradient noise (Perlin, "Improving Noise", SIGGRAPH 2002), with a hash in place of the
//! permutation table, so that it does not repeat; and its analytic derivative in the plane.

use halfline::geometry::{Vec3, vec3};

use halfline::geometry::random::mix;

/// A smooth random function of space, about -1 to 1, zero on average; features are about one unit
/// in size.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    seed: u32,
}

impl Noise {
    /// The noise function number `index` of those that belong to `seed`.
    pub fn new(seed: u64, index: u64) -> Noise {
        Noise { seed: (mix(seed ^ mix(index.wrapping_add(1))) >> 32) as u32 }
    }

    /// The hash of a lattice point (the finaliser of MurmurHash3).
    fn hash(self, x: i64, y: i64, z: i64) -> u32 {
        let mut h = self.seed
            ^ (x as u32).wrapping_mul(0x8da6_b343)
            ^ (y as u32).wrapping_mul(0xd816_3841)
            ^ (z as u32).wrapping_mul(0xcb1a_b31f);
        h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
        h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
        h ^ (h >> 16)
    }

    /// The value at a point of space.
    pub fn at(self, p: Vec3) -> f64 {
        let cell = [p.x.floor(), p.y.floor(), p.z.floor()];
        let f = p - vec3(cell[0], cell[1], cell[2]);
        let [x, y, z] = cell.map(|c| c as i64);
        // The dot product with one of the twelve directions from a cube's centre to its edges.
        let corner = |i: i64, j: i64, k: i64| {
            let (dx, dy, dz) = (f.x - i as f64, f.y - j as f64, f.z - k as f64);
            let h = self.hash(x + i, y + j, z + k) & 15;
            let a = if h < 8 { dx } else { dy };
            let b = match h {
                0..=3 => dy,
                12 | 14 => dx,
                _ => dz,
            };
            (if h & 1 == 0 { a } else { -a }) + (if h & 2 == 0 { b } else { -b })
        };
        let (u, v, w) = (fade(f.x), fade(f.y), fade(f.z));
        mix_linear(
            mix_linear(
                mix_linear(corner(0, 0, 0), corner(1, 0, 0), u),
                mix_linear(corner(0, 1, 0), corner(1, 1, 0), u),
                v,
            ),
            mix_linear(
                mix_linear(corner(0, 0, 1), corner(1, 0, 1), u),
                mix_linear(corner(0, 1, 1), corner(1, 1, 1), u),
                v,
            ),
            w,
        )
    }

    /// Three independent values.
    pub fn vector(self, p: Vec3) -> Vec3 {
        vec3(
            self.at(p),
            self.at(vec3(p.y + 31.7, p.z - 12.3, p.x + 7.9)),
            self.at(vec3(p.z - 47.1, p.x + 23.9, p.y - 5.3)),
        )
    }

    /// The sum of `octaves` noises, each twice as fine and half as strong as the one before.
    pub fn fractal(self, p: Vec3, octaves: u32) -> f64 {
        let (mut sum, mut weight, mut q) = (0.0, 1.0, p);
        for _ in 0..octaves {
            sum += weight * self.at(q);
            weight *= 0.5;
            q = q * 2.0 + vec3(17.3, 9.1, -5.7);
        }
        sum
    }

    /// The value and the gradient of noise over the plane.
    pub fn planar(self, x: f64, y: f64) -> (f64, [f64; 2]) {
        let (cx, cy) = (x.floor(), y.floor());
        let (fx, fy) = (x - cx, y - cy);
        let (ix, iy) = (cx as i64, cy as i64);
        let gradient = |i: i64, j: i64| GRADIENTS[(self.hash(ix + i, iy + j, 0) & 15) as usize];
        let (g00, g10, g01, g11) = (gradient(0, 0), gradient(1, 0), gradient(0, 1), gradient(1, 1));
        let n00 = g00[0] * fx + g00[1] * fy;
        let n10 = g10[0] * (fx - 1.0) + g10[1] * fy;
        let n01 = g01[0] * fx + g01[1] * (fy - 1.0);
        let n11 = g11[0] * (fx - 1.0) + g11[1] * (fy - 1.0);
        let (u, v) = (fade(fx), fade(fy));
        let (du, dv) = (fade_slope(fx), fade_slope(fy));
        let twist = n00 - n10 - n01 + n11;
        let value = n00 + u * (n10 - n00) + v * (n01 - n00) + u * v * twist;
        let slope = |axis: usize| {
            g00[axis]
                + u * (g10[axis] - g00[axis])
                + v * (g01[axis] - g00[axis])
                + u * v * (g00[axis] - g10[axis] - g01[axis] + g11[axis])
        };
        (value, [slope(0) + du * (n10 - n00 + v * twist), slope(1) + dv * (n01 - n00 + u * twist)])
    }

    /// A random point of the unit square for the cell of the plane with lower corner (x, y).
    pub fn cell_point(self, x: i64, y: i64) -> [f64; 2] {
        let h = self.hash(x, y, 1);
        [f64::from(h & 0xffff) / 65536.0, f64::from(h >> 16) / 65536.0]
    }
}

/// Sixteen directions, evenly spread.
const GRADIENTS: [[f64; 2]; 16] = {
    const A: f64 = 0.923_879_532_511_286_7;
    const B: f64 = 0.382_683_432_365_089_8;
    const C: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [
        [1.0, 0.0],
        [A, B],
        [C, C],
        [B, A],
        [0.0, 1.0],
        [-B, A],
        [-C, C],
        [-A, B],
        [-1.0, 0.0],
        [-A, -B],
        [-C, -C],
        [-B, -A],
        [0.0, -1.0],
        [B, -A],
        [C, -C],
        [A, -B],
    ]
};

fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn fade_slope(t: f64) -> f64 {
    30.0 * t * t * (t * (t - 2.0) + 1.0)
}

/// The point at `t` between `a` (0) and `b` (1).
pub fn mix_linear(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

/// 0 below `low`, 1 above `high`, smooth between them. With `low > high` it falls.
pub fn smooth_step(low: f64, high: f64, value: f64) -> f64 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
