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
    /// Slabs of each axis of a cell between which planes are looked for: 16, 32 or 64.
    pub plane_bins: usize,
    /// Bins of each axis between which groups are divided: 8, 16 or 32.
    pub group_bins: usize,
    /// Above last cells, too, divides triangles into groups where that costs clearly less than the best
    /// plane.
    pub weighs_groups: bool,
    /// Sorts the triangles into a grid first, and builds a tree over its cells and one in each: saves
    /// most of the time. No triangle is cut then.
    pub coarse_grid: bool,
}

impl Default for BuildParameters {
    fn default() -> BuildParameters {
        BuildParameters::preset(Preset::Balanced)
    }
}

/// Between a tree soon and one that is quick to walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Preset {
    /// The first picture soonest.
    Fast,
    /// For as many rays as the mesh has triangles, and more.
    Balanced,
    /// The most rays a second, however long it takes to build.
    Best,
}

impl Preset {
    /// All of them, the quickest to build first.
    pub const ALL: [Preset; 3] = [Preset::Fast, Preset::Balanced, Preset::Best];

    /// As the command line and reports have it.
    pub fn name(self) -> &'static str {
        match self {
            Preset::Fast => "fast",
            Preset::Balanced => "balanced",
            Preset::Best => "best",
        }
    }
}

impl BuildParameters {
    /// The parameters that a preset stands for.
    pub const fn preset(preset: Preset) -> BuildParameters {
        let balanced = BuildParameters {
            last_cell_triangles: 256,
            spare_references: 1.0,
            plane_bins: 32,
            group_bins: 16,
            weighs_groups: false,
            coarse_grid: false,
        };
        match preset {
            Preset::Fast => BuildParameters {
                spare_references: 0.0,
                group_bins: 8,
                coarse_grid: true,
                ..balanced
            },
            Preset::Balanced => balanced,
            Preset::Best => BuildParameters {
                last_cell_triangles: 32,
                plane_bins: 64,
                weighs_groups: true,
                ..balanced
            },
        }
    }

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
        for (name, value, [few, some, many]) in [
            ("plane_bins", self.plane_bins, [16, 32, 64]),
            ("group_bins", self.group_bins, [8, 16, 32]),
        ] {
            if ![few, some, many].contains(&value) {
                let reason = format!("must be {few}, {some} or {many}, not {value}");
                return Err(Error::invalid(name, reason));
            }
        }
        Ok(())
    }
}
