//! Vertex colours as files have them, to sRGB in eight bits.

/// The alpha of a colour that has none, and all parts of a colour that a vertex does not have.
pub(super) const UNSET: f32 = f32::NAN;

/// sRGB-encoded colours from 0 to 1 or, if any part of any colour is above 1, from 0 to 255.
/// What is [`UNSET`] becomes opaque white.
pub(super) fn to_bytes(colors: &[[f32; 4]]) -> Vec<[u8; 4]> {
    let scale = if colors.iter().flatten().any(|&part| part > 1.0) { 1.0 } else { 255.0 };
    let to_byte = |part: f32| if part.is_nan() { 255 } else { (part * scale).round() as u8 };
    colors.iter().map(|color| color.map(to_byte)).collect()
}

/// sRGB encoding (IEC 61966-2-1) of a linear part of a colour.
pub(super) fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The linear part of a colour from its sRGB encoding.
pub(super) fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
