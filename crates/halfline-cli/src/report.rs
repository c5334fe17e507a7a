//! What a subcommand found out, for programs and for people.

use std::borrow::Cow;
use std::path::Path;

use halfline::Scene;
use serde::Serialize;

/// The figures of a run: its fields are what `--json` prints.
pub trait Report: Serialize {
    /// False if the result lies in a file of which the report only speaks, so that `--quiet` silences it.
    const IS_THE_RESULT: bool;

    /// What people read instead of the fields, most of it a [`Table`](crate::table::Table).
    fn to_text(&self) -> String;
}

/// Triangles that were kept out of the tree; as a figure, how many.
#[derive(Clone, Copy, Serialize)]
#[serde(into = "usize")]
pub struct Skipped {
    /// Triangles without area.
    pub degenerate: usize,
    /// Triangles with a coordinate that is NaN or infinite.
    pub non_finite: usize,
}

impl Skipped {
    /// The triangles that were kept out of the tree of a scene.
    pub fn of(scene: &Scene) -> Skipped {
        let tree = scene.tree();
        Skipped { degenerate: tree.skipped_zero_area, non_finite: tree.skipped_non_finite }
    }

    /// How many triangles were kept out in all.
    pub fn total(self) -> usize {
        self.degenerate + self.non_finite
    }
}

impl From<Skipped> for usize {
    fn from(skipped: Skipped) -> usize {
        skipped.total()
    }
}

/// The name of a file as figures have it: what is no Unicode is replaced.
pub fn name(path: &Path) -> Cow<'_, str> {
    path.to_string_lossy()
}

/// How many there are in a second, or 0 if it took no time.
pub fn per_second(count: u64, seconds: f64) -> f64 {
    if seconds > 0.0 { count as f64 / seconds } else { 0.0 }
}
