//! How a surface divides the light that comes to it.

use std::f64::consts::PI;

use halfline::geometry::Vec3;
use halfline::mesh::Material;

use crate::color::{Color, grey};
use crate::optics::{cross_boundary, metal_reflectance};
use crate::world::Surface;

/// What becomes of the light at a surface of the model: mirrored by metal or at a boundary, through
/// the boundary, scattered.
pub(super) struct Weights {
    material: Material,
    /// The share that is mirrored sharply.
    pub(super) mirrored: Color,
    /// The share that is mirrored so that only highlights of lights show.
    blurred: Color,
    /// The share that passes through the boundary.
    pub(super) passed: Color,
    /// The unit direction of what passes; `None` for total internal reflection.
    pub(super) refracted: Option<Vec3>,
    scattered: Color,
}

impl Weights {
    /// Of light along `incoming` at `surface`, whose normal towards it is `normal`.
    pub(super) fn new(
        material: Material,
        surface: &Surface,
        normal: Vec3,
        incoming: Vec3,
    ) -> Weights {
        let base = base_color(&material);
        let cosine = (-incoming.dot(normal)).clamp(0.0, 1.0);
        let metallic = f64::from(material.metallic);
        let clear = clear_share(&material);

        let ior = f64::from(material.ior);
        let enters = clear == 0.0 || incoming.dot(surface.at.normal) < 0.0;
        let crossing = cross_boundary(incoming, normal, if enters { ior } else { 1.0 / ior });
        let polish = polish(&material).max(clear);
        let fresnel = metal_reflectance(base, cosine) * metallic
            + grey((1.0 - metallic) * crossing.reflectance);
        Weights {
            material,
            mirrored: fresnel * polish,
            blurred: fresnel * (1.0 - polish),
            passed: base * (clear * (1.0 - crossing.reflectance)),
            refracted: (crossing.reflectance < 1.0).then_some(crossing.refracted),
            scattered: base * ((1.0 - metallic - clear) * (1.0 - crossing.reflectance)).max(0.0),
        }
    }

    /// What goes back in many directions.
    pub(super) fn diffuse(&self) -> Color {
        self.scattered + self.blurred
    }

    /// True if what comes straight from lights shows.
    pub(super) fn is_lit(&self) -> bool {
        self.diffuse().max_element() > 0.0
    }

    /// How much of the light from `towards` goes back along `incoming`.
    pub(super) fn scattering(&self, towards: Vec3, normal: Vec3, incoming: Vec3) -> Color {
        let halfway = (towards - incoming).normalized();
        self.scattered / PI + self.blurred * highlight(&self.material, normal.dot(halfway))
    }
}

pub(super) fn base_color(material: &Material) -> Color {
    let [r, g, b, _] = material.base_color;
    Vec3::from([r, g, b])
}

/// Share of the light that passes into the body and through it.
pub(super) fn clear_share(material: &Material) -> f64 {
    f64::from(material.transmission) * (1.0 - f64::from(material.metallic))
}

/// Share of the mirrored light that stays sharp: a single ray cannot show a blurred mirror, so
/// with roughness the mirror image fades into the highlights of the lights.
fn polish(material: &Material) -> f64 {
    (1.0 - f64::from(material.roughness)).powi(4)
}

/// The highlight for a cosine between the normal and the direction halfway between light and eye:
/// Blinn 1977, with the exponent that fits a roughness (Walter et al. 2007, section 5.2), and
/// normalised after Hoffman, "Physically-Based Shading Models in Film and Game Production", 2010.
fn highlight(material: &Material, cosine: f64) -> f64 {
    // The smallest roughness that highlights are drawn for: sharper ones are mirror images.
    let alpha = f64::from(material.roughness).max(0.1).powi(2);
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    (exponent + 8.0) / (8.0 * PI) * cosine.max(0.0).powf(exponent)
}
