//! Lights, shadows, mirrors and glass.
//!
//! T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980: at each
//! surface the light of all lamps that it sees, plus one ray in the mirror direction and one
//! refracted, and so on. Different from the paper: mirrored and refracted shares follow
//! Fresnel's equations, highlights are normalised (Blinn 1977), lamps may have an area (Cook,
//! Porter, Carpenter 1984), rays to lamps pass straight through glass and lose what it takes,
//! and a branch ends when what it could add would not be seen.

use std::f64::consts::PI;

use halfline::geometry::{Ray, Vec3};
use halfline::mesh::Material;

use super::{Integrator, Radiance, Sighting, dimension};
use crate::color::{Color, grey};
use crate::ground::{GroundPlane, Paint};
use crate::lights::{first_visible, illuminate, is_soft};
use crate::optics::{cross_boundary, metal_reflectance, reflect};
use crate::sampling::Sampler;
use crate::settings::{Background, Light};
use crate::sky::{ambient, surroundings};
use crate::tracer::Tracer;
use crate::world::{Surface, World};

/// A branch that can add less than half a step of an eight-bit display is not followed. Since
/// the weights of all branches of one depth add up to at most 1, this also bounds their number.
const SMALLEST_WEIGHT: f64 = 0.5 / 255.0;

/// Rays to a lamp that casts soft shadows, from what the eye sees directly.
const SOFT_SHADOW_RAYS: u32 = 2;

/// Share of the surroundings' light that reaches a surface; there is no other indirect light.
const AMBIENT: f64 = 0.35;

pub(crate) struct Whitted<'a> {
    pub(crate) world: &'a World<'a>,
    pub(crate) lights: Vec<Light>,
    pub(crate) background: Background,
    pub(crate) max_depth: u32,
}

/// The state of one sample's tree of rays.
struct Tree<'a, 'world> {
    sampler: &'a Sampler,
    tracer: &'a mut Tracer<'world>,
    next_dimension: u32,
}

/// Where in that tree.
#[derive(Clone, Copy)]
struct Branch {
    depth: u32,
    /// How much of its light can reach the eye.
    weight: f64,
}

impl Integrator for Whitted<'_> {
    fn radiance(&self, sighting: &Sighting, sampler: &Sampler, tracer: &mut Tracer) -> Radiance {
        let Some(surface) = sighting.surface else { return Radiance::NONE };
        let mut tree = Tree { sampler, tracer, next_dimension: dimension::PATHS };
        self.shade(sighting.ray, surface, Branch { depth: 0, weight: 1.0 }, &mut tree)
    }
}

