//! NEON, which every 64-bit ARM machine has: eight lanes in two registers, eight doubles in four.

#![allow(unsafe_code)]

use std::arch::aarch64::*;

use super::front::FRONT;
use super::{EXPONENT_BITS, Job, LANES, LINE, POWER_AND_INVERSE, Simd, SimdF64, WORDS};

/// The witness, which may be made anywhere: the target has the instructions.
#[derive(Clone, Copy)]
pub struct Neon;

/// How far to the left the bits of an index vector are to be moved so that the number of each lane
/// lies at bit two: four times the number is the number of the lane's first byte.
const STEPS: [i32; LANES] = [2, -1, -4, -7, -10, -13, -16, -19];

/// A bit for each lane.
const BITS: [u32; LANES] = [1, 2, 4, 8, 16, 32, 64, 128];

/// The same in the bytes of a word.
const BITS_OF_BYTES: u64 = 0x8040_2010_0804_0201;

#[inline(always)]
fn load_u32(words: &[u32; LANES]) -> [uint32x4_t; 2] {
    // SAFETY: every machine of this kind has the instructions; the array is as long as the loads.
    unsafe { [vld1q_u32(words.as_ptr()), vld1q_u32(words.as_ptr().add(4))] }
}

#[inline(always)]
fn store_u32(a: [uint32x4_t; 2], words: &mut [u32; LANES]) {
    // SAFETY: every machine of this kind has the instructions; the array is as long as the stores.
    unsafe {
        vst1q_u32(words.as_mut_ptr(), a[0]);
        vst1q_u32(words.as_mut_ptr().add(4), a[1]);
    }
}

/// The lower half of each lane.
#[inline(always)]
fn halves_of(lanes: [uint32x4_t; 2]) -> uint16x8_t {
    // SAFETY: every machine of this kind has the instructions.
    unsafe { vuzp1q_u16(vreinterpretq_u16_u32(lanes[0]), vreinterpretq_u16_u32(lanes[1])) }
}

/// A bit for each lane whose bits are all set; in the others none is.
#[inline(always)]
fn bits_of(lanes: [uint32x4_t; 2]) -> u32 {
    // SAFETY: every machine of this kind has the instructions.
    unsafe {
        let bits = halves_of(load_u32(&BITS));
        u32::from(vaddvq_u16(vandq_u16(halves_of(lanes), bits)))
    }
}

/// The same for eight doubles.
#[inline(always)]
fn bits_of_wide(lanes: [uint64x2_t; 4]) -> u32 {
    // SAFETY: every machine of this kind has the instructions.
    unsafe {
        let word = |a, b| vuzp1q_u32(vreinterpretq_u32_u64(a), vreinterpretq_u32_u64(b));
        bits_of([word(lanes[0], lanes[1]), word(lanes[2], lanes[3])])
    }
}

/// All bits of each lane for which the mask has one.
#[inline(always)]
fn lanes_of(mask: u32) -> [uint32x4_t; 2] {
    // SAFETY: every machine of this kind has the instructions.
    unsafe {
        let (bits, mask) = (load_u32(&BITS), vdupq_n_u32(mask));
        [vtstq_u32(mask, bits[0]), vtstq_u32(mask, bits[1])]
    }
}

/// The bytes of eight lanes, for a table of 32 bytes.
#[inline(always)]
fn bytes_of(lanes: [uint32x4_t; 2]) -> uint8x16x2_t {
    // SAFETY: every machine of this kind has the instructions.
    unsafe { uint8x16x2_t(vreinterpretq_u8_u32(lanes[0]), vreinterpretq_u8_u32(lanes[1])) }
}

/// Transposes four rows to four columns.
#[inline(always)]
fn transpose_4([a, b, c, d]: [float32x4_t; 4]) -> [float32x4_t; 4] {
    // SAFETY: every machine of this kind has the instructions.
    unsafe {
        let (ab, ab2) = (pairs_of(vtrn1q_f32(a, b)), pairs_of(vtrn2q_f32(a, b)));
        let (cd, cd2) = (pairs_of(vtrn1q_f32(c, d)), pairs_of(vtrn2q_f32(c, d)));
        let (first, second) = (vtrn1q_f64(ab, cd), vtrn1q_f64(ab2, cd2));
        let (third, fourth) = (vtrn2q_f64(ab, cd), vtrn2q_f64(ab2, cd2));
        [first, second, third, fourth].map(|row| vreinterpretq_f32_f64(row))
    }
}

