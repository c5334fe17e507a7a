//! What many distances are like.

use halfline_render::ColorScale;
use rayon::prelude::*;
use serde::Serialize;

use crate::table::{Table, bar};
use crate::units;

/// Figures of the distances from one mesh to another.
#[derive(Serialize)]
pub struct Deviation {
    /// Points that were measured.
    pub points: u64,
    /// Points that are not finite, and count nowhere.
    pub invalid_points: u64,
    /// The smallest number; signed if the distances are.
    pub minimum: f64,
    /// The largest number; signed if the distances are.
    pub maximum: f64,
    /// The mean; of signed numbers if the distances are.
    pub mean: f64,
    /// The root of the mean square.
    pub rms: f64,
    /// Of distances without sign.
    pub percentiles: Percentiles,
    /// The largest distance: the one-sided Hausdorff distance, as far as these points tell.
    pub hausdorff: f64,
    /// How many points are at most the tolerance away.
    pub within_tolerance: Option<u64>,
    pub histogram: Histogram,
}

/// What is asked about distances.
pub struct Question {
    /// True if those inside are negative.
    pub is_signed: bool,
    /// How far points may be away.
    pub tolerance: Option<f64>,
    /// Where the histogram ends; by itself at a round number that 99 % of the distances, and the tolerance
    /// twice, are below.
    pub range: Option<f64>,
}

/// What so many per cent of the distances are at most: between two of them, interpolated.
#[derive(Clone, Copy, Serialize)]
pub struct Percentiles {
    pub p50: f64,
    pub p90: f64,
    pub p95: f64,
    pub p99: f64,
}

/// How many distances are where.
#[derive(Serialize)]
pub struct Histogram {
    /// Where the bins begin and end. A number on an edge belongs to the bin above, but for the last.
    pub edges: Vec<f64>,
    /// How many there are in each bin.
    pub counts: Vec<u64>,
    /// How many there are below all bins.
    pub below: u64,
    /// How many there are above all bins.
    pub above: u64,
}

/// Bins of a histogram. Even, so that zero is an edge of signed ones.
const BINS: usize = 10;

impl Deviation {
    /// The figures of `distances`, in which NaN stands for a point that is not finite; `None` if all are.
    pub fn of(distances: &[f64], question: &Question) -> Option<Deviation> {
        let Question { is_signed, tolerance, range } = *question;
        let finite = || distances.iter().filter(|distance| !distance.is_nan());
        let mut sizes: Vec<f64> = finite().map(|distance| distance.abs()).collect();
        sizes.par_sort_unstable_by(f64::total_cmp);
        let hausdorff = *sizes.last()?;
        let (count, mut sum, mut squares) = (sizes.len() as f64, 0.0, 0.0);
        let (mut minimum, mut maximum) = (f64::INFINITY, f64::NEG_INFINITY);
        // In units of the largest, no sum and no square leaves the range of doubles.
        let unit = if hausdorff > 0.0 { hausdorff } else { 1.0 };
        for &distance in finite() {
            minimum = distance.min(minimum);
            maximum = distance.max(maximum);
            let share = distance / unit;
            sum += share;
            squares += share * share;
        }
        let percentile = |share: f64| {
            let place = share * (count - 1.0);
            let (low, high) = (sizes[place as usize], sizes[place.ceil() as usize]);
            low + (high - low) * place.fract()
        };
        let percentiles = Percentiles {
            p50: percentile(0.5),
            p90: percentile(0.9),
            p95: percentile(0.95),
            p99: percentile(0.99),
        };
        let range = range.unwrap_or_else(|| {
            ColorScale::round_range(percentiles.p99.max(2.0 * tolerance.unwrap_or(0.0)))
        });
        Some(Deviation {
            points: sizes.len() as u64,
            invalid_points: (distances.len() - sizes.len()) as u64,
            minimum,
            maximum,
            mean: sum / count * unit,
            rms: (squares / count).sqrt() * unit,
            percentiles,
            hausdorff,
            within_tolerance: tolerance
                .map(|tolerance| sizes.partition_point(|&size| size <= tolerance) as u64),
            histogram: Histogram::of(distances, is_signed, range),
        })
    }

    /// Adds these figures to a table.
    pub fn rows(&self, table: &mut Table, what: &str, tolerance: Option<f64>) {
        let count = units::count;
        let note = match self.invalid_points {
            0 => what.to_owned(),
            invalid => format!("{what}; {} more are not finite", count(invalid)),
        };
        table.row("points", count(self.points), note);
        for (label, value, note) in [
            ("minimum", self.minimum, ""),
            ("mean", self.mean, ""),
            ("RMS", self.rms, ""),
            ("50 %", self.percentiles.p50, "are at most so far away, on either side"),
            ("90 %", self.percentiles.p90, ""),
            ("95 %", self.percentiles.p95, ""),
            ("99 %", self.percentiles.p99, ""),
            ("maximum", self.maximum, ""),
            ("Hausdorff", self.hausdorff, "the largest distance, one-sided"),
        ] {
            table.row(label, units::number(value), note);
        }
        if let (Some(within), Some(tolerance)) = (self.within_tolerance, tolerance) {
            let note = format!(
                "{} are within the tolerance of {}",
                count(within),
                units::number(tolerance)
            );
            table.row("within", percent(within, self.points), note);
        }
        self.histogram.rows(table);
    }
}

