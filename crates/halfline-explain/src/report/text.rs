//! An explanation for a terminal.

use std::fmt::Write;

use halfline::explain::{Step, TriangleTest, Verdict};
use halfline::geometry::Hit;
use halfline::textbook::Visits;

use super::{Report, words};
use crate::units::{count, counted, number};

/// Columns that lines have at most, where words allow.
const WIDTH: usize = 96;

/// Of a leaf's triangles that are missed so many are shown at most, those that are passed closest.
const MISSES_SHOWN: usize = 6;

/// The whole explanation as text.
pub fn of(report: &Report) -> String {
    let explanation = report.explanation;
    let ray = &explanation.ray;
    let mut text = String::new();
    let (origin, direction) = (words::point(ray.origin), words::point(ray.direction));
    let _ = writeln!(text, "{}: the ray from {origin} along {direction}", report.name);
    if (ray.t_min, ray.t_max) != (0.0, f64::INFINITY) {
        let _ = writeln!(text, "from t = {} to {}", number(ray.t_min), number(ray.t_max));
    }
    let _ = writeln!(
        text,
        "\nIts walk through the textbook's tree ({}, at most {} levels deep). Signs are those of the \
         edges\nb-c, c-a and a-b: a triangle is met where no two are opposite.\n",
        explanation.rule, explanation.termination.maximum_depth
    );
    for (number, step) in explanation.walk.steps.iter().enumerate() {
        write_step(&mut text, report, number, step);
    }
    write_counts(&mut text, report);
    write_answer(&mut text, report);
    text
}

fn write_step(text: &mut String, report: &Report, index: usize, step: &Step) {
    let explanation = report.explanation;
    let heading = match step {
        Step::Clip { .. } => "the box of all triangles".to_owned(),
        Step::Inner { at, axis, plane, case, plane_touched, .. } => {
            let (name, plane) = (words::axis_name(*axis), number(*plane));
            let depth = explanation.cells[at.cell].depth;
            let touched = if *plane_touched { ", plane touched" } else { "" };
            let case = case.name();
            format!("cell {}, depth {depth}, plane {name} = {plane}: {case}{touched}", at.cell)
        }
        Step::Leaf { at, .. } => {
            let depth = explanation.cells[at.cell].depth;
            format!("cell {}, depth {depth}, a leaf, {}", at.cell, words::interval(at))
        }
        Step::Pop { at, is_entered, .. } => {
            let what = if *is_entered { "popped" } else { "popped and dropped" };
            format!("cell {} {what}, {}", at.cell, words::interval(at))
        }
        Step::End { .. } => "end".to_owned(),
    };
    let _ = writeln!(text, "{index:>4}  {heading}");
    wrap(text, &words::why(step, explanation), 6);
    if let Step::Leaf { tests, closest, .. } = step {
        write_tests(text, tests, closest.as_ref());
    }
}

fn write_tests(text: &mut String, tests: &[TriangleTest], closest: Option<&Hit>) {
    // Show all but those that are missed by far.
    let mut distances: Vec<f64> = tests.iter().filter_map(distance).collect();
    distances.sort_by(f64::total_cmp);
    let farthest = distances.get(MISSES_SHOWN).copied().unwrap_or(f64::INFINITY);
    let is_shown = |test: &TriangleTest| distance(test).is_none_or(|d| d < farthest);
    let shown = tests.iter().filter(|test| is_shown(test));
    let width = shown.clone().map(|test| test.face.to_string().len()).max().unwrap_or(0);
    for test in shown {
        let signs = test.edge_signs.map(sign).join(" ");
        let why = words::test(test, closest);
        let _ = writeln!(text, "      face {:>width$}  {signs}  {why}", test.face);
    }
    let hidden = tests.iter().filter(|test| !is_shown(test)).count() as u64;
    if hidden > 0 {
        let what = counted(hidden, "triangle");
        let _ = writeln!(text, "      and {what} that the ray passes farther off");
    }
}

fn distance(test: &TriangleTest) -> Option<f64> {
    match test.verdict {
        Verdict::Outside { distance, .. } => Some(distance),
        _ => None,
    }
}

fn sign(sign: i8) -> &'static str {
    match sign {
        1 => "+",
        -1 => "-",
        _ => "0",
    }
}

fn write_counts(text: &mut String, report: &Report) {
    let explanation = report.explanation;
    let all = Visits { triangles: explanation.triangle_count as u64, ..Visits::default() };
    let (textbook, engine) = (explanation.walk.visits, explanation.engine.visits);
    text.push('\n');
    write_visits(text, &[("brute force", all), ("textbook", textbook), ("engine", engine)]);
}

/// A table of what was visited, by whom.
pub(super) fn write_visits(text: &mut String, rows: &[(&str, Visits)]) {
    let _ = writeln!(text, "{:<13}{:>8}{:>8}{:>13}", "", "nodes", "leaves", "triangles");
    for (name, Visits { nodes, leaves, triangles }) in rows {
        let (nodes, leaves, triangles) = (count(*nodes), count(*leaves), count(*triangles));
        let _ = writeln!(text, "{name:<13}{nodes:>8}{leaves:>8}{triangles:>13}");
    }
}

fn write_answer(text: &mut String, report: &Report) {
    let explanation = report.explanation;
    let hit = &explanation.hit;
    text.push('\n');
    if hit.is_hit() {
        let (t, point) = (number(hit.t), words::point(explanation.ray.at(hit.t)));
        let (face, u, v) = (hit.face, number(hit.u), number(hit.v));
        let _ =
            writeln!(text, "It hits face {face} at t = {t}, u = {u}, v = {v}, which is {point}.");
        return;
    }
    match &explanation.nearest_miss {
        Some(miss) => {
            let size = explanation.cells[0].bounds.extent().length();
            let why = words::nearest_miss(miss, size);
            wrap(text, &format!("It misses. The nearest miss: {why}."), 0);
            let (on_ray, on_face) =
                (words::point(miss.point_on_ray), words::point(miss.point_on_face));
            let _ = writeln!(text, "The two are nearest at {on_ray} (ray) and {on_face} (face).");
        }
        None => {
            let _ = writeln!(text, "It misses, for the mesh has no triangles to hit.");
        }
    }
}

/// Adds a paragraph, its lines indented.
pub(super) fn wrap(text: &mut String, paragraph: &str, indent: usize) {
    let mut column = 0;
    for word in paragraph.split_whitespace() {
        let length = word.chars().count();
        if column > 0 && column + 1 + length > WIDTH {
            text.push('\n');
            column = 0;
        }
        if column == 0 {
            text.extend(std::iter::repeat_n(' ', indent));
            column = indent;
        } else {
            text.push(' ');
            column += 1;
        }
        text.push_str(word);
        column += length;
    }
    text.push('\n');
}
