//! Plaster under a soft sky with one soft key light.
//!
//! The sky's light is gathered by ambient occlusion (Zhukov, Iones, Kronin 1998; Landis 2002):
//! rays in proportion to the cosine, of limited reach, each bringing the sky's colour from its
//! own direction. What is hidden brings back a little of the surface's own colour, as several
//! bounces between near surfaces would (after Jimenez et al. 2016). The key light comes from
//! above the camera's left shoulder, warm where the sky is cool, so that shape reads from both
//! brightness and tint. Nothing depends on the orientation of faces: scans have it wrong.

use halfline::error::Result;
use halfline::geometry::{Ray, Vec3, vec3};
use halfline::mesh::Material;
use rayon::prelude::*;

use super::{Integrator, PrimaryHit, PrimaryHits, Radiance, dimension};
use crate::camera::Camera;
use crate::color::{Color, mix};
use crate::ground::Paint;
use crate::image::Rendering;
use crate::sampling::{cosine_hemisphere, uniform_cone};
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

    /// What each surface that is seen must know of its surroundings, and where that is to be asked.
    fn questions(&self, primary_hits: PrimaryHits, tracer: &mut Tracer) -> Questions {
        let mut questions = Questions::default();
        for PrimaryHit { ray, surface, sampler, .. } in primary_hits.met() {
            let normal = surface.normal_against(ray.direction);
            for part in 0..self.rays {
                let sample = sampler.square(dimension::OCCLUSION, part, self.rays);
                let direction = cosine_hemisphere(normal, sample);
                questions.sky.push(surface, normal, direction, self.reach);
            }
            tracer.counts.occlusion += u64::from(self.rays);

            let sample = sampler.square(dimension::KEY_LIGHT, 0, 1);
            let towards_key = uniform_cone(self.key, self.cos_key_radius, sample);
            let key_cosine = towards_key.dot(normal);
            if key_cosine > 0.0 {
                tracer.counts.shadow += 1;
                questions.key.push(surface, normal, towards_key, f64::INFINITY);
            }
            questions.key_cosines.push(key_cosine);
        }
        questions
    }

    /// The light on a surface: what a white one would send back, and what it would if nothing were in
    /// the way. From the same rays, so that the two are equal to the bit where nothing is.
    fn light(
        &self,
        albedo: Color,
        sky: impl Iterator<Item = (Vec3, bool)>,
        key_cosine: f64,
        key_is_occluded: bool,
    ) -> [Color; 2] {
        let returned = albedo * RETURNED;
        let mut sums = [Vec3::ZERO; 2];
        for (direction, occluded) in sky {
            let open = self.sky(direction);
            sums[0] += if occluded { open * returned } else { open };
            sums[1] += open;
        }
        let mut light = sums.map(|sum| sum / f64::from(self.rays.max(1)));
        if key_cosine > 0.0 {
            light[1] += KEY * key_cosine;
            if !key_is_occluded {
                light[0] += KEY * key_cosine;
            }
        }
        light
    }
}

/// What is asked about all surfaces that are seen, in their order.
#[derive(Default)]
struct Questions {
    /// Into the surroundings, as many for each surface.
    sky: Wave,
    /// To the key light, from the surfaces that face it.
    key: Wave,
    /// Of the angle between each surface's normal and the way to the key light.
    key_cosines: Vec<f64>,
}

/// Rays that are cast together, and for each whether something lies on it.
#[derive(Default)]
struct Wave {
    rays: Vec<Ray>,
    occluded: Vec<bool>,
}

impl Wave {
    /// Adds a ray from `surface`, seen from the side of `normal`.
    fn push(&mut self, surface: &Surface, normal: Vec3, direction: Vec3, reach: f64) {
        let origin = surface.at.origin_towards(direction);
        self.rays.push(Ray::with_range(origin, direction, 0.0, reach));
        // Into the flat face, which only a smoothed normal lets happen, nothing is open.
        let flat = surface.at.normal;
        self.occluded.push(direction.dot(flat) * normal.dot(flat) <= 0.0);
    }

    fn cast(&mut self, tracer: &Tracer) -> Result<()> {
        tracer.occlude(&self.rays, &mut self.occluded)
    }

    /// The direction of each ray, and whether something lies on it.
    fn answers(&self) -> impl Iterator<Item = (Vec3, bool)> {
        self.rays.iter().map(|ray| ray.direction).zip(self.occluded.iter().copied())
    }
}

impl Integrator for Clay<'_> {
    fn radiances(&self, primary_hits: PrimaryHits, tracer: &mut Tracer) -> Result<Vec<Radiance>> {
        let mut questions = self.questions(primary_hits, tracer);
        questions.sky.cast(tracer)?;
        questions.key.cast(tracer)?;

        let (mut sky, mut key) = (questions.sky.answers(), questions.key.answers());
        let mut key_cosines = questions.key_cosines.iter();
        Ok(primary_hits.each(|PrimaryHit { surface, .. }| {
            let key_cosine = *key_cosines.next().expect("one for each surface");
            let key_is_occluded =
                key_cosine > 0.0 && key.next().is_some_and(|(_, occluded)| occluded);
            let mut light = |albedo| {
                let sky = sky.by_ref().take(self.rays as usize);
                self.light(albedo, sky, key_cosine, key_is_occluded)
            };
            match &self.world.ground {
                Some(ground) if surface.is_ground() => {
                    let albedo = ground.color(surface.at.point);
                    let opacity = ground.opacity(surface.at.point);
                    let [light, full] = light(albedo);
                    match ground.paint {
                        Paint::Shadow => {
                            // Green, the middle of the spectrum, in which shadows have the least
                            // tint.
                            let kept = light.y / full.y;
                            Radiance { color: Vec3::ZERO, alpha: (1.0 - kept) * opacity }
                        }
                        Paint::Checker(..) => Radiance::opaque(albedo * light).faded(opacity),
                    }
                }
                _ => {
                    let [r, g, b, _] = self.world.material(surface).base_color;
                    let albedo = Vec3::from([r, g, b]);
                    let [light, _] = light(albedo);
                    Radiance::opaque(albedo * light)
                }
            }
        }))
    }
}

/// Shows light as film does.
pub(crate) fn press_highlights(picture: &mut Rendering) {
    picture.color.par_iter_mut().with_min_len(1 << 12).for_each(|[r, g, b, _]| {
        for channel in [r, g, b] {
            *channel = shoulder(*channel);
        }
    });
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
