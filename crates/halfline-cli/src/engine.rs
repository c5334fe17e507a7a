//! Who answers a batch of rays: the engine, or one of the two judges that it must agree with.

use halfline::error::Result;
use halfline::geometry::{Hit, Ray};
use halfline::mesh::Mesh;
use halfline::progress::{Observer, SharedProgress, Stage};
use halfline::{AllHits, Scene, brute_force, textbook};
use rayon::prelude::*;

/// Answers batches of rays, in parallel and in the rays' order, reporting [`Stage::Trace`].
pub trait Engine: Sync {
    /// The closest hit of each ray.
    fn closest(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<Hit>>;
    /// Whether each ray hits anything.
    fn any(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<bool>>;
    /// All hits of each ray.
    fn all(&self, rays: &[Ray], observer: &dyn Observer) -> Result<AllHits>;
}

impl Engine for Scene {
    fn closest(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<Hit>> {
        self.observed(observer).intersect(rays)
    }

    fn any(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<bool>> {
        self.observed(observer).occluded(rays)
    }

    fn all(&self, rays: &[Ray], observer: &dyn Observer) -> Result<AllHits> {
        self.observed(observer).intersect_all(rays)
    }
}

/// For all rays, for all triangles.
pub struct BruteForce<'mesh>(pub &'mesh Mesh);

impl Engine for BruteForce<'_> {
    fn closest(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<Hit>> {
        each(rays, observer, |ray| brute_force::closest(self.0, ray))
    }

    fn any(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<bool>> {
        each(rays, observer, |ray| brute_force::any(self.0, ray))
    }

    fn all(&self, rays: &[Ray], observer: &dyn Observer) -> Result<AllHits> {
        each_all(rays, observer, |ray, hits| brute_force::all(self.0, ray, hits))
    }
}

impl Engine for textbook::KdTree<'_> {
    fn closest(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<Hit>> {
        each(rays, observer, |ray| self.ray_tree_intersection(ray))
    }

    fn any(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<bool>> {
        each(rays, observer, |ray| textbook::KdTree::any(self, ray))
    }

    fn all(&self, rays: &[Ray], observer: &dyn Observer) -> Result<AllHits> {
        each_all(rays, observer, |ray, hits| textbook::KdTree::all(self, ray, hits))
    }
}

/// The judges know single rays only.
fn each<T: Send>(
    rays: &[Ray],
    observer: &dyn Observer,
    cast: impl Fn(&Ray) -> T + Sync,
) -> Result<Vec<T>> {
    let progress = SharedProgress::new(observer, Stage::Trace, rays.len());
    rays.par_iter()
        .map(|ray| {
            progress.check()?;
            let answer = cast(ray);
            progress.advance(1)?;
            Ok(answer)
        })
        .collect()
}

fn each_all(
    rays: &[Ray],
    observer: &dyn Observer,
    cast: impl Fn(&Ray, &mut Vec<Hit>) + Sync,
) -> Result<AllHits> {
    let hits_of_rays = each(rays, observer, |ray| {
        let mut hits = Vec::new();
        cast(ray, &mut hits);
        hits
    })?;
    let mut all = AllHits::default();
    for hits in hits_of_rays {
        all.push_row(hits);
    }
    Ok(all)
}
