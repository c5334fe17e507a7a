//! What users hold: a mesh with its tree, and the questions one can ask it.

use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::{Hit, Ray};
use crate::mesh::Mesh;
use crate::progress::{Observer, Silent, Stage};

/// What casting one ray cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounters {
    /// Tree nodes visited, leaves included.
    pub nodes: u32,
    /// Leaves visited.
    pub leaves: u32,
    /// Triangles tested.
    pub triangles: u32,
}

/// Every hit of each ray of a batch, in compressed sparse rows: the hits of ray i are
/// `hits[splits[i]..splits[i + 1]]`, sorted by t and then by face.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllHits {
    /// One more entry than there are rays.
    pub splits: Vec<usize>,
    /// The hits.
    pub hits: Vec<Hit>,
}

/// A mesh and the kd-tree over it.
pub struct Scene {
    mesh: Mesh,
}

impl Scene {
    /// Builds the tree over `mesh` with default parameters.
    pub fn new(mesh: Mesh) -> Result<Scene> {
        Scene::build(mesh, &Silent)
    }

    /// Builds the tree over `mesh`, reporting [`Stage::Build`] to `observer`.
    pub fn build(mesh: Mesh, _observer: &dyn Observer) -> Result<Scene> {
        Ok(Scene { mesh })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The hit with the smallest t of one ray; of equal ones that with the lowest face index.
    pub fn closest(&self, ray: &Ray) -> Hit {
        self.closest_counted(ray, &mut RayCounters::default())
    }

    /// [`Scene::closest`], adding what it cost to `counters`.
    pub fn closest_counted(&self, ray: &Ray, counters: &mut RayCounters) -> Hit {
        // PLACEHOLDER until the tree lands.
        let mut best = Hit::MISS;
        for face in 0..self.mesh.triangle_count() as u32 {
            counters.triangles += 1;
            let [a, b, c] = self.mesh.corners(face);
            let (e1, e2) = (b - a, c - a);
            let p = ray.direction.cross(e2);
            let det = e1.dot(p);
            let s = ray.origin - a;
            let u = s.dot(p) / det;
            let q = s.cross(e1);
            let v = ray.direction.dot(q) / det;
            let t = e2.dot(q) / det;
            if u >= 0.0
                && v >= 0.0
                && u + v <= 1.0
                && t >= ray.t_min
                && t <= ray.t_max
                && t < best.t
            {
                best = Hit { t, face, u, v };
            }
        }
        best
    }

    /// True if one ray hits anything.
    pub fn any(&self, ray: &Ray) -> bool {
        self.closest(ray).is_hit()
    }

    /// The closest hit of each ray, in parallel; the result does not depend on the threads.
    pub fn intersect(&self, rays: &[Ray]) -> Vec<Hit> {
        rays.par_iter().map(|ray| self.closest(ray)).collect()
    }

    /// [`Scene::intersect`], reporting [`Stage::Trace`] in rays to `observer`.
    pub fn intersect_observed(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<Hit>> {
        observer.report(Stage::Trace, rays.len() as u64, rays.len() as u64);
        Ok(self.intersect(rays))
    }

    /// For each ray whether it hits anything.
    pub fn occluded(&self, rays: &[Ray]) -> Vec<bool> {
        rays.par_iter().map(|ray| self.any(ray)).collect()
    }
}
