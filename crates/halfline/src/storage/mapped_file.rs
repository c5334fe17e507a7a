//! A whole file as memory, read only.

use std::fs::File;
use std::ops::Deref;

#[cfg(unix)]
use super::shortened::Region;

/// Pages of a file.
///
/// They show what other programs do to the file while it is mapped: nobody may trust in a second look
/// what was verified in a first one. Where the file is cut short meanwhile, its pages read as zeros
/// from then on (see `shortened.rs`), and [`MappedFile::was_shortened`] tells.
#[derive(Debug)]
pub struct MappedFile {
    // Before the map, so that it is dropped before: an address is never watched over after its map.
    #[cfg(unix)]
    region: Region,
    map: memmap2::Mmap,
}

impl MappedFile {
    /// The map of a whole regular file; `None` where the file system cannot map.
    #[allow(unsafe_code)]
    pub fn new(file: &File) -> Option<MappedFile> {
        // SAFETY: the map is read only, and its length is the file's, asked by memmap2. Nobody can
        // promise that no other program changes the file meanwhile; every reader in this crate indexes
        // what it reads with bounds checks in each pass and assumes no relation between two reads of
        // the same byte, so a change can give a wrong answer or an error, never a wild access.
        let map = unsafe { memmap2::Mmap::map(file) }.ok()?;
        Some(MappedFile {
            #[cfg(unix)]
            region: Region::watch_over(&map),
            map,
        })
    }

    /// True once something was read that the file does not have any more, since it was cut short.
    pub fn was_shortened(&self) -> bool {
        #[cfg(unix)]
        return self.region.was_shortened();
        // There the system refuses to cut mapped files short.
        #[cfg(not(unix))]
        false
    }
}

impl Deref for MappedFile {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.map
    }
}