#[inline(always)]
fn pairs_of(a: float32x4_t) -> float64x2_t {
    // SAFETY: every machine of this kind has the instructions.
    unsafe { vreinterpretq_f64_f32(a) }
}

impl Simd for Neon {
    type F32x8 = [float32x4_t; 2];

    #[inline(always)]
    fn splat(self, x: f32) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vdupq_n_f32(x); 2] }
    }

    #[inline(always)]
    fn load(self, array: &[f32; LANES]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions; the array is as long as the loads.
        unsafe { [vld1q_f32(array.as_ptr()), vld1q_f32(array.as_ptr().add(4))] }
    }

    #[inline(always)]
    fn set(self, numbers: [f32; LANES]) -> [float32x4_t; 2] {
        self.load(&numbers)
    }

    #[inline(always)]
    fn mul_add(
        self,
        a: [float32x4_t; 2],
        b: [float32x4_t; 2],
        c: [float32x4_t; 2],
    ) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vfmaq_f32(c[0], a[0], b[0]), vfmaq_f32(c[1], a[1], b[1])] }
    }

    #[inline(always)]
    fn sub(self, a: [float32x4_t; 2], b: [float32x4_t; 2]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vsubq_f32(a[0], b[0]), vsubq_f32(a[1], b[1])] }
    }

    #[inline(always)]
    fn add(self, a: [float32x4_t; 2], b: [float32x4_t; 2]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vaddq_f32(a[0], b[0]), vaddq_f32(a[1], b[1])] }
    }

    #[inline(always)]
    fn mul(self, a: [float32x4_t; 2], b: [float32x4_t; 2]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vmulq_f32(a[0], b[0]), vmulq_f32(a[1], b[1])] }
    }

    #[inline(always)]
    fn div(self, a: [float32x4_t; 2], b: [float32x4_t; 2]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vdivq_f32(a[0], b[0]), vdivq_f32(a[1], b[1])] }
    }

    #[inline(always)]
    fn store(self, a: [float32x4_t; 2], array: &mut [f32; LANES]) {
        // SAFETY: every machine of this kind has the instructions; the array is as long as the stores.
        unsafe {
            vst1q_f32(array.as_mut_ptr(), a[0]);
            vst1q_f32(array.as_mut_ptr().add(4), a[1]);
        }
    }

    #[inline(always)]
    fn neg_mul_add(
        self,
        a: [float32x4_t; 2],
        b: [float32x4_t; 2],
        c: [float32x4_t; 2],
    ) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vfmsq_f32(c[0], a[0], b[0]), vfmsq_f32(c[1], a[1], b[1])] }
    }

    #[inline(always)]
    fn abs(self, a: [float32x4_t; 2]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vabsq_f32(a[0]), vabsq_f32(a[1])] }
    }

    #[inline(always)]
    fn sqrt(self, a: [float32x4_t; 2]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vsqrtq_f32(a[0]), vsqrtq_f32(a[1])] }
    }

    #[inline(always)]
    fn lt(self, a: [float32x4_t; 2], b: [float32x4_t; 2]) -> u32 {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { bits_of([vcltq_f32(a[0], b[0]), vcltq_f32(a[1], b[1])]) }
    }

    /// Of NaN and a number it takes the number, whichever comes first: one instruction where the second
    /// in any case would be two.
    #[inline(always)]
    fn min(self, a: [float32x4_t; 2], b: [float32x4_t; 2]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vminnmq_f32(a[0], b[0]), vminnmq_f32(a[1], b[1])] }
    }

    #[inline(always)]
    fn max(self, a: [float32x4_t; 2], b: [float32x4_t; 2]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vmaxnmq_f32(a[0], b[0]), vmaxnmq_f32(a[1], b[1])] }
    }

    #[inline(always)]
    fn compress(
        self,
        near: [float32x4_t; 2],
        far: [float32x4_t; 2],
        words: &[u32; LANES],
        lanes: u32,
        nears: &mut [f32; LANES],
        kept: &mut [u32; LANES],
    ) -> usize {
        // SAFETY: every machine of this kind has the instructions; an entry of the table, and a half
        // of the steps, are as long as their loads.
        unsafe {
            // Unpack the order: of each lane the number of its first byte.
            let steps = [vld1q_s32(STEPS.as_ptr()), vld1q_s32(STEPS.as_ptr().add(4))];
            let lanes = vdupq_n_u32(lanes);
            let order = halves_of([vshlq_u32(lanes, steps[0]), vshlq_u32(lanes, steps[1])]);
            let order = vand_u8(vmovn_u16(order), vdup_n_u8(7 << 2));

            // Which lanes are met, in that order?
            let is_met = bytes_of([vcleq_f32(near[0], far[0]), vcleq_f32(near[1], far[1])]);
            let is_met = vqtbl2_u8(is_met, order);
            let mask = vaddv_u8(vand_u8(is_met, vcreate_u8(BITS_OF_BYTES)));

            // Bring their numbers to the front, make of each those of its four bytes, and move all bytes.
            let front = vld1_u8(FRONT[usize::from(mask)].as_ptr());
            let order = vtbl1_u8(order, front);
            let order = vcombine_u8(order, order);
            let twice = vreinterpretq_u16_u8(vzip1q_u8(order, order));
            let bytes = vreinterpretq_u8_u32(vdupq_n_u32(0x0302_0100));
            let low = vorrq_u8(vreinterpretq_u8_u16(vzip1q_u16(twice, twice)), bytes);
            let high = vorrq_u8(vreinterpretq_u8_u16(vzip2q_u16(twice, twice)), bytes);
            let move_bytes =
                |table: uint8x16x2_t| [vqtbl2q_u8(table, low), vqtbl2q_u8(table, high)];
            let near = bytes_of(near.map(|near| vreinterpretq_u32_f32(near)));
            self.store(move_bytes(near).map(|near| vreinterpretq_f32_u8(near)), nears);
            let words = move_bytes(bytes_of(load_u32(words)));
            store_u32(words.map(|words| vreinterpretq_u32_u8(words)), kept);
            mask.count_ones() as usize
        }
    }

    #[inline(always)]
    fn eq_u32(self, words: &[u32; LANES], word: u32) -> u32 {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let [low, high] = load_u32(words);
            let word = vdupq_n_u32(word);
            bits_of([vceqq_u32(low, word), vceqq_u32(high, word)])
        }
    }

    #[inline(always)]
    fn masked_fill_u32(self, mask: u32, word: u32, words: &mut [u32; LANES]) {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let (lanes, old, word) = (lanes_of(mask), load_u32(words), vdupq_n_u32(word));
            store_u32(
                [vbslq_u32(lanes[0], word, old[0]), vbslq_u32(lanes[1], word, old[1])],
                words,
            );
        }
    }

    #[inline(always)]
    fn lt_u32(self, words: &[u32; WORDS], limit: u32) -> u32 {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            // A byte for each word that is below, 16 in a register.
            let limit = vdupq_n_u32(limit);
            let mut below = [vdupq_n_u8(0); 2];
            for half in 0..2 {
                let mut pairs = [vdupq_n_u16(0); 2];
                for pair in 0..2 {
                    let words = &words[half * WORDS / 2 + pair * LANES..];
                    let Some(words) = words.first_chunk() else { unreachable!("there are 32") };
                    let [low, high] = load_u32(words);
                    pairs[pair] = halves_of([vcltq_u32(low, limit), vcltq_u32(high, limit)]);
                }
                let [low, high] = pairs.map(|pair| vreinterpretq_u8_u16(pair));
                below[half] = vuzp1q_u8(low, high);
            }

            // Leave a bit of each, and add up neighbours until a byte has eight.
            let bits = vreinterpretq_u8_u64(vdupq_n_u64(BITS_OF_BYTES));
            let bits = vpaddq_u8(vandq_u8(below[0], bits), vandq_u8(below[1], bits));
            let bits = vpaddq_u8(bits, bits);
            let bits = vpaddq_u8(bits, bits);
            vgetq_lane_u32::<0>(vreinterpretq_u32_u8(bits))
        }
    }

    #[inline(never)]
    fn outlined<J: Job>(self, job: J) -> J::Output {
        job.run(self)
    }

    type F64 = NeonDoubles;

    #[inline(always)]
    fn doubles(self) -> NeonDoubles {
        NeonDoubles
    }

    #[inline(always)]
    fn narrow(self, a: [float64x2_t; 4]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let four = |low, high| vcvt_high_f32_f64(vcvt_f32_f64(low), high);
            [four(a[0], a[1]), four(a[2], a[3])]
        }
    }

    #[inline(always)]
    fn widen(self, a: [float32x4_t; 2]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let low = |a| vcvt_f64_f32(vget_low_f32(a));
            [low(a[0]), vcvt_high_f64_f32(a[0]), low(a[1]), vcvt_high_f64_f32(a[1])]
        }
    }

    #[inline(always)]
    fn select_lt(
        self,
        a: [float32x4_t; 2],
        b: [float32x4_t; 2],
        x: [float32x4_t; 2],
        y: [float32x4_t; 2],
    ) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let low = vbslq_f32(vcltq_f32(a[0], b[0]), x[0], y[0]);
            [low, vbslq_f32(vcltq_f32(a[1], b[1]), x[1], y[1])]
        }
    }

    #[inline(always)]
    fn select(self, mask: u32, x: [float32x4_t; 2], y: [float32x4_t; 2]) -> [float32x4_t; 2] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let lanes = lanes_of(mask);
            [vbslq_f32(lanes[0], x[0], y[0]), vbslq_f32(lanes[1], x[1], y[1])]
        }
    }

    #[inline(always)]
    fn transpose(
        self,
        [a, b, c, d, e, f, g, h]: [[float32x4_t; 2]; LANES],
    ) -> [[float32x4_t; 2]; LANES] {
        // The quarters, each by itself.
        let low = [transpose_4([a[0], b[0], c[0], d[0]]), transpose_4([e[0], f[0], g[0], h[0]])];
        let high = [transpose_4([a[1], b[1], c[1], d[1]]), transpose_4([e[1], f[1], g[1], h[1]])];
        let row = |[left, right]: [[float32x4_t; 4]; 2], row: usize| [left[row], right[row]];
        [
            row(low, 0),
            row(low, 1),
            row(low, 2),
            row(low, 3),
            row(high, 0),
            row(high, 1),
            row(high, 2),
            row(high, 3),
        ]
    }

    #[inline(always)]
    fn prefetch(self, address: usize, lines: usize) {
        for line in 0..lines {
            let place = address.wrapping_add(line * LINE);
            // SAFETY: a prefetch reads nothing, and may name any address.
            unsafe {
                std::arch::asm!(
                    "prfm pldl1keep, [{place}]",
                    place = in(reg) place,
                    options(nomem, nostack, preserves_flags),
                );
            }
        }
    }
}

