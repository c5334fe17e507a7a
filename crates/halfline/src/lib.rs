//! halfline casts half-lines (rays) at triangle meshes of any size through a kd-tree.

pub mod brute_force;
pub mod build;
pub mod error;
pub mod geometry;
pub mod io;
pub mod mesh;
pub mod numeric;
pub mod progress;
pub mod scene;
pub mod textbook;
pub mod traverse;
pub mod tree;

pub use error::Error;
pub use geometry::{Aabb, Hit, Ray, Vec3};
pub use mesh::Mesh;
pub use scene::Scene;
