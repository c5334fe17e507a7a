//! Exact signs, error bounds, and the rule that says what "hits" means.
//!
//! A ray meets a *closed* triangle: one that touches an edge or a corner hits, and where several
//! triangles are met at the same t, the one with the lowest index counts. So the closest hit, and
//! whether there is any, know no gaps. All hits are *crossings*: a ray through an edge or a corner
//! is moved by an infinitesimal, always in the same direction, so of the triangles around it each
//! sheet of the surface is crossed once. A ray within a triangle's plane does not hit it, nor does
//! any ray hit a triangle whose corners lie on one line or are not finite.
//!
//! [`PreparedRay`] is that rule; the engine, [`textbook`](crate::textbook) and
//! [`brute_force`](crate::brute_force) share it, and nothing else.
//!
//! [`SurfacePoint`] gives rays that leave a surface a start from which they do not hit it again.

mod double_double;
mod edge_function;
mod exact;
mod frame;
mod leaf_filter;
mod power_of_two;
mod ray_triangle;
mod surface_point;

pub use edge_function::Orientation;
pub use frame::Frame;
pub use leaf_filter::{CornerLanes, LeafFilter};
pub use ray_triangle::{Contact, PreparedRay};
pub use surface_point::SurfacePoint;

pub(crate) use double_double::UNIT_ROUNDOFF;
pub(crate) use frame::{FRAME_ERROR, round_down, round_up};
pub(crate) use power_of_two::{exponent_of, scale_by_power_of_two, scale_vector};
pub(crate) use ray_triangle::is_nearer;
pub use ray_triangle::is_zero_area;