impl Whitted<'_> {
    /// The light that comes along a mirrored or refracted ray.
    fn trace(&self, ray: &Ray, branch: Branch, tree: &mut Tree) -> Color {
        let surface = tree.tracer.closest(ray);
        if let Some((t, radiance)) = first_visible(&self.lights, ray)
            && surface.as_ref().is_none_or(|surface| t < surface.t)
        {
            return radiance;
        }
        let behind = self.surroundings(ray.direction);
        match surface {
            Some(surface) => self.shade(ray, &surface, branch, tree).over(behind),
            None => behind,
        }
    }

    fn surroundings(&self, direction: Vec3) -> Color {
        surroundings(&self.background, direction.dot(self.world.up))
    }

    fn shade(&self, ray: &Ray, surface: &Surface, branch: Branch, tree: &mut Tree) -> Radiance {
        match &self.world.ground {
            Some(ground) if surface.is_ground() => {
                self.shade_ground(ground, ray, surface, branch, tree)
            }
            _ => Radiance::opaque(self.shade_model(ray, surface, branch, tree)),
        }
    }

    fn shade_model(&self, ray: &Ray, surface: &Surface, branch: Branch, tree: &mut Tree) -> Color {
        let material = self.world.material(surface);
        let base = base_color(&material);
        let normal = surface.normal_against(ray.direction);
        let cosine = (-ray.direction.dot(normal)).clamp(0.0, 1.0);
        let metallic = f64::from(material.metallic);
        let clear = clear_share(&material);

        // Split the light: mirrored by metal or at a boundary, through the boundary, scattered.
        let ior = f64::from(material.ior);
        let enters = clear == 0.0 || ray.direction.dot(surface.at.normal) < 0.0;
        let crossing = cross_boundary(ray.direction, normal, if enters { ior } else { 1.0 / ior });
        let polish = polish(&material).max(clear);
        let fresnel = metal_reflectance(base, cosine) * metallic
            + grey((1.0 - metallic) * crossing.reflectance);
        let mirrored = fresnel * polish;
        let blurred = fresnel * (1.0 - polish);
        let passed = base * (clear * (1.0 - crossing.reflectance));
        let scattered = base * ((1.0 - metallic - clear) * (1.0 - crossing.reflectance)).max(0.0);

        // Add what the lamps and the surroundings give to the scattering part.
        let mut light = Vec3::ZERO;
        let diffuse = scattered + blurred;
        if diffuse.max_element() > 0.0 {
            let [lamps, _] = self.lamps(surface, normal, branch, tree, |towards| {
                let halfway = (towards - ray.direction).normalized();
                scattered / PI + blurred * highlight(&material, normal.dot(halfway))
            });
            light += lamps + diffuse * self.ambient(normal);
        }

        // Follow the mirrored ray and the refracted ray.
        if let Some(next) = self.grow(branch, mirrored) {
            let direction = outside(reflect(ray.direction, normal), surface, normal);
            tree.tracer.counts.reflection += 1;
            light += mirrored * self.follow(surface, direction, next, tree);
        }
        if crossing.reflectance < 1.0
            && let Some(next) = self.grow(branch, passed)
        {
            tree.tracer.counts.refraction += 1;
            light += passed * self.follow(surface, crossing.refracted, next, tree);
        }
        light
    }

    fn shade_ground(
        &self,
        ground: &GroundPlane,
        ray: &Ray,
        surface: &Surface,
        branch: Branch,
        tree: &mut Tree,
    ) -> Radiance {
        let normal = surface.normal;
        let color = ground.color(surface.at.point);
        let lights = self.lamps(surface, normal, branch, tree, |_| color / PI);
        let ambient = color * self.ambient(normal);
        let [light, full] = lights.map(|lamps| lamps + ambient);
        let matte = match ground.paint {
            Paint::Shadow => {
                let kept = if full.y > 0.0 { light.y / full.y } else { 1.0 };
                Radiance { color: Vec3::ZERO, alpha: 1.0 - kept }
            }
            Paint::Checker(..) => Radiance::opaque(light),
        };
        let share = ground.reflectivity;
        let mut radiance = matte.faded(1.0 - share);
        if let Some(next) = self.grow(branch, grey(share)) {
            let direction = reflect(ray.direction, normal);
            tree.tracer.counts.reflection += 1;
            radiance.color += self.follow(surface, direction, next, tree) * share;
            radiance.alpha += share;
        }
        radiance.faded(ground.opacity(surface.at.point))
    }

    /// The branch that carries `share` of the light of `branch`; `None` if it is not worth it.
    fn grow(&self, branch: Branch, share: Color) -> Option<Branch> {
        let weight = branch.weight * share.max_element();
        (weight >= SMALLEST_WEIGHT).then_some(Branch { depth: branch.depth + 1, weight })
    }

    fn follow(&self, surface: &Surface, direction: Vec3, branch: Branch, tree: &mut Tree) -> Color {
        if branch.depth > self.max_depth {
            return self.surroundings(direction);
        }
        let ray = Ray::new(surface.at.origin_towards(direction), direction);
        self.trace(&ray, branch, tree)
    }

    fn ambient(&self, normal: Vec3) -> Color {
        ambient(&self.background, normal.dot(self.world.up)) * AMBIENT
    }

    /// The light of all lamps that a surface sends back by `scattering`, and what it would send
    /// back if nothing cast shadows.
    fn lamps(
        &self,
        surface: &Surface,
        normal: Vec3,
        branch: Branch,
        tree: &mut Tree,
        scattering: impl Fn(Vec3) -> Color,
    ) -> [Color; 2] {
        let mut sum = [Vec3::ZERO; 2];
        for light in &self.lights {
            let parts = if is_soft(light) && branch.depth == 0 { SOFT_SHADOW_RAYS } else { 1 };
            let dimension = tree.next_dimension;
            tree.next_dimension += 1;
            for part in 0..parts {
                let sample = tree.sampler.square(dimension, part, parts);
                let Some(incoming) = illuminate(light, surface.at.point, sample) else { continue };
                let cosine = incoming.towards.dot(normal);
                if cosine <= 0.0 {
                    continue;
                }
                let light = scattering(incoming.towards)
                    * incoming.irradiance
                    * (cosine / f64::from(parts));
                sum[1] += light;
                let flat = surface.at.normal;
                if incoming.towards.dot(flat) * normal.dot(flat) > 0.0 {
                    tree.tracer.counts.shadow += 1;
                    sum[0] += light
                        * self.transmittance(
                            surface,
                            incoming.towards,
                            incoming.distance,
                            tree.tracer,
                        );
                }
            }
        }
        sum
    }

    /// How much light of each colour passes from a lamp to a surface.
    fn transmittance(
        &self,
        surface: &Surface,
        towards: Vec3,
        distance: f64,
        tracer: &mut Tracer,
    ) -> Color {
        let mut ray = Ray::with_range(surface.at.origin_towards(towards), towards, 0.0, distance);
        if !self.world.has_clear_material {
            return grey(if tracer.is_hidden(&ray) { 0.0 } else { 1.0 });
        }
        let mut passed = grey(1.0);
        for _ in 0..=self.max_depth {
            let Some(surface) = tracer.closest(&ray) else { return passed };
            if surface.is_ground() {
                return Vec3::ZERO;
            }
            let material = self.world.material(&surface);
            let clear = clear_share(&material);
            let crossing =
                cross_boundary(towards, surface.normal_against(towards), f64::from(material.ior));
            passed = passed * base_color(&material) * (clear * (1.0 - crossing.reflectance));
            if passed.max_element() < SMALLEST_WEIGHT {
                return Vec3::ZERO;
            }
            let origin = surface.at.origin_towards(towards);
            ray = Ray::with_range(origin, towards, 0.0, ray.t_max - surface.t);
        }
        Vec3::ZERO
    }
}

