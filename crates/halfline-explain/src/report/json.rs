//! An explanation as JSON: docs/explain.schema.json describes it. Whoever changes what is written here
//! changes that, and [`FORMAT`] if readers of the old one would be wrong.

use std::collections::BTreeSet;

use halfline::explain::{
    Cell, Content, EngineContent, EngineStep, Side, Step, TriangleTest, Verdict, Visit,
};
use halfline::geometry::{Aabb, Hit};
use halfline::textbook::Visits;
use serde_json::{Map, Value, json};

use super::{Report, words};

/// The version of what is written.
pub(super) const FORMAT: u32 = 1;

/// All of an explanation.
pub fn of(report: &Report) -> Value {
    let Report { name, mesh, explanation } = report;
    let ray = &explanation.ray;
    let brute_force = Visits { triangles: explanation.triangle_count as u64, ..Visits::default() };
    let steps = explanation.walk.steps.iter().map(|step| step_value(report, step));
    json!({
        "format": FORMAT,
        "halfline": env!("CARGO_PKG_VERSION"),
        "mesh": {
            "name": name,
            "triangles": mesh.triangle_count(),
            "bounds": bounds(&explanation.cells[0].bounds),
        },
        "ray": {
            "origin": ray.origin.to_array(),
            "direction": ray.direction.to_array(),
            "t_min": number(ray.t_min),
            "t_max": number(ray.t_max),
        },
        "tree": {
            "rule": explanation.rule.name(),
            "maximum_depth": explanation.termination.maximum_depth,
            "few_triangles": explanation.termination.few_triangles,
        },
        "hit": hit_value(report),
        "nearest_miss": nearest_miss(report),
        "ending": words::ending(explanation),
        "counts": {
            "brute_force": visits(&brute_force),
            "textbook": visits(&explanation.walk.visits),
            "engine": visits(&explanation.engine.visits),
        },
        "cells": explanation.cells.iter().map(cell).collect::<Vec<_>>(),
        "steps": steps.collect::<Vec<_>>(),
        "triangles": triangles(report),
        "engine": {
            "steps": explanation.engine.steps.iter().map(engine_step).collect::<Vec<_>>(),
        },
    })
}

/// A number, or null for one that JSON cannot hold.
pub(super) fn number(value: f64) -> Value {
    json!(value)
}

pub(super) fn bounds(bounds: &Aabb) -> Value {
    match bounds.is_empty() {
        true => Value::Null,
        false => json!([bounds.min.to_array(), bounds.max.to_array()]),
    }
}

pub(super) fn visits(visits: &Visits) -> Value {
    let Visits { nodes, leaves, triangles } = visits;
    json!({ "nodes": nodes, "leaves": leaves, "triangles": triangles })
}

fn hit_value(report: &Report) -> Value {
    let hit = &report.explanation.hit;
    if !hit.is_hit() {
        return Value::Null;
    }
    let point = report.explanation.ray.at(hit.t).to_array();
    json!({ "t": hit.t, "face": hit.face, "uv": [hit.u, hit.v], "point": point })
}

fn nearest_miss(report: &Report) -> Value {
    let Some(miss) = &report.explanation.nearest_miss else { return Value::Null };
    let size = report.explanation.cells[0].bounds.extent().length();
    json!({
        "face": miss.test.face,
        "distance": number(miss.distance),
        "t": number(miss.t),
        "point_on_ray": miss.point_on_ray.to_array(),
        "point_on_face": miss.point_on_face.to_array(),
        "why": words::nearest_miss(miss, size),
    })
}

fn cell(cell: &Cell) -> Value {
    let (axis, plane, children) = match &cell.content {
        Content::Inner { axis, plane, children } => {
            (json!(words::axis_name(*axis)), number(*plane), json!(children))
        }
        Content::Leaf { .. } | Content::Unknown { .. } => (Value::Null, Value::Null, Value::Null),
    };
    let side = cell.parent.map(|(_, side)| match side {
        Side::Below => "below",
        Side::Above => "above",
    });
    json!({
        "depth": cell.depth,
        "parent": cell.parent.map(|(parent, _)| parent),
        "side": side,
        "bounds": bounds(&cell.bounds),
        "triangles": cell.triangle_count,
        "axis": axis,
        "plane": plane,
        "children": children,
    })
}

