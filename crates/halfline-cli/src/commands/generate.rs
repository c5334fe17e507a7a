//! `halfline generate`: meshes to try things on.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use halfline::geometry::Vec3;
use halfline::progress::Stage;
use halfline_io::models::{self, Kind, View};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::session::{Figures, Session};
use crate::table::Table;
use crate::{output, session, units, values};

const EXAMPLES: &str = "\
Examples:
  halfline generate scan -n 5500000 -o scan.ply
  halfline generate hall --triangles 100k --seed 7 -o hall.ply";

/// The options of `halfline generate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// What to make; z points up
    #[arg(value_name = "KIND", value_parser = kind_parser())]
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

/// Understands the kinds' names, and lists them in the help with a line each.
fn kind_parser() -> impl TypedValueParser<Value = Kind> {
    let values = Kind::ALL.map(|kind| PossibleValue::new(kind.name()).help(kind.description()));
    PossibleValuesParser::new(values).try_map(|name| name.parse::<Kind>())
}

/// Makes the mesh.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    output::check(&options.output, &[])?;
    let (mesh, generate_seconds) = session.timed_as(Stage::Load, "generate", |observer| {
        models::generate(options.kind, options.triangles, options.seed, observer)
    })?;
    let ((), write_seconds) = session
        .timed(Stage::Write, |observer| halfline_io::save_ply(&mesh, &options.output, observer))?;

    let file_bytes = options.output.metadata().map(|metadata| metadata.len()).ok();
    let (triangles, vertices) = (mesh.triangle_count() as u64, mesh.positions().len() as u64);
    let view = models::suggested_view(options.kind);
    let mut figures = Figures::new();
    let mut tell = |name: &str, value| figures.insert(name.into(), value);
    tell("kind", json!(options.kind.name()));
    tell("seed", json!(options.seed));
    tell("output", json!(options.output.to_string_lossy()));
    tell("triangles", json!(triangles));
    tell("vertices", json!(vertices));
    tell("file_bytes", json!(file_bytes));
    tell("view", view.as_ref().map_or(Value::Null, view_figures));
    tell("generate_seconds", json!(generate_seconds));
    tell("write_seconds", json!(write_seconds));
    tell("peak_memory_bytes", json!(session::peak_memory_bytes()));

    let text = || {
        let mut table = Table::new(options.output.display());
        let note =
            format!("{} triangles, {} vertices", units::count(triangles), units::count(vertices));
        table.row("generate", units::seconds(generate_seconds), note);
        table.row(
            "write",
            units::seconds(write_seconds),
            file_bytes.map_or(String::new(), units::bytes),
        );
        table.print() + &hint(options, view.as_ref())
    };
    session.tell(figures, text, false)
}

fn view_figures(view: &View) -> Value {
    json!({
        "position": view.from.to_array(),
        "focal_point": view.at.to_array(),
        "up": view.up.to_array(),
        "angle_degrees": view.angle_degrees,
    })
}

/// The command that shows the mesh from its best side.
fn hint(options: &Options, view: Option<&View>) -> String {
    let mesh = shell_word(&options.output);
    let picture = shell_word(&options.output.with_extension("png"));
    let mut command = format!("  halfline render {mesh} -o {picture} --up +Z");
    if let Some(view) = view {
        let vector = |v: Vec3| format!("{},{},{}", v.x, v.y, v.z);
        command += &format!(
            " --camera-position {} --camera-focal-point {} --camera-view-angle {}",
            vector(view.from),
            vector(view.at),
            view.angle_degrees
        );
    }
    if options.kind == Kind::Hall {
        // Under a roof, all the sky would be hidden.
        command += " --occlusion-reach 0.08";
    }
    format!("To see it:\n{command}\n")
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