/// A share in per cent. Only all of it is 100 %, and only nothing is 0 %.
fn percent(part: u64, whole: u64) -> String {
    let share = 100.0 * part as f64 / whole as f64;
    match share {
        _ if part == whole => "100 %".into(),
        share if share > 99.99 => "> 99.99 %".into(),
        share if part > 0 && share < 0.01 => "< 0.01 %".into(),
        share => format!("{share:.2} %"),
    }
}

impl Histogram {
    /// Counts `distances` from 0, or -`range` if they are signed, to `range`.
    pub fn of(distances: &[f64], is_signed: bool, range: f64) -> Histogram {
        let edge = |i: usize| match is_signed {
            true => range * (2.0 * i as f64 / BINS as f64 - 1.0),
            false => range * (i as f64 / BINS as f64),
        };
        let edges: Vec<f64> = (0..=BINS).map(edge).collect();
        let mut histogram = Histogram { edges, counts: vec![0; BINS], below: 0, above: 0 };
        for &distance in distances {
            let edges_passed = histogram.edges.partition_point(|&edge| edge <= distance);
            match edges_passed {
                _ if distance.is_nan() => {}
                0 => histogram.below += 1,
                passed if passed <= BINS => histogram.counts[passed - 1] += 1,
                _ if distance == range => histogram.counts[BINS - 1] += 1,
                _ => histogram.above += 1,
            }
        }
        histogram
    }

    /// Where it ends.
    pub fn range(&self) -> f64 {
        self.edges[BINS]
    }

    fn rows(&self, table: &mut Table) {
        let most = self.counts.iter().copied().max().unwrap_or(0).max(self.below).max(self.above);
        let mut row = |label: String, count: u64| {
            let bar = bar(count as f64 / most.max(1) as f64);
            table.row(&label, units::count(count), bar);
        };
        let (first, last) = (self.edges[0], self.range());
        if self.below > 0 {
            row(format!("below {}", units::number(first)), self.below);
        }
        for (ends, &count) in self.edges.windows(2).zip(&self.counts) {
            row(format!("{} to {}", units::number(ends[0]), units::number(ends[1])), count);
        }
        if self.above > 0 {
            row(format!("above {}", units::number(last)), self.above);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(tolerance: Option<f64>) -> Question {
        Question { is_signed: false, tolerance, range: None }
    }

    #[test]
    fn figures_keep_their_range() {
        for scale in [1e-200, 1.0, 1e200] {
            let distances = [3.0, -4.0, f64::NAN, 0.0].map(|d| d * scale);
            let deviation = Deviation::of(&distances, &plain(Some(3.0 * scale))).unwrap();
            let near = |a: f64, b: f64| (a / scale - b).abs() < 1e-12;
            assert!(
                near(deviation.rms, (25.0_f64 / 3.0).sqrt()) && near(deviation.mean, -1.0 / 3.0)
            );
            assert!(near(deviation.minimum, -4.0) && near(deviation.maximum, 3.0));
            assert!(near(deviation.hausdorff, 4.0) && near(deviation.percentiles.p50, 3.0));
            assert_eq!((deviation.points, deviation.invalid_points), (3, 1));
            assert_eq!(deviation.within_tolerance, Some(2));
        }
        assert!(Deviation::of(&[f64::NAN], &plain(None)).is_none());
        assert_eq!(Deviation::of(&[0.0], &plain(None)).unwrap().rms, 0.0);
    }

    #[test]
    fn what_is_on_an_edge_is_above_it() {
        let distances = [-1.5, -1.0, -0.0, 0.0, 0.1, 1.0, 1.1, f64::NAN];
        let signed = Histogram::of(&distances, true, 1.0);
        assert_eq!(signed.counts, [1, 0, 0, 0, 0, 3, 0, 0, 0, 1]);
        assert_eq!((signed.below, signed.above), (1, 1));
        let plain = Histogram::of(&[0.0, 0.1, 1.0], false, 1.0);
        assert_eq!(plain.counts, [1, 1, 0, 0, 0, 0, 0, 0, 0, 1]);
    }

    #[test]
    fn shares_are_never_rounded_to_all_or_nothing() {
        assert_eq!(percent(5, 5), "100 %");
        assert_eq!(percent(999_999, 1_000_000), "> 99.99 %");
        assert_eq!(percent(1, 1_000_000), "< 0.01 %");
        assert_eq!((percent(0, 7), percent(1, 3)), ("0.00 %".into(), "33.33 %".into()));
    }
}
