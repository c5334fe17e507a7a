//! Where the textbook splits cells, by name.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};
use crate::textbook::{Middle, ObjectMedian, SplittingRule, SurfaceArea};

/// In units of one triangle test; a step down the textbook's tree is an addition, a division and
/// a comparison.
pub const TRAVERSAL_COST: f64 = 0.5;

/// Which of the textbook's rules splits cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// Splits cells in the [`Middle`].
    Middle,
    /// Splits cells at the [`ObjectMedian`].
    Median,
    /// Splits cells by the [`SurfaceArea`] heuristic, with [`TRAVERSAL_COST`].
    #[default]
    SurfaceArea,
}

impl Rule {
    /// Every rule.
    pub const ALL: [Rule; 3] = [Rule::Middle, Rule::Median, Rule::SurfaceArea];

    /// The name, as `Display` prints and `FromStr` reads it.
    pub const fn name(self) -> &'static str {
        match self {
            Rule::Middle => "middle",
            Rule::Median => "median",
            Rule::SurfaceArea => "sah",
        }
    }

    /// Where it splits a cell, in a few words.
    pub const fn description(self) -> &'static str {
        match self {
            Rule::Middle => "In the middle of the cell",
            Rule::Median => "So that each side gets half of the triangles",
            Rule::SurfaceArea => "Where the surface-area heuristic expects the least cost",
        }
    }

    /// The textbook's rule.
    pub fn splitting_rule(self) -> &'static dyn SplittingRule {
        const SURFACE_AREA: SurfaceArea = SurfaceArea { traversal_cost: TRAVERSAL_COST };
        match self {
            Rule::Middle => &Middle,
            Rule::Median => &ObjectMedian,
            Rule::SurfaceArea => &SURFACE_AREA,
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Rule {
    type Err = Error;

    fn from_str(name: &str) -> Result<Rule> {
        Rule::ALL.into_iter().find(|rule| rule.name() == name).ok_or_else(|| {
            let names = Rule::ALL.map(Rule::name).join(", ");
            Error::invalid("rule", format!("\"{name}\" is none of {names}"))
        })
    }
}
