//! What a user may choose about a tree.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};

/// How the tree is built.
///
/// ```
/// use halfline::{BuildParameters, Preset};
///
/// let parameters = BuildParameters::preset(Preset::Best).with_duplication_budget(0.5);
/// assert_eq!(parameters.preset_name(), "custom");
/// ```
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildParameters {
    /// Cells of at most this many triangles are divided by object splits alone. Smaller values give more
    /// references and a larger tree. At least 1.
    pub spatial_split_min_triangles: usize,
    /// How many references beyond the first spatial splits may give to all triangles together, for each
    /// triangle. Bounds the memory. Between 0 (no triangle is ever cut) and 16.
    pub duplication_budget: f64,
    /// Bins of each axis of a cell between which spatial splits are looked for: 16, 32 or 64.
    pub spatial_bins: usize,
    /// Bins of each axis between which object splits are looked for: 8, 16 or 32.
    pub object_bins: usize,
    /// In larger cells, too, takes an object split where that costs clearly less than the best spatial split.
    pub weigh_object_splits: bool,
    /// Sorts the triangles into a grid first, and builds a tree over its cells and one in each: saves
    /// most of the time. No triangle is cut then.
    pub coarse_grid: bool,
}

impl Default for BuildParameters {
    fn default() -> BuildParameters {
        BuildParameters::preset(Preset::Balanced)
    }
}

/// Between a tree that is built soon and one that is quick to walk. The answers are the same.
///
/// ```
/// use halfline::Preset;
///
/// assert_eq!("best".parse::<Preset>()?, Preset::Best);
/// assert_eq!(Preset::Best.to_string(), "best");
/// let error = "finest".parse::<Preset>().unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "preset: expected one of 'fast', 'balanced', 'best', found 'finest'",
/// );
/// # Ok::<(), halfline::Error>(())
/// ```
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Preset {
    /// Builds soonest: for the first picture.
    Fast,
    /// Builds in the usual time: for as many rays as the mesh has triangles, and more.
    Balanced,
    /// Gives the most rays a second, however long it takes to build.
    Best,
}

impl Preset {
    /// All presets, the quickest to build first.
    pub const ALL: [Preset; 3] = [Preset::Fast, Preset::Balanced, Preset::Best];

    /// The name by which the command line, Python and reports call a preset.
    pub fn name(self) -> &'static str {
        match self {
            Preset::Fast => "fast",
            Preset::Balanced => "balanced",
            Preset::Best => "best",
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Preset {
    type Err = Error;

    /// The preset of a name.
    fn from_str(name: &str) -> Result<Preset> {
        Preset::ALL.into_iter().find(|preset| preset.name() == name).ok_or_else(|| {
            let names = Preset::ALL.map(|preset| format!("'{preset}'")).join(", ");
            Error::invalid("preset", format!("expected one of {names}, found '{name}'"))
        })
    }
}

impl TryFrom<&str> for Preset {
    type Error = Error;

    fn try_from(name: &str) -> Result<Preset> {
        name.parse()
    }
}

impl BuildParameters {
    /// The parameters that a preset stands for.
    pub const fn preset(preset: Preset) -> BuildParameters {
        let balanced = BuildParameters {
            spatial_split_min_triangles: 256,
            duplication_budget: 1.0,
            spatial_bins: 32,
            object_bins: 16,
            weigh_object_splits: false,
            coarse_grid: false,
        };
        match preset {
            Preset::Fast => BuildParameters {
                duplication_budget: 0.0,
                object_bins: 8,
                coarse_grid: true,
                ..balanced
            },
            Preset::Balanced => balanced,
            Preset::Best => BuildParameters {
                spatial_split_min_triangles: 32,
                spatial_bins: 64,
                weigh_object_splits: true,
                ..balanced
            },
        }
    }

    /// These parameters, but for [`spatial_split_min_triangles`](BuildParameters::spatial_split_min_triangles).
    #[must_use]
    pub const fn with_spatial_split_min_triangles(self, triangles: usize) -> BuildParameters {
        BuildParameters { spatial_split_min_triangles: triangles, ..self }
    }

    /// These parameters, but for [`duplication_budget`](BuildParameters::duplication_budget).
    #[must_use]
    pub const fn with_duplication_budget(self, references_per_triangle: f64) -> BuildParameters {
        BuildParameters { duplication_budget: references_per_triangle, ..self }
    }

    /// These parameters, but for [`spatial_bins`](BuildParameters::spatial_bins).
    #[must_use]
    pub const fn with_spatial_bins(self, bins: usize) -> BuildParameters {
        BuildParameters { spatial_bins: bins, ..self }
    }

    /// These parameters, but for [`object_bins`](BuildParameters::object_bins).
    #[must_use]
    pub const fn with_object_bins(self, bins: usize) -> BuildParameters {
        BuildParameters { object_bins: bins, ..self }
    }

    /// These parameters, but for [`weigh_object_splits`](BuildParameters::weigh_object_splits).
    #[must_use]
    pub const fn with_weigh_object_splits(self, weigh: bool) -> BuildParameters {
        BuildParameters { weigh_object_splits: weigh, ..self }
    }

    /// These parameters, but for [`coarse_grid`](BuildParameters::coarse_grid).
    #[must_use]
    pub const fn with_coarse_grid(self, coarse: bool) -> BuildParameters {
        BuildParameters { coarse_grid: coarse, ..self }
    }

    /// The name of the preset that has these parameters; "custom" if there is none.
    pub fn preset_name(&self) -> &'static str {
        let is_preset = |preset: &Preset| BuildParameters::preset(*preset) == *self;
        Preset::ALL.into_iter().find(is_preset).map_or("custom", Preset::name)
    }

    /// Refuses values that make no sense.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the parameter that is out of its range.
    pub fn check(&self) -> Result<()> {
        if self.spatial_split_min_triangles == 0 {
            return Err(Error::invalid("spatial_split_min_triangles", "must be at least 1"));
        }
        if !(0.0..=16.0).contains(&self.duplication_budget) {
            let reason = format!("must be between 0 and 16, not {}", self.duplication_budget);
            return Err(Error::invalid("duplication_budget", reason));
        }
        for (name, value, [few, some, many]) in [
            ("spatial_bins", self.spatial_bins, [16, 32, 64]),
            ("object_bins", self.object_bins, [8, 16, 32]),
        ] {
            if ![few, some, many].contains(&value) {
                let reason = format!("must be {few}, {some} or {many}, not {value}");
                return Err(Error::invalid(name, reason));
            }
        }
        Ok(())
    }
}
