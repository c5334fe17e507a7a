//! A random colour for each face of the file, lightly shaded so that shape stays readable.

use halfline::error::Result;

use super::{Integrator, PrimaryHit, PrimaryHits, Radiance};
use crate::color::{decode_srgb, grey};
use crate::sampling::hash;
use crate::tracer::Tracer;
use crate::world::World;

pub(crate) struct FaceColors<'a> {
    pub(crate) world: &'a World<'a>,
    pub(crate) seed: u64,
}

impl Integrator for FaceColors<'_> {
    fn radiances(&self, primary_hits: PrimaryHits, _: &mut Tracer) -> Result<Vec<Radiance>> {
        Ok(primary_hits.each(|PrimaryHit { ray, surface, .. }| {
            let color = if surface.is_ground() {
                grey(0.5)
            } else {
                let face = self.world.scene.mesh().source_face(surface.face);
                let bits = hash(u64::from(face) ^ hash(self.seed));
                let unit = |shift: u32| (bits >> shift & 0xffff) as f32 / 65535.0;
                decode_srgb(pastel(unit(0), unit(16), unit(32)))
            };
            let facing = surface.normal.dot(ray.direction).abs();
            Radiance::opaque(color * (0.35 + 0.65 * facing)).faded(self.world.opacity(surface))
        }))
    }
}

/// A colour of any hue that is neither dark nor dull; all arguments from 0 to 1.
fn pastel(hue: f32, saturation: f32, value: f32) -> [f32; 3] {
    let (saturation, value) = (0.45 + 0.4 * saturation, 0.7 + 0.3 * value);
    // Hue to colour by the piecewise linear functions of Smith 1978.
    [5.0, 3.0, 1.0].map(|shift: f32| {
        let k = (shift + hue * 6.0) % 6.0;
        value * (1.0 - saturation * k.min(4.0 - k).clamp(0.0, 1.0))
    })
}
