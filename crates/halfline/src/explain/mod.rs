//! Why a ray hit what it hit, or nothing: its walk through the textbook's tree, step by step, and what
//! the engine did for the same answer.
//!
//! The textbook's cells are split only where the ray comes ([`Cells`]), so that a mesh of millions of
//! triangles is explained in seconds; they are those of [`textbook`](crate::textbook) to the bit.

mod cells;
mod engine_walk;
mod nearest_miss;
mod point;
mod rule;
mod slice;
mod verdict;
mod walk;

pub use cells::{Cell, Cells, Content, Side};
pub use engine_walk::{EngineContent, EngineStep, EngineWalk};
pub use nearest_miss::{NearestMiss, nearest_miss};
pub use point::{PointExplanation, PointStep};
pub use rule::{Rule, TRAVERSAL_COST};
pub use slice::{Point, Rectangle, Slice, SliceCell, SlicePlane};
pub use verdict::{Edge, TriangleTest, Verdict};
pub use walk::{Case, Step, Visit, Walk};

use crate::error::{Error, Result};
use crate::geometry::{Hit, Ray, Vec3};
use crate::numeric::PreparedRay;
use crate::progress::Observer;
use crate::scene::Scene;
use crate::textbook::Termination;

/// What became of a ray, and how.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// The ray.
    pub ray: Ray,
    /// Where the textbook splits cells.
    pub rule: Rule,
    /// When it stops.
    pub termination: Termination,
    /// The cells that the walk saw, by number: those that it came to, and their children. The root is
    /// cell 0.
    pub cells: Vec<Cell>,
    /// The textbook's walk.
    pub walk: Walk,
    /// The engine's walk.
    pub engine: EngineWalk,
    /// Triangles that brute force tests: all.
    pub triangle_count: usize,
    /// The closest hit, at which both walks end.
    pub hit: Hit,
    /// For a ray that hits nothing the triangle that it passes closest.
    pub nearest_miss: Option<NearestMiss>,
}

impl Scene {
    /// Explains what a ray hits, or why it hits nothing. It takes some passes over the mesh, and about
    /// 110 bytes for each triangle meanwhile.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a ray that hits nothing by definition ([`Ray::is_valid`]), which says why;
    /// [`Error::Interrupted`].
    pub fn explain(&self, ray: &Ray, rule: Rule, observer: &dyn Observer) -> Result<Explanation> {
        let prepared = check(ray)?;
        self.guarded(|| {
            let termination = Termination::automatic(self.mesh().triangle_count());
            let mut cells = Cells::new(self.mesh(), rule, termination, observer)?;
            let bounds = cells.get(0).bounds;
            let walk = Walk::through(&mut cells, ray, &prepared)?;
            let engine = EngineWalk::through(self, ray);
            let hit = engine.hit;
            let nearest_miss = match hit.is_hit() {
                true => None,
                false => nearest_miss(self.mesh(), ray, &bounds, observer)?,
            };
            Ok(Explanation {
                ray: *ray,
                rule,
                termination,
                cells: cells.into_cells(),
                walk,
                engine,
                triangle_count: self.mesh().triangle_count(),
                hit,
                nearest_miss,
            })
        })
    }
}

/// Prepares a ray, or says why it hits nothing whatever the mesh.
pub fn check(ray: &Ray) -> Result<PreparedRay> {
    let wrong = |reason: String| Err(Error::invalid("ray", reason + ": it hits nothing"));
    let Ray { origin, direction, t_min, t_max } = *ray;
    let text = |Vec3 { x, y, z }: Vec3| format!("{x}, {y}, {z}");
    if !origin.is_finite() {
        return wrong(format!("its origin {} is not finite", text(origin)));
    }
    if !direction.is_finite() {
        return wrong(format!("its direction {} is not finite", text(direction)));
    }
    if direction == Vec3::ZERO {
        return wrong("its direction is zero".into());
    }
    match PreparedRay::new(ray) {
        Some(prepared) => Ok(prepared),
        None => wrong(format!("its range from {t_min} to {t_max} is empty")),
    }
}
