//! From points to their distances.

use std::ops::Range;
use std::path::Path;

use halfline::columns::{ClosestPointColumns, Column, Vectors};
use halfline::error::{Error, Result};
use halfline::mesh::Positions;
use halfline::progress::{Observer, Part};
use halfline::{Mesh, Scene};

use super::samples;
use crate::input;

/// Points measured at a time: enough to keep all threads busy, few enough that their nearest points,
/// which nobody wants, take no room beside the distances.
const BATCH: usize = 1 << 18;

/// What is measured.
pub enum Points<'a> {
    /// The vertices of a mesh.
    Vertices(&'a Positions),
    /// Points spread over its surface.
    Samples(Vec<[f64; 3]>),
}

impl<'a> Points<'a> {
    /// The vertices of `mesh`, which is known as `path`, or so many samples of its surface.
    ///
    /// # Errors
    /// If there is none.
    pub fn of(
        path: &Path,
        mesh: &'a Mesh,
        samples: Option<usize>,
        seed: u64,
    ) -> Result<Points<'a>> {
        let Some(count) = samples else {
            return match mesh.positions().is_empty() {
                true => Err(refused(path, "it has no vertices: there is nothing to measure")),
                false => Ok(Points::Vertices(mesh.positions())),
            };
        };
        check_faces(path, mesh)?;
        samples::spread(mesh, count, seed).map(Points::Samples).ok_or_else(|| {
            refused(path, "its area is zero or infinite: no samples can be spread over it")
        })
    }

    fn len(&self) -> usize {
        match self {
            Points::Vertices(positions) => positions.len(),
            Points::Samples(points) => points.len(),
        }
    }

    fn some(&self, range: Range<usize>) -> Vectors<'_> {
        match self {
            Points::Vertices(Positions::F32(points)) => Column::F32(&points[range]),
            Points::Vertices(Positions::F64(points)) => Column::F64(&points[range]),
            Points::Samples(points) => Column::F64(&points[range]),
        }
    }

    fn is_finite(&self, number: usize) -> bool {
        match self {
            Points::Vertices(positions) => positions.get(number).is_finite(),
            Points::Samples(points) => points[number].iter().all(|c| c.is_finite()),
        }
    }

    /// The distance of each point to the surface of `scene`, which is known as `other`; NaN of a point
    /// that is not finite.
    ///
    /// # Errors
    /// If there is no surface, and as the scene says.
    pub fn distances(
        &self,
        other: &Path,
        scene: &Scene,
        is_signed: bool,
        observer: &dyn Observer,
    ) -> Result<Vec<f64>> {
        let total = self.len();
        let mut distances = vec![f64::NAN; total];
        let mut nearest = Nearest::default();
        for (number, batch) in distances.chunks_mut(BATCH).enumerate() {
            let first = number * BATCH;
            let (before, share) = (first as u64, batch.len() as u64);
            let observer = Part { observer, before, share, total: total as u64 };
            let points = self.some(first..first + batch.len());
            let asked = scene.observed(&observer);
            match is_signed {
                true => asked.signed_distances_columns(points, batch)?,
                false => {
                    let nearest = nearest.columns(batch);
                    asked.closest_points_columns(points, Column::Same(f64::INFINITY), nearest)?;
                }
            }
            for (i, distance) in batch.iter_mut().enumerate() {
                if distance.is_finite() {
                    continue;
                }
                if self.is_finite(first + i) {
                    return Err(refused(other, "it has no face near enough for a finite distance"));
                }
                *distance = f64::NAN;
            }
        }
        Ok(distances)
    }
}

/// Room for what is found besides distances.
#[derive(Default)]
struct Nearest {
    point: Vec<[f64; 3]>,
    face: Vec<i64>,
    uv: Vec<[f64; 2]>,
    feature: Vec<u8>,
}

impl Nearest {
    fn columns<'a>(&'a mut self, distance: &'a mut [f64]) -> ClosestPointColumns<'a> {
        let count = distance.len();
        self.point.resize(count, [0.0; 3]);
        self.face.resize(count, 0);
        self.uv.resize(count, [0.0; 2]);
        self.feature.resize(count, 0);
        ClosestPointColumns {
            distance,
            point: &mut self.point,
            face: &mut self.face,
            uv: &mut self.uv,
            feature: &mut self.feature,
        }
    }
}

/// Refuses a mesh, known as `path`, that has no surface.
pub fn check_faces(path: &Path, mesh: &Mesh) -> Result<()> {
    match mesh.triangle_count() {
        0 => Err(refused(path, "it has no faces, and so no surface")),
        _ => Ok(()),
    }
}

/// The error about a mesh, known as `path`.
pub fn refused(path: &Path, reason: &str) -> Error {
    Error::invalid(input::name(path).display().to_string(), reason)
}
