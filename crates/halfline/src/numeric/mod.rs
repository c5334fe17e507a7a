//! Exact signs, error bounds, and the rule that says what "hits" means.
//!
//! A ray meets a *closed* triangle: one that touches an edge or a corner hits, and where several
//! triangles are met at the same t, the one with the lowest index counts. So the closest hit, and
//! whether there is any, know no gaps. A ray within a triangle's plane does not hit it, nor does
//! any ray hit a triangle whose corners lie on one line or are not finite.
//!
//! All hits, and so counts, are
//!
//! 1. the *crossings*: a ray through an edge or a corner is moved by an infinitesimal, always in
//!    the same direction, so of the triangles around it each sheet of the surface is crossed once;
//! 2. the *border contacts*: where the contacts at one t contain no crossing, but one of them lies
//!    on the border of the surface, the one with the lowest face index is a hit.
//!
//! A contact lies on the border if it is inside an edge that an odd number of triangles have, or at
//! a vertex where such an edge ends. Edges are the same if their ends are at the same place,
//! exactly, and all triangles with three distinct finite corners have edges, also those whose
//! corners lie on one line. So a ray through the border of an open surface hits it once, and on a
//! surface whose edges all have an even number of triangles, as those of a closed one do, there are
//! crossings only: from inside their number is odd. A ray that touches an edge in the midst of a
//! surface without passing through it, as at a silhouette, has a closest hit there and no others,
//! or two.
//!
//! [`PreparedRay`] and `complete_hits` are that rule; the engine, [`textbook`](crate::textbook) and
//! [`brute_force`](crate::brute_force) share it, and nothing else.
//!
//! [`SurfacePoint`] gives rays that leave a surface a start from which they do not hit it again.

mod border;
mod closest_point;
mod double_double;
mod edge_function;
mod exact;
mod frame;
mod hit_point;
mod plane_side;
mod power_of_two;
mod ray_triangle;
mod solid_angle;
mod surface_point;

pub use edge_function::Orientation;
pub use frame::Frame;
pub(crate) use hit_point::{
    BARYCENTRIC_ERROR, CORRECTION_ERROR, MAX_DETERMINANT_ERROR, POINT_ERROR, WEIGHT_ERROR,
};
pub use ray_triangle::{
    Contact, Interval, LineIntersection, PreparedRay, TakeIntersection, Touched,
};
pub use surface_point::SurfacePoint;

pub(crate) use border::{Touch, complete_hits, has_edges};
pub(crate) use closest_point::{MeasureErrors, NearestPart, Region};
pub use double_double::UNIT_ROUNDOFF;
pub(crate) use frame::{FRAME_ERROR, round_down, round_up};
pub(crate) use plane_side::{facing_sign, holds_point, plane_side};
pub(crate) use power_of_two::{exponent_of, scale_vector, two_powers};
pub(crate) use ray_triangle::is_nearer;
pub use ray_triangle::is_zero_area;
pub(crate) use solid_angle::{
    AngleProduct, FRAME, FRAME_LENGTH, SeenVertex, TERM_ERROR, WINDING_DIRECTION, edge_sum,
    exact_solid_angle,
};

/// Half the distance from 1 to the next single-precision number.
pub(crate) const F32_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;
