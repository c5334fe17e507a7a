//! Exact signs, error bounds, and the rule that says what "hits" means.

mod double_double;
mod edge_function;
mod expansion;
mod frame;
mod power_of_two;
mod ray_triangle;

pub use double_double::UNIT_ROUNDOFF;
pub use edge_function::Orientation;
pub use frame::{FRAME_ERROR, FRAME_LIMIT, Frame, round_down, round_up};
pub use power_of_two::{exponent_of, scale_by_power_of_two, scale_vector};
pub use ray_triangle::{Contact, PreparedRay, is_nearer, is_zero_area};
