//! `halfline render`: a picture of a mesh.

mod cluster;
mod options;
mod picture_options;
mod words;

use std::io::BufWriter;
use std::path::Path;

use halfline::progress::Stage;
use halfline_render::{RenderStatistics, Rendering};
use serde_json::json;

pub use options::Options;
pub use picture_options::PictureOptions;

use crate::failure::Failure;
use crate::host::Host;
use crate::session::{Figures, Session};
use crate::source::Source;
use crate::table::Table;
use crate::{left_out, output, session, units};

/// Draws the picture.
pub fn run(options: &Options, session: Session, host: Option<&dyn Host>) -> Result<(), Failure> {
    if is_exr(&options.output) && !cfg!(feature = "exr") {
        return Err(left_out::lacking("--output as .exr").into());
    }
    output::check(&options.output, &[&options.mesh])?;
    let settings = options.picture.options.settings().map_err(Failure::Usage)?;
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

    let (zero_area, non_finite) = (scene.tree().skipped_zero_area, scene.tree().skipped_non_finite);
    let rays = rendering.statistics.rays;
    // On a cluster the seconds of the parts add up to more than passed.
    let statistics = RenderStatistics { trace_seconds, ..rendering.statistics };
    let rays_per_second = statistics.rays_per_second();
    let peak_memory = session::peak_memory_bytes();
    let mut figures = Figures::new();
    let mut tell = |name: &str, value| figures.insert(name.into(), value);
    tell("mesh", json!(options.mesh.to_string_lossy()));
    tell("output", json!(options.output.to_string_lossy()));
    tell("triangles", json!(triangles));
    tell("skipped", json!(zero_area + non_finite));
    tell("width", json!(settings.width));
    tell("height", json!(settings.height));
    tell("shading", json!(settings.shading.name()));
    tell("samples", json!(settings.samples));
    tell("seed", json!(settings.seed));
    tell("preset", json!(source.preset));
    tell("cluster", json!(options.cluster));
    tell("coverage", json!(rendering.coverage()));
    tell("rays", json!(rays.total()));
    tell(
        "rays_by_kind",
        json!({
            "primary": rays.primary,
            "occlusion": rays.occlusion,
            "shadow": rays.shadow,
            "reflection": rays.reflection,
            "refraction": rays.refraction,
        }),
    );
    tell("rays_per_second", json!(rays_per_second));
    tell("load_seconds", json!(source.load_seconds));
    tell("build_seconds", json!(source.build_seconds));
    tell("trace_seconds", json!(trace_seconds));
    tell("write_seconds", json!(write_seconds));
    tell("peak_memory_bytes", json!(peak_memory));

    let text = || {
        let mut table = Table::new(options.output.display());
        let note = match triangles {
            0 => "no triangles: there is nothing to see".to_owned(),
            _ => format!("{} triangles", units::count(triangles)),
        };
        table.row("load", units::seconds(source.load_seconds), note);
        table.skipped(zero_area, non_finite);
        source.build_row(&mut table, "");
        let note = format!(
            "{}rays, {}rays/s{}",
            units::metric(rays.total() as f64),
            units::metric(rays_per_second),
            options.cluster.iter().map(|address| format!(" on {address}")).collect::<String>()
        );
        table.row("trace", units::seconds(trace_seconds), note);
        let note = format!("{} x {} pixels", settings.width, settings.height);
        table.row("write", units::seconds(write_seconds), note);
        table.print()
    };
    session.tell(figures, text, false)
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
