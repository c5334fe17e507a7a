//! From points to the nearest points of a surface: the walk through the tree that looks for them.
//!
//! [`single`] walks with one point, and is the loop to read first. Which point is nearest, and what ties are, is
//! the rule of [`numeric`](crate::numeric).

mod questions;
mod single;

pub use questions::{Answers, ClosestPointColumns, PointSource};
pub use single::{Surface, answer_all};
