//! AVX2 with fused multiply-add: eight lanes in one register.

#![allow(unsafe_code)]

use std::arch::x86_64::*;

use super::front::FRONT;
use super::{EXPONENT_BITS, Job, LANES, LINE, POWER_AND_INVERSE, Simd, SimdF64, WORDS};

/// The witness: exists only inside of [`run`] and of what has more instructions.
#[derive(Clone, Copy)]
pub struct Avx2(());

impl Avx2 {
    /// The witness.
    ///
    /// # Safety
    /// The caller is compiled for AVX2 and runs only where the machine has it.
    #[inline(always)]
    pub unsafe fn witness() -> Avx2 {
        Avx2(())
    }
}

/// Runs a job compiled for AVX2.
///
/// # Safety
/// The machine has the instructions.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
pub unsafe fn run<J: Job>(job: J) -> J::Output {
    job.run(Avx2(()))
}

/// Runs a job compiled for AVX2 in a function of its own, which is never inlined.
///
/// # Safety
/// The machine has the instructions.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
#[inline(never)]
unsafe fn run_outlined<J: Job>(job: J) -> J::Output {
    job.run(Avx2(()))
}

impl Simd for Avx2 {
    type F32x8 = __m256;

    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_set1_ps(x) }
    }

    #[inline(always)]
    fn load(self, array: &[f32; LANES]) -> __m256 {
        // SAFETY: as above; the array is as long as the load.
        unsafe { _mm256_loadu_ps(array.as_ptr()) }
    }

    #[inline(always)]
    fn set(self, [a, b, c, d, e, f, g, h]: [f32; LANES]) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_setr_ps(a, b, c, d, e, f, g, h) }
    }

    #[inline(always)]
    fn mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_fmadd_ps(a, b, c) }
    }

    #[inline(always)]
    fn sub(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_sub_ps(a, b) }
    }

    #[inline(always)]
    fn add(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_add_ps(a, b) }
    }

    #[inline(always)]
    fn mul(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_mul_ps(a, b) }
    }

    #[inline(always)]
    fn div(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_div_ps(a, b) }
    }

    #[inline(always)]
    fn store(self, a: __m256, array: &mut [f32; LANES]) {
        // SAFETY: as above; the array is as long as the store.
        unsafe { _mm256_storeu_ps(array.as_mut_ptr(), a) }
    }

    #[inline(always)]
    fn neg_mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_fnmadd_ps(a, b, c) }
    }

    #[inline(always)]
    fn abs(self, a: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), a) }
    }

    #[inline(always)]
    fn sqrt(self, a: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_sqrt_ps(a) }
    }

    #[inline(always)]
    fn lt(self, a: __m256, b: __m256) -> u32 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32 }
    }

    #[inline(always)]
    fn min(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_min_ps(a, b) }
    }

    #[inline(always)]
    fn max(self, a: __m256, b: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_max_ps(a, b) }
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
        // stores; the table has an entry for each mask of eight bits.
        unsafe {
            // Bring the lanes into their order, then those that are met to the front.
            let steps = _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21);
            let order = _mm256_srlv_epi32(_mm256_set1_epi32(lanes as i32), steps);
            let near = _mm256_permutevar8x32_ps(near, order);
            let far = _mm256_permutevar8x32_ps(far, order);
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            let words = _mm256_permutevar8x32_epi32(words, order);
            let mask = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as usize;
            let front = _mm_loadl_epi64(FRONT.as_ptr().add(mask & 0xff).cast());
            let front = _mm256_cvtepu8_epi32(front);
            let near = _mm256_permutevar8x32_ps(near, front);
            let words = _mm256_permutevar8x32_epi32(words, front);
            _mm256_storeu_ps(nears.as_mut_ptr(), near);
            _mm256_storeu_si256(kept.as_mut_ptr().cast(), words);
            mask.count_ones() as usize
        }
    }

    #[inline(always)]
    fn eq_u32(self, words: &[u32; LANES], word: u32) -> u32 {
        // SAFETY: the witness stands for the instructions; the array is as long as the load.
        unsafe {
            let words = _mm256_loadu_si256(words.as_ptr().cast());
            let equal = _mm256_cmpeq_epi32(words, _mm256_set1_epi32(word as i32));
            _mm256_movemask_ps(_mm256_castsi256_ps(equal)) as u32
        }
    }

    #[inline(always)]
    fn masked_fill_u32(self, mask: u32, word: u32, words: &mut [u32; LANES]) {
        // SAFETY: the witness stands for the instructions; the array is as long as load and store.
        unsafe {
            let place = words.as_mut_ptr().cast();
            let old = _mm256_loadu_si256(place);
            let new = _mm256_blendv_epi8(old, _mm256_set1_epi32(word as i32), lanes_of(mask));
            _mm256_storeu_si256(place, new);
        }
    }

    #[inline(always)]
    fn lt_u32(self, words: &[u32; WORDS], limit: u32) -> u32 {
        // Comparisons are of signed numbers only: move both by half of the range.
        let half = i32::MIN;
        let mut bits = 0;
        for (part, words) in words.chunks_exact(LANES).enumerate() {
            // SAFETY: the witness stands for the instructions; a chunk is as long as the load.
            unsafe {
                let words = _mm256_loadu_si256(words.as_ptr().cast());
                let words = _mm256_xor_si256(words, _mm256_set1_epi32(half));
                let limit = _mm256_set1_epi32(limit as i32 ^ half);
                let below = _mm256_castsi256_ps(_mm256_cmpgt_epi32(limit, words));
                bits |= (_mm256_movemask_ps(below) as u32) << (part * LANES);
            }
        }
        bits
    }

    #[inline(always)]
    fn outlined<J: Job>(self, job: J) -> J::Output {
        // SAFETY: the witness stands for the instructions.
        unsafe { run_outlined(job) }
    }

    type F64 = Avx2Doubles;

    #[inline(always)]
    fn doubles(self) -> Avx2Doubles {
        Avx2Doubles(())
    }

    #[inline(always)]
    fn narrow(self, [a, b]: [__m256d; 2]) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_set_m128(_mm256_cvtpd_ps(b), _mm256_cvtpd_ps(a)) }
    }

    #[inline(always)]
    fn widen(self, a: __m256) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            let (low, high) = (_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
            [_mm256_cvtps_pd(low), _mm256_cvtps_pd(high)]
        }
    }

    #[inline(always)]
    fn select_lt(self, a: __m256, b: __m256, x: __m256, y: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_blendv_ps(y, x, _mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) }
    }

    #[inline(always)]
    fn select(self, mask: u32, x: __m256, y: __m256) -> __m256 {
        // SAFETY: the witness stands for the instructions.
        unsafe { _mm256_blendv_ps(y, x, _mm256_castsi256_ps(lanes_of(mask))) }
    }

    #[inline(always)]
    fn transpose(self, [a, b, c, d, e, f, g, h]: [__m256; LANES]) -> [__m256; LANES] {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            // Pairs of rows, quadruples, all eight.
            let (ab, ab2) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
            let (cd, cd2) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
            let (ef, ef2) = (_mm256_unpacklo_ps(e, f), _mm256_unpackhi_ps(e, f));
            let (gh, gh2) = (_mm256_unpacklo_ps(g, h), _mm256_unpackhi_ps(g, h));
            let a0 = _mm256_shuffle_ps::<0x44>(ab, cd);
            let a1 = _mm256_shuffle_ps::<0xee>(ab, cd);
            let a2 = _mm256_shuffle_ps::<0x44>(ab2, cd2);
            let a3 = _mm256_shuffle_ps::<0xee>(ab2, cd2);
            let e0 = _mm256_shuffle_ps::<0x44>(ef, gh);
            let e1 = _mm256_shuffle_ps::<0xee>(ef, gh);
            let e2 = _mm256_shuffle_ps::<0x44>(ef2, gh2);
            let e3 = _mm256_shuffle_ps::<0xee>(ef2, gh2);
            [
                _mm256_permute2f128_ps::<0x20>(a0, e0),
                _mm256_permute2f128_ps::<0x20>(a1, e1),
                _mm256_permute2f128_ps::<0x20>(a2, e2),
                _mm256_permute2f128_ps::<0x20>(a3, e3),
                _mm256_permute2f128_ps::<0x31>(a0, e0),
                _mm256_permute2f128_ps::<0x31>(a1, e1),
                _mm256_permute2f128_ps::<0x31>(a2, e2),
                _mm256_permute2f128_ps::<0x31>(a3, e3),
            ]
        }
    }

    #[inline(always)]
    fn prefetch(self, address: usize, lines: usize) {
        for line in 0..lines {
            let place = std::ptr::without_provenance::<i8>(address.wrapping_add(line * LINE));
            // SAFETY: a prefetch reads nothing, and may name any address.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(place) }
        }
    }
}

