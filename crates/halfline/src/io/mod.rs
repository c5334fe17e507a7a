//! Bytes to meshes and back: one file per format.

pub mod gltf;
pub mod obj;
pub mod off;

mod colors;
mod lines;
mod mtl;
mod sibling;
