//! The engine with the triangle test that others use, to measure what the exact one costs.
//!
//! T. Moller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 2 (1997), in
//! single precision, eight triangles at once. Rays slip through edges and vertices, and far
//! from the origin of the frame t is wrong by as much as single precision is.

use super::leaf_test::LeafTest;
use super::query::Search;
use super::walk::{RayCounters, Stack, walk};
use crate::geometry::{Hit, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{PreparedRay, is_nearer};
use crate::tree::{BLOCK_SIZE, KdTree, LeafBlock};

/// A ray in the frame.
struct Plain {
    origin: [f32; 3],
    direction: [f32; 3],
    t_min: f32,
}

/// The nearest hit, or any.
struct Nearest<const IS_ANY: bool>(Hit, [Vec3; 3]);

impl<const IS_ANY: bool> Search for Nearest<IS_ANY> {
    #[inline]
    fn t_max(&self, ray_t_max: f64) -> f64 {
        if self.0.is_hit() { self.0.t } else { ray_t_max }
    }

    #[inline]
    fn is_done(&self) -> bool {
        IS_ANY && self.0.is_hit()
    }
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
fn sub(p: &[Lanes; 3], q: &[Lanes; 3]) -> [Lanes; 3] {
    let mut difference = [[0.0; BLOCK_SIZE]; 3];
    for axis in 0..3 {
        for lane in 0..BLOCK_SIZE {
            difference[axis][lane] = p[axis][lane] - q[axis][lane];
        }
    }
    difference
}

impl<const IS_ANY: bool> LeafTest<Nearest<IS_ANY>> for Plain {
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
    fn test(
        &self,
        tree: &KdTree,
        _mesh: &Mesh,
        prepared: &PreparedRay,
        block: &LeafBlock,
        count: u32,
        query: &mut Nearest<IS_ANY>,
    ) {
        let [a, b, c] = &block.corners;
        let direction = self.direction.map(|x| [x; BLOCK_SIZE]);
        let origin = self.origin.map(|x| [x; BLOCK_SIZE]);
        let (ab, ac, ao) = (sub(b, a), sub(c, a), sub(&origin, a));
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
            let hit = Hit { t: f64::from(parameter[lane]), face: block.faces[lane], ..Hit::MISS };
            if is_nearer(&hit, &query.0) {
                *query = Nearest(hit, block.user_corners(&tree.frame, lane));
            }
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

    fn walk<const IS_ANY: bool>(&mut self, ray: &Ray) -> Nearest<IS_ANY> {
        let mut query = Nearest(Hit::MISS, [Vec3::ZERO; 3]);
        let Some(prepared) = PreparedRay::new(ray) else { return query };
        let counters = &mut RayCounters::default();
        let stack = &mut self.stack;
        walk::<Plain, _>(self.tree, self.mesh, ray, &prepared, &mut query, stack, counters);
        query
    }

    /// The closest hit, with u and v in plain double precision.
    pub fn closest(&mut self, ray: &Ray) -> Hit {
        let Nearest(nearest, [a, b, c]) = self.walk::<false>(ray);
        if !nearest.is_hit() {
            return Hit::MISS;
        }
        let (ab, ac, ao) = (b - a, c - a, ray.origin - a);
        let p = ray.direction.cross(ac);
        let inverse = 1.0 / ab.dot(p);
        let (u, v) = (ao.dot(p) * inverse, ray.direction.dot(ao.cross(ab)) * inverse);
        Hit { u, v, ..nearest }
    }

    /// Whether there is any hit.
    pub fn any(&mut self, ray: &Ray) -> bool {
        self.walk::<true>(ray).0.is_hit()
    }
}
