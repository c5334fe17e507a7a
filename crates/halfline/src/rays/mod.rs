//! Rays on their way into the tree: where they come from, and what boxes and triangles need of them.
//!
//! The user's rays, in whatever form they lie in memory, are a [`RaySource`]. Eight at a time they become a
//! [`RayOctet`], and one by one a [`TraversalRay`].

mod projection;
mod ray_octet;
mod ray_order;
mod ray_source;
mod slab;
mod traversal_ray;

pub use projection::{projection_axes, select_by_size};
pub use ray_octet::{ALL, RayFields, RayOctet, prepare_octets};
pub use ray_order::{RayOrder, rays_per_band};
pub use ray_source::{Column, RayColumns, RayLanes, RaySource, Scalars, Vectors};
pub use traversal_ray::{Parameter, RootFrame, TraversalRay};
