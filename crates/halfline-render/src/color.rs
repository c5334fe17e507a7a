//! Colours, linear and as displays encode them.

use halfline::geometry::{Vec3, vec3};
use halfline::mesh::{linear_from_srgb, srgb_from_linear};

/// Linear red, green and blue, as x, y and z.
pub(crate) type Color = Vec3;

/// The eight-bit sRGB code nearest to a linear value; values outside 0 to 1 are clamped, NaN
/// is 0.
pub fn srgb8_from_linear(linear: f32) -> u8 {
    (srgb_from_linear(linear.clamp(0.0, 1.0)) * 255.0).round() as u8
}

/// The linear colour of an sRGB-encoded one.
pub(crate) fn decode_srgb(encoded: [f32; 3]) -> Color {
    Vec3::from(encoded.map(linear_from_srgb))
}

/// The linear value of each eight-bit sRGB code.
pub(crate) fn srgb8_table() -> [f64; 256] {
    std::array::from_fn(|code| f64::from(linear_from_srgb(code as f32 / 255.0)))
}

/// A linear grey.
pub(crate) const fn grey(value: f64) -> Color {
    vec3(value, value, value)
}

/// From `a` at 0 to `b` at 1.
pub(crate) fn mix(a: Color, b: Color, share: f64) -> Color {
    a * (1.0 - share) + b * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_survives_decoding_and_encoding() {
        for (code, &linear) in srgb8_table().iter().enumerate() {
            assert_eq!(usize::from(srgb8_from_linear(linear as f32)), code);
        }
    }

    #[test]
    fn middle_grey_has_the_standard_s_value() {
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-6);
        assert_eq!(srgb8_from_linear(0.5), 188);
    }

    #[test]
    fn out_of_range_light_is_clamped() {
        assert_eq!([-1.0, f32::NAN, 7.0, f32::INFINITY].map(srgb8_from_linear), [0, 0, 255, 255]);
    }
}
