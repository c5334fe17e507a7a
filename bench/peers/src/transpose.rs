//! Rays as Embree's packets want them, a row for each of a ray's numbers, and hits back.
//!
//! Rows are stored whole, in one register. Embree reads them whole, and a row that was just written
//! piece by piece would have to reach the cache before it could be read.

use halfline::{HitF32, RayF32};

/// Origin, `t_min`, direction, time, `t_max`, for `N` rays. Time is left as it is.
pub type Rows<const N: usize> = [[f32; N]; 9];

pub const FAR: usize = 8;

/// The primitive of a ray that hit none.
pub const INVALID: u32 = u32::MAX;

const _: () =
    assert!(size_of::<RayF32>() == 32 && size_of::<HitF32>() == 8 && HitF32::MISS.face == INVALID);

/// Turns rays into rows. `has_registers` is [`has_registers_for`] of their number, asked once.
#[inline(always)]
pub fn transpose<const N: usize>(rays: &[RayF32; N], rows: &mut Rows<N>, has_registers: bool) {
    #[cfg(target_arch = "x86_64")]
    if has_registers {
        let (from, to) = (rays.as_ptr().cast(), rows.as_mut_ptr().cast());
        // SAFETY: there are N rays and N columns, and the machine has registers of N numbers, as
        // the caller found.
        unsafe {
            match N {
                4 => return four(from, to),
                8 => return eight(from, to),
                16 => return sixteen(from, to),
                _ => {}
            }
        }
    }
    let _ = has_registers;
    for (lane, ray) in rays.iter().enumerate() {
        for axis in 0..3 {
            rows[axis][lane] = ray.origin[axis];
            rows[4 + axis][lane] = ray.direction[axis];
        }
        rows[3][lane] = ray.t_min;
        rows[FAR][lane] = ray.t_max;
    }
}

/// Whether this machine can transpose so many rays in registers of as many numbers.
pub fn has_registers_for(rays: usize) -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        match rays {
            4 => true,
            8 => has!("avx"),
            16 => has!("avx512f") && has!("avx512dq"),
            _ => false,
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = rays;
        false
    }
}

/// Four by four numbers, for the first half of the rays' numbers and for the second.
///
/// # Safety
/// There are 4 rays, and 9 rows of 4 numbers.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "sse")]
#[inline]
unsafe fn four(rays: *const f32, rows: *mut f32) {
    use std::arch::x86_64::*;

    for half in 0..2 {
        // SAFETY: the caller's promise.
        let [mut a, mut b, mut c, mut d] =
            [0, 1, 2, 3].map(|ray| unsafe { _mm_loadu_ps(rays.add(8 * ray + 4 * half)) });
        _MM_TRANSPOSE4_PS(&mut a, &mut b, &mut c, &mut d);
        for (i, values) in [a, b, c, d].into_iter().enumerate() {
            // SAFETY: the caller's promise.
            unsafe { _mm_storeu_ps(rows.add(4 * row(4 * half + i)), values) };
        }
    }
}

/// Two transpositions of four by four side by side: each register holds half the numbers of ray i
/// in its lower half and of ray i + 4 in its upper.
///
/// # Safety
/// There are 8 rays, and 9 rows of 8 numbers.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx")]
unsafe fn eight(rays: *const f32, rows: *mut f32) {
    use std::arch::x86_64::*;

    let pair = |a, b| {
        let (low, high) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        (_mm256_castps_pd(low), _mm256_castps_pd(high))
    };
    for half in 0..2 {
        let load = |ray: usize| {
            // SAFETY: the caller's promise.
            unsafe {
                let low = rays.add(8 * ray + 4 * half);
                _mm256_loadu2_m128(low.add(8 * 4), low)
            }
        };
        let ((a, b), (c, d)) = (pair(load(0), load(1)), pair(load(2), load(3)));
        let columns = [
            _mm256_unpacklo_pd(a, c),
            _mm256_unpackhi_pd(a, c),
            _mm256_unpacklo_pd(b, d),
            _mm256_unpackhi_pd(b, d),
        ];
        for (i, values) in columns.into_iter().enumerate() {
            // SAFETY: the caller's promise.
            unsafe { _mm256_storeu_ps(rows.add(8 * row(4 * half + i)), _mm256_castpd_ps(values)) };
        }
    }
}

