//! A file's bytes, mapped rather than copied where the operating system can.

use std::io::Read;
use std::ops::Deref;
use std::path::Path;

use super::{MappedFile, open_regular};
use crate::error::{Error, Result};
use crate::progress::Observer;

/// The bytes of a file. Readers must not trust in a second look what they verified in a first one: see
/// [`MappedFile`].
#[derive(Debug)]
pub enum Bytes {
    /// Pages of the file itself, read only.
    Mapped(MappedFile),
    /// A copy, for what cannot be mapped: streams, empty files, some file systems.
    Owned(Vec<u8>),
}

/// How much of a stream is read between two looks at the observer.
const STREAM_CHUNK: u64 = 1 << 20;

impl Bytes {
    /// Maps the regular file at `path`, or reads it where it cannot be mapped.
    pub fn open(path: &Path, observer: &dyn Observer) -> Result<Bytes> {
        let (file, metadata) = open_regular(path)?;
        match metadata.len() > 0 {
            true => match MappedFile::new(&file) {
                Some(map) => Ok(Bytes::Mapped(map)),
                None => Bytes::read(path, file, u64::MAX, observer, &|_| Ok(())),
            },
            false => Ok(Bytes::Owned(Vec::new())),
        }
    }

    /// Reads `stream`, which errors call `name`, to its end.
    ///
    /// `accept` sees the first bytes before the rest is read, and refuses by an error what is not worth
    /// reading.
    ///
    /// # Errors
    /// [`Error::Format`] if the stream has more than `most` bytes.
    pub fn read(
        name: &Path,
        mut stream: impl Read,
        most: u64,
        observer: &dyn Observer,
        accept: &dyn Fn(&[u8]) -> Result<()>,
    ) -> Result<Bytes> {
        let mut bytes = Vec::new();
        loop {
            observer.check()?;
            let read = stream
                .by_ref()
                .take(STREAM_CHUNK)
                .read_to_end(&mut bytes)
                .map_err(|e| Error::io(name, e))? as u64;
            if read == bytes.len() as u64 {
                accept(&bytes)?;
            }
            if bytes.len() as u64 > most {
                let reason = "more bytes follow than may come this way: save them to a file first";
                return Err(Error::format(name, format!("byte {most}"), reason));
            }
            if read < STREAM_CHUNK {
                return Ok(Bytes::Owned(bytes));
            }
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

    #[test]
    fn a_file_is_mapped_and_an_empty_one_owned() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, b"abc").unwrap();
        let bytes = Bytes::open(&path, &NoProgress).unwrap();
        assert!(matches!(bytes, Bytes::Mapped(_)));
        assert_eq!(&*bytes, b"abc");
        std::fs::write(&path, b"").unwrap();
        let bytes = Bytes::open(&path, &NoProgress).unwrap();
        assert!(matches!(&bytes, Bytes::Owned(v) if v.is_empty()));
    }

    #[test]
    fn a_folder_and_a_missing_file_are_errors_that_name_them() {
        let folder = tempfile::tempdir().unwrap();
        let error = Bytes::open(folder.path(), &NoProgress).unwrap_err().to_string();
        assert!(error.contains("directory"), "{error}");
        let error = Bytes::open(&folder.path().join("none.ply"), &NoProgress).unwrap_err();
        assert!(error.to_string().contains("none.ply"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn what_waits_or_never_ends_is_not_opened() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe.ply");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        // Whoever opens the pipe all the same finds its end, and no reason to wait.
        let writer = pipe.clone();
        std::thread::spawn(move || std::fs::write(writer, ""));
        let device = folder.path().join("device.ply");
        std::os::unix::fs::symlink("/dev/null", &device).unwrap();
        let socket = folder.path().join("socket.ply");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        for (path, kind) in [(pipe, "a pipe"), (device, "a device"), (socket, "a socket")] {
            let error = Bytes::open(&path, &NoProgress).unwrap_err().to_string();
            let expected = format!("{}: not a regular file but {kind}", path.display());
            assert_eq!(error, expected);
        }
    }

    fn read_stream(
        stream: impl Read,
        most: u64,
        accept: &dyn Fn(&[u8]) -> Result<()>,
    ) -> Result<Bytes> {
        Bytes::read(Path::new("stream"), stream, most, &NoProgress, accept)
    }

    #[test]
    fn a_stream_is_refused_after_its_first_bytes() {
        let refuse = |first: &[u8]| {
            assert!(first.len() as u64 <= STREAM_CHUNK);
            Err(Error::invalid("stream", "refused"))
        };
        let error = read_stream(std::io::repeat(0), u64::MAX, &refuse);
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
        let bytes = read_stream(std::io::repeat(7).take(length), length, &accept).unwrap();
        assert_eq!(bytes.len() as u64, length);
        assert_eq!(seen.get(), 1);
    }

    #[test]
    fn a_stream_without_end_is_given_up() {
        for most in [5, 3 * STREAM_CHUNK] {
            let error = read_stream(std::io::repeat(7), most, &|_| Ok(())).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("stream: byte {most}: more bytes follow")),
                "{error}"
            );
        }
    }
}
