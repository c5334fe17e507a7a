//! The distance from the camera's plane: near is bright, far is dark.

use halfline::error::Result;
use halfline::geometry::{NO_FACE, Vec3};
use halfline::mesh::linear_from_srgb;

use super::{Integrator, PrimaryHit, PrimaryHits, Radiance};
use crate::camera::Camera;
use crate::image::Rendering;
use crate::tracer::Tracer;
use crate::world::World;

/// Encoded greys of the nearest and the farthest point of the picture.
const NEAREST: f32 = 0.97;
const FARTHEST: f32 = 0.12;

pub(crate) struct Depth<'a> {
    pub(crate) world: &'a World<'a>,
    pub(crate) camera: &'a Camera,
}

impl Integrator for Depth<'_> {
    fn radiances(&self, primary_hits: PrimaryHits, _: &mut Tracer) -> Result<Vec<Radiance>> {
        // Distances pass as colours until their range is known.
        Ok(primary_hits.each(|PrimaryHit { surface, .. }| {
            let depth = Vec3::splat(self.camera.depth(surface.at.point));
            Radiance::opaque(depth).faded(self.world.opacity(surface))
        }))
    }
}

/// Turns the distances that passed as colours into greys, from the nearest to the farthest.
pub(crate) fn spread_depth(picture: &mut Rendering) {
    // The model alone sets the range: the ground goes on for much longer.
    let (mut nearest, mut farthest) = (f32::INFINITY, f32::NEG_INFINITY);
    for (&depth, &face) in picture.depth.iter().zip(&picture.face) {
        if face != NO_FACE {
            nearest = nearest.min(depth);
            farthest = farthest.max(depth);
        }
    }
    for [r, g, b, _] in &mut picture.color {
        let share = if farthest > nearest { (*r - nearest) / (farthest - nearest) } else { 0.0 };
        let encoded = NEAREST + (FARTHEST - NEAREST) * share.clamp(0.0, 1.0);
        let grey = linear_from_srgb(encoded);
        (*r, *g, *b) = (grey, grey, grey);
    }
}
