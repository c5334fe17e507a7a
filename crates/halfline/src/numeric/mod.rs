//! Exact signs, error bounds, and the rule that says what "hits" means.

mod double_double;
mod edge_function;
mod expansion;
mod ray_triangle;

pub use edge_function::Orientation;
pub use ray_triangle::{Contact, PreparedRay, is_nearer, is_zero_area};
