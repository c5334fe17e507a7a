//! Plots on log-log paper, as SVG.
//!
//! Drawn here and not by a crate: plotters, the one that is kept up for this, has no superscripts, no
//! labels at the ends of curves and no vertical marks, which is most of what there is to draw; and what it
//! would take to add them is more than the drawing.

use maud::{Markup, html};

use super::axis::Axis;

/// The colours of M. Okabe and K. Ito, "Color Universal Design", 2008, which can be told apart with any
/// kind of colour vision; and a shape for each, for paper without colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink {
    /// The colour of lines and markers.
    pub color: &'static str,
    /// The shape of markers.
    pub marker: Marker,
}

/// The shape of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Marker {
    /// A disc.
    Circle,
    /// A square.
    Square,
    /// A triangle on its base.
    Triangle,
    /// A square on its corner.
    Diamond,
    /// A triangle on its tip.
    Wedge,
}

/// A measurement.
#[derive(Clone, Debug)]
pub struct Point {
    /// The values on both axes.
    pub at: [f64; 2],
    /// Drawn open: not measured.
    pub is_open: bool,
    /// What a browser shows while the reader points at it.
    pub title: String,
}

/// Points of one engine, and the line through them.
#[derive(Clone, Debug)]
pub struct Series {
    /// How it looks.
    pub ink: Ink,
    /// The name of the series, at its end.
    pub label: String,
    /// What is added to the name, in lighter type.
    pub note: String,
    /// The points of the series, from left to right.
    pub points: Vec<Point>,
    /// A thin line beside them; the points themselves if there is none.
    pub curve: Option<Vec<[f64; 2]>>,
}

/// A vertical line.
#[derive(Clone, Debug)]
pub struct Guide {
    /// Where it crosses the horizontal axis.
    pub at: f64,
    /// What it marks.
    pub label: String,
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Width and height.
    pub size: [f64; 2],
    /// The name of the plot, above it.
    pub title: String,
    /// The axis from left to right.
    pub x: Axis,
    /// The axis from below to above.
    pub y: Axis,
    /// What is drawn.
    pub series: Vec<Series>,
    /// Vertical lines.
    pub guides: Vec<Guide>,
    /// Room for names on the right.
    pub label_room: f64,
}

/// Room around the plot: left, top, bottom.
const LEFT: f64 = 58.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 46.0;
/// Height of a line of names.
const LINE: f64 = 13.0;
/// The colour of text, of axes and of brute force is that of the text around the plot.
pub const INK: &str = "currentColor";
const FAINT: [&str; 2] = ["#888", "0.22"];
const GREY: &str = "#767676";

/// Fonts that are everywhere.
pub const FONT: &str = "Helvetica, Arial, 'Liberation Sans', sans-serif";

impl Chart {
    fn frame(&self) -> [f64; 4] {
        let [width, height] = self.size;
        [LEFT, TOP, width - self.label_room, height - BOTTOM]
    }

    fn px(&self, value: f64) -> f64 {
        let [left, _, right, _] = self.frame();
        left + self.x.place(value) * (right - left)
    }

    fn py(&self, value: f64) -> f64 {
        let [_, top, _, bottom] = self.frame();
        bottom - self.y.place(value) * (bottom - top)
    }

    /// The plot's content, in its own coordinates.
    pub fn content(&self) -> Markup {
        let [left, top, right, bottom] = self.frame();
        html! {
            @for (value, is_decade) in self.x.ticks() {
                (self.x_tick(value, is_decade))
            }
            @for (value, is_decade) in self.y.ticks() {
                (self.y_tick(value, is_decade))
            }
            @for guide in &self.guides {
                (self.guide(guide))
            }
            path d=(format!("M{left} {top}V{bottom}H{right}")) fill="none" stroke=(INK) stroke-width="1" {}
            text x=(left) y=(top - 16.0) font-size="13" font-weight="bold" fill=(INK) { (self.title) }
            text x=(number((left + right) / 2.0)) y=(number(bottom + 38.0)) font-size="11.5"
                text-anchor="middle" fill=(INK) { (self.x.label) }
            text transform=(format!("translate(14 {}) rotate(-90)", number((top + bottom) / 2.0)))
                font-size="11.5" text-anchor="middle" fill=(INK) { (self.y.label) }
            @for series in &self.series {
                (self.line(series))
            }
            @for series in &self.series {
                @for point in &series.points {
                    (self.point(series.ink, point))
                }
            }
            (self.names())
        }
    }

    fn x_tick(&self, value: f64, is_decade: bool) -> Markup {
        let [_, top, _, bottom] = self.frame();
        let x = number(self.px(value));
        let end = if is_decade { bottom + 6.0 } else { bottom + 3.0 };
        html! {
            @if is_decade {
                path d=(format!("M{x} {top}V{bottom}")) stroke=(FAINT[0]) stroke-opacity=(FAINT[1]) stroke-width="1" {}
            }
            path d=(format!("M{x} {bottom}V{end}")) stroke=(INK) stroke-width="0.8" {}
            @if self.x.is_labelled(value, is_decade) {
                text x=(x) y=(number(bottom + 19.0)) font-size="11" text-anchor="middle" fill=(INK) {
                    (self.x.number(value))
                }
            }
        }
    }

