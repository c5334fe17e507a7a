//! `halfline info`: what a mesh and its tree are like.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use clap::Args;
use halfline::mesh::Positions;
use halfline::tree::TreeStatistics;
use serde::Serialize;

use crate::failure::Failure;
use crate::report::{Report, Skipped};
use crate::session::Session;
use crate::source::Source;
use crate::table::{Table, bar};
use crate::tree_options::TreeOptions;
use crate::{input, report, session, units};

const EXAMPLES: &str = "\
Examples:
  halfline info scan.ply
  halfline info scan.ply --json | jq .tree.references_per_triangle";

/// The options of `halfline info`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// The mesh to look into, or - for standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,

    #[command(flatten)]
    tree: TreeOptions,
}

/// Loads the mesh, builds its tree unless it comes with one, and tells about both.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    let file_bytes = match input::is_stdin(&options.mesh) {
        true => None,
        false => options.mesh.metadata().map(|metadata| metadata.len()).ok(),
    };
    let source = Source::open(&options.mesh, &options.tree, &session)?;
    let scene = &source.scene;
    let (mesh, tree) = (scene.mesh(), scene.tree());
    let (statistics, bounds) =
        scene.guarded(|| Ok((tree.statistics(mesh.triangle_count()), mesh.bounds())))?;

    let skipped = Skipped::of(scene);
    session.tell(&InfoReport {
        mesh: report::name(&options.mesh),
        file_bytes,
        triangles: mesh.triangle_count(),
        vertices: mesh.positions().len(),
        precision: match mesh.positions() {
            Positions::F32(_) => "float32",
            Positions::F64(_) => "float64",
        },
        bounds: (!bounds.is_empty()).then(|| [bounds.min.to_array(), bounds.max.to_array()]),
        skipped,
        skipped_degenerate: skipped.degenerate,
        skipped_non_finite: skipped.non_finite,
        preset: source.preset,
        content_hash: source.content_hash(),
        tree: statistics,
        load_seconds: source.load_seconds,
        build_seconds: source.build_seconds,
        peak_memory_bytes: session::peak_memory_bytes(),
        source: &source,
    })
}

/// What a mesh and its tree are like.
#[derive(Serialize)]
struct InfoReport<'a> {
    mesh: Cow<'a, str>,
    file_bytes: Option<u64>,
    triangles: usize,
    vertices: usize,
    precision: &'a str,
    /// The lowest and the highest corner; none of a mesh without finite vertices.
    bounds: Option<[[f64; 3]; 2]>,
    skipped: Skipped,
    skipped_degenerate: usize,
    skipped_non_finite: usize,
    preset: &'a str,
    content_hash: Option<String>,
    tree: TreeStatistics,
    load_seconds: f64,
    build_seconds: f64,
    peak_memory_bytes: Option<u64>,
    #[serde(skip)]
    source: &'a Source,
}

impl Report for InfoReport<'_> {
    const IS_THE_RESULT: bool = true;

    fn to_text(&self) -> String {
        let mut table = Table::new(input::name(Path::new(&*self.mesh)).display());
        let count = |value: usize| units::count(value as u64);
        let note = format!("{} vertices, {}", count(self.vertices), self.precision);
        table.row("triangles", count(self.triangles), note);
        table.skipped(self.skipped);
        self.bounds_rows(&mut table);
        let note = self.file_bytes.map_or(String::new(), units::bytes);
        table.row("load", units::seconds(self.load_seconds), note);
        let note = self
            .peak_memory_bytes
            .map_or(String::new(), |bytes| format!(", peak memory so far {}", units::bytes(bytes)));
        self.source.build_row(&mut table, &note);
        tree_rows(&mut table, &self.tree);
        table.print()
    }
}

impl InfoReport<'_> {
    fn bounds_rows(&self, table: &mut Table) {
        let Some([low, high]) = self.bounds else {
            table.row("bounds", "none", "");
            return;
        };
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let label = if axis == 0 { "bounds" } else { "" };
            let [extent, low, high] =
                [high[axis] - low[axis], low[axis], high[axis]].map(units::number);
            table.row(label, extent, format!("{name} from {low} to {high}"));
        }
    }
}

fn tree_rows(table: &mut Table, tree: &TreeStatistics) {
    let count = |value: usize| units::count(value as u64);
    let (spatial, object) = (count(tree.spatial_splits), count(tree.object_splits));
    let note = format!("levels, {spatial} spatial and {object} object splits");
    table.row("tree", count(tree.depth), note);
    let note = format!("nodes, expected cost of a line {:.1}", tree.sah_cost);
    table.row("", count(tree.nodes), note);
    table.row("", format!("{:.3}", tree.references_per_triangle), "references per triangle");
    table.row("", format!("{:.1}", tree.bytes_per_triangle), "bytes per triangle");
    table.row(
        "leaves",
        count(tree.leaves),
        format!("{:.1} children a node", tree.children_per_node),
    );
    let most = tree.leaves_by_size.iter().copied().max().unwrap_or(0);
    for (size, &leaves) in tree.leaves_by_size.iter().enumerate() {
        if leaves > 0 {
            let bar = bar(leaves as f64 / most as f64);
            table.row(&format!("  of {size}"), count(leaves), bar);
        }
    }
}
