//! Why a ray hit what it hit, or nothing, for people to read: [`Report`] tells an
//! [`Explanation`](halfline::explain::Explanation) in words, as text, as JSON and as a page to step
//! through; [`PointReport`] one of a point; [`draw_slice`] draws the cells of the textbook's tree where a plane cuts them.

mod markup;
mod report;
pub mod units;

pub use report::{PointReport, Report, SLICE_SIZE, SliceOptions, draw_slice};
