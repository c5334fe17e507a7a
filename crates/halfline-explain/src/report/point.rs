//! Why a point is as far from the surface as it is, as text and JSON: docs/explain.schema.json describes the latter,
//! as `point_explanation`.

use std::fmt::Write;

use halfline::Mesh;
use halfline::explain::{EngineContent, PointExplanation, PointStep};
use halfline::geometry::{ClosestPoint, Feature};
use serde_json::{Value, json};

use super::json::{FORMAT, bounds, number as json_number, visits};
use super::text::{wrap, write_visits};
use super::words;
use crate::units::{count, counted, number};

/// An explanation of a point, and the mesh that it is about.
#[derive(Clone, Copy)]
pub struct PointReport<'a> {
    /// What people know the mesh by.
    pub name: &'a str,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// What is nearest to the point, and on which side it is.
    pub explanation: &'a PointExplanation,
}

/// Crossings that are shown one by one.
const CROSSINGS_SHOWN: usize = 8;

impl PointReport<'_> {
    /// The whole explanation.
    pub fn to_json(&self) -> Value {
        let PointReport { name, mesh, explanation } = self;
        let winding = &explanation.winding;
        let crossings = winding.crossings.iter();
        let crossings = crossings.map(|(face, sign)| json!({ "face": face, "sign": sign }));
        json!({
            "format": FORMAT,
            "halfline": env!("CARGO_PKG_VERSION"),
            "mesh": {
                "name": name,
                "triangles": mesh.triangle_count(),
                "bounds": bounds(&explanation.bounds),
            },
            "point": explanation.point.to_array(),
            "closest": match explanation.closest.is_found() {
                true => closest(&explanation.closest),
                false => Value::Null,
            },
            "signed_distance": json_number(explanation.signed_distance()),
            "is_inside": explanation.is_inside,
            "is_on_surface": winding.is_on_surface,
            "nearest": explanation.nearest.iter().map(closest).collect::<Vec<_>>(),
            "winding": {
                "number": json_number(winding.winding_number),
                "direction": winding.direction.to_array(),
                "crossings": crossings.collect::<Vec<_>>(),
                "boundary_edges": explanation.boundary_edges,
                "boundary": json_number(winding.boundary),
                "boundary_error": json_number(winding.boundary_error),
            },
            "counts": {
                "brute_force": {
                    "nodes": 0,
                    "leaves": 0,
                    "triangles": explanation.triangle_count,
                },
                "engine": visits(&explanation.visits),
            },
            "engine": {
                "steps": explanation.steps.iter().map(step).collect::<Vec<_>>(),
            },
        })
    }

    /// A report for a terminal, plain, in lines of up to a hundred columns.
    pub fn to_text(&self) -> String {
        let explanation = self.explanation;
        let mut text = String::new();
        let _ = writeln!(text, "{}: the point {}", self.name, words::point(explanation.point));
        let _ = writeln!(
            text,
            "\nThe engine's walk to what is nearest: each box is opened if it is nearer than the nearest \
             so far.\n"
        );
        for (number, step) in explanation.steps.iter().enumerate() {
            write_step(&mut text, number, step);
        }
        if explanation.steps.is_empty() && explanation.closest.is_found() {
            let why = "no box of the tree was opened: either all faces are without area, or the point is \
                       too far away for single precision, and every walk through the tree is then taken \
                       in double precision and not recorded";
            wrap(&mut text, why, 2);
        }
        text.push('\n');
        write_visits(&mut text, &[("brute force", self.all()), ("engine", explanation.visits)]);
        self.write_nearest(&mut text);
        self.write_winding(&mut text);
        self.write_answer(&mut text);
        text
    }

    fn all(&self) -> halfline::textbook::Visits {
        let triangles = self.explanation.triangle_count as u64;
        halfline::textbook::Visits { triangles, ..Default::default() }
    }

    fn write_nearest(&self, text: &mut String) {
        let nearest = &self.explanation.nearest;
        let Some(first) = nearest.first() else { return };
        let _ = writeln!(text, "\nThe nearest of the faces that were looked at:");
        let width = nearest.iter().map(|one| one.face.to_string().len()).max().unwrap_or(0);
        for one in nearest {
            let note = match one.distance == first.distance && one.face != first.face {
                true => ", no nearer than the first, which has the lower index",
                false => "",
            };
            let (distance, at) = (number(one.distance), words::point(one.point));
            let part = part_name(one.feature);
            let _ = writeln!(
                text,
                "  face {:>width$}  {distance} away, {part} it at {at}{note}",
                one.face
            );
        }
    }

    fn write_winding(&self, text: &mut String) {
        let PointExplanation { winding, boundary_edges, .. } = self.explanation;
        let leaving = winding.crossings.iter().filter(|(_, sign)| *sign > 0).count() as u64;
        let entering = winding.crossings.len() as u64 - leaving;
        let sum = leaving as i64 - entering as i64;
        let _ = writeln!(text, "\nThe winding number, {}:", number(winding.winding_number));
        let direction = words::point(winding.direction);
        let crossings = counted(winding.crossings.len() as u64, "crossing");
        wrap(
            text,
            &format!(
                "{sum:+} from the {crossings} of a ray along {direction}: {} out of the surface, {} \
                 into it",
                count(leaving),
                count(entering),
            ),
            2,
        );
        for (face, sign) in winding.crossings.iter().take(CROSSINGS_SHOWN) {
            let way = if *sign > 0 { "out" } else { "in" };
            let _ = writeln!(text, "      face {face}  {sign:+}  {way}");
        }
        if let Some(more @ 1..) = winding.crossings.len().checked_sub(CROSSINGS_SHOWN) {
            let _ = writeln!(text, "      and {} more", count(more as u64));
        }
        match boundary_edges {
            0 => wrap(text, "the surface has no boundary, so that is all of it, exactly", 2),
            &edges => {
                let (share, error) = (winding.boundary, number(winding.boundary_error));
                let edges = count(edges as u64);
                let share = if share < 0.0 { number(share) } else { format!("+{}", number(share)) };
                let what =
                    format!("{share} from the {edges} edges of the boundary, within {error}");
                wrap(text, &what, 2);
            }
        }
    }

    fn write_answer(&self, text: &mut String) {
        let explanation = self.explanation;
        let closest = &explanation.closest;
        text.push('\n');
        if !closest.is_found() {
            let _ = writeln!(text, "Nothing is near it, for the mesh has no surface.");
            return;
        }
        let (face, at, part) =
            (closest.face, words::point(closest.point), part_name(closest.feature));
        let answer = match (
            explanation.winding.is_on_surface || closest.distance == 0.0,
            explanation.is_inside,
        ) {
            (true, _) => {
                format!("It lies on the surface, {part} face {face}, and so counts as inside.")
            }
            (_, true) => format!(
                "It is inside, {} from the surface: nearest is {at}, {part} face {face}. Its winding \
                 number is above a half.",
                number(closest.distance)
            ),
            _ => format!(
                "It is outside, {} from the surface: nearest is {at}, {part} face {face}. Its winding \
                 number is not above a half.",
                number(closest.distance)
            ),
        };
        wrap(text, &answer, 0);
    }
}

