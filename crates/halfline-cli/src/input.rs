//! Where meshes and rays come from: regular files, and standard input as `-`.

use std::path::Path;

use halfline::Error;
use halfline::error::Result;

/// What standard input is called in messages.
pub const STDIN: &str = "standard input";

/// The most bytes that are read from standard input. They are held in memory, where a file is mapped.
pub const MOST_STDIN_BYTES: u64 = 4 << 30;

/// True if `path` is the argument that stands for standard input.
pub fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// What `path` is called where people read it.
pub fn name(path: &Path) -> &Path {
    if is_stdin(path) { Path::new(STDIN) } else { path }
}

/// Refuses pipes, devices and sockets, and says how a pipe can be read.
pub fn check_regular(path: &Path) -> Result<()> {
    let kind =
        path.metadata().ok().and_then(|found| halfline::storage::stream_name(found.file_type()));
    kind.map_or(Ok(()), |kind| {
        let reason = format!("not a regular file but {kind}: give - to read standard input");
        Err(Error::io(path, std::io::Error::other(reason)))
    })
}
