//! One ray's walk through the tree, as text, JSON, a page to step through, and a slice of the cells.

mod json;
mod slice;
mod text;
mod words;

use halfline::Mesh;
use halfline::explain::Explanation;
use serde_json::Value;

pub use slice::{SliceOptions, draw_slice};

/// An explanation, and the mesh that it is about.
#[derive(Clone, Copy)]
pub struct Told<'a> {
    /// What people know the mesh by.
    pub name: &'a str,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// What became of the ray.
    pub explanation: &'a Explanation,
}

impl Told<'_> {
    /// All of it, as docs/explain.schema.json describes it.
    pub fn to_json(&self) -> Value {
        json::of(self)
    }

    /// A report for a terminal, plain, in lines of up to a hundred columns.
    pub fn to_text(&self) -> String {
        text::of(self)
    }
}
