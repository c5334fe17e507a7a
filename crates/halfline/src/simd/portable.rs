//! No instruction set in particular: loops over lanes, which compilers vectorise.

use super::{EXPONENT_BITS, Job, LANES, POWER_AND_INVERSE, Simd, SimdF64, WORDS};

/// The witness that needs nothing.
#[derive(Clone, Copy)]
pub struct Portable;

/// Two numbers of at most 26 bits that sum to `a` (Veltkamp).
#[inline(always)]
fn halves(a: f64) -> (f64, f64) {
    let scaled = 134_217_729.0 * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}

#[inline(always)]
fn each(value: impl Fn(usize) -> f32) -> [f32; LANES] {
    let mut lanes = [0.0; LANES];
    for lane in 0..LANES {
        lanes[lane] = value(lane);
    }
    lanes
}

impl Simd for Portable {
    type F32x8 = [f32; LANES];

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; LANES] {
        [x; LANES]
    }

    #[inline(always)]
    fn load(self, array: &[f32; LANES]) -> [f32; LANES] {
        *array
    }

    #[inline(always)]
    fn set(self, numbers: [f32; LANES]) -> [f32; LANES] {
        numbers
    }

    /// Not fused: without the instruction that would be a slow call.
    #[inline(always)]
    fn mul_add(self, a: [f32; LANES], b: [f32; LANES], c: [f32; LANES]) -> [f32; LANES] {
        each(|lane| a[lane] * b[lane] + c[lane])
    }

    #[inline(always)]
    fn sub(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|lane| a[lane] - b[lane])
    }

    #[inline(always)]
    fn add(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|lane| a[lane] + b[lane])
    }

    #[inline(always)]
    fn mul(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|lane| a[lane] * b[lane])
    }

    #[inline(always)]
    fn div(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|lane| a[lane] / b[lane])
    }

    #[inline(always)]
    fn store(self, a: [f32; LANES], array: &mut [f32; LANES]) {
        *array = a;
    }

    #[inline(always)]
    fn neg_mul_add(self, a: [f32; LANES], b: [f32; LANES], c: [f32; LANES]) -> [f32; LANES] {
        each(|lane| c[lane] - a[lane] * b[lane])
    }

    #[inline(always)]
    fn abs(self, a: [f32; LANES]) -> [f32; LANES] {
        each(|lane| a[lane].abs())
    }

    #[inline(always)]
    fn sqrt(self, a: [f32; LANES]) -> [f32; LANES] {
        each(|lane| a[lane].sqrt())
    }

    #[inline(always)]
    fn lt(self, a: [f32; LANES], b: [f32; LANES]) -> u32 {
        let mut bits = [0; LANES];
        for lane in 0..LANES {
            bits[lane] = u32::from(a[lane] < b[lane]) << lane;
        }
        bits.into_iter().fold(0, |all, bit| all | bit)
    }

    #[inline(always)]
    fn min(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|lane| if a[lane] < b[lane] { a[lane] } else { b[lane] })
    }

    #[inline(always)]
    fn max(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|lane| if a[lane] > b[lane] { a[lane] } else { b[lane] })
    }

    #[inline(always)]
    fn compress(
        self,
        near: [f32; LANES],
        far: [f32; LANES],
        words: &[u32; LANES],
        lanes: u32,
        nears: &mut [f32; LANES],
        kept: &mut [u32; LANES],
    ) -> usize {
        // Write every lane, and go on only where it is kept: no branch depends on the ray.
        let mut count = 0;
        for step in 0..LANES {
            let lane = (lanes >> (3 * step) & 7) as usize;
            nears[count] = near[lane];
            kept[count] = words[lane];
            count += usize::from(near[lane] <= far[lane]);
        }
        count
    }

    #[inline(always)]
    fn eq_u32(self, words: &[u32; LANES], word: u32) -> u32 {
        (0..LANES).fold(0, |bits, i| bits | u32::from(words[i] == word) << i)
    }

    #[inline(always)]
    fn masked_fill_u32(self, mask: u32, word: u32, words: &mut [u32; LANES]) {
        for lane in 0..LANES {
            words[lane] = if mask >> lane & 1 == 1 { word } else { words[lane] };
        }
    }

    #[inline(always)]
    fn lt_u32(self, words: &[u32; WORDS], limit: u32) -> u32 {
        (0..WORDS).fold(0, |bits, i| bits | u32::from(words[i] < limit) << i)
    }

    #[inline(never)]
    fn outlined<J: Job>(self, job: J) -> J::Output {
        job.run(self)
    }

    type F64 = PortableDoubles;

    #[inline(always)]
    fn doubles(self) -> PortableDoubles {
        PortableDoubles
    }

    #[inline(always)]
    fn narrow(self, a: [f64; LANES]) -> [f32; LANES] {
        each(|lane| a[lane] as f32)
    }

    #[inline(always)]
    fn widen(self, a: [f32; LANES]) -> [f64; LANES] {
        each_double(|lane| f64::from(a[lane]))
    }

    #[inline(always)]
    fn select_lt(
        self,
        a: [f32; LANES],
        b: [f32; LANES],
        x: [f32; LANES],
        y: [f32; LANES],
    ) -> [f32; LANES] {
        each(|lane| if a[lane] < b[lane] { x[lane] } else { y[lane] })
    }

    #[inline(always)]
    fn select(self, mask: u32, x: [f32; LANES], y: [f32; LANES]) -> [f32; LANES] {
        each(|lane| if mask >> lane & 1 == 1 { x[lane] } else { y[lane] })
    }

    #[inline(always)]
    fn transpose(self, rows: [[f32; LANES]; LANES]) -> [[f32; LANES]; LANES] {
        let mut columns = [[0.0; LANES]; LANES];
        for row in 0..LANES {
            for column in 0..LANES {
                columns[column][row] = rows[row][column];
            }
        }
        columns
    }

    #[inline(always)]
    fn prefetch(self, _address: usize, _lines: usize) {}
}

