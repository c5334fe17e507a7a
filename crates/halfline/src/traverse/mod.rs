//! From rays to hits.

mod batch;
mod query;
mod single;
mod slab;
mod walk;

pub use batch::{AllHits, intersect, intersect_all, occluded};
pub use single::{all, any, closest};
pub use walk::{RayCounters, Stack};
