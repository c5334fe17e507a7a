//! The trees of mirrored and refracted rays, of many samples at once.

use halfline::error::Result;
use halfline::geometry::{Ray, Vec3};

use super::super::{PrimaryHits, Radiance, dimension};
use super::weights::Weights;
use super::{SMALLEST_WEIGHT, Whitted};
use crate::color::{Color, grey};
use crate::lights::first_visible;
use crate::optics::reflect;
use crate::tracer::Tracer;
use crate::world::Surface;

/// A surface that light comes from.
pub(super) struct Node {
    /// Which of the samples it is a part of.
    pub(super) sample: usize,
    pub(super) branch: Branch,
    /// The direction of the ray that came here.
    pub(super) incoming: Vec3,
    pub(super) surface: Surface,
    /// The normal to shade with, towards where the ray came from.
    pub(super) normal: Vec3,
    /// What becomes of the light, at a point on the model; `None` on the ground.
    pub(super) weights: Option<Weights>,
    /// Where mirrored and refracted light comes from.
    pub(super) sources: [Source; 2],
    /// The first of the random numbers for the lights.
    pub(super) first_dimension: u32,
    /// What it sends back of what comes straight from lights, and what it would send back without shadows.
    pub(super) direct: [Color; 2],
    /// The light that the point sends on, once it is known.
    pub(super) radiance: Radiance,
}

/// Where in its tree a node is.
#[derive(Clone, Copy)]
pub(super) struct Branch {
    pub(super) depth: u32,
    /// How much of its light can reach the eye.
    weight: f64,
}

/// Where the light of a mirrored or refracted ray comes from.
pub(super) enum Source {
    /// From where nobody looked, since it would not be seen.
    NotFollowed,
    /// From a light or the surroundings.
    Light(Color),
    /// From this node.
    Node(usize),
}

/// Rays that leave the nodes of one depth.
#[derive(Default)]
struct Wave {
    rays: Vec<Ray>,
    /// For each ray the node, which of its sources it looks for, and the branch that it begins.
    ends: Vec<(usize, usize, Branch)>,
}

impl Node {
    /// True if what comes straight from lights shows on it.
    pub(super) fn is_lit(&self) -> bool {
        self.weights.as_ref().is_none_or(Weights::is_lit)
    }
}

impl Whitted<'_> {
    /// The trees of all primary_hits. Their roots come first, one for each, then depth after depth.
    pub(super) fn grow_trees(
        &self,
        primary_hits: PrimaryHits,
        tracer: &mut Tracer,
    ) -> Result<Vec<Node>> {
        let root = Branch { depth: 0, weight: 1.0 };
        let mut nodes: Vec<Node> = primary_hits
            .met()
            .map(|primary_hit| {
                self.node(primary_hit.number, root, primary_hit.ray.direction, *primary_hit.surface)
            })
            .collect();
        let roots = nodes.len();

        let mut first = 0;
        while first < nodes.len() {
            // Send rays on from all nodes of one depth.
            let mut wave = Wave::default();
            for i in first..nodes.len() {
                self.branch_out(i, &mut nodes[i], &mut wave, tracer);
            }
            first = nodes.len();

            // What they meet are those of the next.
            let surfaces = tracer.closest(&wave.rays)?;
            for ((ray, surface), end) in wave.rays.iter().zip(surfaces).zip(wave.ends) {
                let (parent, which, branch) = end;
                nodes[parent].sources[which] = if let Some((t, radiance)) =
                    first_visible(&self.lights, ray)
                    && surface.as_ref().is_none_or(|surface| t < surface.t)
                {
                    Source::Light(radiance)
                } else if let Some(surface) = surface {
                    nodes.push(self.node(nodes[parent].sample, branch, ray.direction, surface));
                    Source::Node(nodes.len() - 1)
                } else {
                    Source::Light(self.surroundings(ray.direction))
                };
            }
        }

        for root in 0..roots {
            self.number_dimensions(&mut nodes, root, dimension::PATHS);
        }
        Ok(nodes)
    }

    fn node(&self, sample: usize, branch: Branch, incoming: Vec3, surface: Surface) -> Node {
        let (normal, weights) = if surface.is_ground() {
            (surface.normal, None)
        } else {
            let normal = surface.normal_against(incoming);
            let material = self.world.material(&surface);
            (normal, Some(Weights::new(material, &surface, normal, incoming)))
        };
        Node {
            sample,
            branch,
            incoming,
            surface,
            normal,
            weights,
            sources: [Source::NotFollowed, Source::NotFollowed],
            first_dimension: 0,
            direct: [Vec3::ZERO; 2],
            radiance: Radiance::NONE,
        }
    }

    /// Sends on the mirrored and the refracted ray of node `i`, where they are worth it.
    fn branch_out(&self, i: usize, node: &mut Node, wave: &mut Wave, tracer: &mut Tracer) {
        let counts = &mut tracer.counts;
        let mirrored = match &node.weights {
            Some(weights) => weights.mirrored,
            None => grey(self.world.ground.as_ref().map_or(0.0, |ground| ground.reflectivity)),
        };
        if let Some(branch) = grow(node.branch, mirrored) {
            counts.reflection += 1;
            let mut direction = reflect(node.incoming, node.normal);
            if node.weights.is_some() {
                direction = outside(direction, &node.surface, node.normal);
            }
            self.follow(i, node, 0, direction, branch, wave);
        }
        if let Some(weights) = &node.weights
            && let Some(direction) = weights.refracted
            && let Some(branch) = grow(node.branch, weights.passed)
        {
            counts.refraction += 1;
            self.follow(i, node, 1, direction, branch, wave);
        }
    }

    fn follow(
        &self,
        i: usize,
        node: &mut Node,
        which: usize,
        direction: Vec3,
        branch: Branch,
        wave: &mut Wave,
    ) {
        if branch.depth > self.max_depth {
            node.sources[which] = Source::Light(self.surroundings(direction));
            return;
        }
        wave.rays.push(Ray::new(node.surface.at.origin_towards(direction), direction));
        wave.ends.push((i, which, branch));
    }

    /// Gives node `i` and those that follow it their random numbers, from dimension `next` on: a
    /// node's come before those of what it mirrors, and these before those of what lies behind it.
    /// Returns the first that is left.
    fn number_dimensions(&self, nodes: &mut [Node], i: usize, mut next: u32) -> u32 {
        if nodes[i].is_lit() {
            nodes[i].first_dimension = next;
            next += self.lights.len() as u32;
        }
        for which in 0..2 {
            if let Source::Node(child) = nodes[i].sources[which] {
                next = self.number_dimensions(nodes, child, next);
            }
        }
        next
    }
}

/// The branch that carries `share` of the light of `branch`; `None` if it is not worth it.
fn grow(branch: Branch, share: Color) -> Option<Branch> {
    let weight = branch.weight * share.max_element();
    (weight >= SMALLEST_WEIGHT).then_some(Branch { depth: branch.depth + 1, weight })
}

/// Keeps a direction mirrored at a smoothed normal on its side of the flat face.
fn outside(direction: Vec3, surface: &Surface, normal: Vec3) -> Vec3 {
    let flat = surface.at.normal;
    let flat = if normal.dot(flat) < 0.0 { -flat } else { flat };
    let below = direction.dot(flat);
    if below >= 0.0 { direction } else { (direction - flat * (2.0 * below)).normalized() }
}
