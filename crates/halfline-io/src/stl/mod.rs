//! STL, ASCII and binary.
//!
//! STL repeats each vertex for every facet that uses it; reading makes them one again, so that
//! neighbours share vertices. Normals and attributes are ignored.

mod ascii;

#[cfg(test)]
mod tests;

use std::path::Path;

use super::weld::{Welded, weld};
use halfline::error::{Error, Result};
use halfline::mesh::{Mesh, Positions};
use halfline::progress::SharedProgress;
use halfline::progress::{Observer, Stage};
use halfline::storage::Buffer;

/// The header of a binary file, and the number of facets.
const HEADER_BYTES: usize = 84;

/// A facet of a binary file: a normal, three vertices, two attribute bytes.
const FACET_BYTES: usize = 50;

/// What is looked at to tell ASCII from binary.
const START_BYTES: usize = 1024;

/// True if `bytes` begin with the word `solid`, as ASCII files do and some binary ones.
pub(super) fn is_stl(bytes: &[u8]) -> bool {
    let text = without_mark(bytes).trim_ascii_start();
    text.len() >= 5
        && text[..5].eq_ignore_ascii_case(b"solid")
        && text.get(5).is_none_or(|b| !b.is_ascii_alphanumeric())
}

/// `bytes` after the byte-order mark of UTF-8, if there is one.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The facets that a binary file promises.
fn facet_count(bytes: &[u8]) -> Option<usize> {
    let raw = bytes.get(HEADER_BYTES - 4..HEADER_BYTES)?;
    Some(u32::from_le_bytes([raw[0], raw[1], raw[2], raw[3]]) as usize)
}

/// The bytes that a binary file of `facets` has.
fn binary_length(facets: usize) -> u64 {
    HEADER_BYTES as u64 + facets as u64 * FACET_BYTES as u64
}

fn is_ascii(bytes: &[u8]) -> bool {
    if !is_stl(bytes) {
        return false;
    }
    // A binary file's count has a zero byte (or more than 16 million facets); text has none.
    let start = &bytes[..bytes.len().min(START_BYTES)];
    let is_text = |b: &u8| *b >= b' ' || b.is_ascii_whitespace();
    if start.iter().all(is_text) {
        return true;
    }
    // Text with a broken name is still told by its first facet, unless all fits a binary file.
    let fits = facet_count(bytes).is_some_and(|n| binary_length(n) <= bytes.len() as u64);
    !fits && memchr::memmem::find(start, b"facet").is_some()
}

/// True if no more bytes than these are needed. ASCII does not tell where it ends.
pub(super) fn is_complete(bytes: &[u8]) -> bool {
    !is_ascii(bytes)
        && facet_count(bytes).is_some_and(|facets| binary_length(facets) <= bytes.len() as u64)
}

/// True if a binary file of at most `most` bytes can begin with `start`, or be just that. Most other
/// files promise more or fewer facets in the place where the number of facets lies.
pub(super) fn may_be_binary(start: &[u8], most: u64) -> bool {
    facet_count(start).is_some_and(|facets| {
        let length = binary_length(facets);
        facets > 0 && (start.len() as u64..=most).contains(&length)
    })
}

/// The mesh that `bytes`, an STL file, describe. `path` names it in errors.
///
/// Vertices with the same bits become one, and -0 becomes 0. Coordinates of ASCII files stay in
/// double precision if single precision cannot reproduce their digits.
pub fn read(path: &Path, bytes: &[u8], observer: &dyn Observer) -> Result<Mesh> {
    let progress = SharedProgress::new(observer, Stage::Load, bytes.len());
    let mesh = if is_ascii(bytes) {
        let facets = ascii::parse(path, bytes, &progress)?;
        if facets.double {
            into_mesh(Positions::F64, weld(facets.count(), |i| facets.corners(i), 0, &progress)?)
        } else {
            let corner = |c: [f64; 3]| c.map(|value| value as f32);
            let corners = |i| facets.corners(i).map(corner);
            into_mesh(Positions::F32, weld(facets.count(), corners, 0, &progress)?)
        }
    } else {
        into_mesh(Positions::F32, read_binary(path, bytes, &progress)?)
    };
    progress.finish();
    mesh.map_err(|error| Error::format(path, "facets", error.to_string()))
}

fn into_mesh<P>(
    positions: impl Fn(Buffer<P>) -> Positions,
    (vertices, triangles): Welded<P>,
) -> Result<Mesh> {
    Mesh::new(positions(vertices.into()), triangles)
}

fn read_binary(path: &Path, bytes: &[u8], progress: &SharedProgress) -> Result<Welded<[f32; 3]>> {
    let Some(count) = facet_count(bytes) else {
        let reason =
            format!("a binary STL file has at least {HEADER_BYTES} bytes, not {}", bytes.len());
        return Err(Error::format(path, "header", reason));
    };
    if count == 0 && is_stl(bytes) {
        let reason =
            "the file begins with 'solid' but is no text, and read as binary it has no facets";
        return Err(Error::format(path, "header", reason));
    }
    if count == 0 && bytes.len() > HEADER_BYTES {
        let reason = format!(
            "the header promises no facets, and {} bytes follow",
            bytes.len() - HEADER_BYTES
        );
        return Err(Error::format(path, "header", reason));
    }
    if binary_length(count) > bytes.len() as u64 {
        return Err(Error::format(
            path,
            format!("facet {}", (bytes.len() - HEADER_BYTES) / FACET_BYTES),
            format!("the file ends before its end; the header promises {count} facets"),
        ));
    }
    let facets = &bytes[HEADER_BYTES..HEADER_BYTES + count * FACET_BYTES];
    weld(count, |i| corners(&facets[i * FACET_BYTES..][..FACET_BYTES]), FACET_BYTES, progress)
}

/// The corners of a facet of a binary file, which follow its normal.
#[inline]
fn corners(facet: &[u8]) -> [[f32; 3]; 3] {
    let number =
        |at: usize| f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]);
    let corner = |at: usize| [number(at), number(at + 4), number(at + 8)];
    [corner(12), corner(24), corner(36)]
}
