//! The study as one page that needs nothing else: no script, no font, no network.

mod axis;
mod chart;
mod figures;
mod tables;

pub use figures::standalone;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::Study;
use super::cache::DEARER;
use super::stopwatch::COUNTS_PROCESSOR_TIME;
use super::utc::utc;
use chart::Chart;
use figures::{BUILD, BYTES, Figure, STEPS, TESTS, TIME, cache_panels, inline, share_bars};
use halfline_explain::units::{bytes, count, nanoseconds};

/// How the study came about, for whoever reads of it elsewhere.
#[derive(Clone, Debug)]
pub struct Origin {
    /// The command as it was given.
    pub command_line: String,
    /// The version of halfline.
    pub version: String,
    /// Seconds since 1970 at which it ended.
    pub unix_seconds: u64,
    /// Seconds that it took.
    pub seconds: f64,
    /// True if it was in a hurry.
    pub is_quick: bool,
}

/// The report as a page.
pub fn html(study: &Study, origin: &Origin) -> String {
    let mut number = 0;
    let mut figure = |panels: Vec<Chart>, caption: &str| {
        if panels.iter().all(|panel| panel.series.is_empty()) {
            return html! {};
        }
        number += 1;
        html! {
            figure {
                div.panels { @for panel in &panels { (inline(panel)) } }
                figcaption { b { "Figure " (number) ". " } (caption) }
            }
        }
    };
    let main = figure(
        TIME.main_panel(study).into_iter().collect(),
        "Time of a ray against the number of triangles, closest hit, one thread; each point is the median of \
         several turns. Thin lines are the laws that fit best, named at their ends; a question mark: another \
         law fits as well. Open markers are extrapolated: brute force would not finish in time.",
    );
    let others = figure(
        TIME.panels(study).into_iter().skip(1).collect(),
        "Time of a ray in the other families, as in figure 1.",
    );
    let mut of = |what: &Figure, caption: &str| figure(what.panels(study), caption);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "What a ray costs: halfline study" }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body {
                h1 { "What a ray costs" }
                (main)
                p.about { (about(study, origin)) }
                h2 { "Findings" }
                dl.findings {
                    @for finding in study.findings() {
                        dt { (finding.topic) } dd { (powers(&finding.text)) }
                    }
                }
                h2 { "Time" }
                (others)
                (tables::times(study))
                @if let Some(left_out) = study.left_out_text() { p { (left_out) } }
                h2 { "Counts" }
                (of(&STEPS, "Nodes and leaves that a ray visits. They do not depend on the machine: this is \
                    what the algorithm does. A node of halfline has eight children, one of the textbook \
                    two."))
                (of(&TESTS, "Triangles that a ray is tested against. halfline tests those of a leaf, eight \
                    at most, at once."))
                @for family in study.families.iter().filter(|family| family.family.is_uniform_soup()) {
                    @if let Some(theory) = family.theory_text() { p { (theory) } }
                }
                h2 { "Memory" }
                (figure(cache_panels(study), &format!("Time of a visit against the bytes that rays walk in. \
                    A visit is a node or a leaf, and in the textbook's trees also a triangle. Dotted lines: \
                    the caches of one core, here {}. In small trees what a ray costs before its first step \
                    weighs more.", caches(study))))
                (figure(BUILD.panels(study), "Time to build the tree, on one thread."))
                (figure(BYTES.panels(study), "Bytes of the tree for each triangle of the mesh, without the \
                    mesh. halfline's tree has the triangles inside."))
                @if !study.shares.is_empty() {
                    h2 { "The 95 %" }
                    figure.bars {
                        (share_bars(&study.shares))
                        figcaption { (share_caption(study)) }
                    }
                }
                h2 { "All laws" }
                (tables::laws(study))
                h2 { "All figures" }
                (tables::everything(study))
                h2 { "Methods" }
                (methods(study))
                h2 { "References" }
                (references())
            }
        }
    };
    page.into_string()
}

/// `n^(1/3)` as it is printed.
fn powers(text: &str) -> Markup {
    let mut parts = text.split("^(");
    let first = parts.next().unwrap_or_default();
    html! {
        (first)
        @for part in parts {
            @match part.split_once(')') {
                Some((power, rest)) => { sup { (power.replace('-', "−")) } (rest) },
                None => { "^(" (part) },
            }
        }
    }
}

fn caches(study: &Study) -> String {
    let told = |cache: &super::Cache| format!("L{} {}", cache.level, bytes(cache.bytes));
    match study.machine.caches.is_empty() {
        true => "unknown".into(),
        false => study.machine.caches.iter().map(told).collect::<Vec<_>>().join(", "),
    }
}

