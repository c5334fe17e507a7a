//! The picture from a cluster: its workers open the tree's file, and give back rows.

use std::path::{Path, PathBuf};

use halfline::Error;
use halfline::error::Result;
use halfline::progress::{Observer, Stage};
use halfline_render::{RenderSettings, Rendering, Rows, assemble};

use super::options::Options;
use crate::failure::Failure;
use crate::host::{Cluster, Host};
use crate::session::Session;
use crate::source::Source;
use crate::temporary::Temporary;

/// Reaches the cluster that `options` name, if any.
pub fn connect(options: &Options, host: Option<&dyn Host>) -> Result<Option<Box<dyn Cluster>>> {
    let Some(address) = &options.cluster else {
        return Ok(None);
    };
    let host = host.ok_or_else(|| {
        let reason =
            "this program cannot: it needs the Python package, pip install 'halfline[dask]'";
        Error::invalid("--cluster", reason)
    })?;
    host.connect(address).map(Some)
}

/// Lets `cluster` trace the picture, and tells how many seconds it took.
pub fn trace(
    cluster: &dyn Cluster,
    source: &Source,
    settings: &RenderSettings,
    options: &Options,
    session: &Session,
) -> std::result::Result<(Rendering, f64), Failure> {
    let saved;
    let tree = match source.scene.tree_file() {
        Some(file) => file.path(),
        None => {
            saved = Temporary::new(place_beside(&options.output));
            session.timed_as(Stage::Write, "tree", |observer| {
                source.scene.save(saved.path(), observer)
            })?;
            saved.path()
        }
    };
    session.timed(Stage::Trace, |observer| trace_rows(cluster, tree, settings, observer))
}

fn trace_rows(
    cluster: &dyn Cluster,
    tree: &Path,
    settings: &RenderSettings,
    observer: &dyn Observer,
) -> Result<Rendering> {
    let json = serde_json::to_string(settings).expect("settings are plain data");
    let parts = cluster.trace(tree, &json, observer)?;
    let rows: Result<Vec<Rows>> = parts.iter().map(|bytes| Rows::from_bytes(bytes)).collect();
    assemble(settings, rows?)
}

/// Where a mesh's tree lies while workers need it: where the picture will be, which they may see too.
fn place_beside(output: &Path) -> PathBuf {
    let folder = match output.parent() {
        Some(folder) if output.is_file() || output.symlink_metadata().is_err() => folder.to_owned(),
        // Not a file: its folder may be no place for files.
        _ => std::env::temp_dir(),
    };
    let folder = std::path::absolute(&folder).unwrap_or(folder);
    folder.join(format!(".halfline-{}.hlt", std::process::id()))
}