fn feature_name(feature: Feature) -> &'static str {
    match feature {
        Feature::Face => "face",
        Feature::Edge => "edge",
        Feature::Vertex => "vertex",
    }
}

fn part_name(feature: Feature) -> &'static str {
    match feature {
        Feature::Face => "inside",
        Feature::Edge => "on an edge of",
        Feature::Vertex => "at a vertex of",
    }
}

fn closest(closest: &ClosestPoint) -> Value {
    json!({
        "distance": json_number(closest.distance),
        "point": closest.point.to_array(),
        "face": closest.face,
        "uv": [closest.u, closest.v],
        "feature": feature_name(closest.feature),
    })
}

fn step(step: &PointStep) -> Value {
    let (kind, children, faces) = match &step.content {
        EngineContent::Node { children } => ("node", json!(children), Value::Null),
        EngineContent::Leaf { faces } => ("leaf", Value::Null, json!(faces)),
    };
    json!({
        "kind": kind,
        "depth": step.depth,
        "bounds": bounds(&step.bounds),
        "children": children,
        "faces": faces,
        "distance": json_number(step.distance),
        "limit": json_number(step.limit),
    })
}

fn write_step(text: &mut String, index: usize, step: &PointStep) {
    let what = match &step.content {
        EngineContent::Node { children } => {
            format!("node {} of {children} children", step.index)
        }
        EngineContent::Leaf { faces } => {
            let faces: Vec<String> = faces.iter().map(u32::to_string).collect();
            format!("leaf {}, faces {}", step.index, faces.join(" "))
        }
    };
    let so_far = match step.limit.is_finite() {
        true => format!("the nearest so far {}", number(step.limit)),
        false => "nothing met yet".into(),
    };
    let (depth, distance) = (step.depth, number(step.distance));
    let _ = writeln!(text, "{index:>4}  depth {depth}, {distance} away, {so_far}: {what}");
}
