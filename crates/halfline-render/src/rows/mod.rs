//! Rows of a picture that were traced apart from the others.

mod bytes;

use std::fmt;
use std::ops::Range;

use halfline::Scene;
use halfline::error::{Error, Result};
use halfline::geometry::{Aabb, NO_FACE};

use crate::checksum::checksum;
use crate::image::Rendering;
use crate::settings::{RenderSettings, Shading};
use crate::statistics::RenderStatistics;

/// Neighbouring rows of a picture as [`Plan::trace_rows`](crate::Plan::trace_rows) gives them: without
/// their background, and without what only all rows together tell, the scales of
/// [`Shading::Depth`] and [`Shading::Steps`]. [`assemble`](crate::assemble) adds both.
#[derive(Clone, PartialEq)]
pub struct Rows {
    pub(crate) origin: Origin,
    pub(crate) first_row: u32,
    /// Height of the picture that the rows are of.
    pub(crate) picture_height: u32,
    /// The rows alone, unfinished.
    pub(crate) traced: Rendering,
}

/// What rows were traced of, as two fingerprints by which rows of different pictures are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Origin {
    pub(crate) settings: u64,
    pub(crate) scene: u64,
}

impl Rows {
    /// Which rows of the picture they are.
    pub fn range(&self) -> Range<u32> {
        self.first_row..self.first_row + self.traced.height
    }

    /// Width and height of the picture that they are of.
    pub fn picture_size(&self) -> (u32, u32) {
        (self.traced.width, self.picture_height)
    }

    /// What they cost.
    pub fn statistics(&self) -> &RenderStatistics {
        &self.traced.statistics
    }
}

impl fmt::Debug for Rows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Rows")
            .field("range", &self.range())
            .field("picture_size", &self.picture_size())
            .field("statistics", self.statistics())
            .finish_non_exhaustive()
    }
}

/// Tells settings apart, and versions, since another one may draw the same settings otherwise.
pub(crate) fn settings_fingerprint(settings: &RenderSettings) -> u64 {
    // The text holds every field, and every number so that it reads back as the same bits.
    checksum(format!("{} {settings:?}", env!("CARGO_PKG_VERSION")).as_bytes())
}

/// Tells scenes apart by their size and place: enough for a wrong file, at no cost.
pub(crate) fn scene_fingerprint(scene: &Scene, bounds: &Aabb) -> u64 {
    let mesh = scene.mesh();
    let counts = [mesh.triangle_count() as u64, mesh.positions().len() as u64];
    let corners = [bounds.min, bounds.max].map(|corner| corner.to_array().map(f64::to_bits));
    let numbers = counts.iter().chain(corners.as_flattened());
    checksum(&numbers.flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>())
}

/// So many rows of a picture, with nothing in them.
pub(crate) fn blank(settings: &RenderSettings, height: u32) -> Result<Rendering> {
    let width = settings.width;
    let pixels = width as usize * height as usize;
    let counts_steps = settings.shading == Shading::Steps;
    Ok(Rendering {
        width,
        height,
        color: layer(pixels, [0.0; 4])?,
        depth: layer(pixels, f32::INFINITY)?,
        normal: layer(pixels, [0.0; 3])?,
        face: layer(pixels, NO_FACE)?,
        steps: if counts_steps { Some(layer(pixels, [0.0; 2])?) } else { None },
        statistics: RenderStatistics::default(),
    })
}

fn layer<T: Clone>(pixels: usize, value: T) -> Result<Vec<T>> {
    let mut layer = Vec::new();
    layer.try_reserve_exact(pixels).map_err(|_| {
        Error::invalid("resolution", format!("no memory for a picture of {pixels} pixels"))
    })?;
    layer.resize(pixels, value);
    Ok(layer)
}
