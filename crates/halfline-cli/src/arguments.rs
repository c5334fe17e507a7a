//! What the command line understands; each subcommand's options stand with the subcommand.

use clap::builder::Styles;
use clap::builder::styling::AnsiColor;
use clap::{Parser, Subcommand};

use crate::commands::{build, distance, doctor, explain, generate, info, query, render, study};
use crate::global_options::GlobalOptions;

const EXAMPLES: &str = "\
Examples:
  halfline render scan.ply -o scan.png           a picture, framed by itself
  halfline info scan.ply                         what the mesh and its tree are like
  halfline doctor scan.ply                       whether it is closed, and rays find no gap
  halfline query scan.ply rays.npy -o hits.npz   where a million rays hit
  halfline distance scan.ply --to cad.stl        how far a scan is from what it should be
  halfline explain scan.ply --pixel 640,360      why a ray hit or missed, step by step
  halfline build scan.ply -o scan.hlt            its tree, which all of these open at once
  halfline study --quick                         how cost grows with n, as a report
  halfline generate sphere -n 100000 -o s.ply    a mesh to try things on

Meshes: PLY, STL, OBJ, OFF, glTF, GLB, each also as .gz, and trees: .hlt.
A mesh may come through a pipe as -, up to 4 GiB: zcat scan.stl.gz | halfline info -
Exit codes: 0 done, 1 the input or the work failed, 2 wrong arguments, 130 interrupted.";

const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// Casts rays at triangle meshes of any size: pictures, hits as NumPy arrays, facts.
#[derive(Debug, Parser)]
#[command(name = "halfline", bin_name = "halfline", version, after_help = EXAMPLES, styles = STYLES)]
#[command(max_term_width = 100, propagate_version = true, subcommand_required = true)]
#[command(arg_required_else_help = true, disable_help_subcommand = true)]
pub struct Arguments {
    /// Options that every subcommand takes.
    #[command(flatten)]
    pub global: GlobalOptions,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Trace a picture of a mesh
    Render(Box<render::Options>),
    /// Tell what a mesh and its tree are like
    Info(info::Options),
    /// Find what is wrong with a mesh, and whether rays slip through it
    Doctor(doctor::Options),
    /// Cast the rays of a NumPy file at a mesh
    Query(query::Options),
    /// Measure how far one mesh is from another
    Distance(Box<distance::Options>),
    /// Tell why a ray hits what it hits, or nothing, step by step
    Explain(Box<explain::Options>),
    /// Measure what a ray costs, as meshes grow
    Study(study::Options),
    /// Build a mesh's tree, as a file that takes the mesh's place
    Build(build::Options),
    /// Make a mesh to try things on
    Generate(generate::Options),
}
