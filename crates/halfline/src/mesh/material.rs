//! How a surface looks, in the terms of glTF 2.0.

/// The metallic-roughness model of glTF 2.0, section 3.9.2, with KHR_materials_transmission and
/// KHR_materials_ior.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Linear red, green, blue, alpha.
    pub base_color: [f32; 4],
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: f32,
    /// 0 for a mirror, 1 for a fully rough surface.
    pub roughness: f32,
    /// Share of the light that passes into a dielectric instead of being scattered back.
    pub transmission: f32,
    /// Index of refraction.
    pub ior: f32,
}

impl Default for Material {
    /// A rough, light grey dielectric.
    fn default() -> Material {
        Material {
            base_color: [0.8, 0.8, 0.8, 1.0],
            metallic: 0.0,
            roughness: 1.0,
            transmission: 0.0,
            ior: 1.5,
        }
    }
}
