//! From rays to hits.

mod around_point;
mod batch;
mod caster;
mod query;
mod slab;
mod walk;

pub use batch::{AllHits, intersect, intersect_all, occluded};
pub use caster::Caster;
pub use walk::RayCounters;
