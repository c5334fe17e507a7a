//! From rays to what they hit: the walk through the tree.
//!
//! [`single`] walks with one ray, and is the loop to read first. [`stream`] keeps many rays under way, each on a
//! walk of its own, and [`packet`] takes rays that go together as one; both give the same bits as `single`.
//! What happens in a leaf is in [`leaf`].

mod answers;
mod cast;
mod crossing_sum;
mod feeder;
mod leaf;
mod packet;
mod point;
mod prefetch;
mod query;
mod single;
mod stack;
mod step_limit;
mod stream;
mod verdict;

pub use answers::{Answers, CancelCheck, CrossingSums, FoundHits, HitColumns, HitCounts};
pub use cast::{Cast, Target, Visit, record_visits};
pub use crossing_sum::{CrossingSum, SignedCrossing};
pub use point::is_on_face;
pub use prefetch::{PrefetchChoice, PrefetchTuner, Prefetcher};
pub use query::{AllContacts, AnyHit, ClosestHit, Query};
pub use single::{Caster, RayCounters};
pub use stack::Stacks;
pub use stream::{SLOTS, cast, next_slot};
pub use verdict::{LeafVerdict, leaf_verdict};
