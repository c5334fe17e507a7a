//! Where results go: checked before the work begins, written beside and renamed at its end.

use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use halfline::Error;
use halfline::progress::Observer;
use halfline::storage::AtomicFile;

use crate::failure::Failure;

/// Understands a path that ends in one of `extensions` (lower case, without the dot).
pub fn path_with_extension(
    extensions: &'static [&'static str],
) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(move |path| match extension(&path) {
        Some(found) if extensions.contains(&found.as_str()) => Ok(path),
        _ => {
            let wanted: Vec<_> = extensions.iter().map(|e| format!(".{e}")).collect();
            Err(format!("the file's name must end in {}", wanted.join(" or ")))
        }
    })
}

/// The path's extension in lower case.
pub fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// Fails now if `output` could not be written after hours of work, or is one of `inputs`.
pub fn check(output: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    check_as("--output", output, inputs)
}

/// [`check`], for a file that is given by another `option`.
pub fn check_as(option: &str, output: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    let same = |input: &&&Path| match (input.canonicalize(), output.canonicalize()) {
        (Ok(input), Ok(output)) => input == output,
        _ => false,
    };
    if let Some(input) = inputs.iter().find(same) {
        return Err(Failure::Usage(format!(
            "{option} {} would overwrite the input {}",
            output.display(),
            input.display()
        )));
    }
    // Only trying tells: permissions, read-only mounts and full quotas have no common query.
    // What is no regular file is written to as it is, and trying would already be doing it.
    if output.metadata().is_err() || output.is_file() || output.is_dir() {
        drop(AtomicFile::create(output)?);
    }
    Ok(())
}

/// Makes the file at `path` of what `write` writes; leaves nothing behind if it fails or the
/// observer wants the end.
pub fn write(
    path: &Path,
    observer: &dyn Observer,
    write: impl FnOnce(&mut Interruptible) -> std::io::Result<()>,
) -> halfline::error::Result<()> {
    let mut file = Interruptible { file: AtomicFile::create(path)?, observer };
    let outcome = write(&mut file);
    observer.check()?;
    outcome.map_err(|error| Error::io(path, error))?;
    file.file.commit()
}

/// A file that refuses to be written to once the work should end.
pub struct Interruptible<'a> {
    file: AtomicFile,
    observer: &'a dyn Observer,
}

impl Write for Interruptible<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        // Not `ErrorKind::Interrupted`, after which writers try again.
        self.observer.check().map_err(std::io::Error::other)?;
        self.file.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Interruptible<'_> {
    fn seek(&mut self, position: SeekFrom) -> std::io::Result<u64> {
        self.file.seek(position)
    }
}

/// Prints on stdout, with colours if that is a terminal. That the reader went away (`| head`) is
/// its own business, not an error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = anstream::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::io(Path::new("standard output"), error).into())
        }
        _ => Ok(()),
    }
}
