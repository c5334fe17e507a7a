//! What a user may choose about a tree.

use crate::error::{Error, Result};

/// How the tree is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildParameters {
    /// Cells of at most this many triangles are not cut by planes any more, but grouped. Smaller
    /// values give more references and a larger tree. At least 1.
    pub last_cell_triangles: usize,
    /// References beyond the first that all triangles together may have, for each triangle. Bounds
    /// the memory. Between 0 (no triangle is ever cut) and 16.
    pub spare_references: f64,
}

impl Default for BuildParameters {
    fn default() -> BuildParameters {
        BuildParameters { last_cell_triangles: 128, spare_references: 1.0 }
    }
}

impl BuildParameters {
    /// Refuses values that make no sense.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the parameter that is out of its range.
    pub fn check(&self) -> Result<()> {
        if self.last_cell_triangles == 0 {
            return Err(Error::invalid("last_cell_triangles", "must be at least 1"));
        }
        if !(0.0..=16.0).contains(&self.spare_references) {
            let reason = format!("must be between 0 and 16, not {}", self.spare_references);
            return Err(Error::invalid("spare_references", reason));
        }
        Ok(())
    }
}
