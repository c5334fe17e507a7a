//! `halfline build`: a mesh in, its tree as a file out, which every subcommand opens at once.

use std::borrow::Cow;
use std::path::PathBuf;

use clap::Args;
use halfline::Scene;
use halfline::progress::{NoProgress, Stage};
use halfline::tree::Verify;
use serde::Serialize;

use crate::failure::Failure;
use crate::report::{Report, Skipped};
use crate::session::Session;
use crate::source::Source;
use crate::table::Table;
use crate::tree_options::TreeOptions;
use crate::{output, report, session, units};

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
    session.tell(&BuildReport {
        mesh: report::name(&options.mesh),
        output: report::name(&options.output),
        triangles,
        skipped: Skipped::of(scene),
        preset: source.preset,
        bytes,
        bytes_per_triangle: bytes as f64 / triangles.max(1) as f64,
        content_hash,
        load_seconds: source.load_seconds,
        build_seconds: source.build_seconds,
        write_seconds,
        peak_memory_bytes: session::peak_memory_bytes(),
        source: &source,
    })
}

/// What a tree's file is like, and what it took to make it.
#[derive(Serialize)]
struct BuildReport<'a> {
    mesh: Cow<'a, str>,
    output: Cow<'a, str>,
    triangles: u64,
    skipped: Skipped,
    preset: &'a str,
    bytes: u64,
    bytes_per_triangle: f64,
    content_hash: String,
    load_seconds: f64,
    build_seconds: f64,
    write_seconds: f64,
    peak_memory_bytes: Option<u64>,
    #[serde(skip)]
    source: &'a Source,
}

impl Report for BuildReport<'_> {
    const IS_THE_RESULT: bool = false;

    fn to_text(&self) -> String {
        let mut table = Table::new(&self.output);
        let note = format!("{} triangles", units::count(self.triangles));
        table.row("load", units::seconds(self.load_seconds), note);
        table.skipped(self.skipped);
        self.source.build_row(&mut table, "");
        let bytes = units::bytes(self.bytes);
        let note = format!("{bytes}, {:.1} bytes per triangle", self.bytes_per_triangle);
        table.row("write", units::seconds(self.write_seconds), note);
        table.row("content", "", &self.content_hash);
        table.print()
    }
}
