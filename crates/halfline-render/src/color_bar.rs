//! The scale beside a heat map: a strip of its colours with numbers.

use halfline::mesh::linear_from_srgb;

use crate::colormap::inferno;
use crate::font;

/// Encoded grey of lines and letters.
const INK: f32 = 0.85;

/// Where the scale goes in a picture, in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ColorBar {
    /// Pixels a dot of the letters is wide and high.
    dot: usize,
    /// The picture's size.
    width: usize,
    height: usize,
    /// False where a picture is so small that letters would leave nothing of it.
    lettered: bool,
}

/// Dots from left to right: caption, gap, strip, tick, gap, number, edge.
const STRIP: usize = 8;
const GAP: usize = 3;
const TICK: usize = 2;
const NUMBER: usize = 5 * font::ADVANCE;
const EDGE: usize = 4;

impl ColorBar {
    pub(crate) fn new(width: u32, height: u32) -> ColorBar {
        let (width, height) = (width as usize, height as usize);
        let dot = (width.min(height) / 300).max(1);
        let mut bar = ColorBar { dot, width, height, lettered: true };
        bar.lettered = bar.dots() * dot * 4 <= width;
        bar
    }

    fn dots(&self) -> usize {
        match self.lettered {
            true => GAP + font::HEIGHT + GAP + STRIP + TICK + GAP + NUMBER + EDGE,
            false => GAP + STRIP + EDGE,
        }
    }

    /// The share of the picture's width that the scale takes, at its right edge.
    pub(crate) fn share(&self) -> f64 {
        ((self.dots() * self.dot) as f64 / self.width as f64).min(0.4)
    }

    /// Draws the scale from 0 to `top` over linear `pixels`.
    pub(crate) fn draw(&self, pixels: &mut [[f32; 4]], top: &Top, caption: &str) {
        let dot = self.dot;
        let mut canvas = Canvas { pixels, width: self.width, height: self.height };
        let left = self.width.saturating_sub(self.dots() * dot);
        let strip = left + if self.lettered { GAP + font::HEIGHT + GAP } else { GAP } * dot;
        let (high, low) = (self.height / 10, self.height - self.height / 10);
        let rows = (low - high).max(1);

        for y in high..low {
            let share = 1.0 - (y - high) as f32 / rows as f32;
            let color = inferno(share).map(linear_from_srgb);
            for x in strip..strip + STRIP * dot {
                canvas.set(x, y, color);
            }
        }
        if !self.lettered {
            return;
        }

        let ink = [linear_from_srgb(INK); 3];
        for i in 0..=top.intervals {
            let y = low - 1 - (rows - 1) * i / top.intervals;
            let tick = strip + STRIP * dot;
            canvas.rectangle(tick, y.saturating_sub(dot / 2), TICK * dot, dot, ink);
            let beyond = if i == top.intervals && top.is_exceeded { "+" } else { "" };
            let number = short(top.value * i as f64 / top.intervals as f64) + beyond;
            let (x, y) = (tick + (TICK + GAP) * dot, y.saturating_sub(font::HEIGHT * dot / 2));
            font::draw(&number, |i, j| canvas.rectangle(x + i * dot, y + j * dot, dot, dot, ink));
        }

        // The caption runs upwards, beside the middle of the strip.
        let length = caption.chars().count() * font::ADVANCE * dot;
        let (x, bottom) = (left + GAP * dot, (self.height + length) / 2);
        if length <= rows {
            font::draw(caption, |i, j| {
                canvas.rectangle(x + j * dot, bottom - (i + 1) * dot, dot, dot, ink);
            });
        }
    }
}

/// The upper end of a scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Top {
    pub(crate) value: f64,
    intervals: usize,
    is_exceeded: bool,
}

impl Top {
    /// The smallest round number that is at least `wanted`; `largest` is the largest value of all.
    pub(crate) fn round(wanted: f64, largest: f64) -> Top {
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

struct Canvas<'a> {
    pixels: &'a mut [[f32; 4]],
    width: usize,
    height: usize,
}

impl Canvas<'_> {
    fn set(&mut self, x: usize, y: usize, [r, g, b]: [f32; 3]) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = [r, g, b, 1.0];
        }
    }

    fn rectangle(&mut self, left: usize, top: usize, width: usize, height: usize, c: [f32; 3]) {
        for y in top..top + height {
            for x in left..left + width {
                self.set(x, y, c);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::srgb8_from_linear;

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

    #[test]
    fn the_strip_runs_from_the_first_colour_to_the_last() {
        let bar = ColorBar::new(400, 300);
        let mut pixels = vec![[0.0; 4]; 400 * 300];
        bar.draw(&mut pixels, &Top::round(100.0, 100.0), "nodes");
        let strip = 400 - bar.dots() + GAP + font::HEIGHT + GAP;
        let code = |y: usize| pixels[y * 400 + strip].map(srgb8_from_linear);
        assert_eq!(code(30)[..3], inferno(1.0).map(|v| (v * 255.0).round() as u8));
        assert!(code(269).iter().take(3).all(|&v| v < 12), "{:?}", code(269));
    }

    #[test]
    fn the_smallest_pictures_survive() {
        for (width, height) in [(1, 1), (3, 2), (1, 500), (500, 1), (96, 72)] {
            let bar = ColorBar::new(width, height);
            assert!(bar.share() <= 0.4);
            let mut pixels = vec![[0.0; 4]; (width * height) as usize];
            bar.draw(&mut pixels, &Top::round(1e12, 2e12), "nodes + triangles per ray");
        }
    }
}
