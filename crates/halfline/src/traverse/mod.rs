//! From rays to hits.

mod all_rows;
mod around_point;
mod batch;
mod bundle;
mod cast;
mod caster;
pub mod columns;
mod filter_lanes;
mod hit_lanes;
mod leaf_kernel;
mod leaf_test;
#[cfg(feature = "variants")]
mod plain;
mod plane_lanes;
mod query;
mod queue;
mod ray_group;
mod second_look;
mod slab;
mod walk;
mod watched;
mod wide_ray;

pub use batch::{
    AllHits, BatchRay, Target, WorkCounts, intersect, intersect_into, intersect_single,
    intersect_single_into,
};
pub use caster::Caster;
pub use leaf_kernel::{LeafVerdict, leaf_verdict};
#[cfg(feature = "variants")]
pub use plain::PlainCaster;
pub use walk::RayCounters;
pub use watched::{Visit, watch};
