//! An exact ray caster for triangle meshes of any size: which triangle does a ray hit, and where?
//!
//! A [`Mesh`] holds vertices and triangles; a [`Scene`] is a mesh with the tree over it, built once, and
//! answers rays. No ray slips between triangles that share an edge or a vertex, however far from the
//! origin, and the answers are the same to the bit on every machine and any number of threads.
//!
//! ```
//! use halfline::{Mesh, Ray, Scene, vec3};
//!
//! // Two triangles make a square; a scene builds the tree over them.
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! let scene = Scene::new(Mesh::new(corners, [[0, 1, 2], [0, 2, 3]])?)?;
//!
//! // One ray hits the square and one passes it by. t counts in units of the direction.
//! let down = vec3(0.0, 0.0, -2.0);
//! let rays = [Ray::new(vec3(0.75, 0.25, 4.0), down), Ray::new(vec3(3.0, 0.25, 4.0), down)];
//! let hits = scene.intersect(&rays);
//! assert_eq!((hits[0].face, hits[0].t), (0, 2.0));
//! assert_eq!(rays[0].at(hits[0].t), vec3(0.75, 0.25, 0.0));
//! assert!(!hits[1].is_hit());
//! # Ok::<(), halfline::Error>(())
//! ```
//!
//! # Batches of rays
//!
//! Rays that are known together are cast together: on all threads, and eight at a time by the vector
//! unit. [`Scene::intersect`] finds where each hits first, [`Scene::occluded`] whether it hits anything,
//! [`Scene::intersect_all`] everything that it hits, and [`Scene::count_intersections`] how much that is.
//! A miss is [`Hit::MISS`], infinitely far away; [`Hit::is_hit`] tells it from a hit.
//!
//! ```
//! # use halfline::{Hit, Mesh, Ray, Scene, vec3};
//! # let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! # let scene = Scene::new(Mesh::new(corners, [[0, 1, 2], [0, 2, 3]])?)?;
//! # let down = vec3(0.0, 0.0, -2.0);
//! # let rays = [Ray::new(vec3(0.5, 0.5, 4.0), down), Ray::new(vec3(3.0, 0.25, 4.0), down)];
//! assert_eq!(scene.occluded(&rays), [true, false]);
//! assert_eq!(scene.intersect(&rays)[1], Hit::MISS);
//!
//! // A ray through the edge that both triangles share crosses one of them, and not two or none.
//! let all = scene.intersect_all(&rays);
//! assert_eq!(all.row(0).len(), 1);
//! assert_eq!(scene.count_intersections(&rays), [1, 0]);
//! # Ok::<(), halfline::Error>(())
//! ```
//!
//! # Points
//!
//! [`Scene::closest_points`] finds what of the surface is nearest to each point, [`Scene::contains`] whether it is
//! inside, also of a surface with holes, by [`Scene::winding_numbers`]; [`Scene::signed_distances`] are both.
//!
//! ```
//! # use halfline::{Mesh, Scene, vec3};
//! let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let scene = Scene::new(Mesh::new(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?)?;
//! let points = [vec3(0.25, 0.25, 0.125), vec3(0.25, 0.25, -2.0)];
//! assert_eq!(scene.contains(&points), [true, false]);
//! assert_eq!(scene.signed_distances(&points), [-0.125, 2.0]);
//! assert_eq!(scene.closest_points(&points)[1].point, vec3(0.25, 0.25, 0.0));
//! # Ok::<(), halfline::Error>(())
//! ```
//!
//! # One ray after another
//!
//! Where each ray depends on the last, a [`Caster`] answers one at a time, with `None` for a miss. Each
//! thread needs one of its own.
//!
//! ```
//! # use halfline::{Mesh, Ray, Scene, vec3};
//! # let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! # let scene = Scene::new(Mesh::new(corners, [[0, 1, 2], [0, 2, 3]])?)?;
//! let mut caster = scene.caster();
//! let ray = Ray::new(vec3(0.75, 0.25, 4.0), vec3(0.0, 0.0, -1.0));
//! if let Some(hit) = caster.intersect(&ray) {
//!     // A ray that leaves the surface from here does not hit the same face again.
//!     let up = vec3(0.0, 0.0, 1.0);
//!     let onwards = Ray::new(scene.surface_point(&hit).origin_towards(up), up);
//!     assert_eq!(caster.intersect(&onwards), None);
//! }
//! # Ok::<(), halfline::Error>(())
//! ```
//!
//! # Precision
//!
//! A mesh keeps the precision in which its vertices came, single or double; nothing is rounded, and each
//! answer is that of double precision. Large batches of rays take half the memory as [`RayF32`]s, and
//! [`Scene::intersect_f32`] gives their hits as [`HitF32`]s, the quickest way.
//!
//! # Progress and interruption
//!
//! Long work reports to an [`Observer`], which may end it: [`SceneBuilder::observer`] takes one for the
//! tree, and [`Scene::observed`] for rays. Work that was ended returns [`Error::Interrupted`].
//!
//! ```
//! use halfline::progress::Stage;
//! use halfline::{Mesh, Observer, Preset, Scene};
//!
//! struct Printer;
//!
//! impl Observer for Printer {
//!     fn report(&self, stage: Stage, done: u64, total: u64) {
//!         eprintln!("{stage:?}: {done} of {total}");
//!     }
//! }
//!
//! # let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! # let mesh = Mesh::new(corners, [[0, 1, 2], [0, 2, 3]])?;
//! # let rays: Vec<halfline::Ray> = Vec::new();
//! let scene = Scene::builder(mesh).preset(Preset::Best).observer(&Printer).build()?;
//! let hits = scene.observed(&Printer).intersect(&rays)?;
//! # assert!(hits.is_empty());
//! # Ok::<(), halfline::Error>(())
//! ```
//!
//! # Files
//!
//! [`Scene::save`] writes mesh and tree to a file, and [`Scene::open`] maps it: a scene of any size is
//! there at once. Meshes are read from files by the crate `halfline-io`.
//!
//! # Exactness
//!
//! What counts as a hit is decided by exact signs, on the coordinates as they were given, and t is the
//! double nearest to the exact one: [`numeric`] defines it. Two other ways to the same answers are there
//! to judge the engine by, and to be read: [`brute_force`] and the lecture's kd-tree, [`textbook`].
//! [`explain`] tells step by step why a ray hit what it hit.
//!
//! # Errors
//!
//! Each [`Error`] prints as one line that names the file or argument, the place in it, and the reason.
//!
//! # Crates beside this one
//!
//! - `halfline-io` reads meshes from PLY, STL, OBJ, OFF, glTF and GLB files, and generates some.
//! - `halfline-check` tells whether a mesh is closed, and whether rays slip through it.
//! - `halfline-render` makes pictures.
//!
//! # Features
//!
//! None is on by default.
//!
//! - `serde`: vectors, materials and the figures of trees as data.
//! - `variants`: the engine with a plain triangle test, in [`inspect`], to measure what the exact one
//!   costs.

