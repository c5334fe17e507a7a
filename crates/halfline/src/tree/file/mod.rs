//! A tree and its mesh as a file that is mapped, not read.
//!
//! The file holds the arrays that the engine walks, as they lie in memory; docs/tree-file.md specifies
//! it. Opening maps it and looks at the first page, so it takes the same time whatever the size, and all
//! processes on a machine share the memory. Checksums tell whether anything was damaged; they are
//! computed over the whole file, at the speed of memory, unless the file was not touched since it was
//! written (see [`Verify`]). What is read later is never trusted: every index is checked where it is
//! used, and every walk is bounded, so a file that is damaged under the map gives an error or a wrong
//! answer, but no wild access and no walk without end.

mod checksums;
mod header;
mod read;
mod write;

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use checksums::Verify;
pub use read::{Opened, is_tree_file, open};
pub use write::write;

use crate::error::{Error, Result};
use crate::storage::MappedFile;

/// Sixteen bytes that tell contents apart: XXH3. It prints as 32 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ContentHash(pub u128);

impl fmt::Display for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

/// The file that a scene's arrays lie in.
#[derive(Clone, Debug)]
pub struct TreeFile {
    path: PathBuf,
    content_hash: ContentHash,
    mesh_hash: ContentHash,
    map: Arc<MappedFile>,
}

impl TreeFile {
    /// Where the file is, as an absolute path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The hash of the mesh, the tree and how it was built: the same for the same input on every machine.
    pub fn content_hash(&self) -> ContentHash {
        self.content_hash
    }

    /// The hash of the mesh's vertices and triangles.
    pub fn mesh_hash(&self) -> ContentHash {
        self.mesh_hash
    }

    /// How large the file is, in bytes.
    pub fn bytes(&self) -> u64 {
        self.map.len() as u64
    }

    /// An error once something was read that the file does not have any more.
    pub(crate) fn check(&self) -> Result<()> {
        if self.map.was_shortened() {
            return Err(Error::format(
                &self.path,
                "end",
                "the file was cut short while it was in use",
            ));
        }
        Ok(())
    }

    /// What is wrong if work on what the file holds cannot go on.
    pub(crate) fn damaged(&self) -> Error {
        Error::format(&self.path, "tree", "the file is damaged: what it holds makes no sense")
    }
}
