//! Bytes to meshes and back: one file per format.

mod atomic;
mod colors;
pub mod gltf;
mod gzip;
mod lines;
mod mtl;
pub mod obj;
pub mod off;
pub mod ply;
mod progress;
mod sibling;
pub mod stl;
mod text;
mod weld;

#[cfg(test)]
mod tests;

use std::ffi::OsStr;
use std::path::Path;

pub use atomic::{AtomicFile, abandon_all};
pub use ply::save as save_ply;

use self::progress::Portion;
use crate::error::{Error, Result};
use crate::map::Bytes;
use crate::mesh::Mesh;
use crate::progress::Observer;

/// The formats that can be told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Ply,
    Stl,
    Obj,
    Off,
    Gltf,
}

/// What [`load`] reads, for the error about everything else.
const SUPPORTED: &str = "supported are PLY, STL, OBJ, OFF, glTF and GLB, each also as .gz";

/// Enough of a file to tell its format.
const START_BYTES: usize = 1024;

/// Reads the mesh in the file at `path`, whose format is known by its content or else by its
/// extension. Reports [`Stage::Load`](crate::progress::Stage::Load) in bytes of the file.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read, [`Error::Format`] if it is not what it should be,
/// [`Error::Interrupted`] if `observer` ends the work.
pub fn load(path: &Path, observer: &dyn Observer) -> Result<Mesh> {
    let bytes = Bytes::open(path, observer, &|start| recognise(path, start).map(|_| ()))?;
    let format = recognise(path, &bytes)?;
    if !gzip::is_gzip(&bytes) {
        let mesh = read(format, path, &bytes, observer);
        bytes.check(path)?;
        return mesh;
    }
    // Inflating takes most of the time.
    let total = bytes.len() as u64;
    let inflating = Portion { observer, before: 0, share: total / 5 * 4, total };
    let limit = gzip::inflated_limit(bytes.len());
    let content = gzip::inflate(path, &bytes, &inflating, &|content| match format {
        Format::Ply => ply::is_complete(content, limit),
        Format::Stl => stl::is_complete(content),
        Format::Obj | Format::Off | Format::Gltf => false,
    })?;
    let reading =
        Portion { observer, before: inflating.share, share: total - inflating.share, total };
    read(format, path, &content, &reading)
}

fn read(format: Format, path: &Path, bytes: &[u8], observer: &dyn Observer) -> Result<Mesh> {
    match format {
        Format::Ply => ply::read(path, bytes, observer),
        Format::Stl => stl::read(path, bytes, observer),
        Format::Obj => obj::read(path, bytes, observer),
        Format::Off => off::read(path, bytes, observer),
        Format::Gltf => gltf::read(path, bytes, observer),
    }
}

/// The format of the file at `path`, which begins with `bytes`.
fn recognise(path: &Path, bytes: &[u8]) -> Result<Format> {
    if bytes.is_empty() {
        return Err(Error::format(path, "byte 0", "the file is empty"));
    }
    let inflated;
    let (start, name) = if gzip::is_gzip(bytes) {
        inflated = gzip::inflate_start(path, bytes, START_BYTES)?;
        let name = if extension(path) == "gz" { path.file_stem() } else { path.file_name() };
        (&inflated[..], name)
    } else {
        (bytes, path.file_name())
    };
    if start.starts_with(b"\x89HLT") {
        let reason = "this is not a mesh but a tree: open it as a scene";
        return Err(Error::format(path, "byte 0", reason));
    }
    by_content(start).or_else(|| by_extension(Path::new(name.unwrap_or_default()))).ok_or_else(
        || Error::format(path, "byte 0", format!("the format is not known; {SUPPORTED}")),
    )
}

fn by_content(start: &[u8]) -> Option<Format> {
    if ply::is_ply(start) {
        Some(Format::Ply)
    } else if stl::is_stl(start) {
        Some(Format::Stl)
    } else if start.starts_with(b"glTF") {
        Some(Format::Gltf)
    } else if off::is_off(start) {
        Some(Format::Off)
    } else {
        None
    }
}

fn by_extension(name: &Path) -> Option<Format> {
    match &*extension(name) {
        "ply" => Some(Format::Ply),
        "stl" => Some(Format::Stl),
        "obj" => Some(Format::Obj),
        "off" => Some(Format::Off),
        "gltf" | "glb" => Some(Format::Gltf),
        _ => None,
    }
}

/// The extension in lower case.
fn extension(path: &Path) -> String {
    path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase()
}