fn interval(visit: &Visit) -> Value {
    json!([number(visit.t_near), number(visit.t_far)])
}

fn closest(hit: Option<&Hit>) -> Value {
    hit.map_or(Value::Null, |hit| json!({ "face": hit.face, "t": hit.t }))
}

fn step_value(report: &Report, step: &Step) -> Value {
    let why = words::why(step, report.explanation);
    match step {
        Step::Clip { within } => json!({
            "kind": "clip",
            "cell": 0,
            "t_near": within.map(|[near, _]| near),
            "t_far": within.map(|[_, far]| far),
            "is_met": within.is_some(),
            "why": why,
        }),
        Step::Inner {
            at,
            axis,
            plane,
            t_split,
            t_split_bounds: _,
            case,
            plane_touched,
            near,
            far,
            enter,
            push,
        } => json!({
            "kind": "inner",
            "cell": at.cell,
            "t_near": number(at.t_near),
            "t_far": number(at.t_far),
            "axis": words::axis_name(*axis),
            "plane": number(*plane),
            "t_split": t_split.map(number),
            "case": case.name(),
            "plane_touched": plane_touched,
            "near": near,
            "far": far,
            "enter": enter.cell,
            "enter_interval": interval(enter),
            "push": push.map(|push| push.cell),
            "push_interval": push.as_ref().map(interval),
            "why": why,
        }),
        Step::Leaf { at, tests, closest: nearest } => json!({
            "kind": "leaf",
            "cell": at.cell,
            "t_near": number(at.t_near),
            "t_far": number(at.t_far),
            "tests": tests.iter().map(|test| test_value(test, nearest.as_ref())).collect::<Vec<_>>(),
            "closest": closest(nearest.as_ref()),
            "why": why,
        }),
        Step::Pop { at, closest: _, is_entered } => json!({
            "kind": "pop",
            "cell": at.cell,
            "t_near": number(at.t_near),
            "t_far": number(at.t_far),
            "is_entered": is_entered,
            "why": why,
        }),
        Step::End { hit } => json!({ "kind": "end", "hit": closest(hit.as_ref()), "why": why }),
    }
}

fn test_value(test: &TriangleTest, nearest: Option<&Hit>) -> Value {
    let (t, edge, by) = match test.verdict {
        Verdict::Hit(hit) => (number(hit.t), Value::Null, Value::Null),
        Verdict::Beyond { t } | Verdict::Behind { t } => (number(t), Value::Null, Value::Null),
        Verdict::Outside { edge, distance } => (Value::Null, json!(edge.name()), number(distance)),
        Verdict::EdgeOn | Verdict::NoArea => (Value::Null, Value::Null, Value::Null),
    };
    json!({
        "face": test.face,
        "edge_signs": test.edge_signs,
        "verdict": words::verdict_name(test, nearest),
        "t": t,
        "edge": edge,
        "by": by,
        "why": words::test(test, nearest),
    })
}

/// The corners of every face that was tested, and of the nearest miss.
fn triangles(report: &Report) -> Value {
    let mut faces = BTreeSet::new();
    for step in &report.explanation.walk.steps {
        if let Step::Leaf { tests, .. } = step {
            faces.extend(tests.iter().map(|test| test.face));
        }
    }
    faces.extend(report.explanation.nearest_miss.map(|miss| miss.test.face));
    let corners = |face: u32| json!(report.mesh.corners(face).map(|corner| corner.to_array()));
    let triangles = faces.into_iter().map(|face| (face.to_string(), corners(face)));
    Value::Object(triangles.collect::<Map<_, _>>())
}

fn engine_step(step: &EngineStep) -> Value {
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
        "t_limit": number(step.t_limit),
    })
}
