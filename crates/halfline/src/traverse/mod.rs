//! From rays to hits.

mod batch;
mod query;
mod slab;
mod walk;

pub use batch::{AllHits, intersect, intersect_all, occluded};
pub use query::{AllCrossings, AnyHit, ClosestHit};
pub use walk::{RayCounters, walk};
