//! halfline casts half-lines (rays) at triangle meshes of any size through a kd-tree.
//!
//! A [`Mesh`] holds the user's vertices and triangles; the crate `halfline-io` reads them from files,
//! and generates some. A [`Scene`] is a mesh with the tree over it, built once. It
//! answers batches of rays on all threads, and the answer does not depend on how many there are.
//!
//! ```
//! use halfline::geometry::vec3;
//! use halfline::mesh::Positions;
//! use halfline::{Mesh, Ray, Scene};
//!
//! // Build a unit square from two triangles, and the tree over it.
//! let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! let mesh = Mesh::new(Positions::F32(corners.into()), vec![[0, 1, 2], [0, 2, 3]])?;
//! let scene = Scene::new(mesh)?;
//!
//! // Ask where rays hit first: t counts in units of the direction, which may have any length.
//! let down = vec3(0.0, 0.0, -2.0);
//! let rays = [Ray::new(vec3(0.75, 0.25, 4.0), down), Ray::new(vec3(3.0, 0.25, 4.0), down)];
//! let hits = scene.intersect(&rays);
//! assert_eq!((hits[0].t, hits[0].face), (2.0, 0));
//! assert_eq!((hits[0].u, hits[0].v), (0.5, 0.25));
//!
//! // A miss is infinitely far away.
//! assert!(!hits[1].is_hit());
//! assert_eq!(hits[1].t, f64::INFINITY);
//!
//! // Ask only whether rays hit anything.
//! assert_eq!(scene.occluded(&rays), [true, false]);
//!
//! // Ask for all hits: a ray through the edge that both triangles share crosses one of them.
//! let all = scene.intersect_all(&[Ray::new(vec3(0.5, 0.5, 4.0), down)]);
//! assert_eq!(all.hits.len(), 1);
//! # Ok::<(), halfline::Error>(())
//! ```
//!
//! What counts as a hit is decided by exact signs, on the coordinates as they were given: see
//! [`numeric`]. So no ray slips between triangles that share an edge or a vertex, t is the double
//! nearest to the exact one, and far from the origin all of this holds as well. Two other ways to
//! the same answers are there to judge the engine by, and to be read: [`brute_force`] and the
//! lecture's kd-tree, [`textbook`].
//!
//! The crate `halfline-check` tells whether a mesh is closed, and what it suffers from, and casts rays
//! at the vertices and edges of a closed one, where each must hit.
//!
//! Long work reports to a [`progress::Observer`], which may end it. All errors are [`Error`]s,
//! whose one line names the file or argument, the place and the reason.

mod batch;
pub mod brute_force;
pub mod builder;
pub mod error;
pub mod explain;
pub mod geometry;
mod intersect;
pub mod mesh;
pub mod numeric;
pub mod progress;
mod rays;
pub mod scene;
pub mod simd;
pub mod storage;
pub mod textbook;
mod traverse;
pub mod tree;

pub use error::Error;
pub use geometry::{Aabb, Hit, HitF32, Ray, RayF32, Vec3};
pub use mesh::Mesh;
pub use scene::Scene;
