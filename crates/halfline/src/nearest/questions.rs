//! Where points come from and where answers go.

use std::ops::Range;

use crate::geometry::{ClosestPoint, Vec3};
use crate::rays::{Scalars, Vectors};

/// Points by number, and how far away what is nearest may be.
#[derive(Clone, Copy)]
pub struct PointSource<'a> {
    points: Points<'a>,
    max_distance: Scalars<'a>,
}

#[derive(Clone, Copy)]
enum Points<'a> {
    Rows(&'a [Vec3]),
    Columns(Vectors<'a>),
}

impl<'a> PointSource<'a> {
    /// Points of a slice.
    pub fn rows(points: &'a [Vec3], max_distance: f64) -> PointSource<'a> {
        PointSource { points: Points::Rows(points), max_distance: Scalars::Same(max_distance) }
    }

    /// Points in a column.
    pub fn columns(points: Vectors<'a>, max_distance: Scalars<'a>) -> PointSource<'a> {
        PointSource { points: Points::Columns(points), max_distance }
    }

    /// Some of the points, numbered from zero.
    pub fn slice(&self, numbers: Range<usize>) -> PointSource<'a> {
        let points = match self.points {
            Points::Rows(points) => Points::Rows(&points[numbers.clone()]),
            Points::Columns(points) => Points::Columns(points.slice(numbers.clone())),
        };
        PointSource { points, max_distance: self.max_distance.slice(numbers) }
    }

    /// A point, and the largest distance that counts; `None` if by definition nothing is near it: for points that
    /// are not finite, and distances that are negative or not a number.
    #[inline]
    pub fn at(&self, number: usize) -> Option<(Vec3, f64)> {
        let point = match self.points {
            Points::Rows(points) => points[number],
            Points::Columns(points) => points.at(number).into(),
        };
        let max_distance = self.max_distance.at(number);
        (point.is_finite() && max_distance >= 0.0).then_some((point, max_distance))
    }
}

/// Where closest points go, an entry of each for each point: what the fields of [`ClosestPoint`] mean, but that
/// the face is -1 where there is none.
#[derive(Debug)]
pub struct ClosestPointColumns<'a> {
    /// Distances; infinite where there is no closest point.
    pub distance: &'a mut [f64],
    /// The closest points; not a number where there is none.
    pub point: &'a mut [[f64; 3]],
    /// Indices of triangles.
    pub face: &'a mut [i64],
    /// Barycentric weights of the triangles' second and third vertices; not a number where there is none.
    pub uv: &'a mut [[f64; 2]],
    /// In which part of the triangle, as [`Feature`](crate::geometry::Feature) counts them.
    pub feature: &'a mut [u8],
}

/// Places for answers, by the number of the point.
pub enum Answers<'a> {
    /// Rows.
    Rows(&'a mut [ClosestPoint]),
    /// Columns.
    Columns(ClosestPointColumns<'a>),
}

impl<'a> Answers<'a> {
    /// How many places there are.
    pub fn len(&self) -> usize {
        match self {
            Answers::Rows(rows) => rows.len(),
            Answers::Columns(columns) => columns.distance.len(),
        }
    }

    /// Puts an answer.
    #[inline]
    pub fn put(&mut self, number: usize, answer: &ClosestPoint) {
        match self {
            Answers::Rows(rows) => rows[number] = *answer,
            Answers::Columns(columns) => {
                columns.distance[number] = answer.distance;
                columns.point[number] = answer.point.to_array();
                columns.face[number] = if answer.is_found() { answer.face.into() } else { -1 };
                columns.uv[number] = [answer.u, answer.v];
                columns.feature[number] = answer.feature as u8;
            }
        }
    }

    /// The places of each chunk of so many points.
    pub fn chunks(self, chunk: usize) -> Vec<Answers<'a>> {
        match self {
            Answers::Rows(rows) => rows.chunks_mut(chunk).map(Answers::Rows).collect(),
            Answers::Columns(ClosestPointColumns { distance, point, face, uv, feature }) => {
                let parts = distance.chunks_mut(chunk).zip(point.chunks_mut(chunk));
                let parts = parts.zip(face.chunks_mut(chunk)).zip(uv.chunks_mut(chunk));
                let parts = parts.zip(feature.chunks_mut(chunk));
                let columns = parts.map(|((((distance, point), face), uv), feature)| {
                    Answers::Columns(ClosestPointColumns { distance, point, face, uv, feature })
                });
                columns.collect()
            }
        }
    }
}
