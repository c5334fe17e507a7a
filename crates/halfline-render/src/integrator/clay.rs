//! Plaster under a soft sky with one soft key light.
//!
//! The sky's light is gathered by ambient occlusion (Zhukov, Iones, Kronin 1998; Landis 2002):
//! rays in proportion to the cosine, of limited reach, each bringing the sky's colour from its
//! own direction. What is hidden brings back a little of the surface's own colour, as several
//! bounces between near surfaces would (after Jimenez et al. 2016). The key light comes from
//! above the camera's left shoulder, warm where the sky is cool, so that shape reads from both
//! brightness and tint. Nothing depends on the orientation of faces: scans have it wrong.

use halfline::geometry::{Ray, Vec3, vec3};
use halfline::mesh::Material;

use super::{Integrator, Radiance, Sighting, dimension};
use crate::camera::Camera;
use crate::color::{Color, mix};
use crate::ground::Paint;
use crate::image::Rendering;
use crate::sampling::{Sampler, cosine_hemisphere, uniform_cone};
use crate::tracer::Tracer;
use crate::world::{Surface, World};

/// What models without colours of their own are made of.
pub(crate) const PLASTER: Material = Material {
    base_color: [0.50, 0.455, 0.40, 1.0],
    metallic: 0.0,
    roughness: 1.0,
    transmission: 0.0,
    ior: 1.5,
};

/// Light that a white surface sends back, by where it comes from.
const ZENITH: Color = vec3(0.46, 0.53, 0.66);
const HORIZON: Color = vec3(0.37, 0.40, 0.46);
const NADIR: Color = vec3(0.22, 0.20, 0.185);
const KEY: Color = vec3(1.24, 1.12, 0.95);

/// Share of the light that comes back from where the sky is hidden, before it is multiplied by
/// the surface's colour once more.
const RETURNED: f64 = 0.16;

/// Light up to this level is shown as it is; what is brighter nears white without reaching it, as
/// on film, so that white paint keeps its shape.
const SHOULDER: f32 = 0.55;

/// Half the angle under which the key light is seen.
const KEY_RADIUS_DEGREES: f64 = 7.0;

pub(crate) struct Clay<'a> {
    world: &'a World<'a>,
    /// Towards the key light.
    key: Vec3,
    cos_key_radius: f64,
    reach: f64,
    rays: u32,
}

impl<'a> Clay<'a> {
    /// `reach` is the length of the occlusion rays, `rays` their number.
    pub(crate) fn new(world: &'a World<'a>, camera: &Camera, reach: f64, rays: u32) -> Clay<'a> {
        let key = camera.up() - camera.right() * 0.9 - camera.forward() * 0.45;
        Clay {
            world,
            key: key.normalized(),
            cos_key_radius: KEY_RADIUS_DEGREES.to_radians().cos(),
            reach,
            rays,
        }
    }

    fn sky(&self, direction: Vec3) -> Color {
        let height = direction.dot(self.world.up);
        if height >= 0.0 { mix(HORIZON, ZENITH, height) } else { mix(HORIZON, NADIR, -height) }
    }

    /// The light on a surface that faces `normal`: what a white one would send back, and what
    /// it would if nothing were in the way. From the same rays, so that the two are equal to
    /// the bit where nothing is.
    fn light(
        &self,
        surface: &Surface,
        normal: Vec3,
        albedo: Color,
        sampler: &Sampler,
        tracer: &mut Tracer,
    ) -> [Color; 2] {
        let returned = albedo * RETURNED;
        let mut sky = [Vec3::ZERO; 2];
        for part in 0..self.rays {
            let sample = sampler.square(dimension::OCCLUSION, part, self.rays);
            let direction = cosine_hemisphere(normal, sample);
            let open = self.sky(direction);
            tracer.counts.occlusion += 1;
            sky[0] += if is_hidden(surface, normal, direction, self.reach, tracer) {
                open * returned
            } else {
                open
            };
            sky[1] += open;
        }
        let mut light = sky.map(|sum| sum / f64::from(self.rays.max(1)));

        let sample = sampler.square(dimension::KEY_LIGHT, 0, 1);
        let towards_key = uniform_cone(self.key, self.cos_key_radius, sample);
        let cosine = towards_key.dot(normal);
        if cosine > 0.0 {
            tracer.counts.shadow += 1;
            light[1] += KEY * cosine;
            if !is_hidden(surface, normal, towards_key, f64::INFINITY, tracer) {
                light[0] += KEY * cosine;
            }
        }
        light
    }
}

impl Integrator for Clay<'_> {
    fn radiance(&self, sighting: &Sighting, sampler: &Sampler, tracer: &mut Tracer) -> Radiance {
        let Some(surface) = sighting.surface else { return Radiance::NONE };
        let normal = surface.normal_against(sighting.ray.direction);
        match &self.world.ground {
            Some(ground) if surface.is_ground() => {
                let albedo = ground.color(surface.at.point);
                let opacity = ground.opacity(surface.at.point);
                let [light, full] = self.light(surface, normal, albedo, sampler, tracer);
                match ground.paint {
                    Paint::Shadow => {
                        // Green, the middle of the spectrum, in which shadows have the least tint.
                        let kept = light.y / full.y;
                        Radiance { color: Vec3::ZERO, alpha: (1.0 - kept) * opacity }
                    }
                    Paint::Checker(..) => Radiance::opaque(albedo * light).faded(opacity),
                }
            }
            _ => {
                let [r, g, b, _] = self.world.material(surface).base_color;
                let albedo = Vec3::from([r, g, b]);
                let [light, _] = self.light(surface, normal, albedo, sampler, tracer);
                Radiance::opaque(albedo * light)
            }
        }
    }

    fn finish(&self, picture: &mut Rendering) {
        for [r, g, b, _] in &mut picture.color {
            for channel in [r, g, b] {
                *channel = shoulder(*channel);
            }
        }
    }
}

/// True if something lies on the way from `surface`, seen from the side of `normal`.
fn is_hidden(
    surface: &Surface,
    normal: Vec3,
    direction: Vec3,
    reach: f64,
    tracer: &mut Tracer,
) -> bool {
    // Into the flat face, which only a smoothed normal lets happen.
    let flat = surface.at.normal;
    if direction.dot(flat) * normal.dot(flat) <= 0.0 {
        return true;
    }
    tracer.is_hidden(&Ray::with_range(surface.at.origin_towards(direction), direction, 0.0, reach))
}

/// The identity up to [`SHOULDER`], then an exponential with the same slope there, up to 1.
fn shoulder(light: f32) -> f32 {
    let room = 1.0 - SHOULDER;
    if light <= SHOULDER { light } else { 1.0 - room * ((SHOULDER - light) / room).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shoulder_is_smooth_and_stays_below_white() {
        assert_eq!([0.0, 0.3, SHOULDER].map(shoulder), [0.0, 0.3, SHOULDER]);
        let slope = (shoulder(SHOULDER + 1e-3) - SHOULDER) / 1e-3;
        assert!((slope - 1.0).abs() < 2e-3, "{slope}");
        assert!(shoulder(2.0) > shoulder(1.5) && shoulder(2.0) < 1.0);
    }
}
