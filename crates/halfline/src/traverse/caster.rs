//! One ray after another.

use super::leaf_test::Watertight;
use super::query::{AllContacts, AnyHit, ClosestHit, Query};
use super::walk::{RayCounters, Stack, walk};
use crate::geometry::{Hit, Ray};
use crate::mesh::Mesh;
use crate::numeric::PreparedRay;
use crate::tree::KdTree;

/// Casts one ray after another at a scene: [`Scene::caster`](crate::Scene::caster) gives one.
///
/// It holds what a walk through the tree needs besides the tree, so casting allocates and clears
/// nothing; each thread needs one of its own.
pub struct Caster<'scene> {
    tree: &'scene KdTree,
    mesh: &'scene Mesh,
    stack: Stack,
    all: AllContacts,
}

impl<'scene> Caster<'scene> {
    pub(crate) fn new(tree: &'scene KdTree, mesh: &'scene Mesh) -> Caster<'scene> {
        Caster { tree, mesh, stack: Stack::default(), all: AllContacts::default() }
    }

    /// The hit with the smallest t; of equal ones that with the lowest face index.
    pub fn closest(&mut self, ray: &Ray) -> Hit {
        self.closest_counted(ray, &mut RayCounters::default())
    }

    /// [`Caster::closest`], adding what it cost to `counters`.
    pub fn closest_counted(&mut self, ray: &Ray, counters: &mut RayCounters) -> Hit {
        let Some(prepared) = PreparedRay::new(ray) else { return Hit::MISS };
        let mut closest = ClosestHit::default();
        walk::<Watertight, _>(
            self.tree,
            self.mesh,
            ray,
            &prepared,
            &mut closest,
            &mut self.stack,
            counters,
        );
        closest.finish(&prepared)
    }

    /// True if the ray hits anything.
    pub fn any(&mut self, ray: &Ray) -> bool {
        let Some(prepared) = PreparedRay::new(ray) else { return false };
        let mut any = AnyHit::default();
        let counters = &mut RayCounters::default();
        walk::<Watertight, _>(
            self.tree,
            self.mesh,
            ray,
            &prepared,
            &mut any,
            &mut self.stack,
            counters,
        );
        any.found
    }

    /// Appends all hits to `hits`, sorted by t and then by face; see [`numeric`](crate::numeric).
    pub fn all(&mut self, ray: &Ray, hits: &mut Vec<Hit>) {
        let Some(prepared) = PreparedRay::new(ray) else { return };
        let counters = &mut RayCounters::default();
        self.all.restart();
        walk::<Watertight, _>(
            self.tree,
            self.mesh,
            ray,
            &prepared,
            &mut self.all,
            &mut self.stack,
            counters,
        );
        hits.extend_from_slice(self.all.finish(&prepared, self.tree, self.mesh));
    }
}
