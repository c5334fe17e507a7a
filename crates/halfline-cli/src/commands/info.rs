//! `halfline info`: what a mesh and its kd-tree are like.

use std::path::PathBuf;

use clap::Args;
use halfline::geometry::Aabb;
use halfline::mesh::Positions;
use halfline::tree::TreeStatistics;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::session::{Figures, Session};
use crate::source::Source;
use crate::table::{Table, bar};
use crate::tree_options::TreeOptions;
use crate::{input, session, units};

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

    let precision = match mesh.positions() {
        Positions::F32(_) => "float32",
        Positions::F64(_) => "float64",
    };
    let skipped = tree.skipped_zero_area + tree.skipped_non_finite;
    let peak_memory = session::peak_memory_bytes();
    let mut figures = Figures::new();
    let mut tell = |name: &str, value| figures.insert(name.into(), value);
    tell("mesh", json!(options.mesh.to_string_lossy()));
    tell("file_bytes", json!(file_bytes));
    tell("triangles", json!(mesh.triangle_count()));
    tell("vertices", json!(mesh.positions().len()));
    tell("precision", json!(precision));
    tell("bounds", bounds_figures(&bounds));
    tell("skipped", json!(skipped));
    tell("skipped_degenerate", json!(tree.skipped_zero_area));
    tell("skipped_non_finite", json!(tree.skipped_non_finite));
    tell("preset", json!(source.preset));
    tell("content_hash", source.content_hash_figure());
    tell("tree", tree_figures(&statistics));
    tell("load_seconds", json!(source.load_seconds));
    tell("build_seconds", json!(source.build_seconds));
    tell("peak_memory_bytes", json!(peak_memory));

    let text = || {
        let mut table = Table::new(input::name(&options.mesh).display());
        let count = |value: usize| units::count(value as u64);
        let note = format!("{} vertices, {precision}", count(mesh.positions().len()));
        table.row("triangles", count(mesh.triangle_count()), note);
        table.skipped(tree.skipped_zero_area, tree.skipped_non_finite);
        bounds_rows(&mut table, &bounds);
        let note = file_bytes.map_or(String::new(), units::bytes);
        table.row("load", units::seconds(source.load_seconds), note);
        let note = peak_memory
            .map_or(String::new(), |bytes| format!(", peak memory so far {}", units::bytes(bytes)));
        source.build_row(&mut table, &note);
        tree_rows(&mut table, &statistics);
        table.print()
    };
    session.tell(figures, text, true)
}

fn bounds_figures(bounds: &Aabb) -> Value {
    match bounds.is_empty() {
        true => Value::Null,
        false => json!([bounds.min.to_array(), bounds.max.to_array()]),
    }
}

fn tree_figures(tree: &TreeStatistics) -> Value {
    json!({
        "depth": tree.depth,
        "nodes": tree.nodes,
        "spatial_splits": tree.spatial_splits,
        "object_splits": tree.object_splits,
        "leaves": tree.leaves,
        "empty_leaves": tree.empty_leaves,
        "leaves_by_size": tree.leaves_by_size,
        "references": tree.references,
        "references_per_triangle": tree.references_per_triangle,
        "sah_cost": tree.sah_cost,
        "bytes": tree.bytes,
        "bytes_per_triangle": tree.bytes_per_triangle,
    })
}

fn bounds_rows(table: &mut Table, bounds: &Aabb) {
    if bounds.is_empty() {
        table.row("bounds", "none", "");
        return;
    }
    let extent = bounds.extent();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        let label = if axis == 0 { "bounds" } else { "" };
        let figure = units::number(extent[axis]);
        let (low, high) = (units::number(low), units::number(high));
        table.row(label, figure, format!("{name} from {low} to {high}"));
    }
}

fn tree_rows(table: &mut Table, tree: &TreeStatistics) {
    let count = |value: usize| units::count(value as u64);
    let note = format!(
        "levels, {} planes, {} groups",
        count(tree.spatial_splits),
        count(tree.object_splits)
    );
    table.row("tree", count(tree.depth), note);
    let note = format!("nodes, expected cost of a line {:.1}", tree.sah_cost);
    table.row("", count(tree.nodes), note);
    table.row("", format!("{:.3}", tree.references_per_triangle), "references per triangle");
    table.row("", format!("{:.1}", tree.bytes_per_triangle), "bytes per triangle");
    table.row("leaves", count(tree.leaves), format!("{} empty", count(tree.empty_leaves)));
    let most = tree.leaves_by_size.iter().copied().max().unwrap_or(0);
    for (size, &leaves) in tree.leaves_by_size.iter().enumerate() {
        if leaves > 0 {
            let bar = bar(leaves as f64 / most as f64);
            table.row(&format!("  of {size}"), count(leaves), bar);
        }
    }
}
