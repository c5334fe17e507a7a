//! The vector units: one narrow trait, one witness for each instruction set, one dispatch.
//!
//! Kernels are written once, over `Simd`, and marked `inline(always)`; `Level::run` compiles
//! them for each instruction set and calls the one that it stands for. What differs between the sets
//! is rounding alone (fused products and sums), and only where either rounding is accounted for: all
//! of them give the same answers. The idea of a witness, a value that exists only where its
//! instructions do, is that of the crate `pulp`.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod front;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
mod ring;

pub(crate) use ring::Ring;

use std::fmt;

use crate::error::{Error, Result};

/// Lanes of a vector, children of a node, triangles of a leaf.
pub const LANES: usize = 8;

/// Words that are looked at together.
pub const WORDS: usize = 32;

/// Bytes of a cache line.
const LINE: usize = 64;

/// The operations of an instruction set, on eight single-precision numbers.
///
/// An index vector is packed into 24 bits, three for each lane.
pub(crate) trait Simd: Copy + Send + Sync {
    /// Eight single-precision numbers, one in each lane.
    type F32x8: Copy;

    /// A vector with `x` in each lane.
    fn splat(self, x: f32) -> Self::F32x8;

    /// The numbers of an array.
    fn load(self, array: &[f32; LANES]) -> Self::F32x8;

    /// Numbers that were just found one by one, without a way through memory, where a vector could only be read
    /// once all of them have come to the cache.
    fn set(self, numbers: [f32; LANES]) -> Self::F32x8;

    /// `a * b + c`, rounded once or twice.
    fn mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;