fn base_color(material: &Material) -> Color {
    let [r, g, b, _] = material.base_color;
    Vec3::from([r, g, b])
}

/// Share of the light that passes into the body and through it.
fn clear_share(material: &Material) -> f64 {
    f64::from(material.transmission) * (1.0 - f64::from(material.metallic))
}

/// Share of the mirrored light that stays sharp: a single ray cannot show a blurred mirror, so
/// with roughness the mirror image fades into the highlights of the lamps.
fn polish(material: &Material) -> f64 {
    (1.0 - f64::from(material.roughness)).powi(4)
}

/// The highlight for a cosine between the normal and the direction halfway between lamp and eye:
/// Blinn 1977, with the exponent that fits a roughness (Walter et al. 2007, section 5.2), and
/// normalised after Hoffman, "Physically-Based Shading Models in Film and Game Production", 2010.
fn highlight(material: &Material, cosine: f64) -> f64 {
    // The smallest roughness that highlights are drawn for: sharper ones are mirror images.
    let alpha = f64::from(material.roughness).max(0.1).powi(2);
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    (exponent + 8.0) / (8.0 * PI) * cosine.max(0.0).powf(exponent)
}

/// Keeps a direction mirrored at a smoothed normal on its side of the flat face.
fn outside(direction: Vec3, surface: &Surface, normal: Vec3) -> Vec3 {
    let flat = surface.at.normal;
    let flat = if normal.dot(flat) < 0.0 { -flat } else { flat };
    let below = direction.dot(flat);
    if below >= 0.0 { direction } else { (direction - flat * (2.0 * below)).normalized() }
}
