//! Gzip (RFC 1952) around a mesh file, inflated within bounds.

use std::io::Read;
use std::path::Path;

use flate2::bufread::GzDecoder;

use crate::is_gzip;
use halfline::error::{Error, Result};
use halfline::progress::{Observer, SharedProgress, Stage};

/// A stream may inflate to this many times its size. Meshes shrink by a factor of two to fifty;
/// the format's own limit, which bombs live on, is 1032.
const LARGEST_RATIO: usize = 256;

/// Streams may inflate to this many bytes in any case.
const ALWAYS_ALLOWED: usize = 64 << 20;

const CHUNK: usize = 256 << 10;

/// The most bytes that a stream of `compressed` bytes may inflate to.
pub fn inflated_limit(compressed: usize) -> usize {
    compressed.saturating_mul(LARGEST_RATIO).max(ALWAYS_ALLOWED)
}

/// The first bytes, at most `count`, of what a gzip stream inflates to.
pub fn inflate_start(path: &Path, compressed: &[u8], count: usize) -> Result<Vec<u8>> {
    let mut members = Members::new(path, compressed);
    let mut start = vec![0; count];
    let mut filled = 0;
    while filled < count {
        match members.read(&mut start[filled..])? {
            0 => break,
            read => filled += read,
        }
    }
    start.truncate(filled);
    Ok(start)
}

/// Inflates `compressed`, all members of it, and verifies its checksums.
///
/// `enough` is shown the content so far each time that it has doubled, and says whether what
/// follows can only be bytes after the end. Those are not kept, and are read on (for the sake of
/// the checksum) only within the limit.
///
/// # Errors
/// [`Error::Format`] if the stream is cut short or corrupt, or inflates past its limit without
/// `enough` being satisfied.
pub fn inflate(
    path: &Path,
    compressed: &[u8],
    observer: &dyn Observer,
    enough: &dyn Fn(&[u8]) -> bool,
) -> Result<Vec<u8>> {
    let progress = SharedProgress::new(observer, Stage::Load, compressed.len());
    let limit = inflated_limit(compressed.len());
    let mut members = Members::new(path, compressed);
    let mut content = Vec::new();
    let mut chunk = vec![0; CHUNK];
    let mut next_look = 4 * CHUNK;
    let mut complete = false;
    let mut inflated = 0_usize;
    loop {
        let before = members.position();
        let read = members.read(&mut chunk)?;
        progress.advance(members.position() - before)?;
        if read == 0 {
            return Ok(content);
        }
        inflated += read;
        if complete {
            if inflated > limit {
                return Ok(content);
            }
            continue;
        }
        content.extend_from_slice(&chunk[..read]);
        if content.len() >= next_look || content.len() > limit {
            complete = enough(&content);
            if !complete && content.len() > limit {
                return Err(members.error(format!(
                    "inflates to more than {limit} bytes, which no mesh of its size would need"
                )));
            }
            next_look = content.len() * 2;
        }
    }
}

/// The members of a gzip stream one after the other. What follows the last is ignored.
struct Members<'a> {
    path: &'a Path,
    length: usize,
    decoder: Option<GzDecoder<&'a [u8]>>,
}

impl<'a> Members<'a> {
    fn new(path: &'a Path, compressed: &'a [u8]) -> Members<'a> {
        Members { path, length: compressed.len(), decoder: Some(GzDecoder::new(compressed)) }
    }

    /// Compressed bytes used up.
    fn position(&self) -> usize {
        self.decoder.as_ref().map_or(self.length, |d| self.length - d.get_ref().len())
    }

    /// Reads some content into `buffer`; 0 only at the end of the last member.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        while let Some(decoder) = &mut self.decoder {
            match decoder.read(buffer) {
                Ok(0) => {
                    let rest = self.decoder.take().map_or(&[][..], GzDecoder::into_inner);
                    if is_gzip(rest) {
                        self.decoder = Some(GzDecoder::new(rest));
                    }
                }
                Ok(read) => return Ok(read),
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
                    return Err(self.error("the gzip stream is cut short".to_owned()));
                }
                Err(e) => return Err(self.error(format!("corrupt gzip stream: {e}"))),
            }
        }
        Ok(0)
    }

    fn error(&self, reason: String) -> Error {
        Error::format(self.path, format!("compressed byte {}", self.position()), reason)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::io::Write;

    use super::*;
    use halfline::progress::NoProgress;

    pub(crate) fn compress(content: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    }

    fn inflate_all(compressed: &[u8]) -> Result<Vec<u8>> {
        inflate(Path::new("x.gz"), compressed, &NoProgress, &|_| false)
    }

    #[test]
    fn members_are_joined_and_bytes_after_the_last_ignored() {
        let mut stream = compress(b"first ");
        stream.extend(compress(b""));
        stream.extend(compress(b"second"));
        stream.extend(b"\0\0padding");
        assert_eq!(inflate_all(&stream).unwrap(), b"first second");
        assert_eq!(inflate_start(Path::new("x"), &stream, 8).unwrap(), b"first se");
    }

    #[test]
    fn every_truncation_is_an_error() {
        let stream = compress(b"some content that is not too short");
        for length in 2..stream.len() {
            let error = inflate_all(&stream[..length]).unwrap_err().to_string();
            assert!(error.contains("cut short"), "{length}: {error}");
        }
    }

    #[test]
    fn a_wrong_checksum_is_an_error() {
        let mut stream = compress(b"some content");
        let checksum = stream.len() - 8;
        stream[checksum] ^= 1;
        let error = inflate_all(&stream).unwrap_err().to_string();
        assert!(error.contains("corrupt gzip"), "{error}");
    }

    #[test]
    fn a_bomb_is_refused_at_the_limit() {
        let stream = compress(&vec![0; ALWAYS_ALLOWED + 2 * CHUNK]);
        assert!(stream.len() < 100_000);
        let error = inflate_all(&stream).unwrap_err().to_string();
        assert!(error.contains("inflates to more than 67108864 bytes"), "{error}");
    }

    #[test]
    fn bytes_after_what_is_enough_are_not_kept() {
        let stream = compress(&vec![1; 16 << 20]);
        let enough = |content: &[u8]| content.len() > 100;
        let content = inflate(Path::new("x"), &stream, &NoProgress, &enough).unwrap();
        assert_eq!(content.len(), 4 * CHUNK);
    }
}
