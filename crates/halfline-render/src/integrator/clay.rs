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
use crate::sampling::{Sampler, cosine_hemisphere, uniform_cone};
use crate::statistics::RayCounts;
use crate::world::{Surface, World};

/// What models without colours of their own are made of.
pub(crate) const PLASTER: Material = Material {
    base_color: [0.62, 0.585, 0.545, 1.0],
    metallic: 0.0,
    roughness: 1.0,
    transmission: 0.0,
    ior: 1.5,
};

/// Light that a white surface sends back, by where it comes from.
const ZENITH: Color = vec3(0.66, 0.74, 0.88);
const HORIZON: Color = vec3(0.58, 0.60, 0.64);
const NADIR: Color = vec3(0.34, 0.31, 0.285);
const KEY: Color = vec3(0.98, 0.90, 0.79);

/// Share of the light that comes back from where the sky is hidden, before it is multiplied by
/// the surface's colour once more.
const RETURNED: f64 = 0.22;

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
        let key = camera.up() * 0.95 - camera.right() * 0.75 - camera.forward() * 0.75;
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
        counts: &mut RayCounts,
    ) -> [Color; 2] {
        let returned = albedo * RETURNED;
        let mut sky = [Vec3::ZERO; 2];
        for part in 0..self.rays {
            let sample = sampler.square(dimension::OCCLUSION, part, self.rays);
            let direction = cosine_hemisphere(normal, sample);
            let open = self.sky(direction);
            counts.occlusion += 1;
            sky[0] += if self.is_hidden(surface, normal, direction, self.reach) {
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
            counts.shadow += 1;
            light[1] += KEY * cosine;
            if !self.is_hidden(surface, normal, towards_key, f64::INFINITY) {
                light[0] += KEY * cosine;
            }
        }
        light
    }

    /// True if something lies on the way from `surface`, seen from the side of `normal`.
    fn is_hidden(&self, surface: &Surface, normal: Vec3, direction: Vec3, reach: f64) -> bool {
        // Into the flat face, which only a smoothed normal lets happen.
        let flat = surface.at.normal;
        if direction.dot(flat) * normal.dot(flat) <= 0.0 {
            return true;
        }
        let ray = Ray::with_range(surface.at.origin_towards(direction), direction, 0.0, reach);
        self.world.is_hidden(&ray)
    }
}

impl Integrator for Clay<'_> {
    fn radiance(&self, sighting: &Sighting, sampler: &Sampler, counts: &mut RayCounts) -> Radiance {
        let Some(surface) = sighting.surface else { return Radiance::NONE };
        let normal = surface.normal_against(sighting.ray.direction);
        match &self.world.ground {
            Some(ground) if surface.is_ground() => {
                let albedo = ground.color(surface.at.point);
                let opacity = ground.opacity(surface.at.point);
                let [light, full] = self.light(surface, normal, albedo, sampler, counts);
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
                let [light, _] = self.light(surface, normal, albedo, sampler, counts);
                Radiance::opaque(albedo * light)
            }
        }
    }
}
