//! `halfline render`: a picture of a mesh.

mod cluster;
mod options;
mod picture_options;

use std::borrow::Cow;
use std::io::BufWriter;
use std::path::Path;

use halfline::progress::Stage;
use halfline_render::{RayCounts, Rendering};
use serde::Serialize;

pub use options::Options;

use crate::failure::Failure;
use crate::host::Host;
use crate::report::{Report, Skipped};
use crate::session::Session;
use crate::source::Source;
use crate::table::Table;
use crate::{left_out, output, report, session, units};

/// Draws the picture.
pub fn run(options: &Options, session: Session, host: Option<&dyn Host>) -> Result<(), Failure> {
    output::check(&options.output, &[&options.mesh])?;
    if is_exr(&options.output) && !cfg!(feature = "exr") {
        return Err(left_out::lacking("--output as .exr").into());
    }
    let settings = options.picture.settings().map_err(Failure::Usage)?;
    let cluster = cluster::connect(options, host)?;
    let source = Source::open(&options.mesh, &options.tree, &session)?;
    let scene = &source.scene;
    let triangles = scene.mesh().triangle_count() as u64;
    let (rendering, trace_seconds) = match &cluster {
        Some(cluster) => cluster::trace(&**cluster, &source, &settings, options, &session)?,
        None => session
            .timed(Stage::Trace, |observer| halfline_render::render(scene, &settings, observer))?,
    };
    let write_seconds = write(&options.output, &rendering, &session)?;

    session.tell(&RenderReport {
        mesh: report::name(&options.mesh),
        output: report::name(&options.output),
        triangles,
        skipped: Skipped::of(scene),
        width: settings.width,
        height: settings.height,
        shading: settings.shading.name(),
        samples: settings.samples,
        seed: settings.seed,
        preset: source.preset,
        cluster: options.cluster.as_deref(),
        coverage: rendering.coverage(),
        rays: rendering.statistics.rays.total(),
        rays_by_kind: rendering.statistics.rays,
        // On a cluster the seconds of the parts add up to more than passed.
        rays_per_second: report::per_second(rendering.statistics.rays.total(), trace_seconds),
        load_seconds: source.load_seconds,
        build_seconds: source.build_seconds,
        trace_seconds,
        write_seconds,
        peak_memory_bytes: session::peak_memory_bytes(),
        source: &source,
    })
}

/// What a picture is of, and what it cost.
#[derive(Serialize)]
struct RenderReport<'a> {
    mesh: Cow<'a, str>,
    output: Cow<'a, str>,
    triangles: u64,
    skipped: Skipped,
    width: u32,
    height: u32,
    shading: &'a str,
    samples: u32,
    seed: u64,
    preset: &'a str,
    cluster: Option<&'a str>,
    coverage: f64,
    rays: u64,
    rays_by_kind: RayCounts,
    rays_per_second: f64,
    load_seconds: f64,
    build_seconds: f64,
    trace_seconds: f64,
    write_seconds: f64,
    peak_memory_bytes: Option<u64>,
    #[serde(skip)]
    source: &'a Source,
}

impl Report for RenderReport<'_> {
    const IS_THE_RESULT: bool = false;

    fn to_text(&self) -> String {
        let mut table = Table::new(&self.output);
        let note = match self.triangles {
            0 => "no triangles: there is nothing to see".to_owned(),
            triangles => format!("{} triangles", units::count(triangles)),
        };
        table.row("load", units::seconds(self.load_seconds), note);
        table.skipped(self.skipped);
        self.source.build_row(&mut table, "");
        let note = format!(
            "{}rays, {}rays/s{}",
            units::metric(self.rays as f64),
            units::metric(self.rays_per_second),
            self.cluster.map(|address| format!(" on {address}")).unwrap_or_default()
        );
        table.row("trace", units::seconds(self.trace_seconds), note);
        let note = format!("{} x {} pixels", self.width, self.height);
        table.row("write", units::seconds(self.write_seconds), note);
        table.print()
    }
}

fn is_exr(path: &Path) -> bool {
    output::extension(path).is_some_and(|e| e == "exr")
}

/// Writes the picture, and tells how many seconds it took.
fn write(path: &Path, rendering: &Rendering, session: &Session) -> Result<f64, Failure> {
    let ((), seconds) = session.timed(Stage::Write, |observer| {
        output::write(path, observer, |file| match is_exr(path) {
            #[cfg(feature = "exr")]
            true => rendering.write_exr(file),
            _ => rendering.write_png(BufWriter::new(file)),
        })
    })?;
    Ok(seconds)
}
