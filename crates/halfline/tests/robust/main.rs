//! The engine on scenes and rays of any size, anywhere, and its tree on meshes that are made to hurt.

#[path = "../common/mod.rs"]
mod common;
mod full_range;
mod invariance;
mod tree_structure;
