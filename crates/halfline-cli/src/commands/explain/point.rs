//! What is nearest to a point, and on which side it is.

use std::path::Path;

use halfline::Vec3;
use halfline::explain::PointExplanation;
use halfline::progress::Stage;
use halfline_explain::PointReport;

use super::{Options, name_of, write};
use crate::failure::Failure;
use crate::session::Session;
use crate::source::Source;
use crate::table::Table;
use crate::{output, units};

/// Tells it.
pub fn tell(
    options: &Options,
    point: Vec3,
    source: &Source,
    session: Session,
) -> Result<(), Failure> {
    let scene = &source.scene;
    let (explanation, _) = session
        .timed_as(Stage::Trace, "explaining", |observer| scene.explain_point(point, observer))?;
    let name = name_of(&options.mesh);
    let explained = PointReport { name: &name, mesh: scene.mesh(), explanation: &explanation };
    if let Some(path) = &options.output {
        let content = match output::extension(path).as_deref() {
            Some("json") => format!("{:#}\n", explained.to_json()),
            _ => explained.to_text(),
        };
        write(path, &content, &session)?;
    }
    match &options.output {
        _ if session.wants_json() => session.tell_figures(&explained.to_json()),
        None => session.tell_text(|| explained.to_text(), true),
        Some(path) => session.tell_text(|| summary(path, &explanation), false),
    }
}

/// What is in a file that was written.
fn summary(path: &Path, explanation: &PointExplanation) -> String {
    let mut table = Table::new(path.display());
    let closest = &explanation.closest;
    match closest.is_found() {
        true => table.row("nearest", format!("face {}", closest.face), ""),
        false => table.row("nearest", "none", ""),
    };
    let side = if explanation.is_inside { "inside" } else { "outside" };
    table.row("distance", units::number(explanation.signed_distance()), side);
    let visits = explanation.visits;
    let note = format!(
        "nodes, {} of them leaves, {} triangles",
        units::count(visits.leaves),
        units::count(visits.triangles)
    );
    table.row("engine", units::count(visits.nodes), note);
    table.print()
}
