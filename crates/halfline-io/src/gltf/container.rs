//! GLB, the binary container: a header and chunks.

use std::path::Path;

use halfline::error::{Error, Result};

/// The document and the binary chunk of a GLB file, or the whole file as a document.
pub(super) fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let header_error = |reason: String| Error::format(path, "GLB header", reason);
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(header_error(format!("needs 12 bytes, the file has {}", bytes.len())));
    };
    if version != 2 {
        return Err(header_error(format!("version {version} is not supported, only 2")));
    }
    let have = bytes.len();
    let length = length as usize;
    if length > have || length < 12 {
        return Err(header_error(format!("promises {length} bytes, the file has {have}")));
    }

    // Bytes after the promised length belong to nobody and are not looked at.
    let bytes = &bytes[..length];
    let mut position = 12;
    let mut document = None;
    let mut binary = None;
    while position < length {
        let place = format!("GLB chunk at byte {position}");
        let (Some(chunk_length), Some(kind)) = (word(bytes, position), word(bytes, position + 4))
        else {
            return Err(Error::format(path, place, "its header is cut off"));
        };
        let start = position + 8;
        let Some(chunk) = bytes[start..].get(..chunk_length as usize) else {
            let left = length - start;
            let reason = format!("promises {chunk_length} bytes, {left} are left");
            return Err(Error::format(path, place, reason));
        };
        match (&kind.to_le_bytes(), document) {
            (b"JSON", None) => document = Some(chunk),
            (b"BIN\0", Some(_)) if binary.is_none() => binary = Some(chunk),
            (_, None) => return Err(Error::format(path, place, "the first chunk must be JSON")),
            // Chunks of unknown kinds are to be passed over.
            _ => {}
        }
        position = start + chunk.len().next_multiple_of(4);
    }
    match document {
        Some(document) => Ok((document, binary)),
        None => Err(header_error("no chunk follows it".to_owned())),
    }
}

fn word(bytes: &[u8], position: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(position..)?.first_chunk()?))
}
