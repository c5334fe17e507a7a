//! What is seen where there is no surface.

use halfline::geometry::{Vec3, vec3};
use halfline::mesh::linear_from_srgb;

use crate::color::{Color, decode_srgb, grey, mix};
use crate::settings::Background;

/// The background behind a point of the picture, `x` and `y` from -1 to 1, y up: linear colour
/// and alpha.
pub(crate) fn backdrop(background: &Background, x: f64, y: f64) -> (Color, f64) {
    match background {
        Background::Studio => {
            // Brightest a little above the middle, darker to the corners: in encoded values, in
            // which equal steps look equal.
            let distance = (0.55 * x * x + 0.6 * (y - 0.15) * (y - 0.15)).min(1.0);
            let [r, g, b] = [0.93, 0.935, 0.94].map(|v: f64| v - 0.22 * distance);
            let linear = |v: f64| f64::from(linear_from_srgb(v as f32));
            (vec3(linear(r), linear(g), linear(b)), 1.0)
        }
        Background::Color(color) => (decode_srgb(*color), 1.0),
        Background::Transparent => (Vec3::ZERO, 0.0),
    }
}

/// What mirrors and glass show in a direction, given by its cosine with the up axis, where there
/// is nothing: the one colour of the background, or else a bright sky over a darker floor.
pub(crate) fn surroundings(background: &Background, cos_up: f64) -> Color {
    match background {
        Background::Color(color) => decode_srgb(*color),
        Background::Studio | Background::Transparent => {
            if cos_up >= 0.0 {
                mix(grey(0.80), vec3(0.52, 0.57, 0.66), cos_up.sqrt())
            } else {
                mix(grey(0.42), grey(0.16), (-cos_up).sqrt())
            }
        }
    }
}

/// What a white surface sends back of the light of [`surroundings`], by the cosine of its normal
/// with the up axis.
pub(crate) fn ambient(background: &Background, cos_up: f64) -> Color {
    // A surface that faces up sees the sky alone, one that faces sideways as much floor as sky;
    // the half-spaces in between have shares that are linear in the cosine.
    let [floor, sky] = [-0.5, 0.5].map(|cosine| surroundings(background, cosine));
    mix(floor, sky, 0.5 + 0.5 * cos_up)
}
