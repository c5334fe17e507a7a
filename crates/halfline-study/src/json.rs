//! The study as one JSON object.

use serde_json::{Value, json};

use super::engine::Engine;
use super::fit::Fits;
use super::growth::Quantity;
use super::machine::Machine;
use super::measure::{Measurement, Sample};
use super::share::Shares;
use super::speedup::SpeedUp;
use super::{FamilyStudy, LECTURE_SIZES, Study};

/// Machine, families, shares and findings.
pub fn figures(study: &Study) -> Value {
    let findings: Vec<Value> = study
        .findings()
        .into_iter()
        .map(|finding| json!({ "topic": finding.topic, "text": finding.text }))
        .collect();
    json!({
        "machine": machine(&study.machine),
        "families": study.families.iter().map(family).collect::<Vec<_>>(),
        "shares": study.shares.iter().map(shares).collect::<Vec<_>>(),
        "findings": findings,
    })
}

fn machine(machine: &Machine) -> Value {
    let caches: Vec<Value> = machine
        .caches
        .iter()
        .map(|cache| json!({ "level": cache.level, "bytes": cache.bytes }))
        .collect();
    json!({
        "processor": machine.processor,
        "cores": machine.cores,
        "caches": caches,
        "memory_bytes": machine.memory_bytes,
        "system": machine.system,
    })
}

fn family(family: &FamilyStudy) -> Value {
    let rows: Vec<Value> = family
        .samples
        .iter()
        .flat_map(|sample| sample.measurements.iter().map(|m| row(sample, m)))
        .collect();
    let mut growths = Vec::new();
    for engine in Engine::ALL {
        for quantity in Quantity::ALL {
            if let Some(fits) = family.growth(engine, quantity).fits {
                growths.push(growth(engine, quantity, &fits));
            }
        }
    }
    let cache_ends: Vec<Value> = Engine::ALL
        .into_iter()
        .filter_map(|engine| family.cache_end(engine))
        .map(|found| {
            json!({
                "engine": found.engine.name(),
                "floor_ns_per_visit": found.floor,
                "end_bytes": found.end.map(|end| end.bytes),
                "end_triangles": found.end.map(|end| end.triangles),
                "largest_triangles": found.largest.0,
                "largest_factor": found.largest.1,
            })
        })
        .collect();
    let mut speed_ups = Vec::new();
    for n in LECTURE_SIZES {
        let found = Engine::ALL.into_iter().filter(|&engine| engine != Engine::BruteForce);
        speed_ups
            .extend(found.filter_map(|engine| family.speed_up(engine, n)).map(|s| speed_up(&s)));
    }
    json!({
        "family": family.family.name(),
        "description": family.family.description(),
        "rows": rows,
        "growth": growths,
        "cache": cache_ends,
        "speed_up": speed_ups,
    })
}

fn row(sample: &Sample, measurement: &Measurement) -> Value {
    let cost = measurement.rays.as_ref();
    json!({
        "engine": measurement.engine.name(),
        "n": measurement.triangles,
        "rays": cost.map(|cost| cost.rays),
        "hit_share": sample.hit_share,
        "nodes_per_ray": cost.map(|cost| cost.nodes),
        "leaves_per_ray": cost.map(|cost| cost.leaves),
        "triangles_per_ray": cost.map(|cost| cost.triangles),
        "ns_per_ray": cost.map(|cost| cost.nanoseconds),
        "build_seconds": measurement.build_seconds,
        "bytes_per_triangle": measurement.bytes_per_triangle(),
        "extrapolated": cost.is_some_and(|cost| cost.extrapolated),
        "note": measurement.refusal.map(super::csv::note),
    })
}

fn growth(engine: Engine, quantity: Quantity, fits: &Fits) -> Value {
    let laws: Vec<Value> = fits
        .ranked
        .iter()
        .map(|fit| {
            json!({
                "law": fit.law.name(),
                "a": fit.a,
                "b": fit.b,
                "deviation": fit.deviation,
                "aicc": fit.aicc,
            })
        })
        .collect();
    json!({
        "engine": engine.name(),
        "quantity": quantity.name(),
        "verdict": fits.verdict(),
        "points": fits.points,
        "laws": laws,
    })
}

fn speed_up(speed_up: &SpeedUp) -> Value {
    json!({
        "engine": speed_up.engine.name(),
        "n": speed_up.triangles,
        "factor": speed_up.factor(),
        "brute_ns_per_ray": speed_up.brute.nanoseconds,
        "brute_extrapolated": speed_up.brute.extrapolated,
        "ns_per_ray": speed_up.tree.nanoseconds,
        "extrapolated": speed_up.tree.extrapolated,
    })
}

fn shares(shares: &Shares) -> Value {
    let [generation, intersection, shading] = shares.parts();
    json!({
        "engine": shares.engine.name(),
        "n": shares.triangles,
        "resolution": shares.resolution,
        "rays": shares.rays,
        "seconds": shares.seconds(),
        "ray_generation": generation,
        "intersection": intersection,
        "shading": shading,
    })
}
