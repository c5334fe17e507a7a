//! obvhs, the quickest of the tree libraries on crates.io, with both of its trees.

use std::time::Duration;

use glam::{Vec3A, vec3a};
use halfline::{HitF32, RayF32};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;

use crate::embree::SingleMesh;

/// A mesh with a binary tree and one of eight compressed children a node.
pub struct Obvhs {
    binary: Bvh2,
    wide: CwBvh,
    /// The triangles in the order of each tree, as its author advises.
    of_binary: Vec<Triangle>,
    of_wide: Vec<Triangle>,
}

/// Which tree is asked.
#[derive(Clone, Copy, Debug)]
pub enum Tree {
    Binary,
    Wide,
}

fn ray(ray: &RayF32) -> Ray {
    Ray::new(Vec3A::from(ray.origin), Vec3A::from(ray.direction), ray.t_min, ray.t_max)
}

impl Obvhs {
    /// Builds both trees as well as is practical.
    pub fn new(mesh: &SingleMesh) -> Obvhs {
        let corner = |i: u32| {
            let [x, y, z] = mesh.positions[i as usize];
            vec3a(x, y, z)
        };
        let triangles: Vec<Triangle> = mesh
            .triangles
            .iter()
            .map(|&[a, b, c]| Triangle { v0: corner(a), v1: corner(b), v2: corner(c) })
            .collect();
        let build = BvhBuildParams::slow_build();
        let binary = build_bvh2_from_tris(&triangles, build, &mut Duration::default());
        let wide = build_cwbvh_from_tris(&triangles, build, &mut Duration::default());
        let ordered = |indices: &[u32]| indices.iter().map(|&i| triangles[i as usize]).collect();
        let of_binary = ordered(&binary.primitive_indices);
        let of_wide = ordered(&wide.primitive_indices);
        Obvhs { binary, wide, of_binary, of_wide }
    }

    /// The closest hit of each ray.
    pub fn intersect(&self, tree: Tree, rays: &[RayF32], hits: &mut [HitF32]) {
        for (given, hit) in rays.iter().zip(hits) {
            let mut found = RayHit::none();
            match tree {
                Tree::Binary => {
                    let test = |ray: &Ray, id: usize| self.of_binary[id].intersect(ray);
                    let is_hit = self.binary.ray_traverse(ray(given), &mut found, test);
                    *hit = answer(is_hit, &found, &self.binary.primitive_indices);
                }
                Tree::Wide => {
                    let test = |ray: &Ray, id: usize| self.of_wide[id].intersect(ray);
                    let is_hit = self.wide.ray_traverse(ray(given), &mut found, test);
                    *hit = answer(is_hit, &found, &self.wide.primitive_indices);
                }
            }
        }
    }

    /// Whether each ray hits anything.
    pub fn occluded(&self, tree: Tree, rays: &[RayF32], flags: &mut [bool]) {
        for (given, flag) in rays.iter().zip(flags) {
            *flag = match tree {
                Tree::Binary => {
                    let test = |ray: &Ray, id: usize| self.of_binary[id].intersect(ray);
                    !self.binary.ray_traverse_miss(ray(given), test)
                }
                Tree::Wide => {
                    let test = |ray: &Ray, id: usize| self.of_wide[id].intersect(ray);
                    !self.wide.ray_traverse_miss(ray(given), test)
                }
            };
        }
    }
}

fn answer(is_hit: bool, found: &RayHit, indices: &[u32]) -> HitF32 {
    if !is_hit {
        return HitF32::MISS;
    }
    HitF32 { t: found.t, face: indices[found.primitive_id as usize] }
}
