//! PLY, the Stanford polygon file format: ASCII and binary of both byte orders.
//!
//! A `header` tells what the body holds, `schema` which of that makes up a mesh. Binary bodies
//! are read in two passes: `layout` finds where the records lie, `binary` fills the arrays.

mod ascii;
mod binary;
mod faces;
mod header;
mod layout;
mod scalar;
mod schema;
mod writer;

#[cfg(test)]
mod tests;

use std::path::Path;

use self::faces::Triangles;
use self::header::Encoding;
use self::layout::Failure;
use self::schema::Schema;
use halfline::error::{Error, Result};
use halfline::mesh::{Mesh, Positions};
use halfline::progress::SharedProgress;
use halfline::progress::{NoProgress, Observer, Stage};

pub(super) use header::is_ply;
pub use writer::{save, save_distances};

/// The arrays of a mesh.
struct Parts {
    positions: Positions,
    colors: Option<Vec<[u8; 4]>>,
    triangles: Triangles,
}

/// The mesh that `bytes`, a PLY file, describe. `path` names it in errors.
///
/// Vertices without faces, a point cloud, make a mesh without triangles.
pub fn read(path: &Path, bytes: &[u8], observer: &dyn Observer) -> Result<Mesh> {
    let Some(header) = header::parse(path, bytes)? else {
        return Err(Error::format(path, "header", "the file ends before a line 'end_header'"));
    };
    let schema = Schema::of(path, &header)?;
    let progress = SharedProgress::new(observer, Stage::Load, bytes.len());
    let parts = match header.encoding {
        Encoding::Ascii => ascii::read(path, &header, &schema, bytes, &progress),
        Encoding::LittleEndian => {
            binary::read::<false>(path, &header, &schema, bytes, observer, &progress)
        }
        Encoding::BigEndian => {
            binary::read::<true>(path, &header, &schema, bytes, observer, &progress)
        }
    }?;
    let Triangles { triangles, source_faces } = parts.triangles;
    let mut mesh = Mesh::new(parts.positions, triangles)
        .map_err(|error| Error::format(path, "faces", error.to_string()))?;
    mesh.source_faces = source_faces.map(Into::into);
    mesh.vertex_colors = parts.colors.map(Into::into);
    progress.finish();
    Ok(mesh)
}

/// True if no more bytes than these are needed: because they hold all that their header promises,
/// or because they are wrong, or promise more than `limit` bytes can hold.
pub(super) fn is_complete(bytes: &[u8], limit: usize) -> bool {
    let path = Path::new("");
    let Ok(parsed) = header::parse(path, bytes) else {
        return true;
    };
    let Some(header) = parsed else {
        return false;
    };
    let least = header.elements.iter().map(|e| e.least_bytes(header.encoding));
    if least.fold(0, u128::saturating_add) > limit as u128 || Schema::of(path, &header).is_err() {
        return true;
    }
    match header.encoding {
        Encoding::Ascii => ascii::is_complete(&header, bytes),
        _ => !matches!(layout::locate(&header, bytes, &NoProgress), Err(Failure::Short { .. })),
    }
}
