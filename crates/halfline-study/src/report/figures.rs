//! The report's figures: which quantity, of whom, on which axes.

use maud::{Markup, html};

use super::axis::Axis;
use super::chart::{Chart, FONT, Guide, INK, Ink, Marker, Point, Series, number};
use crate::engine::Engine;
use crate::fit::Law;
use crate::growth::Quantity;
use crate::measure::{Measurement, RayCost};
use crate::share::Shares;
use crate::{FamilyStudy, Study};
use halfline::explain::Rule;
use halfline_explain::units::{bytes, count, figure, nanoseconds};

/// How each engine looks in all figures.
pub const fn ink(engine: Engine) -> Ink {
    match engine {
        Engine::BruteForce => Ink { color: INK, marker: Marker::Wedge },
        Engine::Textbook(Rule::Middle) => Ink { color: "#E69F00", marker: Marker::Triangle },
        Engine::Textbook(Rule::Median) => Ink { color: "#56B4E9", marker: Marker::Diamond },
        Engine::Textbook(Rule::SurfaceArea) => Ink { color: "#009E73", marker: Marker::Square },
        Engine::Fast => Ink { color: "#D55E00", marker: Marker::Circle },
    }
}

/// What is drawn of a measurement; `None` for what it does not have.
pub type Value<'a> = &'a dyn Fn(&Measurement) -> Option<f64>;

/// One figure: a panel for each family, with the same axes.
pub struct Figure<'a> {
    /// What is drawn.
    pub value: Value<'a>,
    /// What the axis says.
    pub label: &'static str,
    /// In words, for a point.
    pub told: fn(f64) -> String,
    /// The quantity, if laws are to be drawn.
    pub law_of: Option<Quantity>,
    /// The engines whose costs are drawn.
    pub engines: &'a [Engine],
}

const PANEL: [f64; 2] = [470.0, 330.0];
const MAIN_PANEL: [f64; 2] = [820.0, 464.0];
const LABEL_ROOM: f64 = 118.0;

/// Time against n.
pub const TIME: Figure = Figure {
    value: &|m| m.rays.as_ref().map(|cost| cost.nanoseconds),
    label: "nanoseconds per ray",
    told: nanoseconds,
    law_of: Some(Quantity::Time),
    engines: &Engine::ALL,
};

const TREES: [Engine; 4] = [
    Engine::Textbook(Rule::Middle),
    Engine::Textbook(Rule::Median),
    Engine::Textbook(Rule::SurfaceArea),
    Engine::Fast,
];

/// Nodes and leaves against n.
pub const STEPS: Figure = Figure {
    value: &|m| m.rays.as_ref().map(RayCost::steps),
    label: "nodes and leaves per ray",
    told: figure,
    law_of: Some(Quantity::Steps),
    engines: &TREES,
};

/// Triangles against n.
pub const TESTS: Figure = Figure {
    value: &|m| m.rays.as_ref().map(|cost| cost.triangles),
    label: "triangles tested per ray",
    told: figure,
    law_of: Some(Quantity::Triangles),
    engines: &Engine::ALL,
};

/// Seconds of building against n.
pub const BUILD: Figure = Figure {
    value: &|m| m.build_seconds,
    label: "seconds to build",
    told: |seconds| nanoseconds(seconds * 1e9),
    law_of: None,
    engines: &TREES,
};

/// Bytes against n.
pub const BYTES: Figure = Figure {
    value: &|m| m.bytes_per_triangle(),
    label: "bytes per triangle",
    told: figure,
    law_of: None,
    engines: &TREES,
};

