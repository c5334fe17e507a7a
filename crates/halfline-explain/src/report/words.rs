//! What happens in a walk, in plain sentences.

use halfline::explain::{
    Case, Content, Explanation, NearestMiss, Step, TriangleTest, Verdict, Visit,
};
use halfline::geometry::{Hit, Vec3};

use crate::units::{counted, number};

/// The name of an axis: x, y or z.
pub fn axis_name(axis: usize) -> &'static str {
    ["x", "y", "z"][axis % 3]
}

/// Coordinates, with commas.
pub fn point(Vec3 { x, y, z }: Vec3) -> String {
    format!("{}, {}, {}", number(x), number(y), number(z))
}

/// A short name of a verdict.
pub fn verdict_name(test: &TriangleTest, closest: Option<&Hit>) -> &'static str {
    match test.verdict {
        Verdict::Hit(hit) if closest.is_some_and(|closest| closest.face != hit.face) => "farther",
        Verdict::Hit(_) => "hit",
        Verdict::Beyond { .. } => "beyond",
        Verdict::Behind { .. } => "behind",
        Verdict::Outside { .. } => "outside",
        Verdict::EdgeOn => "edge-on",
        Verdict::NoArea => "no area",
    }
}

/// Why a test ended as it did; `closest` is the nearest hit of the leaf.
pub fn test(test: &TriangleTest, closest: Option<&Hit>) -> String {
    match test.verdict {
        Verdict::Hit(hit) => match closest {
            Some(closest) if closest.face != hit.face && closest.t < hit.t => {
                format!("hit at t = {}, but face {} is nearer", number(hit.t), closest.face)
            }
            Some(closest) if closest.face != hit.face => {
                let t = number(hit.t);
                format!("hit at t = {t} as well, but face {} has the lower index", closest.face)
            }
            _ => format!("hit at t = {}", number(hit.t)),
        },
        Verdict::Beyond { t } => {
            format!("beyond: the line meets it at t = {}, after the ray's end", number(t))
        }
        Verdict::Behind { t } => {
            format!("behind: the line meets it at t = {}, before the ray begins", number(t))
        }
        Verdict::Outside { edge, distance } => {
            format!("outside edge {} by {}", edge.name(), number(distance))
        }
        Verdict::EdgeOn => "edge-on: the ray lies in its plane, which is no hit".into(),
        Verdict::NoArea => "no area: its corners lie on one line, so nothing hits it".into(),
    }
}

/// From where to where.
pub fn interval(visit: &Visit) -> String {
    format!("t = {} to {}", number(visit.t_near), number(visit.t_far))
}

/// Why the walk goes on as it does.
pub fn why(step: &Step, explanation: &Explanation) -> String {
    match step {
        Step::Clip { within: Some([near, far]) } => {
            let (near, far) = (number(*near), number(*far));
            format!("The ray is within the box of all triangles from t = {near} to {far}.")
        }
        Step::Clip { within: None } if explanation.cells[0].bounds.is_empty() => {
            "There are no triangles, and so no box to meet.".into()
        }
        Step::Clip { within: None } => {
            "The ray passes by the box of all triangles, so it can hit none of them.".into()
        }
        Step::Inner { .. } => inner(step),
        Step::Leaf { at, tests, closest } => leaf(at, tests, closest.as_ref()),
        Step::Pop { at, closest, is_entered } => {
            let is_in_plane = lies_in_plane_of(at.cell, explanation);
            pop(at, closest.as_ref(), *is_entered, is_in_plane)
        }
        Step::End { .. } => ending(explanation),
    }
}

fn inner(step: &Step) -> String {
    let Step::Inner { at, axis, plane, t_split, case, plane_touched, near, far, push, .. } = step
    else {
        return String::new();
    };
    let split = number(t_split.unwrap_or(f64::NAN));
    let (t_near, t_far) = (number(at.t_near), number(at.t_far));
    let (name, plane) = (axis_name(*axis), number(*plane));
    match case {
        Case::NearOnly => format!(
            "The ray leaves the cell at t_far = {t_far}, before it comes to the plane at \
             t_split = {split}: only the near part, cell {near}, is passed."
        ),
        Case::FarOnly => format!(
            "The ray comes into the cell at t_near = {t_near}, when it has passed the plane at \
             t_split = {split} already: only the far part, cell {far}, is passed."
        ),
        Case::Both => {
            let mut text = format!(
                "The ray passes the plane at t_split = {split}, between t_near = {t_near} and \
                 t_far = {t_far}: first the near part, cell {near}; the far one, cell {far}, waits."
            );
            if *plane_touched {
                text = format!(
                    "The plane, at t_split = {split}, touches an end of the interval from \
                     t_near = {t_near} to t_far = {t_far}, as nearly as rounding tells, and what \
                     lies in it may be in either part: first the near one, cell {near}; the far \
                     one, cell {far}, waits."
                );
            }
            text
        }
        Case::ParallelBelow => format!(
            "The ray is parallel to the plane, and below it in {name}: only the part below, \
             cell {near}, is passed."
        ),
        Case::ParallelAbove => format!(
            "The ray is parallel to the plane, and above it in {name}: only the part above, \
             cell {far}, is passed."
        ),
        Case::InPlane => format!(
            "The ray lies in the plane {name} = {plane}, and may hit triangles of both parts: \
             first cell {near}; cell {}, with the same interval, waits.",
            push.map_or(*far, |push| push.cell)
        ),
    }
}

