//! The study as text: a table for each family, its laws, and the findings.

use std::fmt::Write;

use super::engine::Engine;
use super::fit::{Fits, percent};
use super::growth::Quantity;
use super::measure::Sample;
use super::{FamilyStudy, Study};
use halfline::explain::Rule;
use halfline_explain::units::{count, figure, nanoseconds};

/// Lines are no longer.
const WIDTH: usize = 80;

/// A part of the text: its heading, and its lines.
#[derive(Clone, Debug)]
pub struct Section {
    /// The heading.
    pub heading: String,
    /// Lines of at most 80 characters.
    pub body: String,
}

/// Everything that a terminal shows: the main table, what was found out, and then the rest.
pub fn sections(study: &Study) -> Vec<Section> {
    let times = |family: &FamilyStudy| {
        let (name, description) = (family.family.name(), family.family.description());
        Section { heading: format!("{name}: {description}"), body: times(family) }
    };
    let mut sections: Vec<Section> = study.families.iter().map(times).collect();
    let mut body = String::new();
    for finding in study.findings() {
        body += &wrapped(&format!("{}: {}", finding.topic, finding.text), 2);
    }
    sections.insert(sections.len().min(1), Section { heading: "Findings".into(), body });
    for family in &study.families {
        let body = laws(family);
        if !body.is_empty() {
            let heading = format!("{}: how it grows with n", family.family.name());
            sections.push(Section { heading, body });
        }
    }
    sections
}

const TIMES: [(Engine, &str); 5] = [
    (Engine::BruteForce, "brute"),
    (Engine::Textbook(Rule::Middle), "middle"),
    (Engine::Textbook(Rule::Median), "median"),
    (Engine::Textbook(Rule::SurfaceArea), "SAH"),
    (Engine::Fast, "halfline"),
];

/// Time a ray of each engine, and steps of the two best.
fn times(family: &FamilyStudy) -> String {
    let mut text = format!("  {:>10}", "n");
    for (_, name) in TIMES {
        let _ = write!(text, " {name:>9}");
    }
    let _ = writeln!(text, " {:>7} {:>8}", "SAH's", "halfline");
    let _ = writeln!(text, "  {:>10} {:>49} {:>7} {:>8}", "", "time a ray", "steps", "steps");
    let (mut is_extrapolated, mut is_missing) = (false, false);
    for sample in &family.samples {
        let _ = write!(text, "  {:>10}", count(sample.triangles as u64));
        for (engine, _) in TIMES {
            let cell = match cost_of(sample, engine) {
                Some(cost) if cost.extrapolated => {
                    is_extrapolated = true;
                    format!("~{}", nanoseconds(cost.nanoseconds))
                }
                Some(cost) => nanoseconds(cost.nanoseconds),
                None => {
                    is_missing = true;
                    "–".into()
                }
            };
            let _ = write!(text, " {cell:>9}");
        }
        let steps =
            |engine| cost_of(sample, engine).map_or("–".into(), |cost| figure(cost.steps()));
        let _ = writeln!(
            text,
            " {:>7} {:>8}",
            steps(Engine::Textbook(Rule::SurfaceArea)),
            steps(Engine::Fast)
        );
    }
    if is_extrapolated {
        text += "  ~ extrapolated from the largest mesh that finished in time\n";
    }
    if is_missing {
        text += "  – not built: it would take too long, or too much memory\n";
    }
    text
}

fn cost_of(sample: &Sample, engine: Engine) -> Option<&super::RayCost> {
    sample.measurements.iter().find(|m| m.engine == engine)?.rays.as_ref()
}

/// The law of each count, and of time.
fn laws(family: &FamilyStudy) -> String {
    const QUANTITIES: [Quantity; 3] = [Quantity::Steps, Quantity::Triangles, Quantity::Time];
    let (mut rows, mut is_open) = (Vec::new(), false);
    for engine in Engine::ALL {
        let cells = QUANTITIES.map(|quantity| {
            family.growth(engine, quantity).fits.map_or("–".into(), |fits| cell(&fits))
        });
        if cells[2] != "–" {
            is_open |= cells.iter().any(|cell| cell.contains('?'));
            rows.push((engine, cells));
        }
    }
    if rows.is_empty() {
        return String::new();
    }
    let mut text = format!("  {:<17}", "");
    for quantity in QUANTITIES {
        let _ = write!(text, " {:<20}", quantity.name());
    }
    text = text.trim_end().to_owned() + "\n";
    for (engine, cells) in rows {
        let mut line = format!("  {:<17}", engine.title());
        for cell in cells {
            let _ = write!(line, " {cell:<20}");
        }
        text += line.trim_end();
        text.push('\n');
    }
    if is_open {
        text += "  ? another law fits as well: the report says which\n";
    }
    text
}

/// The best law with little room.
fn cell(fits: &Fits) -> String {
    let (best, is_open) = (fits.best(), fits.supported().len() > 1);
    match fits.none_holds() {
        true => "none of them".into(),
        false => format!(
            "{}{} ±{}",
            best.law.name(),
            if is_open { "?" } else { "" },
            percent(best.deviation)
        ),
    }
}

/// `text` in lines, with those after the first moved in.
fn wrapped(text: &str, indent: usize) -> String {
    let mut all = String::new();
    let mut line = " ".repeat(indent);
    let mut is_empty = true;
    for word in text.split(' ') {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            all += line.trim_end();
            all.push('\n');
            line = " ".repeat(indent + 2);
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line += word;
        is_empty = false;
    }
    all + &line + "\n"
}
