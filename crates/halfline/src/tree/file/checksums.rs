//! Whether what a file holds is what was written.

use std::ops::Range;

use rayon::prelude::*;
use twox_hash::{XxHash3_64, XxHash3_128};

use super::ContentHash;
use super::header::{Header, PAGE, Section};
use crate::error::Result;
use crate::mesh::{Mesh, Positions};
use crate::progress::{Observer, SharedProgress, Stage};

/// When opening a file checks that nothing in it was damaged: that takes as long as reading all of it.
/// Its first page and its length are always checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verify {
    /// Checks if the file's time of modification is not the one that it got when it was written, as after
    /// copying it or changing anything in it.
    #[default]
    IfTouched,
    /// Checks each time.
    Always,
    /// Never checks. What is damaged then gives wrong answers or errors, as anything that is damaged after
    /// it was opened.
    Never,
}

/// Bytes under one checksum.
pub const CHUNK: usize = 1 << 20;

/// The checksum of a chunk.
pub fn checksum(bytes: &[u8]) -> u64 {
    XxHash3_64::oneshot(bytes)
}

/// The checksums of the chunks of some bytes.
pub fn checksums_of(bytes: &[u8], progress: &SharedProgress) -> Result<Vec<u64>> {
    bytes
        .par_chunks(CHUNK)
        .map(|chunk| {
            progress.advance(chunk.len())?;
            Ok(checksum(chunk))
        })
        .collect()
}

/// The checksum of a header, which does not cover its own field.
pub fn header_checksum(header: &Header) -> u64 {
    checksum(bytemuck::bytes_of(&Header { header_checksum: 0, ..*header }))
}

/// The hash of what a file holds: of its header, but for what differs from one writing to the next, and
/// of all checksums.
pub fn content_hash(header: &Header, checksums: &[u64]) -> ContentHash {
    let lasting = Header {
        written_at: 0,
        build_seconds: 0.0,
        program: [0; 32],
        header_checksum: 0,
        content_hash: [0; 2],
        ..*header
    };
    let mut hasher = XxHash3_128::new();
    hasher.write(bytemuck::bytes_of(&lasting));
    hasher.write(bytemuck::cast_slice(checksums));
    ContentHash(hasher.finish_128())
}

/// The hash of a mesh's vertices and triangles, as their bytes lie in the file.
pub fn mesh_hash(mesh: &Mesh) -> ContentHash {
    let mut hasher = XxHash3_128::new();
    hasher.write(match mesh.positions() {
        Positions::F32(positions) => bytemuck::cast_slice(positions),
        Positions::F64(positions) => bytemuck::cast_slice(positions),
    });
    hasher.write(bytemuck::cast_slice(mesh.triangles()));
    ContentHash(hasher.finish_128())
}

/// Where a file's bytes are not what they should be; `None` if they are.
pub fn damage(
    bytes: &[u8],
    header: &Header,
    observer: &dyn Observer,
) -> Result<Option<Range<usize>>> {
    let table = header.sections[Section::CHECKSUMS].range();
    let checksums: &[u64] = bytemuck::cast_slice(&bytes[table.clone()]);
    if content_hash(header, checksums) != header.content_hash() {
        return Ok(Some(table));
    }
    let progress = SharedProgress::new(observer, Stage::Load, bytes.len());

    // Hold each chunk against its checksum, and see that there is nothing between sections.
    let mut next = checksums;
    let mut end = PAGE;
    for section in &header.sections {
        let range = section.range();
        if let Some(i) = bytes[end..range.start].iter().position(|&byte| byte != 0) {
            return Ok(Some(end + i..range.start));
        }
        end = range.end;
        if range == table {
            continue;
        }
        let (expected, rest) = next.split_at(range.len().div_ceil(CHUNK).min(next.len()));
        next = rest;
        let found = checksums_of(&bytes[range.clone()], &progress)?;
        if found != expected {
            let wrong = found.iter().zip(expected).position(|(a, b)| a != b).unwrap_or(0);
            let begin = range.start + wrong * CHUNK;
            return Ok(Some(begin..range.end.min(begin + CHUNK)));
        }
    }
    progress.finish();
    Ok(None)
}
