//! What `halfline distance` tells.

use std::borrow::Cow;
use std::path::Path;

use serde::Serialize;

use super::deviation::Deviation;
use super::options::Options;
use crate::report::{self, Report, Skipped};
use crate::table::Table;
use crate::{input, units};

/// How far two meshes are from each other, and what it cost to know.
#[derive(Serialize)]
pub struct DistanceReport<'a> {
    mesh: Cow<'a, str>,
    to: Cow<'a, str>,
    output: Option<Cow<'a, str>>,
    picture: Option<Cow<'a, str>>,
    triangles: u64,
    to_triangles: u64,
    to_skipped: Skipped,
    points: &'static str,
    seed: Option<u64>,
    signed: bool,
    tolerance: Option<f64>,
    /// From the mesh to the other.
    forward: Deviation,
    /// From the other to the mesh.
    backward: Option<Deviation>,
    /// The larger of both Hausdorff distances.
    symmetric_hausdorff: Option<f64>,
    points_per_second: f64,
    load_seconds: f64,
    build_seconds: f64,
    measure_seconds: f64,
    trace_seconds: f64,
    write_seconds: f64,
    peak_memory_bytes: Option<u64>,
    #[serde(skip)]
    has_files: bool,
}

/// How long it took.
#[derive(Default)]
pub struct Seconds {
    pub load: f64,
    pub build: f64,
    pub measure: f64,
    pub trace: f64,
    pub write: f64,
    /// Points that were measured meanwhile, those of files included.
    pub points: u64,
}

impl<'a> DistanceReport<'a> {
    /// The report of a run.
    pub fn new(
        options: &'a Options,
        found: Found,
        seconds: Seconds,
        peak_memory_bytes: Option<u64>,
    ) -> DistanceReport<'a> {
        let Found { triangles, to_triangles, to_skipped, forward, backward } = found;
        let symmetric_hausdorff =
            backward.as_ref().map(|backward| forward.hausdorff.max(backward.hausdorff));
        DistanceReport {
            mesh: report::name(&options.mesh),
            to: report::name(&options.to),
            output: options.output.as_deref().map(report::name),
            picture: options.picture.as_deref().map(report::name),
            triangles,
            to_triangles,
            to_skipped,
            points: if options.samples.is_some() { "samples" } else { "vertices" },
            seed: options.samples.map(|_| options.seed),
            signed: options.signed,
            tolerance: options.tolerance,
            symmetric_hausdorff,
            points_per_second: report::per_second(seconds.points, seconds.measure),
            forward,
            backward,
            load_seconds: seconds.load,
            build_seconds: seconds.build,
            measure_seconds: seconds.measure,
            trace_seconds: seconds.trace,
            write_seconds: seconds.write,
            peak_memory_bytes,
            has_files: options.output.is_some() || options.picture.is_some(),
        }
    }

    fn side(&self, [from, to]: [&str; 2], deviation: &Deviation) -> String {
        let name = |path: &str| input::name(Path::new(path)).display().to_string();
        let mut table = Table::new(format!("{} to {}", name(from), name(to)));
        deviation.rows(&mut table, self.points, self.tolerance);
        table.print()
    }

    fn costs(&self) -> Table {
        let mut table = Table::new("in all");
        if let Some(distance) = self.symmetric_hausdorff {
            table.row("Hausdorff", units::number(distance), "the larger of both, symmetric");
        }
        let count = units::count;
        let note = format!("{} and {} triangles", count(self.triangles), count(self.to_triangles));
        table.row("load", units::seconds(self.load_seconds), note);
        table.row("build", units::seconds(self.build_seconds), "");
        let speed = units::metric(self.points_per_second);
        table.row("measure", units::seconds(self.measure_seconds), format!("{speed}points/s"));
        if self.picture.is_some() {
            table.row("trace", units::seconds(self.trace_seconds), "");
        }
        if self.has_files {
            let files: Vec<&str> =
                [&self.output, &self.picture].into_iter().flatten().map(|name| &**name).collect();
            table.row("write", units::seconds(self.write_seconds), files.join(", "));
        }
        table
    }
}

/// What was found out.
pub struct Found {
    /// Triangles of the mesh.
    pub triangles: u64,
    /// Triangles of the other.
    pub to_triangles: u64,
    /// Those of them that have no area or are not finite.
    pub to_skipped: Skipped,
    /// From the mesh to the other.
    pub forward: Deviation,
    /// From the other to the mesh, if asked for.
    pub backward: Option<Deviation>,
}

impl Report for DistanceReport<'_> {
    const IS_THE_RESULT: bool = true;

    fn to_text(&self) -> String {
        let mut text = self.side([&self.mesh, &self.to], &self.forward);
        if let Some(backward) = &self.backward {
            text += &self.side([&self.to, &self.mesh], backward);
        }
        text + &self.costs().print()
    }
}
