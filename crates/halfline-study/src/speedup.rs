//! How many times quicker than brute force.

use super::FamilyStudy;
use super::engine::Engine;
use super::growth::Quantity;

/// A ray by brute force and by a tree, at the same size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedUp {
    /// The engine with the tree.
    pub engine: Engine,
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Nanoseconds of brute force.
    pub brute: Side,
    /// Nanoseconds of the engine.
    pub tree: Side,
}

/// What a ray costs by brute force, or by a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Nanoseconds a ray.
    pub nanoseconds: f64,
    /// True if not measured at this size: of brute force, what a triangle costs times their number; of a
    /// tree, the best law's curve.
    pub extrapolated: bool,
}

impl SpeedUp {
    /// Brute force's time in units of the tree's.
    pub fn factor(&self) -> f64 {
        self.brute.nanoseconds / self.tree.nanoseconds
    }

    /// True if either was not measured.
    pub fn is_extrapolated(&self) -> bool {
        self.brute.extrapolated || self.tree.extrapolated
    }
}

impl FamilyStudy {
    /// By how much an engine is quicker than brute force on a mesh of about `triangles` triangles; `None`
    /// for sizes that were not measured and that no law tells about.
    pub fn speed_up(&self, engine: Engine, triangles: usize) -> Option<SpeedUp> {
        let (brute, tree) =
            (self.side(Engine::BruteForce, triangles)?, self.side(engine, triangles)?);
        Some(SpeedUp { engine, triangles, brute, tree })
    }

    fn side(&self, engine: Engine, triangles: usize) -> Option<Side> {
        // A closed surface has an even number.
        let is_there = |n: usize| n.abs_diff(triangles) <= 1;
        let there = self.measured(engine, true).find(|(m, _)| is_there(m.triangles));
        if let Some((_, cost)) = there {
            let extrapolated = cost.extrapolated;
            return Some(Side { nanoseconds: cost.nanoseconds, extrapolated });
        }
        let n = triangles as f64;
        let nanoseconds = if engine == Engine::BruteForce {
            let (measurement, cost) = self.measured(engine, false).last()?;
            cost.nanoseconds / measurement.triangles as f64 * n
        } else {
            self.growth(engine, Quantity::Time).fits?.best().at(n)
        };
        Some(Side { nanoseconds, extrapolated: true })
    }
}