/// All bits of each lane for which the mask has one.
///
/// # Safety
/// The machine has the instructions.
#[inline(always)]
unsafe fn lanes_of(mask: u32) -> __m256i {
    // SAFETY: the caller's promise.
    unsafe {
        let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        let lanes = _mm256_and_si256(_mm256_set1_epi32(mask as i32), bits);
        _mm256_cmpeq_epi32(lanes, bits)
    }
}

/// The witness for doubles.
#[derive(Clone, Copy)]
pub struct Avx2Doubles(());

impl SimdF64 for Avx2Doubles {
    type F64x8 = [__m256d; 2];

    #[inline(always)]
    fn splat(self, x: f64) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_set1_pd(x); 2] }
    }

    #[inline(always)]
    fn set(self, [a, b, c, d, e, f, g, h]: [f64; LANES]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_setr_pd(a, b, c, d), _mm256_setr_pd(e, f, g, h)] }
    }

    #[inline(always)]
    fn store(self, a: [__m256d; 2], array: &mut [f64; LANES]) {
        // SAFETY: as above; the array is as long as both stores.
        unsafe {
            _mm256_storeu_pd(array.as_mut_ptr(), a[0]);
            _mm256_storeu_pd(array.as_mut_ptr().add(4), a[1]);
        }
    }

    #[inline(always)]
    fn add(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_add_pd(a[0], b[0]), _mm256_add_pd(a[1], b[1])] }
    }

    #[inline(always)]
    fn sub(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_sub_pd(a[0], b[0]), _mm256_sub_pd(a[1], b[1])] }
    }

    #[inline(always)]
    fn mul(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_mul_pd(a[0], b[0]), _mm256_mul_pd(a[1], b[1])] }
    }

    #[inline(always)]
    fn mul_add(self, a: [__m256d; 2], b: [__m256d; 2], c: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_fmadd_pd(a[0], b[0], c[0]), _mm256_fmadd_pd(a[1], b[1], c[1])] }
    }

    #[inline(always)]
    fn div(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_div_pd(a[0], b[0]), _mm256_div_pd(a[1], b[1])] }
    }

    #[inline(always)]
    fn product_error(
        self,
        a: [__m256d; 2],
        b: [__m256d; 2],
        product: [__m256d; 2],
    ) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            [_mm256_fmsub_pd(a[0], b[0], product[0]), _mm256_fmsub_pd(a[1], b[1], product[1])]
        }
    }

    #[inline(always)]
    fn sqrt(self, a: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_sqrt_pd(a[0]), _mm256_sqrt_pd(a[1])] }
    }

    #[inline(always)]
    fn abs(self, a: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            [_mm256_andnot_pd(sign, a[0]), _mm256_andnot_pd(sign, a[1])]
        }
    }

    #[inline(always)]
    fn power(self, a: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            let bits = _mm256_set1_pd(f64::from_bits(EXPONENT_BITS));
            [_mm256_and_pd(bits, a[0]), _mm256_and_pd(bits, a[1])]
        }
    }

    #[inline(always)]
    fn inverse_power(self, a: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            let sum = _mm256_set1_epi64x(POWER_AND_INVERSE as i64);
            let low = _mm256_sub_epi64(sum, _mm256_castpd_si256(a[0]));
            let high = _mm256_sub_epi64(sum, _mm256_castpd_si256(a[1]));
            [_mm256_castsi256_pd(low), _mm256_castsi256_pd(high)]
        }
    }

    #[inline(always)]
    fn min(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_min_pd(a[0], b[0]), _mm256_min_pd(a[1], b[1])] }
    }

    #[inline(always)]
    fn max(self, a: [__m256d; 2], b: [__m256d; 2]) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe { [_mm256_max_pd(a[0], b[0]), _mm256_max_pd(a[1], b[1])] }
    }

    #[inline(always)]
    fn lt(self, a: [__m256d; 2], b: [__m256d; 2]) -> u32 {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            let low = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a[0], b[0]));
            let high = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a[1], b[1]));
            (low | high << 4) as u32
        }
    }

    #[inline(always)]
    fn le(self, a: [__m256d; 2], b: [__m256d; 2]) -> u32 {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            let low = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(a[0], b[0]));
            let high = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(a[1], b[1]));
            (low | high << 4) as u32
        }
    }

    #[inline(always)]
    fn select_lt(
        self,
        a: [__m256d; 2],
        b: [__m256d; 2],
        x: [__m256d; 2],
        y: [__m256d; 2],
    ) -> [__m256d; 2] {
        // SAFETY: the witness stands for the instructions.
        unsafe {
            [
                _mm256_blendv_pd(y[0], x[0], _mm256_cmp_pd::<_CMP_LT_OQ>(a[0], b[0])),
                _mm256_blendv_pd(y[1], x[1], _mm256_cmp_pd::<_CMP_LT_OQ>(a[1], b[1])),
            ]
        }
    }
}
