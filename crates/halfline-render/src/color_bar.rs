//! The scale beside a picture whose colours are numbers: a strip of them with some of the numbers.

use halfline::mesh::linear_from_srgb;

use crate::font;

/// Where the scale goes in a picture, in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ColorBar {
    /// Pixels a dot of the letters is wide and high.
    dot: usize,
    /// The picture's size.
    width: usize,
    height: usize,
    /// Characters that a number may have.
    digits: usize,
    /// False where a picture is so small that letters would leave nothing of it.
    lettered: bool,
}

/// What stands on a scale.
pub(crate) struct Markings<'a> {
    /// The sRGB-encoded colour by the share of the strip, from 0 at its bottom to 1.
    pub(crate) color: &'a dyn Fn(f32) -> [f32; 3],
    /// The share of the strip, and what is written there. Of two that would overlap, the first counts.
    pub(crate) ticks: &'a [(f64, String)],
    /// What the numbers are.
    pub(crate) caption: &'a str,
    /// The sRGB-encoded grey of lines and letters.
    pub(crate) ink: f32,
}

/// Dots from left to right: caption, gap, strip, tick, gap, number, edge.
const STRIP: usize = 8;
const GAP: usize = 3;
const TICK: usize = 2;
const EDGE: usize = 4;

impl ColorBar {
    /// The place in a picture of some size for a scale whose numbers have at most so many `digits`.
    pub(crate) fn new(width: u32, height: u32, digits: usize) -> ColorBar {
        let (width, height) = (width as usize, height as usize);
        let dot = (width.min(height) / 300).max(1);
        let mut bar = ColorBar { dot, width, height, digits, lettered: true };
        bar.lettered = bar.dots() * dot * 4 <= width;
        bar
    }

    fn dots(&self) -> usize {
        let number = self.digits * font::ADVANCE;
        match self.lettered {
            true => GAP + font::HEIGHT + GAP + STRIP + TICK + GAP + number + EDGE,
            false => GAP + STRIP + EDGE,
        }
    }

    /// The share of the picture's width that the scale takes, at its right edge.
    pub(crate) fn share(&self) -> f64 {
        ((self.dots() * self.dot) as f64 / self.width as f64).min(0.4)
    }

    /// Draws the scale over linear `pixels`.
    pub(crate) fn draw(&self, pixels: &mut [[f32; 4]], markings: &Markings) {
        let dot = self.dot;
        let mut canvas = Canvas { pixels, width: self.width, height: self.height };
        let left = self.width.saturating_sub(self.dots() * dot);
        let strip = left + if self.lettered { GAP + font::HEIGHT + GAP } else { GAP } * dot;
        let (high, low) = (self.height / 10, self.height - self.height / 10);
        let rows = (low - high).max(1);

        for y in high..low {
            let share = 1.0 - (y - high) as f32 / rows as f32;
            let color = (markings.color)(share).map(linear_from_srgb);
            for x in strip..strip + STRIP * dot {
                canvas.set(x, y, color);
            }
        }
        if !self.lettered {
            return;
        }

        let ink = [linear_from_srgb(markings.ink); 3];
        let mut written: Vec<usize> = Vec::new();
        for (share, number) in markings.ticks {
            let y = low - 1 - ((rows - 1) as f64 * share.clamp(0.0, 1.0)).round() as usize;
            if written.iter().any(|other| y.abs_diff(*other) < (font::HEIGHT + 2) * dot) {
                continue;
            }
            written.push(y);
            let tick = strip + STRIP * dot;
            canvas.rectangle(tick, y.saturating_sub(dot / 2), TICK * dot, dot, ink);
            let (x, y) = (tick + (TICK + GAP) * dot, y.saturating_sub(font::HEIGHT * dot / 2));
            font::draw(number, |i, j| canvas.rectangle(x + i * dot, y + j * dot, dot, dot, ink));
        }

        // The caption runs upwards, beside the middle of the strip.
        let length = markings.caption.chars().count() * font::ADVANCE * dot;
        let (x, bottom) = (left + GAP * dot, (self.height + length) / 2);
        if length <= rows {
            font::draw(markings.caption, |i, j| {
                canvas.rectangle(x + j * dot, bottom - (i + 1) * dot, dot, dot, ink);
            });
        }
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
    use crate::colormap::inferno;

    fn markings(ticks: &[(f64, String)]) -> Markings<'_> {
        Markings { color: &inferno, ticks, caption: "nodes + triangles per ray", ink: 1.0 }
    }

    #[test]
    fn a_number_that_would_overlap_is_left_out() {
        let drawn = |ticks: &[(f64, String)]| {
            let mut pixels = vec![[0.0; 4]; 400 * 300];
            ColorBar::new(400, 300, 5).draw(&mut pixels, &markings(ticks));
            pixels
        };
        let [first, near, far] = [(0.5, "5"), (0.51, "6"), (0.6, "7")].map(|(s, n)| (s, n.into()));
        let alone = drawn(std::slice::from_ref(&first));
        assert!(drawn(&[first.clone(), near]) == alone && drawn(&[first, far]) != alone);
    }

    #[test]
    fn the_strip_runs_from_the_first_colour_to_the_last() {
        let bar = ColorBar::new(400, 300, 5);
        let mut pixels = vec![[0.0; 4]; 400 * 300];
        bar.draw(&mut pixels, &markings(&[]));
        let strip = 400 - bar.dots() + GAP + font::HEIGHT + GAP;
        let code = |y: usize| pixels[y * 400 + strip].map(srgb8_from_linear);
        assert_eq!(code(30)[..3], inferno(1.0).map(|v| (v * 255.0).round() as u8));
        assert!(code(269).iter().take(3).all(|&v| v < 12), "{:?}", code(269));
    }

    #[test]
    fn the_smallest_pictures_survive() {
        for (width, height) in [(1, 1), (3, 2), (1, 500), (500, 1), (96, 72)] {
            let bar = ColorBar::new(width, height, 5);
            assert!(bar.share() <= 0.4);
            let mut pixels = vec![[0.0; 4]; (width * height) as usize];
            bar.draw(&mut pixels, &markings(&[(0.0, "0".into()), (1.0, "1000000M".into())]));
        }
    }
}
