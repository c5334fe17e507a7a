#![doc = include_str!("../README.md")]

mod colors;
#[cfg(feature = "gltf")]
pub mod gltf;
#[cfg_attr(not(feature = "gzip"), path = "gzip_left_out.rs")]
mod gzip;
mod lines;
#[cfg(feature = "models")]
pub mod models;
mod mtl;
pub mod obj;
pub mod off;
pub mod ply;
mod sibling;
pub mod stl;
mod text;
pub mod triangulate;
mod weld;

#[cfg(all(test, feature = "gzip"))]
mod tests;

use std::ffi::OsStr;
use std::io::Read;
use std::path::Path;

pub use ply::{save as save_ply, save_distances as save_ply_distances};

use halfline::error::{Error, Result};
use halfline::mesh::Mesh;
use halfline::progress::{Observer, Part};
use halfline::storage::Bytes;

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

/// Enough of a compressed file to tell its format.
const START_BYTES: usize = 64 << 10;

/// Reads the mesh in the regular file at `path`, whose format is known by its content or else by its
/// extension. Reports [`Stage::Load`](halfline::progress::Stage::Load) in bytes of the file.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read, or is a pipe or a device; [`Error::Format`] if it is not
/// what it should be; [`Error::Interrupted`] if `observer` ends the work.
pub fn load(path: &Path, observer: &dyn Observer) -> Result<Mesh> {
    let bytes = Bytes::open(path, observer)?;
    if bytes.is_empty() {
        return Err(Error::format(path, "byte 0", "the file is empty"));
    }
    let format = recognise(path, &bytes, &|_, name| by_extension(name))?;
    let mesh = read_inflated(format, path, &bytes, observer);
    bytes.check(path)?;
    mesh
}

/// Reads the mesh that `stream` brings, to its end. Errors call it `name`. Its format is known by its
/// content alone. Files that it names are looked for in the current folder and below.
///
/// # Errors
/// As [`load`], and [`Error::Format`] if there are more than `most` bytes, all of which are held in
/// memory.
pub fn load_stream(
    name: &Path,
    stream: impl Read,
    most: u64,
    observer: &dyn Observer,
) -> Result<Mesh> {
    let recognise = |start: &[u8]| match start {
        [] => Err(Error::format(name, "byte 0", "there is nothing in it")),
        start => recognise(name, start, &|start, _| by_statements(start, most)),
    };
    let bytes = Bytes::read(name, stream, most, observer, &|start| recognise(start).map(|_| ()))?;
    read_inflated(recognise(&bytes)?, name, &bytes, observer)
}

/// Reads what may be compressed.
fn read_inflated(
    format: Format,
    path: &Path,
    bytes: &[u8],
    observer: &dyn Observer,
) -> Result<Mesh> {
    if !is_gzip(bytes) {
        return read(format, path, bytes, observer);
    }
    // Inflating takes most of the time.
    let total = bytes.len() as u64;
    let inflating = Part { observer, before: 0, share: total / 5 * 4, total };
    let limit = gzip::inflated_limit(bytes.len());
    let content = gzip::inflate(path, bytes, &inflating, &|content| match format {
        Format::Ply => ply::is_complete(content, limit),
        Format::Stl => stl::is_complete(content),
        Format::Obj | Format::Off | Format::Gltf => false,
    })?;
    let reading = Part { observer, before: inflating.share, share: total - inflating.share, total };
    read(format, path, &content, &reading)
}

fn read(format: Format, path: &Path, bytes: &[u8], observer: &dyn Observer) -> Result<Mesh> {
    match format {
        Format::Ply => ply::read(path, bytes, observer),
        Format::Stl => stl::read(path, bytes, observer),
        Format::Obj => obj::read(path, bytes, observer),
        Format::Off => off::read(path, bytes, observer),
        #[cfg(feature = "gltf")]
        Format::Gltf => gltf::read(path, bytes, observer),
        #[cfg(not(feature = "gltf"))]
        Format::Gltf => Err(left_out(path, "gltf")),
    }
}

/// The format of the file at `path`, which begins with `bytes`; asks `otherwise` with its start and its
/// name, less what compression does to both, if no format's mark is there.
fn recognise(
    path: &Path,
    bytes: &[u8],
    otherwise: &dyn Fn(&[u8], &Path) -> Option<Format>,
) -> Result<Format> {
    let inflated;
    let (start, name) = if is_gzip(bytes) {
        inflated = gzip::inflate_start(path, bytes, START_BYTES)?;
        let name = if extension(path) == "gz" { path.file_stem() } else { path.file_name() };
        (&inflated[..], name)
    } else {
        (bytes, path.file_name())
    };
    if start.starts_with(b"\x89HLT") {
        let reason = "this is not a mesh but a tree: open it as a scene, from its file";
        return Err(Error::format(path, "byte 0", reason));
    }
    let format = by_content(start)
        .or_else(|| otherwise(start, Path::new(name.unwrap_or_default())))
        .ok_or_else(|| {
            Error::format(path, "byte 0", format!("the format is not known; {SUPPORTED}"))
        })?;
    #[cfg(not(feature = "gltf"))]
    if format == Format::Gltf {
        return Err(left_out(path, "gltf"));
    }
    Ok(format)
}

/// True if `bytes` begin as a gzip stream (RFC 1952) does.
fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x1f\x8b")
}

/// The error about a file that needs a feature which this build lacks.
#[cfg(not(all(feature = "gltf", feature = "gzip")))]
fn left_out(path: &Path, feature: &str) -> Error {
    let reason = format!("this build of halfline-io was made without its feature `{feature}`");
    Error::format(path, "byte 0", reason)
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

/// The formats without a mark, told by what stands at the start.
fn by_statements(start: &[u8], most: u64) -> Option<Format> {
    if start.trim_ascii_start().starts_with(b"{") {
        Some(Format::Gltf)
    } else if obj::is_obj(&start[..start.len().min(START_BYTES)]) {
        Some(Format::Obj)
    } else if stl::may_be_binary(start, most) {
        Some(Format::Stl)
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
