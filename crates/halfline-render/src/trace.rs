//! Rows traced in parallel, in bands as high as a tile.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use halfline::error::Result;
use halfline::progress::{Observer, Stage};
use rayon::prelude::*;

use crate::image::Rendering;
use crate::rows::blank;
use crate::statistics::{RayCounts, RenderStatistics};
use crate::tile::{BLOCK, Pixel, TileRenderer};
use crate::tracer::Tracer;
use crate::world::World;

/// Traces rows of a picture.
pub(crate) struct Job<'a> {
    pub(crate) tile_renderer: TileRenderer<'a>,
    pub(crate) world: &'a World<'a>,
    pub(crate) observer: &'a dyn Observer,
}

/// The pixels of as many neighbouring rows as a tile has, in each layer.
struct Band<'a> {
    first_row: usize,
    color: &'a mut [[f32; 4]],
    depth: &'a mut [f32],
    normal: &'a mut [[f32; 3]],
    face: &'a mut [u32],
    steps: Option<&'a mut [[f32; 2]]>,
}

impl Job<'_> {
    /// Some rows of the picture, without what is added once all of them are there.
    pub(crate) fn trace(&self, rows: Range<u32>) -> Result<Rendering> {
        let mut traced = blank(self.tile_renderer.settings, rows.end - rows.start)?;
        let total = traced.pixel_count() as u64;
        let done = AtomicU64::new(0);
        self.observer.report(Stage::Trace, 0, total);
        let start = Instant::now();
        let rays = bands(&mut traced, rows.start as usize)
            .into_par_iter()
            .map(|mut band| {
                let counts = self.trace_band(&mut band)?;
                let pixels = band.color.len() as u64;
                let now_done = done.fetch_add(pixels, Ordering::Relaxed) + pixels;
                self.observer.report(Stage::Trace, now_done, total);
                Ok(counts)
            })
            .try_reduce(RayCounts::default, |mut a, b| {
                a += b;
                Ok(a)
            })?;
        traced.statistics = RenderStatistics { rays, trace_seconds: start.elapsed().as_secs_f64() };
        Ok(traced)
    }

    fn trace_band(&self, band: &mut Band) -> Result<RayCounts> {
        let mut tracer = Tracer::new(self.world, self.observer);
        let width = self.tile_renderer.settings.width as usize;
        let rows = band.first_row..band.first_row + band.color.len() / width;
        let columns = self.tile_renderer.tile_columns();
        for first in (0..width).step_by(columns) {
            let columns = first..(first + columns).min(width);
            for pixel in self.tile_renderer.draw(columns, rows.clone(), &mut tracer)? {
                self.keep(&pixel, band);
            }
        }
        Ok(tracer.counts)
    }

    /// Puts `pixel` into the layers of its band.
    fn keep(&self, pixel: &Pixel, band: &mut Band) {
        let settings = self.tile_renderer.settings;
        let i = (pixel.row - band.first_row) * settings.width as usize + pixel.column;
        let count = f64::from(settings.samples);
        if pixel.sum.alpha > 0.0 {
            let [r, g, b] = (pixel.sum.color / pixel.sum.alpha).to_array().map(|v| v as f32);
            band.color[i] = [r, g, b, (pixel.sum.alpha / count) as f32];
        }
        if let Some(layer) = &mut band.steps {
            layer[i] = pixel.steps.map(|sum| (sum / count) as f32);
        }
        if let Some(middle) = &pixel.middle {
            band.depth[i] = middle.depth;
            band.normal[i] = middle.normal;
            band.face[i] = middle.face;
        }
    }
}

/// `traced` cut into bands; its first row is `first_row` of the picture.
fn bands(traced: &mut Rendering, first_row: usize) -> Vec<Band<'_>> {
    let size = traced.width as usize * BLOCK;
    let mut steps = traced.steps.as_mut().map(|steps| steps.chunks_mut(size));
    let layers = traced
        .color
        .chunks_mut(size)
        .zip(traced.depth.chunks_mut(size))
        .zip(traced.normal.chunks_mut(size))
        .zip(traced.face.chunks_mut(size));
    layers
        .enumerate()
        .map(|(i, (((color, depth), normal), face))| Band {
            first_row: first_row + i * BLOCK,
            color,
            depth,
            normal,
            face,
            steps: steps.as_mut().and_then(Iterator::next),
        })
        .collect()
}
