//! Plain values: points and vectors, rays, boxes, hits, transforms; and random ones.

mod aabb;
mod closest_point;
mod hit;
pub mod random;
mod ray;
mod transform;
mod vec3;

pub use aabb::Aabb;
pub use closest_point::{ClosestPoint, Feature};
pub use hit::{Hit, HitF32, NO_FACE};
pub use ray::{Ray, RayF32};
pub use transform::Transform;
pub use vec3::{Vec3, vec3};