#[inline(always)]
fn each_double(value: impl Fn(usize) -> f64) -> [f64; LANES] {
    let mut lanes = [0.0; LANES];
    for lane in 0..LANES {
        lanes[lane] = value(lane);
    }
    lanes
}

/// The witness for doubles.
#[derive(Clone, Copy)]
pub struct PortableDoubles;

impl SimdF64 for PortableDoubles {
    type F64x8 = [f64; LANES];

    #[inline(always)]
    fn splat(self, x: f64) -> [f64; LANES] {
        [x; LANES]
    }

    #[inline(always)]
    fn set(self, numbers: [f64; LANES]) -> [f64; LANES] {
        numbers
    }

    #[inline(always)]
    fn store(self, a: [f64; LANES], array: &mut [f64; LANES]) {
        *array = a;
    }

    #[inline(always)]
    fn add(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| a[lane] + b[lane])
    }

    #[inline(always)]
    fn sub(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| a[lane] - b[lane])
    }

    #[inline(always)]
    fn mul(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| a[lane] * b[lane])
    }

    #[inline(always)]
    fn mul_add(self, a: [f64; LANES], b: [f64; LANES], c: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| a[lane] * b[lane] + c[lane])
    }

    #[inline(always)]
    fn div(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| a[lane] / b[lane])
    }

    /// After Dekker: halves of 26 bits have exact products.
    #[inline(always)]
    fn product_error(
        self,
        a: [f64; LANES],
        b: [f64; LANES],
        product: [f64; LANES],
    ) -> [f64; LANES] {
        each_double(|lane| {
            let ((a_high, a_low), (b_high, b_low)) = (halves(a[lane]), halves(b[lane]));
            a_low * b_low - (((product[lane] - a_high * b_high) - a_low * b_high) - a_high * b_low)
        })
    }

    #[inline(always)]
    fn sqrt(self, a: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| a[lane].sqrt())
    }

    #[inline(always)]
    fn abs(self, a: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| a[lane].abs())
    }

    #[inline(always)]
    fn power(self, a: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| f64::from_bits(a[lane].to_bits() & EXPONENT_BITS))
    }

    #[inline(always)]
    fn inverse_power(self, a: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| f64::from_bits(POWER_AND_INVERSE.wrapping_sub(a[lane].to_bits())))
    }

    #[inline(always)]
    fn min(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| if a[lane] < b[lane] { a[lane] } else { b[lane] })
    }

    #[inline(always)]
    fn max(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each_double(|lane| if a[lane] > b[lane] { a[lane] } else { b[lane] })
    }

    #[inline(always)]
    fn lt(self, a: [f64; LANES], b: [f64; LANES]) -> u32 {
        let mut bits = [0; LANES];
        for lane in 0..LANES {
            bits[lane] = u32::from(a[lane] < b[lane]) << lane;
        }
        bits.into_iter().fold(0, |all, bit| all | bit)
    }

    #[inline(always)]
    fn le(self, a: [f64; LANES], b: [f64; LANES]) -> u32 {
        let mut bits = [0; LANES];
        for lane in 0..LANES {
            bits[lane] = u32::from(a[lane] <= b[lane]) << lane;
        }
        bits.into_iter().fold(0, |all, bit| all | bit)
    }

    #[inline(always)]
    fn select_lt(
        self,
        a: [f64; LANES],
        b: [f64; LANES],
        x: [f64; LANES],
        y: [f64; LANES],
    ) -> [f64; LANES] {
        each_double(|lane| if a[lane] < b[lane] { x[lane] } else { y[lane] })
    }
}
