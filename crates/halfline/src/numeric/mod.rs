//! Exact signs, error bounds, and the rule that says what "hits" means.

mod double_double;
mod edge_function;
mod expansion;
mod frame;
mod ray_triangle;

pub use double_double::UNIT_ROUNDOFF;
pub use edge_function::Orientation;
pub use frame::{FRAME_ERROR, FRAME_LIMIT, Frame};
pub use ray_triangle::{Contact, PreparedRay, is_nearer, is_zero_area};
