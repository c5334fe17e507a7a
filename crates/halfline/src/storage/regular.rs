//! Opening what strangers name: regular files, and nothing that waits or never ends.

use std::fs::{File, FileType, Metadata};
use std::path::Path;

use crate::error::{Error, Result};

/// Opens the regular file at `path` for reading; a link counts as what it leads to.
///
/// # Errors
/// [`Error::Io`] if there is none, or if a folder, a pipe, a device or a socket lies there.
pub fn open_regular(path: &Path) -> Result<(File, Metadata)> {
    let failed = |error| Error::io(path, error);
    // Asked before it is opened: opening a pipe waits for its writer, and a device may act on it.
    check(path, &std::fs::metadata(path).map_err(failed)?)?;
    let file = File::open(path).map_err(failed)?;
    let metadata = file.metadata().map_err(failed)?;
    check(path, &metadata)?;
    Ok((file, metadata))
}

fn check(path: &Path, metadata: &Metadata) -> Result<()> {
    if metadata.is_dir() {
        return Err(Error::io(path, std::io::ErrorKind::IsADirectory.into()));
    }
    match stream_name(metadata.file_type()) {
        Some(name) => {
            let reason = format!("not a regular file but {name}");
            Err(Error::io(path, std::io::Error::other(reason)))
        }
        None => Ok(()),
    }
}

/// What people call a file that is neither regular nor a folder; `None` for one that is either.
pub fn stream_name(file_type: FileType) -> Option<&'static str> {
    if file_type.is_file() || file_type.is_dir() {
        return None;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if file_type.is_fifo() {
            return Some("a pipe");
        }
        if file_type.is_socket() {
            return Some("a socket");
        }
    }
    Some("a device")
}
