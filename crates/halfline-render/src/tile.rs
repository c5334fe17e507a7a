//! A few neighbouring pixels whose rays are cast together.
//!
//! The engine is quickest with thousands of rays at a time, of which sixteen in a row go about the
//! same way. So a tile takes as many pixels as make up such a batch with their samples, goes through
//! them in blocks, within a block along a Z-order curve (Morton 1966), and takes all samples of a
//! pixel in a row. Where one pixel alone has more samples than a batch, it takes them in rounds: what
//! a tile holds is bounded, whatever the picture. Nothing of that is seen in the picture.

use std::ops::Range;

use halfline::error::Result;
use halfline::geometry::Ray;

use crate::camera::Camera;
use crate::integrator::{Integrator, PrimaryHits, Radiance, dimension};
use crate::sampling::Sampler;
use crate::settings::RenderSettings;
use crate::tracer::Tracer;
use crate::world::Surface;

/// Rows and columns of a block of pixels, a power of two; as many rows has a tile.
pub(crate) const BLOCK: usize = 4;

/// Rays from the eye that make a batch: with a clay's three rays from each surface, the next waves are
/// longer. They all stay in a core's second cache.
pub(crate) const BATCH: usize = 1 << 11;

/// What a tile is drawn with.
pub(crate) struct TileRenderer<'a> {
    pub(crate) settings: &'a RenderSettings,
    pub(crate) camera: &'a Camera,
    pub(crate) integrator: &'a dyn Integrator,
    /// Rays from the eye that are cast together, more or less: [`BATCH`].
    pub(crate) batch: usize,
}

/// What a pixel has become.
pub(crate) struct Pixel {
    pub(crate) column: usize,
    pub(crate) row: usize,
    /// The sum over all samples.
    pub(crate) sum: Radiance,
    /// Nodes and triangles that all samples visited, if they are counted.
    pub(crate) steps: [f64; 2],
    /// What lies on the ray through its middle.
    pub(crate) middle: Option<Middle>,
}

/// What a picture tells of a surface besides its light.
pub(crate) struct Middle {
    pub(crate) depth: f32,
    pub(crate) normal: [f32; 3],
    pub(crate) face: u32,
}

