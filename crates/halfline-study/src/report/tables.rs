//! The report's tables.

use maud::{Markup, html};

use super::powers;
use crate::csv::note;
use crate::engine::Engine;
use crate::fit::{Fit, Fits, Law, percent};
use crate::growth::Quantity;
use crate::measure::{Measurement, RayCost, Sample};
use crate::{LECTURE_SIZES, Study};
use halfline_explain::units::{count, figure, nanoseconds, number};

/// How many times quicker than brute force, and the time of a ray.
pub fn times(study: &Study) -> Markup {
    let engines: Vec<Engine> = Engine::ALL.into_iter().skip(1).collect();
    html! {
        h3 { "Speed-up over brute force" }
        div.wide { table {
            thead { tr {
                th { "family" } th { "triangles" } th { "brute force" }
                @for engine in &engines { th { (engine.title()) } }
            } }
            tbody {
                @for family in &study.families { @for n in LECTURE_SIZES {
                    @let all: Vec<_> = engines.iter().map(|&e| family.speed_up(e, n)).collect();
                    @if let Some(brute) = all.iter().flatten().next().map(|s| s.brute) {
                        tr {
                            td { (family.family.name()) } td { (count(n as u64)) }
                            td { (nanoseconds(brute.nanoseconds)) (mark(brute.extrapolated)) }
                            @for speed_up in &all {
                                td {
                                    @match speed_up {
                                        Some(s) => { (figure(s.factor())) " ×" (mark(s.is_extrapolated())) },
                                        None => "–",
                                    }
                                }
                            }
                        }
                    }
                } }
            }
        } }
        p.mark { "* extrapolated: brute force by what a triangle costs, a tree by its law." }
    }
}

fn mark(is_extrapolated: bool) -> Markup {
    html! { @if is_extrapolated { span.mark { " *" } } }
}

/// How well each law fits each count and the time.
pub fn laws(study: &Study) -> Markup {
    html! {
        p {
            "How far each law is off, as a root mean square. " b { "Bold" } ": the best, whose curve is on the \
            right; with a star: cannot be told from it. Where nothing is bold none of them holds."
        }
        @for family in &study.families {
            details {
                summary { (family.family.name()) }
                div.wide { table {
                    thead { tr {
                        th.text { "engine" } th.text { "" }
                        @for law in Law::ALL { th { (powers(law.name())) } }
                        th.text { "best curve" }
                    } }
                    tbody {
                        @for engine in Engine::ALL { @for (i, quantity) in Quantity::ALL.into_iter().enumerate() {
                            tr.group[i == 0] {
                                td.text { @if i == 0 { (engine.title()) } }
                                td.text { (quantity.name()) @if quantity == Quantity::Time { " (ns)" } }
                                (fits(family.growth(engine, quantity).fits.as_ref()))
                            }
                        } }
                    }
                } }
            }
        }
    }
}

/// The cells of a row of [`laws`].
fn fits(fits: Option<&Fits>) -> Markup {
    let Some(fits) = fits else {
        return html! { @for _ in Law::ALL { td.mark { "–" } } td {} };
    };
    let (best, holds) = (fits.best(), !fits.none_holds());
    let of = |law: Law| fits.ranked.iter().find(|fit| fit.law == law);
    let is_supported = |law: Law| fits.supported()[1..].iter().any(|fit| fit.law == law);
    html! {
        @for law in Law::ALL {
            td { @if let Some(fit) = of(law) {
                @let deviation = format!("±{}", percent(fit.deviation));
                @if holds && law == best.law { b { (deviation) } } @else { (deviation) }
                @if holds && is_supported(law) { " *" }
            } }
        }
        td.text { @if holds { (curve(best)) } }
    }
}

/// A law's curve: `1.2 + 3.4 log n`.
fn curve(fit: &Fit) -> Markup {
    let b = number(fit.b);
    match fit.law {
        Law::Constant => html! { (number(fit.a)) },
        Law::Logarithm => html! { (number(fit.a)) " + " (b) " log" sub { "2" } " n" },
        law => html! { (number(fit.a)) " + " (b) " " (powers(law.name())) },
    }
}

/// Everything that was measured.
pub fn everything(study: &Study) -> Markup {
    html! {
        p { "The same as in " code { "study.csv" } "." }
        @for family in &study.families {
            details {
                summary { (family.family.name()) ", " (family.samples.len()) " sizes" }
                div.wide { table {
                    thead { tr {
                        th { "n" } th.text { "engine" } th { "hits" } th { "rays timed" } th { "nodes" }
                        th { "leaves" } th { "triangles" } th { "time a ray" } th { "quickest" } th { "slowest" }
                        th { "build" } th { "bytes a triangle" } th.text { "" }
                    } }
                    tbody { @for sample in &family.samples { (rows(sample)) } }
                } }
            }
        }
    }
}

fn rows(sample: &Sample) -> Markup {
    let of_cost = |m: &Measurement, value: &dyn Fn(&RayCost) -> String| {
        m.rays.as_ref().map_or("–".to_owned(), value)
    };
    html! { @for (i, m) in sample.measurements.iter().enumerate() {
        tr.group[i == 0] {
            td { @if i == 0 { (count(sample.triangles as u64)) } }
            td.text { (m.engine.title()) }
            td { @if i == 0 { (format!("{:.0} %", sample.hit_share * 100.0)) } }
            td { (of_cost(m, &|cost| count(cost.rays as u64))) }
            td { (of_cost(m, &|cost| figure(cost.nodes))) }
            td { (of_cost(m, &|cost| figure(cost.leaves))) }
            td { (of_cost(m, &|cost| figure(cost.triangles))) }
            td { (of_cost(m, &|cost| nanoseconds(cost.nanoseconds)))
                (mark(m.rays.as_ref().is_some_and(|cost| cost.extrapolated))) }
            td { (of_cost(m, &|cost| nanoseconds(cost.range[0]))) }
            td { (of_cost(m, &|cost| nanoseconds(cost.range[1]))) }
            td { (m.build_seconds.map_or("–".to_owned(), |s| nanoseconds(s * 1e9))) }
            td { (m.bytes_per_triangle().map_or("–".to_owned(), figure)) }
            td.text.mark { @if let Some(refusal) = m.refusal { (note(refusal)) } }
        }
    } }
}
