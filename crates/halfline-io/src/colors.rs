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
