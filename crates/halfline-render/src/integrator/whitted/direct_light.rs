//! The light that comes straight from lights, less what lies on its way.

use std::f64::consts::PI;

use halfline::error::Result;
use halfline::geometry::{Ray, Vec3};

use super::tree::Node;
use super::weights::{base_color, clear_share};
use super::{SMALLEST_WEIGHT, Whitted};
use crate::color::{Color, grey};
use crate::lights::{illuminate, is_soft};
use crate::optics::cross_boundary;
use crate::sampling::Sampler;
use crate::tracer::Tracer;
use crate::world::Surface;

/// Rays to a light that casts soft shadows, from what the eye sees directly.
const SOFT_SHADOW_RAYS: u32 = 2;

impl Whitted<'_> {
    /// Adds what comes straight from all lights to each node, one light after the other.
    pub(super) fn add_lights(
        &self,
        nodes: &mut [Node],
        samplers: &[Sampler],
        tracer: &mut Tracer,
    ) -> Result<()> {
        for light in 0..self.lights.len() {
            // Send rays to the light from where it shines on.
            let mut rays = Vec::new();
            let mut arriving = Vec::new();
            for (i, node) in nodes.iter_mut().enumerate().filter(|(_, node)| node.is_lit()) {
                self.send_light_rays(light, node, &samplers[node.sample], |ray, arrives| {
                    rays.push(ray);
                    arriving.push((i, arrives));
                });
            }
            tracer.counts.shadow += rays.len() as u64;

            // Add what is left of its light.
            let transmittances = self.transmittances(rays, tracer)?;
            for ((i, light), transmittance) in arriving.into_iter().zip(transmittances) {
                nodes[i].direct[0] += light * transmittance;
            }
        }
        Ok(())
    }

    /// Adds to a node what it would send back of a light's if nothing cast shadows, and gives `send`
    /// the rays on which nothing must be, each with its light.
    fn send_light_rays(
        &self,
        light: usize,
        node: &mut Node,
        sampler: &Sampler,
        mut send: impl FnMut(Ray, Color),
    ) {
        let dimension = node.first_dimension + light as u32;
        let light = &self.lights[light];
        let parts = if is_soft(light) && node.branch.depth == 0 { SOFT_SHADOW_RAYS } else { 1 };
        for part in 0..parts {
            let sample = sampler.square(dimension, part, parts);
            let at = &node.surface.at;
            let Some(incoming) = illuminate(light, at.point, sample) else { continue };
            let cosine = incoming.towards.dot(node.normal);
            if cosine <= 0.0 {
                continue;
            }
            let arrives = self.scattering(node, incoming.towards)
                * incoming.irradiance
                * (cosine / f64::from(parts));
            node.direct[1] += arrives;
            if incoming.towards.dot(at.normal) * node.normal.dot(at.normal) > 0.0 {
                let origin = at.origin_towards(incoming.towards);
                send(Ray::with_range(origin, incoming.towards, 0.0, incoming.distance), arrives);
            }
        }
    }

    /// How much of the light from `towards` a node sends on to the eye.
    fn scattering(&self, node: &Node, towards: Vec3) -> Color {
        match (&node.weights, &self.world.ground) {
            (Some(weights), _) => weights.scattering(towards, node.normal, node.incoming),
            (None, Some(ground)) => ground.color(node.surface.at.point) / PI,
            (None, None) => Vec3::ZERO,
        }
    }

    /// How much light of each colour passes along each ray, from a light to a surface.
    fn transmittances(&self, mut rays: Vec<Ray>, tracer: &Tracer) -> Result<Vec<Color>> {
        if !self.world.has_clear_material {
            let mut occluded = vec![false; rays.len()];
            tracer.occlude(&rays, &mut occluded)?;
            return Ok(occluded
                .into_iter()
                .map(|occluded| grey(if occluded { 0.0 } else { 1.0 }))
                .collect());
        }

        // Pass through one surface after the other, all rays together that have not come to an end.
        let mut passed = vec![grey(1.0); rays.len()];
        let mut under_way: Vec<usize> = (0..rays.len()).collect();
        for _ in 0..=self.max_depth {
            let surfaces = tracer.closest(&rays)?;
            let mut next = (Vec::new(), Vec::new());
            for ((ray, i), surface) in rays.into_iter().zip(under_way).zip(surfaces) {
                let Some(surface) = surface else { continue };
                passed[i] = self.pass_through(&surface, ray.direction, passed[i]);
                if passed[i].max_element() < SMALLEST_WEIGHT {
                    passed[i] = Vec3::ZERO;
                    continue;
                }
                let origin = surface.at.origin_towards(ray.direction);
                let reach = ray.t_max - surface.t;
                next.0.push(Ray::with_range(origin, ray.direction, 0.0, reach));
                next.1.push(i);
            }
            (rays, under_way) = next;
        }
        for i in under_way {
            passed[i] = Vec3::ZERO;
        }
        Ok(passed)
    }

    /// What is left of `light` once it has gone straight through `surface`.
    fn pass_through(&self, surface: &Surface, towards: Vec3, light: Color) -> Color {
        if surface.is_ground() {
            return Vec3::ZERO;
        }
        let material = self.world.material(surface);
        let clear = clear_share(&material);
        let normal = surface.normal_against(towards);
        let crossing = cross_boundary(towards, normal, f64::from(material.ior));
        light * base_color(&material) * (clear * (1.0 - crossing.reflectance))
    }
}