fn about(study: &Study, origin: &Origin) -> Markup {
    let machine = &study.machine;
    html! {
        "halfline " (origin.version) ", " code { (origin.command_line) } ", " (utc(origin.unix_seconds)) ", "
        (format!("{:.0} s", origin.seconds)) ". "
        (machine.processor.as_deref().unwrap_or("Unknown processor")) ", " (machine.cores)
        (if machine.cores == 1 { " core" } else { " cores" }) ", " (caches(study))
        @if let Some(memory) = machine.memory_bytes { ", " (bytes(memory)) " of memory" }
        "; " (machine.system) "."
        @if origin.is_quick {
            " Measured in a hurry (" code { "--quick" } "): fewer sizes, fewer rays."
        }
    }
}

fn share_caption(study: &Study) -> Markup {
    let Some(first) = study.shares.first() else { return html! {} };
    let [width, height] = first.resolution;
    html! {
        b { "The lecture's three tasks. " }
        "How the time of one picture is divided: " (count(first.triangles as u64)) " triangles, "
        (width) " × " (height) " pixels, " (count(first.rays)) " rays with those to lamps, \
        Whitted's shading, one thread. A picture takes: "
        @for (i, shares) in study.shares.iter().enumerate() {
            @if i > 0 { ", " }
            (shares.engine.title()) " " (nanoseconds(shares.seconds() * 1e9))
        }
        ". Rays from the eye were timed by making them alone; shading is all that is left."
    }
}

fn methods(study: &Study) -> Markup {
    let clock = match COUNTS_PROCESSOR_TIME {
        true => "the processor time of the thread",
        false => "the time that passes",
    };
    html! {
        p {
            b { "Meshes. " }
            @for (i, family) in study.families.iter().enumerate() {
                @if i > 0 { "; " }
                em { (family.family.name()) } ": " (powers(&family.family.description()))
            }
            ". Generated ones are those of " code { "halfline generate" } " with seed 0."
        }
        p {
            b { "Rays. " }
            "Chords: each starts at a random point of the sphere through the corners of the mesh's box, and is \
            aimed at a random point of the box, both uniform, with a fixed seed. They know nothing of each \
            other. Each engine answers the same ones with the closest hit, and the study ends with an error \
            if two engines differ in any bit of an answer. The share that hits anything is in the tables."
        }
        p {
            b { "Time. " }
            "One thread, " (clock) ", after a warm-up, in turns: each engine casts a batch, then the next \
            engine, so that a noisy machine disturbs all alike. Every turn has rays of its own, so that none \
            finds in the caches what the last turn left there for the same rays. Given is the median over the \
            turns. Brute force is timed as long as 32 rays finish in time; beyond that its time is that of a \
            triangle times their number, and marked."
        }
        p {
            b { "Counts. " }
            "Those of the very rays that were timed. halfline counts the nodes and leaves that its batches \
            fetch; the triangles in them are their number times the mean fill of the leaves that the same rays \
            visit one by one."
        }
        p {
            b { "Trees. " }
            "The textbook's trees end at two triangles a cell or at depth 8 + 1.3 log" sub { "2" } " n (Havran), \
            and are left out where they would take longer, or more memory, than they may. halfline's preset is \
            balanced."
        }
        p {
            b { "Laws. " }
            "For each law f of constant, log n, n" sup { "1/3" } ", n" sup { "1/2" } ", n the curve a + b f(n), b \
            not negative, and a neither but for the logarithm, with the least squares of log-residuals. Given is \
            the root mean square deviation. Laws are ranked by Akaike's criterion, corrected for few points; \
            those within 4 of the best cannot be told from it. None holds where the best deviates by more than \
            20 %. Two parameters and a handful of sizes describe what was measured, and prove nothing about \
            what was not."
        }
        p {
            b { "Where the cache ends. " }
            "At the first size from which on a visit costs at least " (DEARER) " times as much as at the size \
            where it costs least."
        }
    }
}

fn references() -> Markup {
    const REFERENCES: [&str; 6] = [
        "T. Whitted, An Improved Illumination Model for Shaded Display, CACM 23(6), 1980.",
        "J. G. Cleary and G. Wyvill, Analysis of an Algorithm for Fast Ray Tracing Using Uniform Space \
         Subdivision, The Visual Computer 4, 1988.",
        "L. Szirmay-Kalos and G. Márton, Worst-Case Versus Average Case Complexity of Ray-Shooting, Computing \
         61, 1998.",
        "V. Havran, Heuristic Ray Shooting Algorithms, PhD thesis, Czech Technical University in Prague, 2000.",
        "C. M. Hurvich and C.-L. Tsai, Regression and Time Series Model Selection in Small Samples, Biometrika \
         76, 1989.",
        "K. P. Burnham and D. R. Anderson, Model Selection and Multimodel Inference, Springer, 2002.",
    ];
    html! { ol.references { @for reference in REFERENCES { li { (reference) } } } }
}
