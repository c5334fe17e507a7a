//! AVX-512 on registers of 256 bits: the masks and the compression are what it adds. Nodes and leaves
//! are eight wide, and registers of 512 bits cost twice as much on many machines that have them.

#![allow(unsafe_code)]

use std::arch::x86_64::*;

use super::avx2::Avx2;
use super::{EXPONENT_BITS, Job, LANES, POWER_AND_INVERSE, Simd, SimdF64, WORDS};

/// The witness: exists only inside of [`run`].
#[derive(Clone, Copy)]
pub struct Avx512(Avx2);

/// Runs a job compiled for AVX-512.
///
/// # Safety
/// The machine has the instructions.
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
pub unsafe fn run<J: Job>(job: J) -> J::Output {
    // SAFETY: every machine with these instructions has those of AVX2.
    job.run(Avx512(unsafe { Avx2::witness() }))
}

/// Runs a job compiled for AVX-512, in a function that is never inlined.
///
/// # Safety
/// The machine has the instructions.
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
#[inline(never)]
unsafe fn run_outlined<J: Job>(job: J) -> J::Output {
    // SAFETY: every machine with these instructions has those of AVX2.
    job.run(Avx512(unsafe { Avx2::witness() }))
}

impl Simd for Avx512 {
    type F32x8 = __m256;

    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        self.0.splat(x)
    }

    #[inline(always)]
    fn load(self, array: &[f32; LANES]) -> __m256 {
        self.0.load(array)
    }

    #[inline(always)]
    fn set(self, numbers: [f32; LANES]) -> __m256 {
        self.0.set(numbers)
    }

    #[inline(always)]
    fn mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        self.0.mul_add(a, b, c)
    }

    #[inline(always)]
    fn sub(self, a: __m256, b: __m256) -> __m256 {
        self.0.sub(a, b)
    }

    #[inline(always)]
    fn add(self, a: __m256, b: __m256) -> __m256 {
        self.0.add(a, b)
    }

    #[inline(always)]
    fn mul(self, a: __m256, b: __m256) -> __m256 {
        self.0.mul(a, b)
    }

    #[inline(always)]
    fn div(self, a: __m256, b: __m256) -> __m256 {
        self.0.div(a, b)
    }

    #[inline(always)]
    fn store(self, a: __m256, array: &mut [f32; LANES]) {
        self.0.store(a, array);
    }

    #[inline(always)]
    fn neg_mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        self.0.neg_mul_add(a, b, c)
    }

    #[inline(always)]
    fn abs(self, a: __m256) -> __m256 {
        self.0.abs(a)
    }

    #[inline(always)]
    fn sqrt(self, a: __m256) -> __m256 {
        self.0.sqrt(a)
    }

    #[inline(always)]
    fn lt(self, a: __m256, b: __m256) -> u32 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b) as u32 }
    }

    #[inline(always)]
    fn min(self, a: __m256, b: __m256) -> __m256 {
        self.0.min(a, b)
    }

    #[inline(always)]
    fn max(self, a: __m256, b: __m256) -> __m256 {
        self.0.max(a, b)
    }

    #[inline(always)]
    fn compress(
        self,
        near: __m256,
        far: __m256,
        words: &[u32; LANES],
        lanes: u32,
        nears: &mut [f32; LANES],
        kept: &mut [u32; LANES],
    ) -> usize {
        // SAFETY: the witness stands for the instructions; the arrays are as long as loads and
        // stores.
        unsafe {
            // Bring the lanes into their order, then those that are met to the front. (Compression
            // into memory is microcode on some machines; into a register it is not.)
            let steps = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            let order = _mm256_srlv_epi32(_mm256_set1_epi32(lanes as i32), steps);
            let near = _mm256_permutexvar_ps(order, near);
            let far = _mm256_permutexvar_ps(order, far);
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            let words = _mm256_permutexvar_epi32(order, words);
            let mask = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(near, far);
            _mm256_storeu_ps(nears.as_mut_ptr(), _mm256_maskz_compress_ps(mask, near));
            let words = _mm256_maskz_compress_epi32(mask, words);
            _mm256_storeu_si256(kept.as_mut_ptr().cast(), words);
            mask.count_ones() as usize
        }
    }

    #[inline(always)]
    fn eq_u32(self, words: &[u32; LANES], word: u32) -> u32 {
        // SAFETY: the witness stands for the instructions; the array is as long as the load.
        unsafe {
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            u32::from(_mm256_cmpeq_epu32_mask(words, _mm256_set1_epi32(word as i32)))
        }
    }

    #[inline(always)]
    fn masked_fill_u32(self, mask: u32, word: u32, words: &mut [u32; LANES]) {
        // SAFETY: the witness stands for the instructions; the array is as long as load and store.
        unsafe {
            let place = words.as_mut_ptr().cast();
            let old = _mm256_loadu_si256(place);
            let new = _mm256_mask_set1_epi32(old, mask as u8, word as i32);
            _mm256_storeu_si256(place, new);
        }
    }

    #[inline(always)]
    fn lt_u32(self, words: &[u32; WORDS], limit: u32) -> u32 {
        let mut bits = 0;
        for (part, words) in words.chunks_exact(2 * LANES).enumerate() {
            // SAFETY: the witness stands for the instructions; a chunk is as long as the load.
            unsafe {
                let words = _mm512_loadu_si512(words.as_ptr().cast());
                let below = _mm512_cmplt_epu32_mask(words, _mm512_set1_epi32(limit as i32));
                bits |= u32::from(below) << (part * 2 * LANES);
            }
        }
        bits
    }

    #[inline(always)]
    fn outlined<J: Job>(self, job: J) -> J::Output {
        // SAFETY: the witness stands for the instructions.
        unsafe { run_outlined(job) }
    }

    type F64 = Avx512Doubles;

    #[inline(always)]
    fn doubles(self) -> Avx512Doubles {
        Avx512Doubles(())
    }

    #[inline(always)]
    fn narrow(self, a: __m512d) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_cvtpd_ps(a) }
    }

    #[inline(always)]
    fn widen(self, a: __m256) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_cvtps_pd(a) }
    }

    #[inline(always)]
    fn select_lt(self, a: __m256, b: __m256, x: __m256, y: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_mask_blend_ps(_mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b), y, x) }
    }

    #[inline(always)]
    fn select(self, mask: u32, x: __m256, y: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_mask_blend_ps(mask as u8, y, x) }
    }

    #[inline(always)]
    fn transpose(self, rows: [__m256; LANES]) -> [__m256; LANES] {
        self.0.transpose(rows)
    }

    #[inline(always)]
    fn prefetch(self, address: usize, lines: usize) {
        self.0.prefetch(address, lines);
    }
}

