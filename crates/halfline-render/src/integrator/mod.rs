//! From rays to colours: one file per shading mode.

mod clay;
mod depth;
mod face;
mod normal;
mod steps;
mod whitted;

pub(crate) use clay::{Clay, PLASTER};
pub(crate) use depth::Depth;
pub(crate) use face::FaceColors;
pub(crate) use normal::Normals;
pub(crate) use steps::Steps;
pub(crate) use whitted::Whitted;

use halfline::geometry::{Ray, Vec3};

use crate::color::Color;
use crate::image::Rendering;
use crate::sampling::Sampler;
use crate::tracer::Tracer;
use crate::world::Surface;

/// The light of one ray, and how much of what lies behind it hides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Radiance {
    /// Linear, premultiplied by `alpha`.
    pub(crate) color: Color,
    /// 0 shows the background, 1 hides it.
    pub(crate) alpha: f64,
}

impl Radiance {
    pub(crate) const NONE: Radiance = Radiance { color: Vec3::ZERO, alpha: 0.0 };

    pub(crate) fn opaque(color: Color) -> Radiance {
        Radiance { color, alpha: 1.0 }
    }

    /// As seen through something of the given opacity.
    pub(crate) fn faded(self, opacity: f64) -> Radiance {
        Radiance { color: self.color * opacity, alpha: self.alpha * opacity }
    }

    /// With `background` behind it.
    pub(crate) fn over(self, background: Color) -> Color {
        self.color + background * (1.0 - self.alpha)
    }
}

/// A ray from the eye and what it met.
pub(crate) struct Sighting<'a> {
    pub(crate) ray: &'a Ray,
    pub(crate) surface: Option<&'a Surface>,
}

/// Turns rays from the eye into light.
pub(crate) trait Integrator: Sync {
    /// The light that comes along the ray of `sighting`.
    fn radiance(&self, sighting: &Sighting, sampler: &Sampler, tracer: &mut Tracer) -> Radiance;

    /// True if the steps of the rays from the eye must be counted.
    fn counts_steps(&self) -> bool {
        false
    }

    /// Completes the picture with what only all pixels together tell.
    fn finish(&self, _picture: &mut Rendering) {}
}

/// The parts of a pixel's random numbers that are used by different things.
pub(crate) mod dimension {
    /// Where in the pixel.
    pub(crate) const PIXEL: u32 = 0;
    /// Directions of occlusion rays.
    pub(crate) const OCCLUSION: u32 = 1;
    /// Points on the key light.
    pub(crate) const KEY_LIGHT: u32 = 2;
    /// The first of those that the paths of light use.
    pub(crate) const PATHS: u32 = 3;
}
