//! From rays to colours: one file per shading mode.

mod clay;
mod depth;
mod face;
mod normal;
mod steps;
mod whitted;

pub(crate) use clay::{Clay, PLASTER, press_highlights};
pub(crate) use depth::{Depth, spread_depth};
pub(crate) use face::FaceColors;
pub(crate) use normal::Normals;
pub(crate) use steps::{Steps, color_bar as steps_color_bar, spread_steps};
pub(crate) use whitted::Whitted;

use halfline::error::Result;
use halfline::geometry::{Ray, Vec3};

use crate::color::Color;
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

/// Rays from the eye, and what each of them met.
#[derive(Clone, Copy)]
pub(crate) struct PrimaryHits<'a> {
    pub(crate) rays: &'a [Ray],
    pub(crate) surfaces: &'a [Option<Surface>],
    /// The random numbers of each ray.
    pub(crate) samplers: &'a [Sampler],
}

/// A ray from the eye that met something.
#[derive(Clone, Copy)]
pub(crate) struct PrimaryHit<'a> {
    /// Which of the rays it is.
    pub(crate) number: usize,
    pub(crate) ray: &'a Ray,
    pub(crate) surface: &'a Surface,
    pub(crate) sampler: &'a Sampler,
}

impl<'a> PrimaryHits<'a> {
    /// The rays that met something.
    pub(crate) fn met(self) -> impl Iterator<Item = PrimaryHit<'a>> {
        self.surfaces.iter().enumerate().filter_map(move |(number, surface)| {
            let surface = surface.as_ref()?;
            Some(PrimaryHit {
                number,
                ray: &self.rays[number],
                surface,
                sampler: &self.samplers[number],
            })
        })
    }

    /// Parts of `size` rays each, in their order.
    pub(crate) fn parts(self, size: usize) -> impl Iterator<Item = PrimaryHits<'a>> {
        (0..self.rays.len()).step_by(size).map(move |first| {
            let part = first..(first + size).min(self.rays.len());
            PrimaryHits {
                rays: &self.rays[part.clone()],
                surfaces: &self.surfaces[part.clone()],
                samplers: &self.samplers[part],
            }
        })
    }

    /// The light of all rays, where `shade` gives that of one which met something.
    pub(crate) fn each(self, mut shade: impl FnMut(PrimaryHit) -> Radiance) -> Vec<Radiance> {
        let mut radiances = vec![Radiance::NONE; self.rays.len()];
        for primary_hit in self.met() {
            radiances[primary_hit.number] = shade(primary_hit);
        }
        radiances
    }
}

/// Turns rays from the eye into light.
pub(crate) trait Integrator: Sync {
    /// The light that comes along each of the rays of `primary_hits`. What else must be cast for it is
    /// cast in waves: first what the first surfaces ask for, of all rays together, and so on.
    fn radiances(&self, primary_hits: PrimaryHits, tracer: &mut Tracer) -> Result<Vec<Radiance>>;

    /// True if the steps of the rays from the eye must be counted.
    fn counts_steps(&self) -> bool {
        false
    }
}

/// The parts of a pixel's random numbers that are used by different things.
pub(crate) mod dimension {
    /// Where in the pixel.
    pub(crate) const PIXEL: u32 = 0;
    /// Directions of occlusion rays.
    pub(crate) const OCCLUSION: u32 = 1;
    /// Points on the key light.
    pub(crate) const KEY_LIGHT: u32 = 2;
    /// The first of the random numbers that the paths of light use.
    pub(crate) const PATHS: u32 = 3;
}
