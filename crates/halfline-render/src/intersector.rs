//! Who says what a picture's rays hit: the scene itself, unless somebody puts another in its place, to
//! judge it or to hold a stopwatch.

use halfline::Scene;
use halfline::geometry::{Hit, Ray};

/// Answers the rays of a picture, a few thousand at a time; all threads ask at once.
pub trait Intersector: Sync {
    /// The closest hit of each ray.
    fn closest(&self, rays: &[Ray]) -> Vec<Hit>;

    /// Whether each ray hits anything.
    fn occluded(&self, rays: &[Ray]) -> Vec<bool>;
}

impl Intersector for Scene {
    fn closest(&self, rays: &[Ray]) -> Vec<Hit> {
        self.intersect(rays)
    }

    fn occluded(&self, rays: &[Ray]) -> Vec<bool> {
        Scene::occluded(self, rays)
    }
}
