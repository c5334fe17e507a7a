//! Why a point is as far from the surface as it is, and on which side: the engine's walk to what is nearest, the
//! nearest faces, and the parts of the winding number.

use super::engine_walk::{EngineContent, EngineStep, follow};
use crate::error::{Error, Result};
use crate::geometry::{Aabb, ClosestPoint, Vec3};
use crate::numeric::NearestPart;
use crate::progress::{Observer, SharedProgress, Stage};
use crate::scene::{Scene, WindingParts, inspect};
use crate::textbook::Visits;

/// Nearest faces that are told of.
const NEAREST: usize = 8;

/// What is nearest to a point, how that was found, and on which side the point is.
#[derive(Clone, Debug)]
pub struct PointExplanation {
    /// The point.
    pub point: Vec3,
    /// The closest point of the surface; [`ClosestPoint::NONE`] if there is no surface.
    pub closest: ClosestPoint,
    /// The nearest of the faces that the walk looked at, nearest first, of equally near ones the lowest first. The
    /// first is the nearest of all faces.
    pub nearest: Vec<ClosestPoint>,
    /// The nodes and leaves of the engine's tree that were opened, in order.
    pub steps: Vec<PointStep>,
    /// What it took; `nodes` includes the leaves.
    pub visits: Visits,
    /// Triangles that brute force looks at: all.
    pub triangle_count: usize,
    /// The box of the mesh.
    pub bounds: Aabb,
    /// True inside, and on the surface.
    pub is_inside: bool,
    /// The parts of the winding number.
    pub winding: WindingParts,
    /// How many edges the boundary has, of which one part of the winding number is.
    pub boundary_edges: usize,
}

/// A node or leaf that was opened.
#[derive(Clone, Debug, PartialEq)]
pub struct PointStep {
    /// The number of the node among the nodes, or of the leaf among the leaves.
    pub index: usize,
    /// Levels below the root.
    pub depth: usize,
    /// The box of what it holds, as the engine knows it: somewhat too large.
    pub bounds: Aabb,
    /// What is there.
    pub content: EngineContent,
    /// About the distance of the point to the box; 0 inside of it.
    pub distance: f64,
    /// About the distance beyond which nothing mattered any more when it was opened; infinite until a face was met.
    pub limit: f64,
}

impl PointExplanation {
    /// The distance, negative inside.
    pub fn signed_distance(&self) -> f64 {
        let distance = self.closest.distance;
        if self.is_inside && distance > 0.0 { -distance } else { distance }
    }
}

impl Scene {
    /// Explains what is nearest to a point, and on which side of the surface it is.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a point that is not finite; [`Error::Interrupted`].
    pub fn explain_point(&self, point: Vec3, observer: &dyn Observer) -> Result<PointExplanation> {
        if !point.is_finite() {
            let Vec3 { x, y, z } = point;
            let reason = format!("{x}, {y}, {z} is not finite: nothing is near it");
            return Err(Error::invalid("point", reason));
        }
        self.guarded(|| {
            let (closest, visits) = inspect::record_point_visits(self, point, observer)?;
            let places = visits.iter().map(|visit| (visit.place, visit.limit));
            let (steps, visits) = follow(self.tree(), places);
            let asked = self.observed(observer);
            let is_inside = asked.contains(&[point])?[0];
            Ok(PointExplanation {
                point,
                closest,
                nearest: nearest(self, point, &closest, &steps, observer)?,
                steps: steps.into_iter().map(|step| PointStep::of(point, step)).collect(),
                visits,
                triangle_count: self.mesh().triangle_count(),
                bounds: self.mesh().bounds(),
                is_inside,
                winding: self.explain_winding(point),
                boundary_edges: self.boundary().edge_count(),
            })
        })
    }
}

impl PointStep {
    fn of(point: Vec3, step: EngineStep) -> PointStep {
        let EngineStep { index, depth, bounds, content, t_limit: limit } = step;
        let beyond = |axis: usize| {
            (bounds.min[axis] - point[axis]).max(point[axis] - bounds.max[axis]).max(0.0)
        };
        let distance = Vec3::from([beyond(0), beyond(1), beyond(2)]).length();
        PointStep { index, depth, bounds, content, distance, limit }
    }
}

/// The nearest of the faces in the leaves of a walk, and that of `closest`.
fn nearest(
    scene: &Scene,
    point: Vec3,
    closest: &ClosestPoint,
    steps: &[EngineStep],
    observer: &dyn Observer,
) -> Result<Vec<ClosestPoint>> {
    let progress = SharedProgress::new(observer, Stage::Trace, steps.len());
    let mut nearest: Vec<NearestPart> = Vec::with_capacity(NEAREST + 1);
    let mut take = |face: u32| {
        let corners = scene.mesh().corners(face);
        // A face whose triangle was cut lies in several leaves.
        let is_known = nearest.iter().any(|part| part.face == face);
        if is_known || !corners.iter().all(|corner| corner.is_finite()) {
            return;
        }
        let part = NearestPart::of(point, face, corners);
        let place = nearest.iter().position(|other| part.is_before(point, other));
        nearest.insert(place.unwrap_or(nearest.len()), part);
        nearest.truncate(NEAREST);
    };
    // One without area is in no leaf.
    if closest.is_found() {
        take(closest.face);
    }
    for step in steps {
        if let EngineContent::Leaf { faces } = &step.content {
            faces.iter().copied().for_each(&mut take);
        }
        progress.advance(1)?;
    }
    Ok(nearest.iter().map(|part| part.closest_point(point)).collect())
}
