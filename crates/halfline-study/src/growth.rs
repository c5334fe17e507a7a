//! An engine over all sizes of a family, and the laws by which what it costs grows.

use super::FamilyStudy;
use super::engine::Engine;
use super::fit::Fits;
use super::measure::{Measurement, RayCost};

/// What is counted or timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Inner nodes and leaves that a ray visits.
    Steps,
    /// Leaves that a ray visits.
    Leaves,
    /// Triangles that a ray is tested against.
    Triangles,
    /// Nanoseconds that a ray takes.
    Time,
}

impl Quantity {
    /// Counts, and then time.
    pub const ALL: [Quantity; 4] =
        [Quantity::Steps, Quantity::Leaves, Quantity::Triangles, Quantity::Time];

    /// The name of the quantity.
    pub const fn name(self) -> &'static str {
        match self {
            Quantity::Steps => "steps",
            Quantity::Leaves => "leaves",
            Quantity::Triangles => "triangles",
            Quantity::Time => "time",
        }
    }

    /// The value of the quantity.
    pub fn of(self, cost: &RayCost) -> f64 {
        match self {
            Quantity::Steps => cost.steps(),
            Quantity::Leaves => cost.leaves,
            Quantity::Triangles => cost.triangles,
            Quantity::Time => cost.nanoseconds,
        }
    }
}

/// The laws of one quantity.
#[derive(Clone, Debug)]
pub struct Growth {
    /// The engine.
    pub engine: Engine,
    /// What grows.
    pub quantity: Quantity,
    /// How the quantity grows; `None` if too few meshes were measured, or the quantity is always 0.
    pub fits: Option<Fits>,
}

impl FamilyStudy {
    /// What was measured of an engine, size by size; trees that were not built are left out, and so is
    /// what was extrapolated, unless asked for.
    pub fn measured(
        &self,
        engine: Engine,
        extrapolated_too: bool,
    ) -> impl Iterator<Item = (&Measurement, &RayCost)> {
        self.samples.iter().flat_map(|sample| &sample.measurements).filter_map(move |measurement| {
            let cost = measurement.rays.as_ref()?;
            let wanted = measurement.engine == engine && (extrapolated_too || !cost.extrapolated);
            wanted.then_some((measurement, cost))
        })
    }

    /// (n, value) of all that was measured.
    pub fn points(&self, engine: Engine, quantity: Quantity) -> Vec<(f64, f64)> {
        self.measured(engine, false)
            .map(|(measurement, cost)| (measurement.triangles as f64, quantity.of(cost)))
            .collect()
    }

    /// How a quantity grows.
    pub fn growth(&self, engine: Engine, quantity: Quantity) -> Growth {
        Growth { engine, quantity, fits: Fits::to(&self.points(engine, quantity)) }
    }
}