/// Two transpositions of eight by eight side by side: each register holds ray i in its lower half
/// and ray i + 8 in its upper.
///
/// # Safety
/// There are 16 rays, and 9 rows of 16 numbers.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq")]
unsafe fn sixteen(rays: *const f32, rows: *mut f32) {
    use std::arch::x86_64::*;

    let load = |i: usize| {
        // SAFETY: the caller's promise.
        let (low, high) =
            unsafe { (_mm256_loadu_ps(rays.add(8 * i)), _mm256_loadu_ps(rays.add(8 * (i + 8)))) };
        _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high)
    };
    let loaded: [__m512; 8] = std::array::from_fn(load);

    // Pair the numbers of neighbours, then the pairs, within each quarter of a register.
    let pair = |a: __m512, b: __m512| [_mm512_unpacklo_ps(a, b), _mm512_unpackhi_ps(a, b)];
    let four = |a: __m512, b: __m512| {
        let (a, b) = (_mm512_castps_pd(a), _mm512_castps_pd(b));
        [_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b)]
    };
    let fours = |i: usize| {
        let [a, b] = pair(loaded[i], loaded[i + 1]);
        let [c, d] = pair(loaded[i + 2], loaded[i + 3]);
        let ([e, f], [g, h]) = (four(a, c), four(b, d));
        [e, f, g, h]
    };
    let (first, second) = (fours(0), fours(4));

    // Bring together what is left apart: lower quarters are numbers 0 to 3, upper ones 4 to 7.
    let lower = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
    let upper = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
    for i in 0..4 {
        for (number, order) in [(i, lower), (i + 4, upper)] {
            let values = _mm512_permutex2var_pd(first[i], order, second[i]);
            // SAFETY: the caller's promise.
            unsafe { _mm512_storeu_ps(rows.add(16 * row(number)), _mm512_castpd_ps(values)) };
        }
    }
}

/// The row of a ray's number; between direction and `t_max` there is time.
#[cfg(target_arch = "x86_64")]
fn row(number: usize) -> usize {
    if number == 7 { FAR } else { number }
}

/// A ray's direction, with time zero. It is stored whole, as rows are.
#[inline(always)]
pub fn direction(ray: &RayF32, place: &mut [f32; 4]) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::*;
        let [x, y, z] = ray.direction;
        // SAFETY: every such machine has SSE, and there is room for four numbers.
        unsafe { _mm_storeu_ps(place.as_mut_ptr(), _mm_setr_ps(x, y, z, 0.0)) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let [x, y, z] = ray.direction;
        *place = [x, y, z, 0.0];
    }
}

/// The hits of rays that ended at `far` on `primitive`.
#[inline(always)]
pub fn hits<const N: usize>(far: &[f32; N], primitive: &[u32; N], hits: &mut [HitF32; N]) {
    #[cfg(target_arch = "x86_64")]
    if N.is_multiple_of(4) {
        // SAFETY: there are N of each, and every such machine has SSE2.
        unsafe { hits_by_fours(far, primitive, hits) };
        return;
    }
    for ((hit, &far), &face) in hits.iter_mut().zip(far).zip(primitive) {
        *hit = HitF32 { t: if face == INVALID { f32::INFINITY } else { far }, face };
    }
}

/// The same four at a time, without branches.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "sse2")]
#[inline]
fn hits_by_fours(far: &[f32], primitive: &[u32], hits: &mut [HitF32]) {
    use std::arch::x86_64::*;

    let (invalid, infinity) = (_mm_set1_epi32(-1), _mm_set1_ps(f32::INFINITY));
    let fours = far.as_chunks::<4>().0.iter().zip(primitive.as_chunks::<4>().0);
    for ((far, primitive), hits) in fours.zip(hits.as_chunks_mut::<4>().0) {
        // SAFETY: each chunk is four long, and a hit is t and face.
        unsafe {
            let face = _mm_loadu_si128(primitive.as_ptr().cast());
            let is_miss = _mm_castsi128_ps(_mm_cmpeq_epi32(face, invalid));
            let far = _mm_andnot_ps(is_miss, _mm_loadu_ps(far.as_ptr()));
            let t = _mm_or_ps(far, _mm_and_ps(is_miss, infinity));
            let face = _mm_castsi128_ps(face);
            let place: *mut f32 = hits.as_mut_ptr().cast();
            _mm_storeu_ps(place, _mm_unpacklo_ps(t, face));
            _mm_storeu_ps(place.add(4), _mm_unpackhi_ps(t, face));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const N: usize>() {
        let number = |ray: usize, number: usize| (10 * ray + number) as f32;
        let ray = |i| RayF32 {
            origin: [0, 1, 2].map(|axis| number(i, axis)),
            t_min: number(i, 3),
            direction: [4, 5, 6].map(|axis| number(i, axis)),
            t_max: number(i, 7),
        };
        let rays: [RayF32; N] = std::array::from_fn(ray);
        let expected: Rows<N> = std::array::from_fn(|row| {
            std::array::from_fn(|i| match row {
                7 => -1.0,
                FAR => number(i, 7),
                _ => number(i, row),
            })
        });
        for has_registers in [false, has_registers_for(N)] {
            let mut rows = [[-1.0; N]; 9];
            transpose(&rays, &mut rows, has_registers);
            assert_eq!(rows, expected, "{N}, {has_registers}");
        }
    }

    #[test]
    fn every_number_lies_in_its_row() {
        check::<4>();
        check::<8>();
        check::<16>();
    }

    #[test]
    fn hits_are_t_and_face() {
        let primitive = std::array::from_fn(|i| if i % 3 == 1 { INVALID } else { i as u32 });
        let mut found = [HitF32::MISS; 8];
        hits(&std::array::from_fn(|i| 0.5 * i as f32), &primitive, &mut found);
        for (i, hit) in found.into_iter().enumerate() {
            let expected = HitF32 { t: 0.5 * i as f32, face: i as u32 };
            assert_eq!(hit, if i % 3 == 1 { HitF32::MISS } else { expected });
        }
    }
}