impl TileRenderer<'_> {
    /// Columns of pixels in a tile.
    pub(crate) fn tile_columns(&self) -> usize {
        let pixels = self.batch / self.settings.samples as usize;
        (pixels / (BLOCK * BLOCK)).max(1) * BLOCK
    }

    /// Draws the pixels of a few columns and rows.
    pub(crate) fn draw(
        &self,
        columns: Range<usize>,
        rows: Range<usize>,
        tracer: &mut Tracer,
    ) -> Result<Vec<Pixel>> {
        let mut pixels: Vec<Pixel> = in_blocks(columns, rows)
            .map(|[column, row]| Pixel {
                column,
                row,
                sum: Radiance::NONE,
                steps: [0.0; 2],
                middle: None,
            })
            .collect();
        let samples = self.settings.samples;
        let in_round = (self.batch / pixels.len().max(1)).max(1) as u32;
        for first in (0..samples).step_by(in_round as usize) {
            let round = first..samples.min(first.saturating_add(in_round));
            self.draw_round(&mut pixels, round, tracer)?;
        }
        Ok(pixels)
    }

    /// Adds some of the samples to each of the pixels.
    fn draw_round(
        &self,
        pixels: &mut [Pixel],
        round: Range<u32>,
        tracer: &mut Tracer,
    ) -> Result<()> {
        // Send the samples' rays, and with the last of them those through the middles. A single sample
        // is the middle itself.
        let samples = self.settings.samples;
        let is_last = round.end == samples;
        let mut samplers = Vec::with_capacity(pixels.len() * round.len());
        let mut rays = Vec::with_capacity(pixels.len() * (round.len() + 1));
        let middle_ray =
            |pixel: &Pixel| self.camera.ray(pixel.column as f64 + 0.5, pixel.row as f64 + 0.5);
        for pixel in &*pixels {
            let (column, row) = (pixel.column, pixel.row);
            let mut sampler = Sampler::new(self.settings.seed, column as u32, row as u32);
            for sample in round.clone() {
                sampler.sample = sample;
                samplers.push(sampler);
                rays.push(match samples {
                    1 => middle_ray(pixel),
                    _ => {
                        let [x, y] = sampler.square(dimension::PIXEL, 0, 1);
                        self.camera.ray(column as f64 + x, row as f64 + y)
                    }
                });
            }
        }
        let sample_rays = rays.len();
        if is_last && samples > 1 {
            rays.extend(pixels.iter().map(middle_ray));
        }
        tracer.counts.primary += rays.len() as u64;
        let surfaces = self.meet(pixels, &rays, round.len(), tracer)?;

        // Shade the samples, and add them up in their order.
        let (sampled, middles) = surfaces.split_at(sample_rays);
        let rays = &rays[..sample_rays];
        let primary_hits = PrimaryHits { rays, surfaces: sampled, samplers: &samplers };
        let radiances = self.integrator.radiances(primary_hits, tracer)?;
        for (pixel, radiances) in pixels.iter_mut().zip(radiances.chunks(round.len())) {
            for radiance in radiances {
                pixel.sum.color += radiance.color;
                pixel.sum.alpha += radiance.alpha;
            }
        }
        if is_last {
            let middles = if samples > 1 { middles } else { sampled };
            for (pixel, surface) in pixels.iter_mut().zip(middles) {
                pixel.middle = surface.as_ref().map(|surface| Middle {
                    depth: self.camera.depth(surface.at.point) as f32,
                    normal: surface.normal.to_array().map(|v| v as f32),
                    face: surface.face,
                });
            }
        }
        Ok(())
    }

    /// What each ray meets. If steps are counted, those of each pixel's samples, of which it has
    /// `in_round` in a row, are added to it.
    fn meet(
        &self,
        pixels: &mut [Pixel],
        rays: &[Ray],
        in_round: usize,
        tracer: &Tracer,
    ) -> Result<Vec<Option<Surface>>> {
        if !self.integrator.counts_steps() {
            return tracer.closest(rays);
        }
        let (surfaces, counters) = tracer.closest_counted(rays)?;
        for (pixel, counters) in pixels.iter_mut().zip(counters.chunks(in_round)) {
            for counters in counters {
                pixel.steps[0] += f64::from(counters.nodes);
                pixel.steps[1] += f64::from(counters.triangles);
            }
        }
        Ok(surfaces)
    }
}

/// The pixels of some columns and rows, block by block.
fn in_blocks(columns: Range<usize>, rows: Range<usize>) -> impl Iterator<Item = [usize; 2]> {
    let corners = rows.clone().step_by(BLOCK).flat_map({
        let columns = columns.clone();
        move |row| columns.clone().step_by(BLOCK).map(move |column| [column, row])
    });
    corners
        .flat_map(|[column, row]| {
            (0..BLOCK * BLOCK).map(move |i| [column + even_bits(i), row + even_bits(i >> 1)])
        })
        .filter(move |[column, row]| columns.contains(column) && rows.contains(row))
}

/// Bits 0, 2, 4 and so on of `i`, next to each other.
fn even_bits(i: usize) -> usize {
    (0..BLOCK.ilog2()).map(|bit| (i >> (2 * bit) & 1) << bit).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_comes_once_and_blocks_are_squares() {
        let mut pixels: Vec<_> = in_blocks(8..19, 4..7).collect();
        assert_eq!(pixels.len(), 11 * 3);
        pixels.sort_unstable();
        pixels.dedup();
        assert_eq!(pixels.len(), 11 * 3);

        let pixels: Vec<_> = in_blocks(0..8, 0..4).collect();
        for (size, columns, rows) in [(2, 2, 1), (4, 2, 2), (8, 4, 2), (16, 4, 4)] {
            for block in pixels.chunks(size) {
                let extent = |axis: usize| {
                    let numbers = block.iter().map(|pixel| pixel[axis]);
                    numbers.clone().max().unwrap() - numbers.min().unwrap() + 1
                };
                assert_eq!([extent(0), extent(1)], [columns, rows]);
            }
        }
    }
}
