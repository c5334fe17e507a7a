//! `study.csv`: a row for each family, engine and number of triangles.

use serde::Serialize;

use super::Study;
use super::budget::Refusal;
use super::measure::Measurement;
use halfline_explain::units::{bytes, rough_seconds, seconds};

/// A row; docs/study.md says what the columns are.
#[derive(Serialize)]
struct Row<'a> {
    family: &'a str,
    engine: &'static str,
    n: usize,
    rays: usize,
    hit_share: f64,
    nodes_per_ray: Option<f64>,
    leaves_per_ray: Option<f64>,
    triangles_per_ray: Option<f64>,
    ns_per_ray: Option<f64>,
    ns_per_ray_low: Option<f64>,
    ns_per_ray_high: Option<f64>,
    build_seconds: Option<f64>,
    bytes_per_triangle: Option<f64>,
    bytes_walked: Option<usize>,
    extrapolated: bool,
    note: String,
}

/// All measurements of `study`.
pub fn csv(study: &Study) -> String {
    let mut csv = csv::Writer::from_writer(Vec::new());
    for family in &study.families {
        for sample in &family.samples {
            for measurement in &sample.measurements {
                let row = row(family.family.name(), sample.hit_share, measurement);
                csv.serialize(row).expect("memory takes every row");
            }
        }
    }
    let bytes = csv.into_inner().expect("memory takes every row");
    String::from_utf8(bytes).expect("names and figures are text")
}

fn row<'a>(family: &'a str, hit_share: f64, measurement: &Measurement) -> Row<'a> {
    let cost = measurement.rays.as_ref();
    Row {
        family,
        engine: measurement.engine.name(),
        n: measurement.triangles,
        rays: cost.map_or(0, |cost| cost.rays),
        hit_share,
        nodes_per_ray: cost.map(|cost| cost.nodes),
        leaves_per_ray: cost.map(|cost| cost.leaves),
        triangles_per_ray: cost.map(|cost| cost.triangles),
        ns_per_ray: cost.map(|cost| cost.nanoseconds),
        ns_per_ray_low: cost.map(|cost| cost.range[0]),
        ns_per_ray_high: cost.map(|cost| cost.range[1]),
        build_seconds: measurement.build_seconds,
        bytes_per_triangle: measurement.bytes_per_triangle(),
        bytes_walked: measurement.bytes_walked,
        extrapolated: cost.is_some_and(|cost| cost.extrapolated),
        note: measurement.refusal.map_or(String::new(), note),
    }
}

/// Why there is no tree.
pub fn note(refusal: Refusal) -> String {
    match refusal {
        Refusal::Seconds(s) => format!("not built: would take about {}", duration(s)),
        Refusal::Bytes(b) => format!("not built: would take about {}", bytes(b as u64)),
        Refusal::EndedAfter(s) => format!("not built: given up after {}", duration(s)),
        Refusal::EndedAt(b) => format!("not built: given up at {}", bytes(b as u64)),
    }
}

/// Seconds, as roughly as they are known.
fn duration(value: f64) -> String {
    if value < 9.5 { seconds(value) } else { rough_seconds(value) }
}
