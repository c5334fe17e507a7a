//! From rays to hits.

mod around_point;
mod batch;
mod caster;
mod leaf_test;
#[cfg(feature = "variants")]
mod plain;
mod query;
mod slab;
mod walk;

pub use batch::{AllHits, intersect, intersect_all, occluded};
pub use caster::Caster;
#[cfg(feature = "variants")]
pub use plain::PlainCaster;
pub use walk::RayCounters;
