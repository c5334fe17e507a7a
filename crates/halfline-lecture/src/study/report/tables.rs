//! The report's tables.

use maud::{Markup, html};

use super::powers;
use crate::study::csv::note;
use crate::study::engine::Engine;
use crate::study::findings::law_in_short;
use crate::study::growth::Quantity;
use crate::study::measure::{Measurement, RayCost, Sample};
use crate::study::units::{count, figure, nanoseconds};
use crate::study::{FamilyStudy, LECTURE_SIZES, Study};

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
                            td { (family.family.name()) } td { (count(n)) }
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

/// Which law holds for which count and for time.
pub fn laws(study: &Study) -> Markup {
    html! {
        h3 { "How they grow with n" }
        div.wide { table {
            thead { tr {
                th { "family" } th.text { "engine" }
                @for quantity in Quantity::ALL { th.text { (quantity.name()) } }
            } }
            tbody {
                @for family in &study.families { @for (i, engine) in Engine::ALL.into_iter().enumerate() {
                    tr.group[i == 0] {
                        td { @if i == 0 { (family.family.name()) } }
                        td.text { (engine.title()) }
                        @for quantity in Quantity::ALL { (law(family, engine, quantity)) }
                    }
                } }
            }
        } }
        p { "Deviations are root mean squares. Point at a law to see what comes next." }
    }
}

fn law(family: &FamilyStudy, engine: Engine, quantity: Quantity) -> Markup {
    match family.growth(engine, quantity).fits {
        Some(fits) => html! { td.text title=(fits.verdict()) { (powers(&law_in_short(&fits))) } },
        None => html! { td.text.mark { "–" } },
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
            td { @if i == 0 { (count(sample.triangles)) } }
            td.text { (m.engine.title()) }
            td { @if i == 0 { (format!("{:.0} %", sample.hit_share * 100.0)) } }
            td { (of_cost(m, &|cost| count(cost.rays))) }
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
