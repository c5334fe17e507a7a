//! Winding numbers, and what is inside.

use super::{Observed, Scene, unobserved};
use crate::error::Result;
use crate::geometry::Vec3;
use crate::progress::NoProgress;
use crate::rays::{Column, Vectors};
use crate::winding::WindingTarget;
pub use crate::winding::{Boundary, Inside, WindingParts};

impl Scene {
    /// The winding number of each point, in parallel: how often the surface winds around it. Positive inside of
    /// a surface whose triangles run counter-clockwise, seen from outside.
    ///
    /// For a surface without a boundary, each of whose edges is traversed as often forwards as backwards, it is
    /// an exact integer; for others it is the sum of the triangles' solid angles over that of the sphere,
    /// within 1e-9. On the surface it is that of one of the sides, as the surface's crossings are counted
    /// ([`Scene::explain_winding`] tells which points are). Faces whose corners are not finite do not count; a
    /// point that is not finite has NaN.
    ///
    /// ```
    /// use halfline::{Mesh, Scene, vec3};
    ///
    /// // A tetrahedron, and the same without its last face.
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    /// let points = [vec3(0.1, 0.2, 0.3), vec3(1.0, 1.0, 1.0)];
    /// let scene = Scene::new(Mesh::new(corners, faces)?)?;
    /// assert_eq!(scene.winding_numbers(&points), [1.0, 0.0]);
    /// assert_eq!(scene.contains(&points), [true, false]);
    ///
    /// let open = Scene::new(Mesh::new(corners, faces[..3].to_vec())?)?;
    /// let numbers = open.winding_numbers(&points);
    /// assert!(0.5 < numbers[0] && numbers[0] < 1.0 && 0.0 < numbers[1] && numbers[1] < 0.5);
    /// assert_eq!(open.boundary().edge_count(), 3);
    /// # Ok::<(), halfline::Error>(())
    /// ```
    pub fn winding_numbers(&self, points: &[Vec3]) -> Vec<f64> {
        unobserved(self.observed(&NoProgress).winding_numbers(points))
    }

    /// For each point whether it is inside, in parallel: whether its winding number is above one half, decided
    /// with certainty, or whether it lies on the surface. Where the winding number is one half within the last
    /// bound of exact arithmetic on every edge of the boundary, it is not. A point that is not finite is not
    /// inside.
    pub fn contains(&self, points: &[Vec3]) -> Vec<bool> {
        unobserved(self.observed(&NoProgress).contains(points))
    }

    /// The parts of a point's winding number, and whether the point lies on the surface.
    pub fn explain_winding(&self, point: Vec3) -> WindingParts {
        unobserved(self.guarded(|| Ok(self.winding_target().explain(point))))
    }

    /// The mesh's boundary, on which the winding numbers of open surfaces depend: found when it is first asked
    /// for, or the first winding number is, and kept. All faces are looked at for that.
    pub fn boundary(&self) -> &Boundary {
        self.boundary.get_or_init(|| Boundary::new(&self.mesh))
    }

    fn winding_target(&self) -> WindingTarget<'_> {
        WindingTarget { target: self.target(), boundary: self.boundary() }
    }
}

impl Observed<'_> {
    /// Answers as [`Scene::winding_numbers`] does.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn winding_numbers(&self, points: &[Vec3]) -> Result<Vec<f64>> {
        let mut numbers = vec![0.0; points.len()];
        self.winding_numbers_columns(Column::F64(&rows(points)), &mut numbers)?;
        Ok(numbers)
    }

    /// Answers as [`Scene::contains`] does.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn contains(&self, points: &[Vec3]) -> Result<Vec<bool>> {
        let mut flags = vec![false; points.len()];
        self.contains_columns(Column::F64(&rows(points)), Inside::Winding, &mut flags)?;
        Ok(flags)
    }

    /// Answers as [`Scene::winding_numbers`] does, for points in columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells; [`Error::Invalid`](crate::Error::Invalid) if there are not as many points as places.
    pub fn winding_numbers_columns(&self, points: Vectors, numbers: &mut [f64]) -> Result<()> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| scene.winding_target().winding_numbers(points, numbers, observer))
    }

    /// Answers as [`Scene::contains`] does, by either rule, for points in columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells; [`Error::Invalid`](crate::Error::Invalid) if there are not as many points as places.
    pub fn contains_columns(
        &self,
        points: Vectors,
        rule: Inside,
        flags: &mut [bool],
    ) -> Result<()> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| scene.winding_target().contains(points, rule, flags, observer))
    }
}

fn rows(points: &[Vec3]) -> Vec<[f64; 3]> {
    points.iter().map(|point| point.to_array()).collect()
}
