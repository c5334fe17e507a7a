//! `halfline generate`: meshes to try things on.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use clap::Args;
use halfline::progress::Stage;
use halfline_io::models::{self, Kind, View};
use serde::Serialize;

use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use crate::table::Table;
use crate::{output, report, session, units, values};

const EXAMPLES: &str = "\
Examples:
  halfline generate scan -n 5500000 -o scan.ply
  halfline generate hall --triangles 100k --seed 7 -o hall.ply";

/// The options of `halfline generate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// What to make; z points up
    #[arg(value_name = "KIND")]
    #[arg(value_parser = values::named(Kind::ALL, |kind| (kind.name(), kind.description())))]
    kind: Kind,

    /// How many triangles it should have; some kinds only come near. May end in k or M
    #[arg(short = 'n', long, value_name = "N", value_parser = values::count)]
    triangles: usize,

    /// Where the mesh goes, as binary PLY
    #[arg(short, long, value_name = "FILE.ply")]
    #[arg(value_parser = output::path_with_extension(&["ply"]))]
    output: PathBuf,

    /// The same seed gives the same file; for scan, soup, sticks, terrain, hall and mount
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
}

/// Makes the mesh.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    output::check(&options.output, &[])?;
    let (mesh, generate_seconds) = session.timed_as(Stage::Load, "generate", |observer| {
        models::generate(options.kind, options.triangles, options.seed, observer)
    })?;
    let ((), write_seconds) = session
        .timed(Stage::Write, |observer| halfline_io::save_ply(&mesh, &options.output, observer))?;

    session.tell(&GenerateReport {
        kind: options.kind.name(),
        seed: options.seed,
        output: report::name(&options.output),
        triangles: mesh.triangle_count() as u64,
        vertices: mesh.positions().len() as u64,
        file_bytes: options.output.metadata().map(|metadata| metadata.len()).ok(),
        view: models::suggested_view(options.kind).map(ViewReport::from),
        generate_seconds,
        write_seconds,
        peak_memory_bytes: session::peak_memory_bytes(),
        options,
    })
}

/// What a mesh is like that was made, and what it took.
#[derive(Serialize)]
struct GenerateReport<'a> {
    kind: &'a str,
    seed: u64,
    output: Cow<'a, str>,
    triangles: u64,
    vertices: u64,
    file_bytes: Option<u64>,
    view: Option<ViewReport>,
    generate_seconds: f64,
    write_seconds: f64,
    peak_memory_bytes: Option<u64>,
    #[serde(skip)]
    options: &'a Options,
}

/// From where a mesh is seen best.
#[derive(Serialize)]
struct ViewReport {
    position: [f64; 3],
    focal_point: [f64; 3],
    up: [f64; 3],
    angle_degrees: f64,
}

impl From<View> for ViewReport {
    fn from(view: View) -> ViewReport {
        ViewReport {
            position: view.from.to_array(),
            focal_point: view.at.to_array(),
            up: view.up.to_array(),
            angle_degrees: view.angle_degrees,
        }
    }
}

impl Report for GenerateReport<'_> {
    const IS_THE_RESULT: bool = false;

    fn to_text(&self) -> String {
        let mut table = Table::new(&self.output);
        let (triangles, vertices) = (units::count(self.triangles), units::count(self.vertices));
        let note = format!("{triangles} triangles, {vertices} vertices");
        table.row("generate", units::seconds(self.generate_seconds), note);
        let bytes = self.file_bytes.map_or(String::new(), units::bytes);
        table.row("write", units::seconds(self.write_seconds), bytes);
        table.print() + &self.hint()
    }
}

impl GenerateReport<'_> {
    /// The command that shows the mesh from its best side.
    fn hint(&self) -> String {
        let mesh = shell_word(&self.options.output);
        let picture = shell_word(&self.options.output.with_extension("png"));
        let mut command = format!("  halfline render {mesh} -o {picture} --up +Z");
        if let Some(view) = &self.view {
            let vector = |[x, y, z]: [f64; 3]| format!("{x},{y},{z}");
            command += &format!(
                " --camera-position {} --camera-focal-point {} --camera-view-angle {}",
                vector(view.position),
                vector(view.focal_point),
                view.angle_degrees
            );
        }
        if self.options.kind == Kind::Hall {
            // Under a roof, all the sky would be hidden.
            command += " --occlusion-reach 0.08";
        }
        format!("To see it:\n{command}\n")
    }
}

/// `path` as a shell reads it as one word.
fn shell_word(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+,:=@%".contains(c);
    match text.chars().all(plain) {
        true => text,
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_survive_the_shell() {
        for (path, word) in [
            ("out/é_1.ply", "out/é_1.ply"),
            ("my mesh.ply", "'my mesh.ply'"),
            ("it's.ply", r"'it'\''s.ply'"),
            ("$HOME;x.ply", "'$HOME;x.ply'"),
        ] {
            assert_eq!(shell_word(Path::new(path)), word);
        }
    }
}
