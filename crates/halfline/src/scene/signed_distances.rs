//! Distances with the sign of the side.

use super::{Observed, Scene, unobserved};
use crate::error::Result;
use crate::geometry::Vec3;
use crate::nearest::ClosestPointColumns;
use crate::progress::{NoProgress, Part};
use crate::rays::{Column, Scalars, Vectors};
use crate::winding::Inside;

/// Points whose closest points are found at a time: enough to keep all threads busy, few enough that what is found
/// besides distances, and not asked for, takes no room beside them.
const BLOCK: usize = 1 << 18;

impl Scene {
    /// The distance of each point to the surface, in parallel: negative inside, where [`Scene::contains`] says so, and
    /// zero on it; infinite on a mesh without faces. A point that is not finite has NaN.
    ///
    /// ```
    /// use halfline::{Mesh, Scene, vec3};
    ///
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let mesh = Mesh::new(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
    /// let points = [vec3(0.25, 0.25, 0.125), vec3(0.25, 0.25, 0.0), vec3(0.25, 0.25, -2.0)];
    /// assert_eq!(Scene::new(mesh)?.signed_distances(&points), [-0.125, 0.0, 2.0]);
    /// # Ok::<(), halfline::Error>(())
    /// ```
    pub fn signed_distances(&self, points: &[Vec3]) -> Vec<f64> {
        let rows: Vec<[f64; 3]> = points.iter().map(|point| point.to_array()).collect();
        let mut distances = vec![f64::NAN; points.len()];
        let asked = self.observed(&NoProgress);
        unobserved(asked.signed_distances_columns(Column::F64(&rows), &mut distances));
        distances
    }
}

impl Observed<'_> {
    /// Answers as [`Scene::signed_distances`] does, for points in columns: as many as there are places.
    ///
    /// # Errors
    /// [`Error::Invalid`](crate::Error::Invalid) if a column that is not the same for all has another number of
    /// entries; [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn signed_distances_columns(&self, points: Vectors, distances: &mut [f64]) -> Result<()> {
        points.check("points", distances.len())?;
        let total = 2 * distances.len() as u64;
        let largest = BLOCK.min(distances.len());
        let (mut point, mut face) = (vec![[0.0; 3]; largest], vec![0; largest]);
        let (mut uv, mut feature) = (vec![[0.0; 2]; largest], vec![0; largest]);
        let mut inside = vec![false; largest];
        for (number, distance) in distances.chunks_mut(BLOCK).enumerate() {
            let (first, count) = (number * BLOCK, distance.len());
            let points = points.slice(first..first + count);
            let part = |before: usize| Part {
                observer: self.observer,
                before: before as u64,
                share: count as u64,
                total,
            };
            let closest = ClosestPointColumns {
                distance: &mut *distance,
                point: &mut point[..count],
                face: &mut face[..count],
                uv: &mut uv[..count],
                feature: &mut feature[..count],
            };
            let (closest_part, side_part) = (part(2 * first), part(2 * first + count));
            let (infinity, inside) = (Scalars::Same(f64::INFINITY), &mut inside[..count]);
            self.scene.observed(&closest_part).closest_points_columns(points, infinity, closest)?;
            self.scene.observed(&side_part).contains_columns(points, Inside::Winding, inside)?;
            for (i, distance) in distance.iter_mut().enumerate() {
                let is_finite = points.at(i).iter().all(|coordinate| coordinate.is_finite());
                // On the surface, which is inside, zero keeps its sign.
                *distance = match is_finite {
                    true if inside[i] && *distance > 0.0 => -*distance,
                    true => *distance,
                    false => f64::NAN,
                };
            }
        }
        Ok(())
    }
}
