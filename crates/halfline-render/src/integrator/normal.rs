//! The direction of the surface, by the orientation of its face.

use halfline::error::Result;
use halfline::geometry::Vec3;

use super::{Integrator, PrimaryHit, PrimaryHits, Radiance};
use crate::color::decode_srgb;
use crate::tracer::Tracer;
use crate::world::World;

pub(crate) struct Normals<'a> {
    pub(crate) world: &'a World<'a>,
}

impl Integrator for Normals<'_> {
    fn radiances(&self, primary_hits: PrimaryHits, _: &mut Tracer) -> Result<Vec<Radiance>> {
        Ok(primary_hits.each(|PrimaryHit { surface, .. }| {
            // -1 to 1 becomes the display's 0 to 255, as in normal maps.
            let encoded = surface.normal * 0.5 + Vec3::splat(0.5);
            Radiance::opaque(decode_srgb(encoded.to_array().map(|v| v as f32)))
                .faded(self.world.opacity(surface))
        }))
    }
}
