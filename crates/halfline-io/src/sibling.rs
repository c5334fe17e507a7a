//! Files that a mesh file names, in its own folder or below.

use std::io::Read;
use std::path::{Path, PathBuf};

use halfline::error::{Error, Result};
use halfline::storage::open_regular;

/// Where the file called `name` in the mesh file `path` lies. The name is relative to the folder
/// of `path` and must not leave it.
///
/// # Errors
/// The reason for which the name is refused.
pub(super) fn locate(path: &Path, name: &str) -> std::result::Result<PathBuf, &'static str> {
    if has_scheme(name) {
        return Err("names a scheme or a drive; only files beside the mesh are read");
    }
    if name.contains('\0') || name.is_empty() {
        return Err("is not the name of a file");
    }
    // Either slash may part a path, whatever the system: better refused here than found there.
    if name.starts_with(['/', '\\']) {
        return Err("is absolute; only files beside the mesh are read");
    }
    if name.split(['/', '\\']).any(|part| part == "..") {
        return Err("leaves the folder of the mesh");
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    // Joining the parts one by one drops repeated slashes and dots: one file, one path.
    let parts = name.split('/').filter(|part| !part.is_empty() && *part != ".");
    Ok(parts.fold(folder.to_owned(), |place, part| place.join(part)))
}

/// True if `name` begins like `https:`, `file:` or `C:`.
pub(super) fn has_scheme(name: &str) -> bool {
    let Some((scheme, _)) = name.split_once(':') else { return false };
    scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
}

/// The content of a regular file; `None` if there is none at this place, or a folder.
///
/// # Errors
/// [`Error::Io`] if it is there and cannot be read, or is no regular file.
pub(super) fn read(place: &Path) -> Result<Option<Vec<u8>>> {
    if std::fs::metadata(place).map_or(true, |metadata| metadata.is_dir()) {
        return Ok(None);
    }
    let (mut file, _) = open_regular(place)?;
    let mut content = Vec::new();
    file.read_to_end(&mut content).map_err(|source| Error::io(place, source))?;
    Ok(Some(content))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_folder() {
        let mesh = Path::new("/data/scans/mesh.gltf");
        for (name, expected) in [
            ("a.bin", "/data/scans/a.bin"),
            ("./a.bin", "/data/scans/a.bin"),
            ("parts//./a.bin", "/data/scans/parts/a.bin"),
            ("a..b", "/data/scans/a..b"),
            ("with space", "/data/scans/with space"),
        ] {
            assert_eq!(locate(mesh, name), Ok(PathBuf::from(expected)), "{name}");
        }
        for (name, reason) in [
            ("/etc/passwd", "absolute"),
            ("\\\\host\\share", "absolute"),
            ("../a.bin", "leaves"),
            ("parts/../a.bin", "leaves"),
            ("parts\\..\\..\\a.bin", "leaves"),
            ("..", "leaves"),
            ("http://host/a.bin", "scheme"),
            ("file:a.bin", "scheme"),
            ("C:a.bin", "drive"),
            ("a\0b", "not the name"),
            ("", "not the name"),
        ] {
            let refused = locate(mesh, name).expect_err(name);
            assert!(refused.contains(reason), "{name}: {refused}");
        }
    }
}