    fn y_tick(&self, value: f64, is_decade: bool) -> Markup {
        let [left, _, right, _] = self.frame();
        let y = number(self.py(value));
        let start = if is_decade { left - 6.0 } else { left - 3.0 };
        html! {
            @if is_decade {
                path d=(format!("M{left} {y}H{right}")) stroke=(FAINT[0]) stroke-opacity=(FAINT[1]) stroke-width="1" {}
            }
            path d=(format!("M{start} {y}H{left}")) stroke=(INK) stroke-width="0.8" {}
            @if self.y.is_labelled(value, is_decade) {
                text x=(left - 9.0) y=(number(self.py(value) + 4.0)) font-size="11" text-anchor="end" fill=(INK) {
                    (self.y.number(value))
                }
            }
        }
    }

    fn guide(&self, guide: &Guide) -> Markup {
        let [_, top, _, bottom] = self.frame();
        let place = self.x.place(guide.at);
        html! {
            @if (0.0..=1.0).contains(&place) {
                @let x = number(self.px(guide.at));
                path d=(format!("M{x} {top}V{bottom}")) stroke="#b0b0b0" stroke-width="1" stroke-dasharray="2 3" {}
                text x=(x) y=(number(top - 2.0)) font-size="10" text-anchor="middle" fill=(GREY) { (guide.label) }
            }
        }
    }

    fn line(&self, series: &Series) -> Markup {
        let points: Vec<[f64; 2]> = match &series.curve {
            Some(curve) => curve.clone(),
            None => series.points.iter().map(|point| point.at).collect(),
        };
        let places: Vec<String> = points
            .iter()
            .filter(|[_, y]| *y > 0.0)
            .map(|&[x, y]| format!("{} {}", number(self.px(x)), number(self.py(y))))
            .collect();
        html! {
            @if places.len() > 1 {
                path d=(format!("M{}", places.join("L"))) fill="none" stroke=(series.ink.color)
                    stroke-width="1.1" stroke-opacity="0.75" {}
            }
        }
    }

    fn point(&self, ink: Ink, point: &Point) -> Markup {
        let (x, y) = (self.px(point.at[0]), self.py(point.at[1]));
        let fill = if point.is_open { "#fff" } else { ink.color };
        let dash = point.is_open.then_some("1.6 1.2");
        html! {
            path d=(outline(ink.marker, x, y)) fill=(fill) stroke=(ink.color) stroke-width="1.2"
                stroke-dasharray=[dash] {
                title { (point.title) }
            }
        }
    }

    /// The series' names beside their ends, moved apart where they would lie on each other.
    fn names(&self) -> Markup {
        let [_, top, right, bottom] = self.frame();
        let mut ends: Vec<(f64, &Series)> = self
            .series
            .iter()
            .filter_map(|series| {
                let last = series.points.last()?.at;
                let reaches = |end: [f64; 2]| (self.px(end[0]) > right - 20.0).then_some(end);
                let curve = series.curve.as_ref().and_then(|curve| curve.last().copied());
                Some((self.py(curve.and_then(reaches).unwrap_or(last)[1]), series))
            })
            .collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut places: Vec<f64> = ends.iter().map(|end| end.0).collect();
        spread(&mut places, LINE, top + 4.0, bottom - 2.0);
        html! {
            @for ((_, series), y) in ends.iter().zip(places) {
                path d=(outline(series.ink.marker, right + 12.0, y)) fill=(series.ink.color) {}
                text x=(number(right + 20.0)) y=(number(y + 3.8)) font-size="11" fill=(INK) {
                    (series.label)
                    @if !series.note.is_empty() {
                        " " (note(&series.note))
                    }
                }
            }
        }
    }
}

/// Moves sorted places apart until neighbours are `distance` from each other, all within the limits.
fn spread(places: &mut [f64], distance: f64, low: f64, high: f64) {
    // Each place is pushed down by those above it, and then all up again from the lower limit.
    let mut next = low;
    for place in places.iter_mut() {
        *place = place.max(next);
        next = *place + distance;
    }
    let mut next = high;
    for place in places.iter_mut().rev() {
        *place = place.min(next);
        next = *place - distance;
    }
}

/// A marker's outline about a point.
fn outline(marker: Marker, x: f64, y: f64) -> String {
    let polygon = |corners: &[[f64; 2]]| {
        let corners: Vec<String> = corners
            .iter()
            .map(|[dx, dy]| format!("{} {}", number(x + dx), number(y + dy)))
            .collect();
        format!("M{}Z", corners.join("L"))
    };
    match marker {
        Marker::Circle => {
            let (start, y) = (number(x - 3.4), number(y));
            format!("M{start} {y}a3.4 3.4 0 1 0 6.8 0a3.4 3.4 0 1 0 -6.8 0Z")
        }
        Marker::Square => polygon(&[[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]]),
        Marker::Triangle => polygon(&[[0.0, -4.2], [3.8, 2.6], [-3.8, 2.6]]),
        Marker::Diamond => polygon(&[[0.0, -4.4], [4.4, 0.0], [0.0, 4.4], [-4.4, 0.0]]),
        Marker::Wedge => polygon(&[[0.0, 4.2], [3.8, -2.6], [-3.8, -2.6]]),
    }
}

/// A coordinate to a tenth.
pub fn number(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// `n^(1/3)` as it is printed.
fn note(text: &str) -> Markup {
    let (base, power) = text.split_once("^(").unwrap_or((text, ""));
    html! {
        tspan fill=(GREY) { (base) }
        @if !power.is_empty() {
            tspan dy="-4" font-size="8" fill=(GREY) { (power.replace(')', "")) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_moved_apart_and_stay_inside() {
        let mut places = [10.0, 11.0, 12.0, 95.0, 99.0];
        spread(&mut places, 10.0, 0.0, 100.0);
        assert_eq!(places, [10.0, 20.0, 30.0, 90.0, 100.0]);
    }
}
