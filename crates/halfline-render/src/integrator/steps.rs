//! A heat map of what each pixel's ray costs: tree nodes visited and triangles tested.

use halfline::error::Result;
use halfline::mesh::linear_from_srgb;

use super::{Integrator, PrimaryHits, Radiance};
use crate::color_bar::{ColorBar, Markings};
use crate::colormap::inferno;
use crate::image::Rendering;
use crate::tracer::Tracer;

/// The share of pixels whose counts the scale must hold; the rest, mostly single pixels at
/// outlines, show the last colour instead of pressing all others into the first.
const HELD: f64 = 0.99;

/// Characters that [`short`] takes, and a plus.
const DIGITS: usize = 5;

/// Encoded grey of lines and letters.
const INK: f32 = 0.85;

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
    color_bar(picture.width, picture.height).draw(
        &mut picture.color,
        &Markings {
            color: &inferno,
            ticks: &top.ticks(),
            caption: "nodes + triangles per ray",
            ink: INK,
        },
    );
}

/// Where the scale goes.
pub(crate) fn color_bar(width: u32, height: u32) -> ColorBar {
    ColorBar::new(width, height, DIGITS)
}

/// The upper end of a scale.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Top {
    value: f64,
    intervals: usize,
    is_exceeded: bool,
}

impl Top {
    /// The smallest round number that is at least `wanted`; `largest` is the largest value of all.
    fn round(wanted: f64, largest: f64) -> Top {
        // Counts of steps are whole numbers, so that ticks below one would make no sense.
        let wanted = wanted.max(5.0);
        let mut magnitude = 1.0;
        while magnitude * 10.0 < wanted && magnitude < 1e18 {
            magnitude *= 10.0;
        }
        let rounds = [(1.0, 5), (2.0, 4), (5.0, 5), (10.0, 5)];
        let (factor, intervals) =
            rounds.into_iter().find(|(f, _)| f * magnitude >= wanted).unwrap_or((10.0, 5));
        let value = factor * magnitude;
        Top { value, intervals, is_exceeded: largest > value }
    }

    /// The numbers on the scale, each with its share of it.
    fn ticks(&self) -> Vec<(f64, String)> {
        let tick = |i| {
            let share = i as f64 / self.intervals as f64;
            let beyond = if i == self.intervals && self.is_exceeded { "+" } else { "" };
            (share, short(self.value * i as f64 / self.intervals as f64) + beyond)
        };
        (0..=self.intervals).map(tick).collect()
    }
}

/// A number in at most four characters, or with so many digits as it takes above 10^9.
fn short(value: f64) -> String {
    if value < 10_000.0 {
        format!("{value}")
    } else if value < 1e6 {
        format!("{}k", value / 1e3)
    } else {
        format!("{}M", value / 1e6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tops_are_round_and_large_enough() {
        let top = |wanted| Top::round(wanted, wanted).value;
        assert_eq!(
            [0.0, 5.0, 5.1, 99.0, 101.0, 230.0].map(top),
            [5.0, 5.0, 10.0, 100.0, 200.0, 500.0]
        );
        assert!(Top::round(90.0, 101.0).is_exceeded && !Top::round(90.0, 100.0).is_exceeded);
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([0.0, 400.0, 25_000.0, 1e6].map(short), ["0", "400", "25k", "1M"]);
    }
}