mod batch;
pub mod brute_force;
mod builder;
#[doc(hidden)]
pub mod error;
pub mod explain;
pub mod geometry;
mod intersect;
pub mod mesh;
mod nearest;
pub mod numeric;
pub mod progress;
mod rays;
mod scene;
mod simd;
#[doc(hidden)]
pub mod storage;
pub mod textbook;
mod traverse;
pub mod tree;
mod winding;

pub use error::{Error, Result};
#[doc(inline)]
pub use geometry::{Aabb, ClosestPoint, Feature, Hit, HitF32, Ray, RayF32, Vec3, vec3};
#[doc(inline)]
pub use mesh::Mesh;
#[doc(inline)]
pub use progress::{NoProgress, Observer};
pub use scene::{
    AllHits, AllHitsIter, BatchRay, Boundary, Caster, Inside, Observed, Scene, SceneBuilder,
    WindingParts, inspect, is_guarded, quiet_guarded_panics,
};
pub use simd::Level;
#[doc(inline)]
pub use tree::{BuildParameters, Preset};

/// Rays and answers as columns, an array for each of their numbers, as NumPy has them: for
/// [`Observed::intersect_columns`] and its neighbours.
pub mod columns {
    pub use crate::scene::{
        AllHitColumns, ClosestPointColumns, Column, HitColumns, RayColumns, Scalars, Vectors,
    };
}

/// The example of the README, which is compiled and run as this page's are.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
