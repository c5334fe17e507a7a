//! Lights, shadows, mirrors and glass.
//!
//! T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980: at each
//! surface the light of all lights that it sees, plus one ray in the mirror direction and one
//! refracted, and so on. Different from the paper: mirrored and refracted shares follow
//! Fresnel's equations, highlights are normalised (Blinn 1977), lights may have an area (Cook,
//! Porter, Carpenter 1984), rays to lights pass straight through glass and lose what it takes,
//! and a branch ends when what it could add would not be seen.
//!
//! Nor is a tree of rays followed branch by branch. The trees of many samples grow together, depth
//! by depth, each depth one wave of rays. No ray to a light changes how they grow, so those wait
//! until all have grown: then one wave for each light, and where there is glass, one for each surface
//! that light passes on its way.

mod direct_light;
mod tree;
mod weights;

use halfline::error::Result;
use halfline::geometry::Vec3;

use self::tree::{Node, Source};
use self::weights::Weights;
use super::{Integrator, PrimaryHits, Radiance};
use crate::color::Color;
use crate::ground::{GroundPlane, Paint};
use crate::settings::{Background, Light};
use crate::sky::{ambient, surroundings};
use crate::tracer::Tracer;
use crate::world::World;

/// A branch that can add less than half a step of an eight-bit display is not followed. Since
/// the weights of all branches of one depth add up to at most 1, this also bounds their number.
const SMALLEST_WEIGHT: f64 = 0.5 / 255.0;

/// Trees that grow together: few enough for their nodes to stay in a core's second cache, even in glass.
const ROOTS: usize = 1 << 8;

/// Share of the surroundings' light that reaches a surface; there is no other indirect light.
const AMBIENT: f64 = 0.35;

pub(crate) struct Whitted<'a> {
    pub(crate) world: &'a World<'a>,
    pub(crate) lights: Vec<Light>,
    pub(crate) background: Background,
    pub(crate) max_depth: u32,
}

impl Integrator for Whitted<'_> {
    fn radiances(&self, primary_hits: PrimaryHits, tracer: &mut Tracer) -> Result<Vec<Radiance>> {
        let mut radiances = Vec::with_capacity(primary_hits.rays.len());
        for part in primary_hits.parts(ROOTS) {
            radiances.extend(self.of_trees(part, tracer)?);
        }
        Ok(radiances)
    }
}

impl Whitted<'_> {
    /// The light of rays whose trees grow together.
    fn of_trees(&self, primary_hits: PrimaryHits, tracer: &mut Tracer) -> Result<Vec<Radiance>> {
        let mut nodes = self.grow_trees(primary_hits, tracer)?;
        self.add_lights(&mut nodes, primary_hits.samplers, tracer)?;

        // Children come after their parents: from the last to the first, what a node needs is known.
        for i in (0..nodes.len()).rev() {
            nodes[i].radiance = self.shade(&nodes[i], &nodes);
        }
        let mut roots = nodes.iter();
        Ok(primary_hits.each(|_| roots.next().expect("one for each primary_hit").radiance))
    }

    fn surroundings(&self, direction: Vec3) -> Color {
        surroundings(&self.background, direction.dot(self.world.up))
    }

    fn ambient(&self, normal: Vec3) -> Color {
        ambient(&self.background, normal.dot(self.world.up)) * AMBIENT
    }

    /// The light that leaves a node towards where its ray came from.
    fn shade(&self, node: &Node, nodes: &[Node]) -> Radiance {
        match (&node.weights, &self.world.ground) {
            (Some(weights), _) => Radiance::opaque(self.shade_model(node, weights, nodes)),
            (None, Some(ground)) => self.shade_ground(ground, node, nodes),
            (None, None) => unreachable!("what is not the model is the ground"),
        }
    }

    fn shade_model(&self, node: &Node, weights: &Weights, nodes: &[Node]) -> Color {
        let mut light = Vec3::ZERO;
        if weights.is_lit() {
            light += node.direct[0] + weights.diffuse() * self.ambient(node.normal);
        }
        let [mirrored, passed] = &node.sources;
        if let Some(arriving) = self.arriving(mirrored, nodes) {
            light += weights.mirrored * arriving;
        }
        if let Some(arriving) = self.arriving(passed, nodes) {
            light += weights.passed * arriving;
        }
        light
    }

    fn shade_ground(&self, ground: &GroundPlane, node: &Node, nodes: &[Node]) -> Radiance {
        let color = ground.color(node.surface.at.point);
        let ambient = color * self.ambient(node.normal);
        let [light, full] = node.direct.map(|direct| direct + ambient);
        let matte = match ground.paint {
            Paint::Shadow => {
                let kept = if full.y > 0.0 { light.y / full.y } else { 1.0 };
                Radiance { color: Vec3::ZERO, alpha: 1.0 - kept }
            }
            Paint::Checker(..) => Radiance::opaque(light),
        };
        let share = ground.reflectivity;
        let mut radiance = matte.faded(1.0 - share);
        if let Some(arriving) = self.arriving(&node.sources[0], nodes) {
            radiance.color += arriving * share;
            radiance.alpha += share;
        }
        radiance.faded(ground.opacity(node.surface.at.point))
    }

    /// The light that comes along a mirrored or refracted ray; `None` if it was not followed.
    fn arriving(&self, source: &Source, nodes: &[Node]) -> Option<Color> {
        match *source {
            Source::NotFollowed => None,
            Source::Light(light) => Some(light),
            Source::Node(i) => {
                let node = &nodes[i];
                Some(node.radiance.over(self.surroundings(node.incoming)))
            }
        }
    }
}