impl Figure<'_> {
    /// A panel for each family.
    pub fn panels(&self, study: &Study) -> Vec<Chart> {
        let all = || study.families.iter().flat_map(|family| self.drawn(family));
        let x = Axis::around("triangles n", all().map(|(n, _)| n));
        let y = Axis::around(self.label, all().map(|(_, value)| value));
        study.families.iter().map(|family| self.panel(family, x.clone(), y.clone())).collect()
    }

    fn drawn<'s>(&'s self, family: &'s FamilyStudy) -> impl Iterator<Item = (f64, f64)> + 's {
        let measurements = family.samples.iter().flat_map(|sample| &sample.measurements);
        measurements
            .filter(|m| self.engines.contains(&m.engine))
            .filter_map(|m| Some((m.triangles as f64, (self.value)(m)?)))
    }

    /// A larger panel, of the first family alone.
    pub fn main_panel(&self, study: &Study) -> Option<Chart> {
        let family = study.families.first()?;
        let x = Axis::around("triangles n", self.drawn(family).map(|(n, _)| n));
        let y = Axis::around(self.label, self.drawn(family).map(|(_, value)| value));
        Some(Chart { size: MAIN_PANEL, label_room: 150.0, ..self.panel(family, x, y) })
    }

    /// The panel of one family.
    pub fn panel(&self, family: &FamilyStudy, x: Axis, y: Axis) -> Chart {
        let series =
            self.engines.iter().map(|&engine| self.series(family, engine, [x.low, x.high]));
        Chart {
            size: PANEL,
            title: family.family.name().into(),
            series: series.filter(|series| !series.points.is_empty()).collect(),
            x,
            y,
            guides: Vec::new(),
            label_room: LABEL_ROOM,
        }
    }

    fn series(&self, family: &FamilyStudy, engine: Engine, [low, high]: [f64; 2]) -> Series {
        let measurements = family.samples.iter().flat_map(|sample| &sample.measurements);
        let points: Vec<Point> = measurements
            .filter(|m| m.engine == engine)
            .filter_map(|m| {
                let value = (self.value)(m).filter(|value| *value > 0.0)?;
                let is_open = m.rays.as_ref().is_some_and(|cost| cost.extrapolated);
                let told = (self.told)(value);
                let reservation = if is_open { " (extrapolated)" } else { "" };
                let title = format!(
                    "{}, n = {}: {told}{reservation}",
                    engine.title(),
                    count(m.triangles as u64)
                );
                Some(Point { at: [m.triangles as f64, value], is_open, title })
            })
            .collect();
        let fits = self.law_of.and_then(|quantity| family.growth(engine, quantity).fits);
        let fits = fits.filter(|fits| !fits.none_holds());
        let is_open = fits.as_ref().is_some_and(|fits| fits.supported().len() > 1);
        let best = fits.map(|fits| *fits.best());
        let (first, last) = match (points.first(), points.last()) {
            (Some(first), Some(last)) => (first.at[0].max(low), last.at[0].min(high)),
            _ => (low, high),
        };
        let curve = best.map(|fit| {
            let at = |i: i32| first * (last / first).powf(f64::from(i) / 60.0);
            (0..=60).map(at).map(|n| [n, fit.at(n)]).collect()
        });
        let note = best.map_or(String::new(), |fit| law_note(fit.law, is_open));
        Series { ink: ink(engine), label: short(engine).into(), note, points, curve }
    }
}

/// Names with little room.
const fn short(engine: Engine) -> &'static str {
    match engine {
        Engine::BruteForce => "brute force",
        Engine::Textbook(Rule::Middle) => "middle",
        Engine::Textbook(Rule::Median) => "median",
        Engine::Textbook(Rule::SurfaceArea) => "SAH",
        Engine::Fast => "halfline",
    }
}

/// A law with little room; with a question mark if another fits as well.
fn law_note(law: Law, is_open: bool) -> String {
    let name = if law == Law::Constant { "const." } else { law.name() };
    format!("{name}{}", if is_open { "?" } else { "" })
}

/// What a visit costs, against the bytes that rays walk in.
pub fn cache_panels(study: &Study) -> Vec<Chart> {
    let ends = |family: &FamilyStudy| TREES.map(|engine| family.cache_end(engine));
    let all: Vec<_> = study.families.iter().map(ends).collect();
    let steps = || all.iter().flatten().flatten().flat_map(|end| end.steps.iter().copied());
    let caches = || study.machine.caches.iter().map(|cache| cache.bytes as f64);
    let x = Axis::around(
        "bytes of the tree, and of the mesh if rays need it",
        steps().map(|s| s.0).chain(caches()),
    );
    let y = Axis::around("nanoseconds per visit", steps().map(|s| s.1));
    let guides = || {
        let guide = |cache: &crate::Cache| Guide {
            at: cache.bytes as f64,
            label: format!("L{} {}", cache.level, bytes(cache.bytes)),
        };
        study.machine.caches.iter().map(guide).collect()
    };
    let panel = |(family, ends): (&FamilyStudy, &[Option<crate::CacheEnd>; 4])| {
        Chart {
            size: PANEL,
            title: String::new(),
            x: x.clone(),
            y: y.clone(),
            series: ends
                .iter()
                .flatten()
                .map(|end| Series {
                    ink: ink(end.engine),
                    label: short(end.engine).into(),
                    note: String::new(),
                    points: end
                        .steps
                        .iter()
                        .map(|&(size, cost)| Point {
                            at: [size, cost],
                            is_open: false,
                            title: format!(
                                "{}, {}: {cost:.1} ns",
                                end.engine.title(),
                                bytes(size as u64)
                            ),
                        })
                        .collect(),
                    curve: None,
                })
                .collect(),
            guides: guides(),
            label_room: LABEL_ROOM - 30.0,
        }
        .named(family.family.name())
    };
    study.families.iter().zip(&all).map(panel).collect()
}

