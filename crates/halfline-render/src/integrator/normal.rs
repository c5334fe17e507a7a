//! The direction of the surface, by the orientation of its face.

use halfline::geometry::Vec3;

use super::{Integrator, Radiance, Sighting};
use crate::color::decode_srgb;
use crate::sampling::Sampler;
use crate::tracer::Tracer;
use crate::world::World;

pub(crate) struct Normals<'a> {
    pub(crate) world: &'a World<'a>,
}

impl Integrator for Normals<'_> {
    fn radiance(&self, sighting: &Sighting, _: &Sampler, _: &mut Tracer) -> Radiance {
        let Some(surface) = sighting.surface else { return Radiance::NONE };
        // -1 to 1 becomes the display's 0 to 255, as in normal maps.
        let encoded = surface.normal * 0.5 + Vec3::splat(0.5);
        Radiance::opaque(decode_srgb(encoded.to_array().map(|v| v as f32)))
            .faded(self.world.opacity(surface))
    }
}
