//! Pages of memory: a file's bytes, mapped rather than copied where the operating system can, and
//! fresh arrays for what is made of them.

use std::fs::File;
use std::io::Read;
use std::ops::Deref;
use std::path::Path;

use crate::error::{Error, Result};
use crate::progress::Observer;

/// The bytes of a file.
///
/// A mapped file shows what other programs do to it while it is mapped. Readers must therefore not
/// trust in a second look what they verified in a first one; a file that is cut short under the
/// map ends the process with SIGBUS, as with every program that maps files.
#[derive(Debug)]
pub enum Bytes {
    /// Pages of the file itself, read only.
    Mapped(memmap2::Mmap),
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
            && let Some(map) = map(&file)
        {
            return Ok(Bytes::Mapped(map));
        }
        read_stream(path, file, observer, accept).map(Bytes::Owned)
    }
}

/// The map of a whole regular file; `None` where the file system cannot map.
#[allow(unsafe_code)]
fn map(file: &File) -> Option<memmap2::Mmap> {
    // SAFETY: the map is read only, and its length is the file's, asked by memmap2. Nobody can
    // promise that no other program changes the file meanwhile; every reader in this crate indexes
    // the bytes with bounds checks in each pass and assumes no relation between two reads of the
    // same byte, so a change can give a wrong mesh or an error, never a wild access.
    unsafe { memmap2::Mmap::map(file) }.ok()
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

/// An array of `count` zeros, as far as possible in huge pages that nobody has touched yet.
///
/// Reading a large file is bound by the first touches of the memory that it is read to: with pages
/// of 4 KiB they cost twice as much as everything else together. Whoever fills the array should do
/// so in parallel, since a page is cleared by the thread that touches it first.
pub fn zeroed<T: Copy>(zero: T, count: usize) -> Vec<T> {
    let mut items = vec![zero; count];
    advise_huge_pages(&mut items);
    items
}

#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
fn advise_huge_pages<T>(items: &mut [T]) {
    const HUGE_PAGE: usize = 2 << 20;
    let start = items.as_mut_ptr().cast::<u8>();
    let skipped = start.align_offset(HUGE_PAGE);
    let Some(rest) = size_of_val(items).checked_sub(skipped) else {
        return;
    };
    let length = rest - rest % HUGE_PAGE;
    if length > 0 {
        // SAFETY: the range lies within `items`, which is borrowed mutably. The advice changes by
        // which pages the range is backed, never what it holds, and its failure changes nothing.
        unsafe { libc::madvise(start.add(skipped).cast(), length, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn advise_huge_pages<T>(_: &mut [T]) {}

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
    use crate::progress::Silent;

    fn accept_all(_: &[u8]) -> Result<()> {
        Ok(())
    }

    #[test]
    fn a_file_is_mapped_and_an_empty_one_owned() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, b"abc").unwrap();
        let bytes = Bytes::open(&path, &Silent, &accept_all).unwrap();
        assert!(matches!(bytes, Bytes::Mapped(_)));
        assert_eq!(&*bytes, b"abc");
        std::fs::write(&path, b"").unwrap();
        let bytes = Bytes::open(&path, &Silent, &accept_all).unwrap();
        assert!(matches!(&bytes, Bytes::Owned(v) if v.is_empty()));
    }

    #[test]
    fn a_folder_and_a_missing_file_are_errors_that_name_them() {
        let folder = tempfile::tempdir().unwrap();
        let error = Bytes::open(folder.path(), &Silent, &accept_all).unwrap_err().to_string();
        assert!(error.contains("directory"), "{error}");
        let error = Bytes::open(&folder.path().join("none.ply"), &Silent, &accept_all).unwrap_err();
        assert!(error.to_string().contains("none.ply"), "{error}");
    }

    #[test]
    fn fresh_arrays_of_all_sizes_are_zero() {
        for count in [0, 1, 1000, 600_000, 3_000_001] {
            let mut items = zeroed([0_u32; 3], count);
            assert_eq!(items.len(), count);
            assert!(items.iter().all(|item| *item == [0; 3]));
            items.fill([7; 3]);
            items.push([8; 3]);
            assert!(items[..count].iter().all(|item| *item == [7; 3]));
        }
    }

    #[test]
    fn a_stream_is_refused_after_its_first_bytes() {
        let refuse = |first: &[u8]| {
            assert!(first.len() as u64 <= STREAM_CHUNK);
            Err(Error::invalid("stream", "refused"))
        };
        let error = read_stream(Path::new("zeros"), std::io::repeat(0), &Silent, &refuse);
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
            read_stream(Path::new("s"), std::io::repeat(7).take(length), &Silent, &accept).unwrap();
        assert_eq!(bytes.len() as u64, length);
        assert_eq!(seen.get(), 1);
    }
}
