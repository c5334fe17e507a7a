//! What `halfline doctor` tells, in figures and in a table.

use std::borrow::Cow;
use std::path::Path;

use serde::Serialize;

use crate::report::Report;
use crate::source::Source;
use crate::table::Table;
use crate::{input, units};

/// What is wrong with a mesh, and whether rays slip through it.
#[derive(Serialize)]
pub(super) struct DoctorReport<'a> {
    pub(super) mesh: Cow<'a, str>,
    #[serde(flatten)]
    pub(super) surface: SurfaceReport,
    #[serde(flatten)]
    pub(super) rays: RayReport,
    pub(super) seed: u64,
    pub(super) preset: &'a str,
    pub(super) content_hash: Option<String>,
    pub(super) verdict: String,
    pub(super) load_seconds: f64,
    pub(super) examine_seconds: f64,
    pub(super) build_seconds: f64,
    pub(super) peak_memory_bytes: Option<u64>,
    #[serde(skip)]
    pub(super) source: &'a Source,
    /// The first rays that failed, as rows for `numpy.array`.
    #[serde(skip)]
    pub(super) failed_rays: String,
}

/// How a mesh hangs together.
#[derive(Serialize)]
pub(super) struct SurfaceReport {
    pub(super) triangles: usize,
    pub(super) vertices: usize,
    pub(super) duplicate_vertices: usize,
    pub(super) unreferenced_vertices: usize,
    pub(super) edges: usize,
    pub(super) open_edges: Defect,
    pub(super) non_manifold_edges: Defect,
    pub(super) inconsistent_edges: Defect,
    pub(super) degenerate_faces: Defect,
    pub(super) non_finite_faces: Defect,
    pub(super) duplicate_faces: Defect,
    pub(super) components: usize,
    pub(super) euler_characteristic: i64,
    pub(super) closed: bool,
    pub(super) consistent: bool,
    pub(super) facing: Option<&'static str>,
    pub(super) volume: Option<f64>,
}

/// How often something is wrong, and the faces of the file in which it was found first.
#[derive(Serialize)]
pub(super) struct Defect {
    pub(super) count: usize,
    pub(super) first_faces: Vec<u32>,
}

/// What aimed rays did.
#[derive(Serialize)]
pub(super) struct RayReport {
    pub(super) origins: Vec<[f64; 3]>,
    pub(super) from_inside: bool,
    pub(super) targets: usize,
    pub(super) rays: u64,
    pub(super) certain_rays: u64,
    pub(super) crossings: u64,
    pub(super) leaks: u64,
    pub(super) wrong_parities: u64,
    pub(super) late_hits: u64,
    pub(super) examples: Vec<ExampleReport>,
    pub(super) closest_rays_per_second: f64,
    pub(super) all_rays_per_second: f64,
    pub(super) closest_seconds: f64,
    pub(super) all_seconds: f64,
}

/// A ray that did what it must not do.
#[derive(Serialize)]
pub(super) struct ExampleReport {
    /// Origin and direction.
    pub(super) ray: [f64; 6],
    pub(super) aimed_at: String,
    pub(super) triangle: u32,
    pub(super) source_face: u32,
    pub(super) leak: bool,
    pub(super) wrong_parity: bool,
    pub(super) late_hit: bool,
    /// None of a ray that hit nothing.
    pub(super) closest_t: Option<f64>,
    pub(super) crossings: usize,
}

impl Report for DoctorReport<'_> {
    const IS_THE_RESULT: bool = true;

    fn to_text(&self) -> String {
        let mut table = Table::new(input::name(Path::new(&*self.mesh)).display());
        self.surface.rows(&mut table);
        table.row("load", units::seconds(self.load_seconds), "");
        self.source.build_row(&mut table, "");
        table.row("examine", units::seconds(self.examine_seconds), "");
        self.rays.rows(&mut table);
        table.print() + &self.failed_rays + &self.verdict + "\n"
    }
}

impl SurfaceReport {
    fn rows(&self, table: &mut Table) {
        let count = |value: usize| units::count(value as u64);
        table.row("triangles", count(self.triangles), "");
        let mut notes = Vec::new();
        if self.duplicate_vertices > 0 {
            notes.push(format!("{} where another lies", count(self.duplicate_vertices)));
        }
        if self.unreferenced_vertices > 0 {
            notes.push(format!("{} of no triangle", count(self.unreferenced_vertices)));
        }
        table.row("vertices", count(self.vertices), notes.join(", "));
        table.row("edges", count(self.edges), "");
        for (label, defect, meaning) in [
            ("open edges", &self.open_edges, "of one triangle"),
            ("non-manifold", &self.non_manifold_edges, "edges of 3 or more"),
            (
                "inconsistent",
                &self.inconsistent_edges,
                "edges whose two triangles run the same way",
            ),
            ("degenerate", &self.degenerate_faces, "triangles without area"),
            ("non-finite", &self.non_finite_faces, "triangles with NaN, infinity"),
            ("duplicate", &self.duplicate_faces, "triangles with the corners of one before them"),
        ] {
            table.row(label, count(defect.count), defect.note(meaning));
        }
        let note = format!("Euler characteristic {}", self.euler_characteristic);
        table.row("components", count(self.components), note);
        if let Some(volume) = self.volume {
            table.row("volume", units::number(volume), "");
        }
    }
}

impl Defect {
    /// What it is, and in which faces.
    fn note(&self, meaning: &str) -> String {
        let faces = &self.first_faces;
        let named: Vec<String> = faces.iter().map(u32::to_string).collect();
        match self.count {
            0 => meaning.into(),
            // One face may have several of the edges, so count what could not be shown.
            n if n > faces.len() => format!("{meaning}: faces {}, ...", named.join(", ")),
            1 => format!("{meaning}: face {}", named[0]),
            _ => format!("{meaning}: faces {}", named.join(", ")),
        }
    }
}

impl RayReport {
    fn rows(&self, table: &mut Table) {
        if self.rays == 0 {
            return;
        }
        let whence = match self.from_inside {
            true => "inside",
            false => "in the middle and around",
        };
        let note = format!(
            "from {} {} {whence}, at {} vertices and edges",
            self.origins.len(),
            if self.origins.len() == 1 { "point" } else { "points" },
            units::count(self.targets as u64)
        );
        table.row("rays", units::count(self.rays), note);
        let note = "meet their target without any rounding";
        table.row("  certain", units::count(self.certain_rays), note);
        table.row("  leaks", units::count(self.leaks), "hit nothing, but must");
        if self.from_inside {
            let note = "cross the surface an even number of times, but it must be odd";
            table.row("  wrong parity", units::count(self.wrong_parities), note);
        }
        let note = "hit first what lies behind something";
        table.row("  late", units::count(self.late_hits), note);
        for (label, seconds, speed) in [
            ("closest hits", self.closest_seconds, self.closest_rays_per_second),
            ("all hits", self.all_seconds, self.all_rays_per_second),
        ] {
            table.row(label, units::seconds(seconds), format!("{}rays/s", units::metric(speed)));
        }
    }
}
