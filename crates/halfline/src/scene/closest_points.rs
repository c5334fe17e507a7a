//! The questions about points.

use super::{Observed, Scene, unobserved};
use crate::batch;
use crate::builder;
use crate::error::Result;
use crate::geometry::{ClosestPoint, Vec3};
use crate::nearest::{ClosestPointColumns, Surface};
use crate::progress::NoProgress;
use crate::rays::{Scalars, Vectors};

impl Scene {
    /// The point of the surface that is closest to each of some points, in parallel and in their order. The surface
    /// is all triangles with finite corners, their edges and corners included; one without area is the segment or
    /// point that it is. The closest face is that of exact arithmetic, of equally close ones the lowest, and what is
    /// told of the point is the nearest doubles. For a point that is not finite, and on a mesh without faces, it is
    /// [`ClosestPoint::NONE`].
    ///
    /// ```
    /// use halfline::geometry::Feature;
    /// use halfline::{Mesh, Scene, vec3};
    ///
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    /// let scene = Scene::new(Mesh::new(corners, [[0, 1, 2], [0, 2, 3]])?)?;
    /// let closest = scene.closest_points(&[vec3(0.75, 0.25, 2.0), vec3(4.0, 5.0, 0.0)]);
    /// assert_eq!((closest[0].distance, closest[0].face), (2.0, 0));
    /// assert_eq!((closest[0].point, closest[0].feature), (vec3(0.75, 0.25, 0.0), Feature::Face));
    /// assert_eq!((closest[1].distance, closest[1].feature), (5.0, Feature::Vertex));
    /// # Ok::<(), halfline::Error>(())
    /// ```
    pub fn closest_points(&self, points: &[Vec3]) -> Vec<ClosestPoint> {
        unobserved(self.observed(&NoProgress).closest_points(points, f64::INFINITY))
    }

    /// What points are held against. The first time it makes the tree over the faces without area, if the mesh has
    /// some.
    pub(super) fn surface(&self) -> Result<Surface<'_>> {
        let Scene { mesh, tree, parameters, level, without_area, .. } = self;
        if tree.skipped_zero_area > 0 && without_area.get().is_none() {
            // Another thread may have been first, with the same tree.
            let built = builder::build_without_area(mesh, parameters, *level)?;
            without_area.get_or_init(|| built);
        }
        Ok(Surface { target: self.target(), without_area: without_area.get() })
    }
}

impl Observed<'_> {
    /// Answers as [`Scene::closest_points`] does, and with [`ClosestPoint::NONE`] where the distance, as the double
    /// that it is told as, is larger than `max_distance`, or this is negative or not a number.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn closest_points(&self, points: &[Vec3], max_distance: f64) -> Result<Vec<ClosestPoint>> {
        let Observed { scene, observer } = *self;
        let mut closest = vec![ClosestPoint::NONE; points.len()];
        scene.guarded(|| {
            let surface = scene.surface()?;
            batch::closest_points(surface, (points, max_distance), &mut closest, observer)
        })?;
        Ok(closest)
    }

    /// Answers as [`Observed::closest_points`] does, for points and answers in columns: as many points as there are
    /// places.
    ///
    /// # Errors
    /// [`Error::Invalid`](crate::Error::Invalid) if a column that is not the same for all has another number of
    /// entries; [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn closest_points_columns(
        &self,
        points: Vectors,
        max_distance: Scalars,
        closest: ClosestPointColumns,
    ) -> Result<()> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| {
            let surface = scene.surface()?;
            batch::closest_points_columns(surface, (points, max_distance), closest, observer)
        })
    }
}