impl Chart {
    fn named(mut self, title: &str) -> Chart {
        self.title = title.into();
        self
    }
}

/// A chart as part of a page.
pub fn inline(chart: &Chart) -> Markup {
    let [width, height] = chart.size;
    html! {
        svg viewBox=(format!("0 0 {width} {height}")) role="img" font-family=(FONT) { (chart.content()) }
    }
}

/// The main plot as a file of its own: the first family, all engines. White, so that it can be read on
/// any page.
pub fn standalone(study: &Study) -> String {
    const HEAD: f64 = 56.0;
    let Some(family) = study.families.first() else { return String::new() };
    let Some(chart) = TIME.main_panel(study) else { return String::new() };
    let chart = Chart { title: String::new(), ..chart };
    let subtitle = format!(
        "{}; random rays, one thread{}",
        family.family.description(),
        study.machine.processor.as_ref().map_or(String::new(), |name| format!(", {name}"))
    );
    let [width, height] = [MAIN_PANEL[0], MAIN_PANEL[1] + HEAD];
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}"))
            width=(width) height=(height) font-family=(FONT) color="#222" {
            rect width=(width) height=(height) fill="#fff" {}
            text x="20" y="32" font-size="18" font-weight="bold" fill="#222" {
                "What a ray costs, by brute force and by kd-trees"
            }
            text x="20" y="52" font-size="12" fill="#555" { (subtitle) }
            g transform=(format!("translate(6 {HEAD})")) { (chart.content()) }
        }
    };
    format!("{}\n", markup.into_string())
}

/// The colours of the lecture's three tasks.
const TASKS: [(&str, &str); 3] =
    [("ray generation", "#56B4E9"), ("intersection", "#D55E00"), ("shading", "#999999")];

/// Bars that say how a picture's time is divided.
pub fn share_bars(shares: &[Shares]) -> Markup {
    const WIDTH: f64 = 640.0;
    const LEFT: f64 = 110.0;
    const ROW: f64 = 34.0;
    let scale = WIDTH - LEFT - 10.0;
    let height = ROW * shares.len() as f64 + 34.0;
    let bar = |row: usize, shares: &Shares| {
        let y = 26.0 + ROW * row as f64;
        let mut start = 0.0;
        let parts: Vec<_> = shares
            .parts()
            .into_iter()
            .zip(TASKS)
            .map(|(part, task)| {
                let x = LEFT + start * scale;
                start += part;
                (x, part * scale, part, task)
            })
            .collect();
        html! {
            text x=(LEFT - 10.0) y=(number(y + 15.5)) font-size="12" text-anchor="end" fill=(INK) {
                (shares.engine.title())
            }
            @for (x, width, part, (name, color)) in parts {
                rect x=(number(x)) y=(number(y)) width=(number(width)) height="22" fill=(color) {
                    title { (name) ": " (format!("{:.2} %", part * 100.0)) }
                }
                @if width > 44.0 {
                    text x=(number(x + width / 2.0)) y=(number(y + 15.5)) font-size="12"
                        text-anchor="middle" fill=(if name == "intersection" { "#fff" } else { "#222" }) {
                        (format!("{:.1} %", part * 100.0))
                    }
                }
            }
        }
    };
    html! {
        svg viewBox=(format!("0 0 {WIDTH} {height}")) role="img" font-family=(FONT) {
            @for (i, (name, color)) in TASKS.into_iter().enumerate() {
                @let x = LEFT + 150.0 * i as f64;
                rect x=(x) y="4" width="11" height="11" fill=(color) {}
                text x=(x + 17.0) y="14" font-size="12" fill=(INK) { (name) }
            }
            @for (row, shares) in shares.iter().enumerate() { (bar(row, shares)) }
        }
    }
}
