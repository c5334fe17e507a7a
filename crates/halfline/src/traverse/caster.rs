//! One ray at a time.

use super::query::{AllCrossings, AnyHit, ClosestHit};
use super::walk::{RayCounters, Stack, walk};
use crate::geometry::{Hit, Ray};
use crate::mesh::Mesh;
use crate::tree::KdTree;

/// The closest hit, adding what it cost to `counters`.
pub fn closest(
    tree: &KdTree,
    mesh: &Mesh,
    ray: &Ray,
    stack: &mut Stack,
    counters: &mut RayCounters,
) -> Hit {
    let mut closest = ClosestHit::default();
    walk(tree, mesh, ray, &mut closest, stack, counters);
    closest.finish(ray, mesh)
}

/// True if the ray hits anything.
pub fn any(tree: &KdTree, mesh: &Mesh, ray: &Ray, stack: &mut Stack) -> bool {
    let mut any = AnyHit::default();
    walk(tree, mesh, ray, &mut any, stack, &mut RayCounters::default());
    any.found
}

/// Appends every crossing to `hits`, sorted by t and then by face.
pub fn all(tree: &KdTree, mesh: &Mesh, ray: &Ray, stack: &mut Stack, hits: &mut Vec<Hit>) {
    let mut all = AllCrossings::appending_to(hits);
    walk(tree, mesh, ray, &mut all, stack, &mut RayCounters::default());
    all.finish();
}