fn leaf(at: &Visit, tests: &[TriangleTest], closest: Option<&Hit>) -> String {
    let triangles = counted(tests.len() as u64, "triangle");
    match closest {
        None if tests.is_empty() => "A leaf without triangles.".into(),
        None => format!("A leaf of {triangles}: none is hit."),
        Some(hit) if hit.t > at.t_far => format!(
            "A leaf of {triangles}: the closest hit, on face {}, is at t = {}. That lies beyond \
             the cell, which ends at {}: a triangle may reach out of its cell, and something \
             nearer may still come in between.",
            hit.face,
            number(hit.t),
            number(at.t_far)
        ),
        Some(hit) => format!(
            "A leaf of {triangles}: the closest hit, on face {}, is at t = {}.",
            hit.face,
            number(hit.t)
        ),
    }
}

/// True if the ray lies in the plane at which a cell begins.
fn lies_in_plane_of(cell: usize, explanation: &Explanation) -> bool {
    let parent = explanation.cells[cell].parent.map(|(parent, _)| &explanation.cells[parent]);
    match parent.map(|parent| &parent.content) {
        Some(Content::Inner { axis, .. }) => explanation.ray.direction[*axis] == 0.0,
        _ => false,
    }
}

fn pop(at: &Visit, closest: Option<&Hit>, is_entered: bool, is_in_plane: bool) -> String {
    let cell = at.cell;
    match closest {
        Some(hit) if is_in_plane => format!(
            "Cell {cell} waited, and is taken up: the ray lies in its plane, so there may be a \
             nearer hit than that at t = {} on this side too.",
            number(hit.t)
        ),
        Some(hit) if is_entered => format!(
            "Cell {cell} waited, and is taken up: the hit at t = {} does not lie before its \
             plane, so a nearer one may be there.",
            number(hit.t)
        ),
        Some(hit) => format!(
            "Cell {cell} waited, and is dropped: the hit at t = {} lies before it begins, at \
             t = {}, so nothing there can be nearer.",
            number(hit.t),
            number(at.t_near)
        ),
        None => format!("Cell {cell} waited, and is taken up: nothing was hit before it."),
    }
}

/// Where and why the walk ended.
pub fn ending(explanation: &Explanation) -> String {
    let hit = &explanation.hit;
    if hit.is_hit() {
        return format!(
            "The walk ends: the closest hit is on face {} at t = {}, and no cell waits that could \
             hold a nearer one.",
            hit.face,
            number(hit.t)
        );
    }
    match explanation.walk.steps.first() {
        Some(Step::Clip { within: None }) => "The walk ends before it begins: a miss.".into(),
        _ => "The walk ends: no cell waits, and nothing was hit.".into(),
    }
}

/// Why the triangle that a ray passes closest is missed, and by how much.
pub fn nearest_miss(miss: &NearestMiss, size: f64) -> String {
    let NearestMiss { test, distance, t, .. } = miss;
    let face = test.face;
    let share = match *distance / size {
        share if share > 0.0 && share.is_finite() => {
            format!(", {} of the mesh's diagonal,", percent(share))
        }
        _ => String::new(),
    };
    let apart = format!("at a distance of {}{share} at t = {}", number(*distance), number(*t));
    match test.verdict {
        Verdict::Outside { edge, .. } => {
            format!("the ray passes face {face} outside its edge {}, {apart}", edge.name())
        }
        Verdict::Behind { t } => format!(
            "the ray's line meets face {face}, but behind, at t = {}; the ray begins {apart}",
            number(t)
        ),
        Verdict::Beyond { t } => format!(
            "the ray's line meets face {face}, but beyond, at t = {}; the ray ends {apart}",
            number(t)
        ),
        Verdict::EdgeOn => format!(
            "the ray lies in the plane of face {face}, which it therefore does not hit, {apart}"
        ),
        Verdict::NoArea => format!(
            "the ray passes face {face}, which nothing can hit since its corners lie on one line, \
             {apart}"
        ),
        Verdict::Hit(_) => format!("face {face}, {apart}"),
    }
}

fn percent(share: f64) -> String {
    let percent = share * 100.0;
    match percent {
        p if p >= 10.0 => format!("{p:.0} %"),
        p if p >= 0.01 => format!("{p:.2} %"),
        p => format!("{} %", number(p)),
    }
}
