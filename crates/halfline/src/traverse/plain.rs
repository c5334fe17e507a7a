//! The engine with the triangle test that others use, to measure what the exact one costs.
//!
//! T. Moller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 2 (1997), in
//! single precision, eight triangles at once. Rays slip through edges and vertices, and far
//! from the origin of the frame t is wrong by as much as single precision is.

use super::leaf_test::LeafTest;
use super::query::{AnyHit, ClosestHit, Query};
use super::walk::{RayCounters, Stack, walk};
use crate::geometry::{Hit, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{Contact, Orientation, PreparedRay, Touched};
use crate::tree::{BLOCK_SIZE, KdTree, LeafBlock};

/// A ray in the frame.
struct Plain {
    origin: [f32; 3],
    direction: [f32; 3],
    t_min: f32,
}

type Lanes = [f32; BLOCK_SIZE];

/// The cross product in each lane.
#[inline(always)]
fn cross(p: &[Lanes; 3], q: &[Lanes; 3]) -> [Lanes; 3] {
    let mut product = [[0.0; BLOCK_SIZE]; 3];
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        for lane in 0..BLOCK_SIZE {
            product[axis][lane] = p[next][lane] * q[last][lane] - p[last][lane] * q[next][lane];
        }
    }
    product
}

#[inline(always)]
fn dot(p: &[Lanes; 3], q: &[Lanes; 3]) -> Lanes {
    let mut product = [0.0; BLOCK_SIZE];
    for lane in 0..BLOCK_SIZE {
        product[lane] = p[0][lane] * q[0][lane] + p[1][lane] * q[1][lane] + p[2][lane] * q[2][lane];
    }
    product
}

#[inline(always)]
fn minus(p: &[Lanes; 3], q: &[Lanes; 3]) -> [Lanes; 3] {
    let mut difference = [[0.0; BLOCK_SIZE]; 3];
    for axis in 0..3 {
        for lane in 0..BLOCK_SIZE {
            difference[axis][lane] = p[axis][lane] - q[axis][lane];
        }
    }
    difference
}

impl LeafTest for Plain {
    #[inline]
    fn new(ray: &Ray, tree: &KdTree) -> Plain {
        let single = |v: Vec3| v.to_array().map(|x| x as f32);
        Plain {
            origin: single(tree.frame.point(ray.origin)),
            direction: single(ray.direction * tree.frame.scale()),
            t_min: ray.t_min as f32,
        }
    }

    #[inline]
    fn test<Q: Query>(
        &self,
        tree: &KdTree,
        _mesh: &Mesh,
        prepared: &PreparedRay,
        block: &LeafBlock,
        count: u32,
        query: &mut Q,
    ) {
        let [a, b, c] = &block.corners;
        let direction = self.direction.map(|x| [x; BLOCK_SIZE]);
        let origin = self.origin.map(|x| [x; BLOCK_SIZE]);
        let (ab, ac, ao) = (minus(b, a), minus(c, a), minus(&origin, a));
        let p = cross(&direction, &ac);
        let q = cross(&ao, &ab);
        let (determinant, u, v, t) =
            (dot(&ab, &p), dot(&ao, &p), dot(&direction, &q), dot(&ac, &q));
        let t_max = query.t_max(prepared.t_max) as f32;
        let mut bits = [0u32; BLOCK_SIZE];
        let mut parameter = [0.0f32; BLOCK_SIZE];
        for lane in 0..BLOCK_SIZE {
            let inverse = 1.0 / determinant[lane];
            let (u, v) = (u[lane] * inverse, v[lane] * inverse);
            parameter[lane] = t[lane] * inverse;
            let is_inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0);
            let is_hit = is_inside & (parameter[lane] >= self.t_min) & (parameter[lane] <= t_max);
            bits[lane] = if is_hit { 1 << lane } else { 0 };
        }
        let mut hits = bits.into_iter().fold(0, |all, bit| all | bit) & ((1 << count) - 1);
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let contact = Contact {
                t: f64::from(parameter[lane]),
                touched: Touched::Inside,
                is_crossing: true,
                orientation: Orientation::Front,
            };
            // Neither of the queries here looks at the corners.
            let corners = block.user_corners(&tree.frame, lane);
            query.offer(prepared, &contact, block.faces[lane], corners);
        }
    }
}

/// Casts one ray after another, as [`Caster`](super::Caster) does.
pub struct PlainCaster<'scene> {
    tree: &'scene KdTree,
    mesh: &'scene Mesh,
    stack: Stack,
}

impl<'scene> PlainCaster<'scene> {
    pub(crate) fn new(tree: &'scene KdTree, mesh: &'scene Mesh) -> PlainCaster<'scene> {
        PlainCaster { tree, mesh, stack: Stack::default() }
    }

    fn walk<Q: Query>(&mut self, ray: &Ray, query: &mut Q) {
        let Some(prepared) = PreparedRay::new(ray) else { return };
        let counters = &mut RayCounters::default();
        walk::<Plain, _>(self.tree, self.mesh, ray, &prepared, query, &mut self.stack, counters);
    }

    /// The closest hit, with u and v in plain double precision.
    pub fn closest(&mut self, ray: &Ray) -> Hit {
        let mut closest = ClosestHit::default();
        self.walk(ray, &mut closest);
        let nearest = closest.nearest();
        if !nearest.is_hit() {
            return Hit::MISS;
        }
        let [a, b, c] = self.mesh.corners(nearest.face);
        let (ab, ac, ao) = (b - a, c - a, ray.origin - a);
        let p = ray.direction.cross(ac);
        let inverse = 1.0 / ab.dot(p);
        let (u, v) = (ao.dot(p) * inverse, ray.direction.dot(ao.cross(ab)) * inverse);
        Hit { u, v, ..nearest }
    }

    /// Whether there is any hit.
    pub fn any(&mut self, ray: &Ray) -> bool {
        let mut any = AnyHit::default();
        self.walk(ray, &mut any);
        any.found
    }
}
