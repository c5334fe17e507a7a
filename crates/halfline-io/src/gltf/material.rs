//! glTF materials to ours.

use super::document;
use halfline::mesh::Material;

/// The material with the defaults of the specification for what it leaves out. Textures other
/// than that of the base colour are passed over.
pub(super) fn convert(material: &document::Material) -> Material {
    let unit = |value: f32| value.clamp(0.0, 1.0);
    let model = material.pbr_metallic_roughness.as_deref();
    let mut base_color = model.and_then(|model| model.base_color_factor).unwrap_or([1.0; 4]);
    if is_opaque(material) {
        base_color[3] = 1.0;
    }
    let extensions = material.extensions.as_deref();
    let transmission = extensions.and_then(|e| e.transmission.as_ref());
    let ior = extensions.and_then(|e| e.ior.as_ref()).and_then(|e| e.ior);
    Material {
        base_color: base_color.map(unit),
        metallic: unit(model.and_then(|model| model.metallic_factor).unwrap_or(1.0)),
        roughness: unit(model.and_then(|model| model.roughness_factor).unwrap_or(1.0)),
        transmission: unit(transmission.map_or(0.0, |t| t.transmission_factor)),
        // An index of 0 stands for an infinite one in the extension; nothing below 1 is a medium.
        ior: ior.filter(|&ior| ior >= 1.0).unwrap_or(1.5),
    }
}

/// True if alpha is to be ignored.
pub(super) fn is_opaque(material: &document::Material) -> bool {
    material.alpha_mode.as_deref().unwrap_or("OPAQUE") == "OPAQUE"
}
