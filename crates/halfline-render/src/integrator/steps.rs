//! A heat map of what each pixel's ray costs: tree nodes visited and triangles tested.

use halfline::error::Result;
use halfline::mesh::linear_from_srgb;

use super::{Integrator, PrimaryHits, Radiance};
use crate::color_bar::{ColorBar, Top};
use crate::colormap::inferno;
use crate::image::Rendering;
use crate::tracer::Tracer;

/// The share of pixels whose counts the scale must hold; the rest, mostly single pixels at
/// outlines, show the last colour instead of pressing all others into the first.
const HELD: f64 = 0.99;

pub(crate) struct Steps;

impl Integrator for Steps {
    fn radiances(&self, primary_hits: PrimaryHits, _: &mut Tracer) -> Result<Vec<Radiance>> {
        Ok(primary_hits.each(|_| Radiance::NONE))
    }

    fn counts_steps(&self) -> bool {
        true
    }
}

/// Colours each pixel by its steps, and draws the scale.
pub(crate) fn spread_steps(picture: &mut Rendering) {
    let Some(steps) = &picture.steps else { return };
    let costs: Vec<f32> = steps.iter().map(|[nodes, triangles]| nodes + triangles).collect();
    let mut sorted = costs.clone();
    sorted.sort_unstable_by(f32::total_cmp);
    let held = ((sorted.len() - 1) as f64 * HELD).round() as usize;
    let largest = sorted[sorted.len() - 1];
    let top = Top::round(f64::from(sorted[held]), f64::from(largest));
    for (pixel, cost) in picture.color.iter_mut().zip(&costs) {
        let [r, g, b] = inferno(cost / top.value as f32).map(linear_from_srgb);
        *pixel = [r, g, b, 1.0];
    }
    ColorBar::new(picture.width, picture.height).draw(
        &mut picture.color,
        &top,
        "nodes + triangles per ray",
    );
}
