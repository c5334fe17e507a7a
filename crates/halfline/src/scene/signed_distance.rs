//! Signed distances: how far from the surface, and on which side of it.

use super::Observed;
use crate::error::Result;
use crate::geometry::{ClosestPoint, Vec3};
use crate::nearest::ClosestPointColumns;
use crate::rays::{Scalars, Vectors};
use crate::winding::Inside;

impl Observed<'_> {
    /// The distance of each point from the surface, for points in columns: that of the closest point, negative where
    /// the winding number says inside, zero on the surface, infinite where there is no face, and NaN for a point that
    /// is not finite.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells; [`Error::Invalid`](crate::Error::Invalid) if there are not as many points as places.
    pub fn signed_distances_columns(&self, points: Vectors, distances: &mut [f64]) -> Result<()> {
        let count = distances.len();
        let mut is_inside = vec![false; count];
        self.contains_columns(points, Inside::Winding, &mut is_inside)?;
        let nowhere = ClosestPoint::NONE;
        let mut point = vec![nowhere.point.to_array(); count];
        let (mut face, mut uv, mut feature) =
            (vec![-1; count], vec![[f64::NAN; 2]; count], vec![0; count]);
        let closest = ClosestPointColumns {
            distance: &mut *distances,
            point: &mut point,
            face: &mut face,
            uv: &mut uv,
            feature: &mut feature,
        };
        self.closest_points_columns(points, Scalars::Same(f64::INFINITY), closest)?;
        for (number, (distance, is_inside)) in distances.iter_mut().zip(is_inside).enumerate() {
            if is_inside && *distance > 0.0 {
                *distance = -*distance;
            }
            if !Vec3::from(points.at(number)).is_finite() {
                *distance = f64::NAN;
            }
        }
        Ok(())
    }
}
