//! Where results go: checked before the work begins, written beside and renamed at its end.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use halfline::Error;

use crate::session::Failure;

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
    let place = |reason: String| Error::format(output, "output", reason);
    if output.is_dir() {
        return Err(place("is a folder".into()).into());
    }
    let same = |input: &&&Path| match (input.canonicalize(), output.canonicalize()) {
        (Ok(input), Ok(output)) => input == output,
        _ => false,
    };
    if let Some(input) = inputs.iter().find(same) {
        return Err(Failure::Usage(format!(
            "--output {} would overwrite the input {}",
            output.display(),
            input.display()
        )));
    }
    let folder = match output.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(place(format!("there is no folder {}", folder.display())).into());
    }
    // Only trying tells: permissions, read-only mounts and full quotas have no common query.
    tempfile::tempfile_in(folder)
        .map_err(|error| place(format!("cannot write into {}: {error}", folder.display())))?;
    Ok(())
}

/// Prints on stdout. That the reader went away (`| head`) is its own business, not an error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::io(Path::new("standard output"), error).into())
        }
        _ => Ok(()),
    }
}
