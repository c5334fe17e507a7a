//! Where the textbook splits cells, by name.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};
use crate::geometry::Aabb;
use crate::progress::Observer;
use crate::textbook::{Middle, ObjectMedian, Planes, SplittingRule, SurfaceArea, next_axis};

/// In units of one triangle test; a step down the textbook's tree is an addition, a division and
/// a comparison.
pub const TRAVERSAL_COST: f64 = 0.5;

/// Which of the textbook's rules splits cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Rule {
    /// [`Middle`].
    Middle,
    /// [`ObjectMedian`].
    Median,
    /// [`SurfaceArea`], with [`TRAVERSAL_COST`].
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

/// A rule that knows no plane any more once an observer wants the end: a cell is then left as it is,
/// and a tree comes out soon. Whoever built it must ask the observer what it is worth.
pub struct Interruptible<'a> {
    rule: Rule,
    observer: &'a dyn Observer,
}

impl<'a> Interruptible<'a> {
    /// `rule`, until `observer` wants the end.
    pub fn new(rule: Rule, observer: &'a dyn Observer) -> Interruptible<'a> {
        Interruptible { rule, observer }
    }
}

const SURFACE_AREA: SurfaceArea = SurfaceArea { traversal_cost: TRAVERSAL_COST };

impl SplittingRule for Interruptible<'_> {
    fn splitting_planes<'a>(
        &'a self,
        cell: &'a Aabb,
        boxes: &'a [Aabb],
        by_turns: usize,
    ) -> Planes<'a> {
        if self.observer.cancelled() {
            return Box::new(std::iter::empty());
        }
        match self.rule {
            Rule::Middle => Middle.splitting_planes(cell, boxes, by_turns),
            Rule::Median => ObjectMedian.splitting_planes(cell, boxes, by_turns),
            Rule::SurfaceArea => {
                let is_wanted = |_: &usize| !self.observer.cancelled();
                let axes = [by_turns, next_axis(by_turns), next_axis(next_axis(by_turns))];
                SURFACE_AREA.planes_on(axes.into_iter().take_while(is_wanted), cell, boxes)
            }
        }
    }
}