/// The witness for doubles.
#[derive(Clone, Copy)]
pub struct NeonDoubles;

/// What a function makes of each of four pairs.
#[inline(always)]
fn each<T: Copy, U: Copy, R>(a: [T; 4], b: [U; 4], of_pair: impl Fn(T, U) -> R) -> [R; 4] {
    [of_pair(a[0], b[0]), of_pair(a[1], b[1]), of_pair(a[2], b[2]), of_pair(a[3], b[3])]
}

impl SimdF64 for NeonDoubles {
    type F64x8 = [float64x2_t; 4];

    #[inline(always)]
    fn splat(self, x: f64) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { [vdupq_n_f64(x); 4] }
    }

    #[inline(always)]
    fn set(self, numbers: [f64; LANES]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions; the array is as long as the loads.
        unsafe {
            let first = numbers.as_ptr();
            [
                vld1q_f64(first),
                vld1q_f64(first.add(2)),
                vld1q_f64(first.add(4)),
                vld1q_f64(first.add(6)),
            ]
        }
    }

    #[inline(always)]
    fn store(self, a: [float64x2_t; 4], array: &mut [f64; LANES]) {
        // SAFETY: every machine of this kind has the instructions; the array is as long as the stores.
        unsafe {
            let first = array.as_mut_ptr();
            vst1q_f64(first, a[0]);
            vst1q_f64(first.add(2), a[1]);
            vst1q_f64(first.add(4), a[2]);
            vst1q_f64(first.add(6), a[3]);
        }
    }

    #[inline(always)]
    fn add(self, a: [float64x2_t; 4], b: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { each(a, b, |a, b| vaddq_f64(a, b)) }
    }

    #[inline(always)]
    fn sub(self, a: [float64x2_t; 4], b: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { each(a, b, |a, b| vsubq_f64(a, b)) }
    }

    #[inline(always)]
    fn mul(self, a: [float64x2_t; 4], b: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { each(a, b, |a, b| vmulq_f64(a, b)) }
    }

    #[inline(always)]
    fn mul_add(
        self,
        a: [float64x2_t; 4],
        b: [float64x2_t; 4],
        c: [float64x2_t; 4],
    ) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let low = [vfmaq_f64(c[0], a[0], b[0]), vfmaq_f64(c[1], a[1], b[1])];
            [low[0], low[1], vfmaq_f64(c[2], a[2], b[2]), vfmaq_f64(c[3], a[3], b[3])]
        }
    }

    #[inline(always)]
    fn div(self, a: [float64x2_t; 4], b: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { each(a, b, |a, b| vdivq_f64(a, b)) }
    }

    #[inline(always)]
    fn product_error(
        self,
        a: [float64x2_t; 4],
        b: [float64x2_t; 4],
        product: [float64x2_t; 4],
    ) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        let error = |i: usize| unsafe { vfmaq_f64(vnegq_f64(product[i]), a[i], b[i]) };
        [error(0), error(1), error(2), error(3)]
    }

    #[inline(always)]
    fn sqrt(self, a: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { a.map(|a| vsqrtq_f64(a)) }
    }

    #[inline(always)]
    fn abs(self, a: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { a.map(|a| vabsq_f64(a)) }
    }

    #[inline(always)]
    fn power(self, a: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let bits = vdupq_n_u64(EXPONENT_BITS);
            a.map(|a| vreinterpretq_f64_u64(vandq_u64(vreinterpretq_u64_f64(a), bits)))
        }
    }

    #[inline(always)]
    fn inverse_power(self, a: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let sum = vdupq_n_u64(POWER_AND_INVERSE);
            a.map(|a| vreinterpretq_f64_u64(vsubq_u64(sum, vreinterpretq_u64_f64(a))))
        }
    }

    /// Compares, since the instructions for it have other rules for NaN.
    #[inline(always)]
    fn min(self, a: [float64x2_t; 4], b: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { each(a, b, |a, b| vbslq_f64(vcltq_f64(a, b), a, b)) }
    }

    #[inline(always)]
    fn max(self, a: [float64x2_t; 4], b: [float64x2_t; 4]) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { each(a, b, |a, b| vbslq_f64(vcgtq_f64(a, b), a, b)) }
    }

    #[inline(always)]
    fn lt(self, a: [float64x2_t; 4], b: [float64x2_t; 4]) -> u32 {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { bits_of_wide(each(a, b, |a, b| vcltq_f64(a, b))) }
    }

    #[inline(always)]
    fn le(self, a: [float64x2_t; 4], b: [float64x2_t; 4]) -> u32 {
        // SAFETY: every machine of this kind has the instructions.
        unsafe { bits_of_wide(each(a, b, |a, b| vcleq_f64(a, b))) }
    }

    #[inline(always)]
    fn select_lt(
        self,
        a: [float64x2_t; 4],
        b: [float64x2_t; 4],
        x: [float64x2_t; 4],
        y: [float64x2_t; 4],
    ) -> [float64x2_t; 4] {
        // SAFETY: every machine of this kind has the instructions.
        unsafe {
            let is_below = each(a, b, |a, b| vcltq_f64(a, b));
            let low = [vbslq_f64(is_below[0], x[0], y[0]), vbslq_f64(is_below[1], x[1], y[1])];
            [low[0], low[1], vbslq_f64(is_below[2], x[2], y[2]), vbslq_f64(is_below[3], x[3], y[3])]
        }
    }
}
