//! The closest points of a batch.

use super::{CHUNK, PLACES, in_ranges};
use crate::error::Result;
use crate::geometry::{ClosestPoint, Vec3};
use crate::nearest::{
    Answers, ClosestPointColumns, PointSource, PointVisit, Surface, answer_all, record_visits,
};
use crate::progress::Observer;
use crate::rays::{Scalars, Vectors};
use crate::traverse::CancelCheck;

/// The closest point for each point, put into the same place.
pub fn closest_points(
    surface: Surface,
    (points, max_distance): (&[Vec3], f64),
    places: &mut [ClosestPoint],
    observer: &dyn Observer,
) -> Result<()> {
    assert_eq!(places.len(), points.len(), "{PLACES}");
    let source = PointSource::rows(points, max_distance);
    answer(surface, source, Answers::Rows(places), observer)
}

/// The closest point for each point, put into columns.
pub fn closest_points_columns(
    surface: Surface,
    (points, max_distance): (Vectors, Scalars),
    columns: ClosestPointColumns,
    observer: &dyn Observer,
) -> Result<()> {
    let ClosestPointColumns { distance, point, face, uv, feature } = &columns;
    let count = distance.len();
    assert_eq!([point.len(), face.len(), uv.len(), feature.len()], [count; 4], "{PLACES}");
    points.check("points", count)?;
    max_distance.check("max_distance", count)?;
    let source = PointSource::columns(points, max_distance);
    answer(surface, source, Answers::Columns(columns), observer)
}

/// The closest point for one point, which is finite, and what its walk comes to, in order.
pub fn record_point_visits(
    surface: Surface,
    point: Vec3,
    observer: &dyn Observer,
) -> Result<(ClosestPoint, Vec<PointVisit>)> {
    let recorded = record_visits(surface, point, &mut CancelCheck::new(observer));
    observer.check()?;
    Ok(recorded)
}

fn answer(
    surface: Surface,
    source: PointSource,
    answers: Answers,
    observer: &dyn Observer,
) -> Result<()> {
    let count = answers.len();
    let parts = answers.chunks(CHUNK);
    in_ranges(surface.target, (count, CHUNK), parts, observer, |target, numbers, part| {
        let surface = Surface { target, ..surface };
        answer_all(surface, source.slice(numbers), part, &mut CancelCheck::new(observer));
    })?;
    Ok(())
}
