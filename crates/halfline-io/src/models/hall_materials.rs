//! What the hall is made of.

use halfline::mesh::Material;

use super::assembly::Assembly;

/// Indices of the materials.
pub struct Materials {
    /// Of the exhibits.
    pub fossil: u32,
    /// Of the floor beside the planks.
    pub floor: u32,
    pub stone: u32,
    /// Of bars, wires and rivets.
    pub iron: u32,
    /// Of plain walls, and candles.
    pub wall: u32,
    /// Of what shines.
    pub brass: u32,
    /// Of what is clear.
    pub crystal: u32,
    /// Of planks and furniture, from light to dark.
    pub oak: [u32; 3],
    /// Of bindings.
    pub books: [u32; 3],
}

impl Materials {
    /// Adds them to the scene.
    pub fn new(scene: &mut Assembly) -> Materials {
        let rough =
            |r: f32, g: f32, b: f32| Material { base_color: [r, g, b, 1.0], ..Material::default() };
        let metal = |r, g, b, roughness| Material { metallic: 1.0, roughness, ..rough(r, g, b) };
        Materials {
            fossil: scene.material(rough(0.80, 0.70, 0.55)),
            floor: scene.material(Material { roughness: 0.2, ..rough(0.42, 0.38, 0.34) }),
            wall: scene.material(rough(0.82, 0.78, 0.70)),
            stone: scene.material(rough(0.72, 0.68, 0.60)),
            iron: scene.material(rough(0.16, 0.22, 0.20)),
            brass: scene.material(metal(0.83, 0.66, 0.32, 0.25)),
            crystal: scene.material(Material {
                roughness: 0.0,
                transmission: 0.9,
                ..rough(0.95, 0.97, 1.0)
            }),
            oak: [rough(0.56, 0.40, 0.25), rough(0.48, 0.32, 0.19), rough(0.30, 0.19, 0.11)]
                .map(|oak| scene.material(oak)),
            books: [rough(0.40, 0.10, 0.08), rough(0.11, 0.22, 0.17), rough(0.55, 0.42, 0.26)]
                .map(|binding| scene.material(binding)),
        }
    }
}
