//! `halfline build`: a mesh in, its tree as a file out, which every subcommand opens at once.

use std::path::PathBuf;

use clap::Args;
use halfline::Scene;
use halfline::progress::{NoProgress, Stage};
use halfline::tree::Verify;
use serde_json::json;

use crate::failure::Failure;
use crate::session::{Figures, Session};
use crate::source::Source;
use crate::table::Table;
use crate::tree_options::TreeOptions;
use crate::{output, session, units};

const EXAMPLES: &str = "\
TREE.hlt holds the mesh too, so that it takes the mesh's place everywhere. It is mapped, not read:
opening it takes no time, and processes of one machine share its memory.

Examples:
  halfline build scan.ply -o scan.hlt
  halfline render scan.hlt -o scan.png
  halfline build hall.obj -o hall.hlt --preset best";

/// The options of `halfline build`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// The mesh to build the tree of, or - for standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,

    /// Where the tree goes
    #[arg(short, long, value_name = "TREE.hlt")]
    #[arg(value_parser = output::path_with_extension(&["hlt"]))]
    output: PathBuf,

    #[command(flatten)]
    tree: TreeOptions,
}

/// Builds the tree and writes it.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    output::check(&options.output, &[&options.mesh])?;
    let source = Source::open(&options.mesh, &options.tree, &session)?;
    let scene = &source.scene;
    let ((), write_seconds) =
        session.timed(Stage::Write, |observer| scene.save(&options.output, observer))?;

    // What was written has just been summed up: only its first page is looked at.
    let written = Scene::open(&options.output, Verify::Never, &NoProgress)?;
    let (bytes, content_hash) = written
        .tree_file()
        .map_or((0, String::new()), |file| (file.bytes(), file.content_hash().to_string()));
    let triangles = scene.mesh().triangle_count() as u64;
    let bytes_per_triangle =
        if triangles > 0 { bytes as f64 / triangles as f64 } else { bytes as f64 };
    let (zero_area, non_finite) = (scene.tree().skipped_zero_area, scene.tree().skipped_non_finite);
    let mut figures = Figures::new();
    let mut tell = |name: &str, value| figures.insert(name.into(), value);
    tell("mesh", json!(options.mesh.to_string_lossy()));
    tell("output", json!(options.output.to_string_lossy()));
    tell("triangles", json!(triangles));
    tell("skipped", json!(zero_area + non_finite));
    tell("preset", json!(source.preset));
    tell("bytes", json!(bytes));
    tell("bytes_per_triangle", json!(bytes_per_triangle));
    tell("content_hash", json!(content_hash));
    tell("load_seconds", json!(source.load_seconds));
    tell("build_seconds", json!(source.build_seconds));
    tell("write_seconds", json!(write_seconds));
    tell("peak_memory_bytes", json!(session::peak_memory_bytes()));

    let text = || {
        let mut table = Table::new(options.output.display());
        let note = format!("{} triangles", units::count(triangles));
        table.row("load", units::seconds(source.load_seconds), note);
        table.skipped(zero_area, non_finite);
        source.build_row(&mut table, "");
        let note = format!("{}, {bytes_per_triangle:.1} bytes per triangle", units::bytes(bytes));
        table.row("write", units::seconds(write_seconds), note);
        table.row("content", "", content_hash);
        table.print()
    };
    session.tell(figures, text, false)
}
