//! What may be said to `halfline render`.

use std::path::PathBuf;

use clap::Args;

use super::picture_options::PictureOptions;
use crate::output;
use crate::tree_options::TreeOptions;

const EXAMPLES: &str = "\
Examples:
  halfline render scan.ply -o scan.png --up +Z
  halfline render bunny.stl -o bunny.png --no-background --color '#c08040'
  halfline render hall.ply -o hall.exr --camera-position 1,2,30 --camera-focal-point 1,2,0
  halfline render scan.ply -o glass.png --shading whitted --material glass --ground=checker
  halfline render scan.ply -o cost.png --shading steps --resolution 1920,1080";

/// The options of `halfline render`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// The mesh to draw, or - for standard input
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,

    /// Where the picture goes: .png, or .exr with depth, normals and face ids
    #[arg(short, long, value_name = "FILE")]
    #[arg(value_parser = output::path_with_extension(&["png", "exr"]))]
    pub output: PathBuf,

    /// Let the workers of a Dask cluster trace, tcp://HOST:PORT (needs the Python package)
    #[arg(long, value_name = "ADDRESS")]
    pub cluster: Option<String>,

    /// What the picture is like.
    #[command(flatten)]
    pub picture: PictureOptions,

    /// How the tree is built. The last heading of the picture's options is not its own.
    #[command(flatten, next_help_heading = None::<&str>)]
    pub tree: TreeOptions,
}
