//! Sixteen rays as Embree's packets want them: a row for each of a ray's numbers.
//!
//! Rows are stored whole. Embree reads them whole, and a row that was just written number by number
//! would have to reach the cache before it could be read.

use halfline::RayF32;

/// Origin, `t_min`, direction, time, `t_max`, for sixteen rays. Time is left as it is.
pub type Rows = [[f32; 16]; 9];

pub const FAR: usize = 8;

/// Turns rays into rows. `is_wide` is [`has_wide_registers`], asked once.
#[inline(always)]
pub fn transpose(rays: &[RayF32; 16], rows: &mut Rows, is_wide: bool) {
    #[cfg(target_arch = "x86_64")]
    if is_wide {
        // SAFETY: the machine has AVX-512, as the caller found.
        unsafe { in_registers(rays, rows) };
        return;
    }
    let _ = is_wide;
    one_by_one(rays, rows);
}

/// Whether rays can be transposed in registers of sixteen numbers.
pub fn has_wide_registers() -> bool {
    #[cfg(target_arch = "x86_64")]
    let is_wide = std::arch::is_x86_feature_detected!("avx512f")
        && std::arch::is_x86_feature_detected!("avx512dq");
    #[cfg(not(target_arch = "x86_64"))]
    let is_wide = false;
    is_wide
}

/// Transposes ray by ray: on any machine, and for fewer rays than sixteen.
pub fn one_by_one(rays: &[RayF32], rows: &mut Rows) {
    for (lane, ray) in rays.iter().enumerate() {
        for axis in 0..3 {
            rows[axis][lane] = ray.origin[axis];
            rows[4 + axis][lane] = ray.direction[axis];
        }
        rows[3][lane] = ray.t_min;
        rows[FAR][lane] = ray.t_max;
    }
}

/// Two transpositions of eight by eight side by side: each register holds ray i in its lower half
/// and ray i + 8 in its upper.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq")]
fn in_registers(rays: &[RayF32; 16], rows: &mut Rows) {
    use std::arch::x86_64::*;

    const { assert!(size_of::<RayF32>() == 32) };
    let start: *const f32 = rays.as_ptr().cast();
    let load = |i: usize| {
        // SAFETY: a ray is eight numbers, in the order of its fields, and there are sixteen.
        let (low, high) =
            unsafe { (_mm256_loadu_ps(start.add(8 * i)), _mm256_loadu_ps(start.add(8 * (i + 8)))) };
        _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high)
    };
    let rays: [__m512; 8] = std::array::from_fn(load);

    // Pair the numbers of neighbours, then the pairs, within each quarter of a register.
    let pair = |a: __m512, b: __m512| [_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b)];
    let four = |a: __m512, b: __m512| {
        let (a, b) = (_mm512_castps_pd(a), _mm512_castps_pd(b));
        [_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b)]
    };
    let fours = |i: usize| {
        let [a, b] = pair(rays[i], rays[i + 1]);
        let [c, d] = pair(rays[i + 2], rays[i + 3]);
        let ([e, f], [g, h]) = (four(a, c), four(b, d));
        [e, f, g, h]
    };
    let (first, second) = (fours(0), fours(4));

    // Bring together what is left apart: lower quarters are numbers 0 to 3, upper ones 4 to 7.
    let lower = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
    let upper = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
    for i in 0..4 {
        for (row, order) in [(i, lower), (if i == 3 { FAR } else { i + 4 }, upper)] {
            let values = _mm512_permutex2var_pd(first[i], order, second[i]);
            // SAFETY: a row is sixteen numbers.
            unsafe { _mm512_storeu_ps(rows[row].as_mut_ptr(), _mm512_castpd_ps(values)) };
        }
    }
}
