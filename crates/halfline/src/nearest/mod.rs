//! From points to the nearest points of a surface: the walk through the tree that looks for them.
//!
//! [`single`] walks with one point, and is the loop to read first. [`stream`] keeps many under way, and gives the same
//! bits.
//!
//! Which point is nearest, and what ties are, is
//! the rule of [`numeric`](crate::numeric).

mod boxes;
mod candidates;
mod eight_answers;
mod leaf;
mod point_in_frame;
mod questions;
mod single;
mod stream;

pub use questions::{Answers, ClosestPointColumns, PointSource};
pub use single::Surface;
pub use stream::{PointVisit, answer_all, record_visits};