/// The witness for doubles.
#[derive(Clone, Copy)]
pub struct Avx512Doubles(());

impl SimdF64 for Avx512Doubles {
    type F64x8 = __m512d;

    #[inline(always)]
    fn splat(self, x: f64) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_set1_pd(x) }
    }

    #[inline(always)]
    fn set(self, [a, b, c, d, e, f, g, h]: [f64; LANES]) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_setr_pd(a, b, c, d, e, f, g, h) }
    }

    #[inline(always)]
    fn store(self, a: __m512d, array: &mut [f64; LANES]) {
        // SAFETY: as above; the array is as long as the store.
        unsafe { _mm512_storeu_pd(array.as_mut_ptr(), a) }
    }

    #[inline(always)]
    fn add(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_add_pd(a, b) }
    }

    #[inline(always)]
    fn sub(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_sub_pd(a, b) }
    }

    #[inline(always)]
    fn mul(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_mul_pd(a, b) }
    }

    #[inline(always)]
    fn mul_add(self, a: __m512d, b: __m512d, c: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_fmadd_pd(a, b, c) }
    }

    #[inline(always)]
    fn div(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_div_pd(a, b) }
    }

    #[inline(always)]
    fn product_error(self, a: __m512d, b: __m512d, product: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_fmsub_pd(a, b, product) }
    }

    #[inline(always)]
    fn sqrt(self, a: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_sqrt_pd(a) }
    }

    #[inline(always)]
    fn abs(self, a: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_abs_pd(a) }
    }

    #[inline(always)]
    fn power(self, a: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_and_pd(a, _mm512_set1_pd(f64::from_bits(EXPONENT_BITS))) }
    }

    #[inline(always)]
    fn inverse_power(self, a: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            let sum = _mm512_set1_epi64(POWER_AND_INVERSE as i64);
            _mm512_castsi512_pd(_mm512_sub_epi64(sum, _mm512_castpd_si512(a)))
        }
    }

    #[inline(always)]
    fn min(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_min_pd(a, b) }
    }

    #[inline(always)]
    fn max(self, a: __m512d, b: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_max_pd(a, b) }
    }

    #[inline(always)]
    fn lt(self, a: __m512d, b: __m512d) -> u32 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b) as u32 }
    }

    #[inline(always)]
    fn le(self, a: __m512d, b: __m512d) -> u32 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b) as u32 }
    }

    #[inline(always)]
    fn select_lt(self, a: __m512d, b: __m512d, x: __m512d, y: __m512d) -> __m512d {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b), y, x) }
    }
}
