//! Which colour a distance has: a range, a map of colours over it, and a band that is in tolerance.
//!
//! Signed numbers go from blue over grey to red, plain ones from pale to dark. What lies within the
//! tolerance has one colour, and the first colour beyond it is a step away, so that the limit is a line
//! in the picture and not a place to guess.

use halfline::error::{Error, Result};

use crate::colormap::{cool_warm, inferno};

/// What is no number, sRGB-encoded.
const UNKNOWN: [f32; 3] = [0.45, 0.45, 0.47];

/// What is within the tolerance. Its brightness, above that of the colours next to it, tells it apart
/// without its hue.
const BAND: [f32; 3] = [0.84, 0.97, 0.77];

/// The share of a map that is left out next to the band, so that its limit is a step.
const STEP: f64 = 0.38;

/// The share of `inferno` that plain numbers have: on a surface in the dark, its first colours would be
/// taken for shadow.
const PALE_TO_DARK: [f64; 2] = [0.98, 0.28];

/// A range of numbers and its colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorScale {
    is_signed: bool,
    range: f64,
    tolerance: Option<f64>,
}

impl ColorScale {
    /// The scale from -`range`, or 0 unless it `is_signed`, to `range`; numbers beyond have the last
    /// colours. Those at most as far from 0 as the `tolerance` have one colour.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the range is not finite and above 0, or not above the tolerance.
    pub fn new(is_signed: bool, range: f64, tolerance: Option<f64>) -> Result<ColorScale> {
        if !(range > 0.0 && range.is_finite()) {
            return Err(Error::invalid("range", "expected a finite number above 0"));
        }
        match tolerance {
            Some(tolerance) if !(tolerance >= 0.0 && tolerance < range) => {
                let reason = format!("{range} does not reach beyond the tolerance of {tolerance}");
                Err(Error::invalid("range", reason))
            }
            _ => Ok(ColorScale { is_signed, range, tolerance }),
        }
    }

    /// The smallest of 1, 2, 3, 4, 5, 6, 8, times a power of ten, that is at least `wanted`; 1
    /// where there is no such number above 0.
    pub fn round_range(wanted: f64) -> f64 {
        let known = wanted > 0.0 && wanted.is_finite();
        // Beyond these powers of ten, the factors would leave the range of doubles.
        let exponent = if known { wanted.log10().floor().clamp(-300.0, 300.0) as i32 } else { 0 };
        if !known {
            return 1.0;
        }
        [1, 2, 3, 4, 5, 6, 8, 10, 20]
            .into_iter()
            // A decimal number is read to the nearest double; a power of ten multiplied may be beside it.
            .filter_map(|factor| format!("{factor}e{exponent}").parse().ok())
            .find(|&round: &f64| round >= wanted)
            .unwrap_or(wanted)
    }

    /// The largest number with a colour of its own.
    pub fn range(&self) -> f64 {
        self.range
    }

    /// The smallest number with a colour of its own.
    pub(crate) fn lowest(&self) -> f64 {
        if self.is_signed { -self.range } else { 0.0 }
    }

    /// What lies at most so far from 0 has one colour.
    pub fn tolerance(&self) -> Option<f64> {
        self.tolerance
    }

    /// The sRGB-encoded colour of a number; grey for NaN.
    pub fn color(&self, value: f64) -> [f32; 3] {
        if value.is_nan() {
            return UNKNOWN;
        }
        let size = value.abs();
        let share = match self.tolerance {
            Some(tolerance) if size <= tolerance => return BAND,
            Some(tolerance) => {
                STEP + (1.0 - STEP) * ((size - tolerance) / (self.range - tolerance)).min(1.0)
            }
            None => (size / self.range).min(1.0),
        };
        match self.is_signed {
            true => cool_warm((0.5 + 0.5 * share.copysign(value)) as f32),
            false => {
                let [pale, dark] = PALE_TO_DARK;
                inferno((pale + (dark - pale) * share) as f32)
            }
        }
    }

    /// The eight-bit sRGB codes of [`ColorScale::color`].
    pub fn srgb8(&self, value: f64) -> [u8; 3] {
        self.color(value).map(|encoded| (encoded * 255.0).round() as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_round_and_large_enough() {
        let wanted = [0.0, -1.0, f64::NAN, f64::INFINITY, 1.0, 0.0021, 0.0049, 51.0, 3e-310];
        let round = [1.0, 1.0, 1.0, 1.0, 1.0, 0.003, 0.005, 60.0, 1e-300];
        assert_eq!(wanted.map(ColorScale::round_range), round);
        assert!(ColorScale::round_range(f64::MAX) >= f64::MAX);
        // Powers of ten of which logarithms are rounded.
        for exponent in -300..=300 {
            let power: f64 = format!("1e{exponent}").parse().unwrap();
            let round = ColorScale::round_range(power);
            assert!(round >= power && round <= 1.01 * power, "{power} {round}");
        }
    }

    #[test]
    fn the_band_ends_with_a_step() {
        for is_signed in [false, true] {
            let scale = ColorScale::new(is_signed, 2.0, Some(0.5)).unwrap();
            let difference = |a: f64, b: f64| {
                let (a, b) = (scale.color(a), scale.color(b));
                a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
            };
            assert_eq!(difference(-0.5, 0.5), 0.0);
            assert!(difference(0.5, 0.501) > 0.15, "{is_signed}");
            assert!(difference(0.501, 0.502) < 0.01);
            assert_eq!(difference(2.0, f64::INFINITY), 0.0);
            assert_eq!(difference(-0.7, 0.7) > 0.2, is_signed);
        }
    }

    #[test]
    fn a_scale_needs_room() {
        for (range, tolerance) in [
            (0.0, None),
            (f64::NAN, None),
            (f64::INFINITY, None),
            (1.0, Some(1.0)),
            (1.0, Some(-1.0)),
        ] {
            assert!(ColorScale::new(true, range, tolerance).is_err(), "{range} {tolerance:?}");
        }
    }
}