    /// `a - b`.
    fn sub(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;

    /// `a + b`.
    fn add(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;

    /// `a * b`.
    fn mul(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;

    /// `a / b`.
    fn div(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;

    /// Writes all lanes.
    fn store(self, a: Self::F32x8, array: &mut [f32; LANES]);

    /// `c - a * b`, rounded once or twice.
    fn neg_mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;

    /// The magnitude of each number.
    fn abs(self, a: Self::F32x8) -> Self::F32x8;

    /// The root of each number.
    fn sqrt(self, a: Self::F32x8) -> Self::F32x8;

    /// A bit for each lane where `a < b`.
    fn lt(self, a: Self::F32x8, b: Self::F32x8) -> u32;

    /// The smaller of two numbers, the second of which is not NaN; the second if the first is NaN.
    fn min(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;

    /// The larger of two numbers, the second of which is not NaN; the second if the first is NaN.
    fn max(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;

    /// For each lane where `near <= far`, in the order of `lanes`, writes `near` and the word of that
    /// lane to the front of `nears` and `kept`. Returns how many; the rest of both is undefined.
    fn compress(
        self,
        near: Self::F32x8,
        far: Self::F32x8,
        words: &[u32; LANES],
        lanes: u32,
        nears: &mut [f32; LANES],
        kept: &mut [u32; LANES],
    ) -> usize;

    /// A bit for each of eight words that is equal to `word`.
    fn eq_u32(self, words: &[u32; LANES], word: u32) -> u32;

    /// Writes a word to where the mask has a bit.
    fn masked_fill_u32(self, mask: u32, word: u32, words: &mut [u32; LANES]);

    /// A bit for each word below `limit`.
    fn lt_u32(self, words: &[u32; WORDS], limit: u32) -> u32;

    /// The operations of this instruction set on doubles.
    type F64: SimdF64;

    /// The witness of the operations on doubles.
    fn doubles(self) -> Self::F64;

    /// The nearest single-precision numbers.
    fn narrow(self, a: <Self::F64 as SimdF64>::F64x8) -> Self::F32x8;

    /// The numbers of `a` as doubles.
    fn widen(self, a: Self::F32x8) -> <Self::F64 as SimdF64>::F64x8;

    /// `x` where `a < b`, else `y`.
    fn select_lt(
        self,
        a: Self::F32x8,
        b: Self::F32x8,
        x: Self::F32x8,
        y: Self::F32x8,
    ) -> Self::F32x8;

    /// `x` where the mask has a bit, else `y`.
    fn select(self, mask: u32, x: Self::F32x8, y: Self::F32x8) -> Self::F32x8;

    /// Transposes eight rows to eight columns.
    fn transpose(self, rows: [Self::F32x8; LANES]) -> [Self::F32x8; LANES];

    /// Does work with the same instructions in a function of its own: work that is rare would be in the
    /// way of what is not. (A function that is not inlined is compiled for no instruction set.)
    fn outlined<J: Job>(self, job: J) -> J::Output;

    /// Asks for some cache lines from an address on without waiting for them. Nothing is read, so
    /// any address will do.
    fn prefetch(self, address: usize, lines: usize);
}

/// The operations of an instruction set on eight doubles.
pub(crate) trait SimdF64: Copy {
    /// Eight doubles, one in each lane.
    type F64x8: Copy;

    /// A vector with `x` in each lane.
    fn splat(self, x: f64) -> Self::F64x8;

    /// Numbers that were just found one by one, as in [`Simd::set`].
    fn set(self, numbers: [f64; LANES]) -> Self::F64x8;

    /// Writes all lanes.
    fn store(self, a: Self::F64x8, array: &mut [f64; LANES]);

    /// `a + b`.
    fn add(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;

    /// `a - b`.
    fn sub(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;

    /// `a * b`.
    fn mul(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;

    /// `a * b + c`, rounded once or twice.
    fn mul_add(self, a: Self::F64x8, b: Self::F64x8, c: Self::F64x8) -> Self::F64x8;

    /// `a / b`.
    fn div(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;

    /// `a * b - product`, where `product` is `a * b` rounded: exact, unless it underflows or `a` or `b` is beyond
    /// 2^995.
    fn product_error(self, a: Self::F64x8, b: Self::F64x8, product: Self::F64x8) -> Self::F64x8;

    /// The root of each number.
    fn sqrt(self, a: Self::F64x8) -> Self::F64x8;

    /// The magnitude of each number.
    fn abs(self, a: Self::F64x8) -> Self::F64x8;

    /// The largest power of two that is no larger in magnitude, for normal numbers.
    fn power(self, a: Self::F64x8) -> Self::F64x8;

    /// The inverse of a power of two, if both are normal numbers.
    fn inverse_power(self, a: Self::F64x8) -> Self::F64x8;

    /// The smaller of two numbers; the second if one is NaN.
    fn min(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;

    /// The larger of two numbers; the second if one is NaN.
    fn max(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;

    /// A bit for each lane where `a < b`.
    fn lt(self, a: Self::F64x8, b: Self::F64x8) -> u32;

    /// A bit for each lane where `a <= b`.
    fn le(self, a: Self::F64x8, b: Self::F64x8) -> u32;

    /// `x` where `a < b`, else `y`.
    fn select_lt(
        self,
        a: Self::F64x8,
        b: Self::F64x8,
        x: Self::F64x8,
        y: Self::F64x8,
    ) -> Self::F64x8;
}

/// Eight doubles.
pub(crate) type F64x8<S> = <<S as Simd>::F64 as SimdF64>::F64x8;

/// The bits of a double's exponent.
const EXPONENT_BITS: u64 = 0x7ff << 52;

/// The bits of a power of two and of its inverse add up to this.
const POWER_AND_INVERSE: u64 = 2046 << 52;

/// Work that is compiled for every instruction set.
pub(crate) trait Job {
    /// What comes of the work.
    type Output;

    /// Does the work. To be marked `inline(always)`, as everything that it calls and that should
    /// be compiled for the instruction set.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    Scalar,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
}

/// The environment variable that forces an instruction set.
const VARIABLE: &str = "HALFLINE_SIMD";

impl Level {
    /// Plain Rust, which the compiler vectorises as far as every machine of this kind allows.
    pub const SCALAR: Level = Level(Set::Scalar);

    /// All instruction sets of this machine, the best last.
    pub fn available() -> Vec<Level> {
        let mut levels = vec![Level::SCALAR];
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            let has_avx2 = has!("avx2") && has!("fma") && has!("bmi1") && has!("bmi2");
            if has_avx2 && has!("popcnt") && has!("lzcnt") {
                levels.push(Level(Set::Avx2));
                let has_512 = has!("avx512f") && has!("avx512vl") && has!("avx512dq");
                if has_512 && has!("avx512bw") {
                    levels.push(Level(Set::Avx512));
                }
            }
        }
        #[cfg(target_arch = "aarch64")]
        levels.push(Level(Set::Neon));
        levels
    }

    /// The best instruction set of this machine, or the one that the environment variable
    /// `HALFLINE_SIMD` names: `scalar`, `avx2`, `avx512` or `neon`.
    ///
    /// # Errors
    /// [`Error::Invalid`] for any other value, and for an instruction set that this machine lacks.
    pub fn chosen() -> Result<Level> {
        let levels = Level::available();
        let best = levels[levels.len() - 1];
        let Some(value) = std::env::var_os(VARIABLE).filter(|value| !value.is_empty()) else {
            return Ok(best);
        };
        let names = levels.iter().map(|level| level.name()).collect::<Vec<_>>().join(", ");
        levels.into_iter().find(|level| value == level.name()).ok_or_else(|| {
            let value = value.to_string_lossy();
            Error::invalid(VARIABLE, format!("is {value:?}; this machine has {names}"))
        })
    }

    /// The name of the instruction set, as the environment variable has it.
    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Scalar => "scalar",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "avx512",
            #[cfg(target_arch = "aarch64")]
            Set::Neon => "neon",
        }
    }

    /// Does the work with this instruction set.
    #[allow(unsafe_code)]
    pub(crate) fn run<J: Job>(self, job: J) -> J::Output {
        match self.0 {
            Set::Scalar => job.run(portable::Portable),
            // SAFETY: `available` made this level, having found its instructions on this machine.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { avx2::run(job) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { avx512::run(job) },
            #[cfg(target_arch = "aarch64")]
            Set::Neon => job.run(neon::Neon),
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests;
