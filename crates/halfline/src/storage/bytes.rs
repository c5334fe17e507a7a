//! A file's bytes, mapped rather than copied where the operating system can.

use std::fs::File;
use std::io::Read;
use std::ops::Deref;
use std::path::Path;

use super::MappedFile;
use crate::error::{Error, Result};
use crate::progress::Observer;

/// The bytes of a file. Readers must not trust in a second look what they verified in a first one: see
/// [`MappedFile`].
#[derive(Debug)]
pub enum Bytes {
    /// Pages of the file itself, read only.
    Mapped(MappedFile),
    /// A copy, for what cannot be mapped: pipes, devices, empty files.
    Owned(Vec<u8>),
}

/// How much of a stream is read between two looks at the observer.
const STREAM_CHUNK: u64 = 1 << 20;

impl Bytes {
    /// Maps the file at `path`, or reads it if it is a stream.
    ///
    /// `accept` sees the first bytes of a stream before the rest is read, and refuses by an error
    /// what is not worth reading to a perhaps infinite end.
    pub fn open(
        path: &Path,
        observer: &dyn Observer,
        accept: &dyn Fn(&[u8]) -> Result<()>,
    ) -> Result<Bytes> {
        let file = File::open(path).map_err(|e| Error::io(path, e))?;
        let metadata = file.metadata().map_err(|e| Error::io(path, e))?;
        if metadata.is_dir() {
            return Err(Error::io(path, std::io::ErrorKind::IsADirectory.into()));
        }
        if metadata.is_file()
            && metadata.len() > 0
            && let Some(map) = MappedFile::new(&file)
        {
            return Ok(Bytes::Mapped(map));
        }
        read_stream(path, file, observer, accept).map(Bytes::Owned)
    }
}

fn read_stream(
    path: &Path,
    mut stream: impl Read,
    observer: &dyn Observer,
    accept: &dyn Fn(&[u8]) -> Result<()>,
) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    loop {
        observer.check()?;
        let read = stream
            .by_ref()
            .take(STREAM_CHUNK)
            .read_to_end(&mut bytes)
            .map_err(|e| Error::io(path, e))? as u64;
        if read == bytes.len() as u64 {
            accept(&bytes)?;
        }
        if read < STREAM_CHUNK {
            return Ok(bytes);
        }
    }
}

impl Bytes {
    /// An error if the file at `path` was cut short while it was read.
    pub fn check(&self, path: &Path) -> Result<()> {
        match self {
            Bytes::Mapped(map) if map.was_shortened() => {
                Err(Error::format(path, "end", "the file was cut short while it was read"))
            }
            _ => Ok(()),
        }
    }
}

impl Deref for Bytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Bytes::Mapped(map) => map,
            Bytes::Owned(bytes) => bytes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::NoProgress;

    fn accept_all(_: &[u8]) -> Result<()> {
        Ok(())
    }

    #[test]
    fn a_file_is_mapped_and_an_empty_one_owned() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, b"abc").unwrap();
        let bytes = Bytes::open(&path, &NoProgress, &accept_all).unwrap();
        assert!(matches!(bytes, Bytes::Mapped(_)));
        assert_eq!(&*bytes, b"abc");
        std::fs::write(&path, b"").unwrap();
        let bytes = Bytes::open(&path, &NoProgress, &accept_all).unwrap();
        assert!(matches!(&bytes, Bytes::Owned(v) if v.is_empty()));
    }

    #[test]
    fn a_folder_and_a_missing_file_are_errors_that_name_them() {
        let folder = tempfile::tempdir().unwrap();
        let error = Bytes::open(folder.path(), &NoProgress, &accept_all).unwrap_err().to_string();
        assert!(error.contains("directory"), "{error}");
        let error =
            Bytes::open(&folder.path().join("none.ply"), &NoProgress, &accept_all).unwrap_err();
        assert!(error.to_string().contains("none.ply"), "{error}");
    }

    #[test]
    fn a_stream_is_refused_after_its_first_bytes() {
        let refuse = |first: &[u8]| {
            assert!(first.len() as u64 <= STREAM_CHUNK);
            Err(Error::invalid("stream", "refused"))
        };
        let error = read_stream(Path::new("zeros"), std::io::repeat(0), &NoProgress, &refuse);
        assert_eq!(error.unwrap_err().to_string(), "stream: refused");
    }

    #[test]
    fn a_long_stream_is_read_whole_and_its_start_seen_once() {
        let length = 3 * STREAM_CHUNK + 5;
        let seen = std::cell::Cell::new(0);
        let accept = |_: &[u8]| {
            seen.set(seen.get() + 1);
            Ok(())
        };
        let bytes =
            read_stream(Path::new("s"), std::io::repeat(7).take(length), &NoProgress, &accept)
                .unwrap();
        assert_eq!(bytes.len() as u64, length);
        assert_eq!(seen.get(), 1);
    }
}
