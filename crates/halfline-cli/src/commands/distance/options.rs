//! What may be said to `halfline distance`.

use std::path::PathBuf;

use clap::Args;

use crate::camera_options::CameraOptions;
use crate::tree_options::TreeOptions;
use crate::{output, values};

const EXAMPLES: &str = "\
For each vertex of MESH the exact distance to the nearest point of OTHER's surface, in the units of the
files: the largest is the one-sided Hausdorff distance from MESH to OTHER. A MESH without faces, a cloud
of points, will do. With --signed, distances inside of OTHER are negative, as its winding number tells.

deviation.ply is MESH with its vertices' distances as colours and as numbers, `quality` and
`scalar_distance`: MeshLab and CloudCompare show both.

Examples:
  halfline distance scan.ply --to cad.stl --signed
  halfline distance scan.ply --to cad.stl --signed --tolerance 0.1 --picture deviation.png --up +Z
  halfline distance coarse.ply --to fine.ply --samples 1M --symmetric
  halfline distance scan.ply --to cad.stl -o deviation.ply --json | jq .forward.hausdorff";

/// The options of `halfline distance`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// The mesh whose vertices are measured, or - for standard input
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,

    /// The mesh that they are measured to, or - for standard input
    #[arg(long, value_name = "OTHER")]
    pub to: PathBuf,

    /// Negative distances inside of OTHER
    #[arg(long)]
    pub signed: bool,

    /// Measure from OTHER to MESH too, for the symmetric Hausdorff distance
    #[arg(long)]
    pub symmetric: bool,

    /// Measure so many points spread evenly over the surface instead of the vertices; may end in k or M
    #[arg(long, value_name = "N", value_parser = values::count)]
    pub samples: Option<usize>,

    /// Chooses among equally good points
    #[arg(long, value_name = "S", default_value_t = 0, requires = "samples")]
    pub seed: u64,

    /// Tell how much is at most so far from the surface, and show it in one colour
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    #[arg(value_parser = values::within(0.0, f64::INFINITY, true))]
    pub tolerance: Option<f64>,

    /// The distance with the last colour, where the histogram ends [default: what 99 % are below]
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    #[arg(value_parser = values::within(0.0, f64::INFINITY, false))]
    pub range: Option<f64>,

    /// MESH with its vertices' distances
    #[arg(short, long, value_name = "FILE.ply")]
    #[arg(value_parser = output::path_with_extension(&["ply"]))]
    pub output: Option<PathBuf>,

    /// A picture of them, with their scale
    #[arg(long, value_name = "FILE.png")]
    #[arg(value_parser = output::path_with_extension(&["png"]))]
    pub picture: Option<PathBuf>,

    #[command(flatten)]
    pub tree: TreeOptions,

    /// Size of the picture in pixels
    #[arg(long, value_name = "W,H", default_value = "1280,720", value_parser = values::resolution)]
    #[arg(help_heading = "Camera of --picture (by itself it shows the whole model)")]
    pub resolution: (u32, u32),

    #[command(flatten)]
    pub camera: CameraOptions,
}
