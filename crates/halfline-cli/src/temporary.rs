//! Files that are not to be left behind.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The temporary files that may exist now.
static THERE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn there() -> MutexGuard<'static, Vec<PathBuf>> {
    THERE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A name for a file, which is removed when this is dropped.
pub struct Temporary(PathBuf);

impl Temporary {
    /// The file at `path`, which may be written from now on.
    pub fn new(path: PathBuf) -> Temporary {
        there().push(path.clone());
        Temporary(path)
    }

    /// The name of the file.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let mut there = there();
        let _ = std::fs::remove_file(&self.0);
        there.retain(|path| *path != self.0);
    }
}

/// Removes all of them, for those who end the process while others still work.
pub fn remove_all() {
    for path in &*there() {
        let _ = std::fs::remove_file(path);
    }
}
