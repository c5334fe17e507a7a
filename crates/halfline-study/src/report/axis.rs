//! Logarithmic axes: where they end, and where their ticks and numbers are.

use maud::{Markup, html};

/// One of the axes, logarithmic.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it measures, and in which unit.
    pub label: String,
    /// Where the axis begins.
    pub low: f64,
    /// Where the axis ends.
    pub high: f64,
}

impl Axis {
    /// The axis that has room for all of `values`, from one tick to another.
    pub fn around(label: &str, values: impl Iterator<Item = f64>) -> Axis {
        let values = values.filter(|v| *v > 0.0 && v.is_finite());
        let (low, high) =
            values.fold((f64::INFINITY, 0f64), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low > high { (1.0, 10.0) } else { (low, high) };
        let floor = 10f64.powf(low.log10().floor());
        let ceil = 10f64.powf(high.log10().ceil());
        let nice = [5.0, 2.0, 1.0].map(|step| step * floor);
        let low = nice.into_iter().find(|&tick| tick <= low / 1.08).unwrap_or(floor / 2.0);
        let nice = [0.2, 0.5, 1.0, 2.0].map(|step| step * ceil);
        let high = nice.into_iter().find(|&tick| tick >= high * 1.08).unwrap_or(ceil * 2.0);
        Axis { label: label.into(), low, high }
    }

    /// Where a value lies, from 0 to 1.
    pub fn place(&self, value: f64) -> f64 {
        (value / self.low).ln() / (self.high / self.low).ln()
    }

    /// (value, is a power of ten) for each tick.
    pub fn ticks(&self) -> Vec<(f64, bool)> {
        let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        decades
            .flat_map(|decade| {
                (1..10).map(move |step| (f64::from(step) * 10f64.powi(decade), step))
            })
            .map(|(value, step)| (value, step == 1))
            .filter(|&(value, _)| (-1e-9..=1.0 + 1e-9).contains(&self.place(value)))
            .collect()
    }

    /// True if so few decades need numbers at other ticks too; all numbers are plain then.
    fn is_short(&self) -> bool {
        self.high / self.low < 1.2e3
    }

    /// True if a tick has its number.
    pub fn is_labelled(&self, value: f64, is_decade: bool) -> bool {
        let lead = value / 10f64.powf((value * (1.0 + 1e-9)).log10().floor());
        is_decade || self.is_short() && [2.0, 5.0].iter().any(|l| (lead - l).abs() < 1e-6)
    }

    /// The number of a tick.
    pub fn number(&self, value: f64) -> Markup {
        let exponent = value.log10().round() as i32;
        html! {
            @if self.is_short() || exponent == 0 || exponent == 1 {
                (format!("{value:.*}", (-value.log10().floor()).max(0.0) as usize))
            } @else {
                "10" tspan dy="-4.5" font-size="8.5" { (exponent.to_string().replace('-', "−")) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_at_ticks_around_all_values() {
        let ends = |values: &[f64]| {
            let axis = Axis::around("", values.iter().copied());
            let round = |v: f64| (v * 1000.0).round() / 1000.0;
            (round(axis.low), round(axis.high))
        };
        assert_eq!(ends(&[96.0, 1e7]), (50.0, 2e7));
        assert_eq!(ends(&[0.3, 4.0]), (0.2, 5.0));
        assert_eq!(ends(&[]), (0.5, 20.0));
        assert_eq!(ends(&[0.0, 7.0]), (5.0, 10.0));
    }

    #[test]
    fn ticks_are_the_nine_of_each_decade() {
        let axis = Axis { label: String::new(), low: 20.0, high: 2000.0 };
        let ticks = axis.ticks();
        assert_eq!(ticks.len(), 8 + 9 + 2);
        let decades: Vec<f64> = ticks.iter().filter(|tick| tick.1).map(|tick| tick.0).collect();
        assert_eq!(decades, [100.0, 1000.0]);
        let labelled: Vec<f64> =
            ticks.iter().filter(|(v, d)| axis.is_labelled(*v, *d)).map(|tick| tick.0).collect();
        assert_eq!(labelled, [20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0]);
        let small = Axis { label: String::new(), low: 0.05, high: 2.0 };
        let labelled: Vec<f64> = small
            .ticks()
            .into_iter()
            .filter(|(v, d)| small.is_labelled(*v, *d))
            .map(|t| t.0)
            .collect();
        assert_eq!(labelled.len(), 6, "{labelled:?}");
    }
}
