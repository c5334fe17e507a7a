//! One ray's walk through the tree, as text, JSON, a page to step through, and a slice of the cells.

mod json;
mod page;
mod point;
mod slice;
mod text;
mod words;

use halfline::Mesh;
use halfline::explain::Explanation;
use serde_json::{Value, json};

pub use point::PointReport;
pub use slice::{SIZE as SLICE_SIZE, SliceOptions, draw_slice};

/// An explanation, and the mesh that it is about.
#[derive(Clone, Copy)]
pub struct Report<'a> {
    /// What people know the mesh by.
    pub name: &'a str,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// What became of the ray.
    pub explanation: &'a Explanation,
}

impl Report<'_> {
    /// The whole explanation, as docs/explain.schema.json describes it.
    pub fn to_json(&self) -> Value {
        json::of(self)
    }

    /// A report for a terminal, plain, in lines of up to a hundred columns.
    pub fn to_text(&self) -> String {
        text::of(self)
    }

    /// A page to step through, which needs nothing but itself. In its drawing the axis `up` (0, 1 or 2) points
    /// up, until the reader chooses another.
    pub fn to_page(&self, up: usize) -> String {
        let mut data = self.to_json();
        data["scenery"] = json!(scenery(self.mesh));
        data["up"] = json!(up);
        let title = format!("{}: the walk of a ray", self.name);
        page::page(&title, &data)
    }
}

/// Points on the mesh that the page draws, at most.
const SCENERY: usize = 4000;

/// The middles of some faces, evenly over the mesh's order.
fn scenery(mesh: &Mesh) -> Vec<[f64; 3]> {
    let count = mesh.triangle_count();
    let step = count.div_ceil(SCENERY).max(1);
    (0..count)
        .step_by(step)
        .map(|face| {
            let [a, b, c] = mesh.corners(face as u32);
            (a / 3.0 + b / 3.0 + c / 3.0).to_array()
        })
        .filter(|point| point.iter().all(|x| x.is_finite()))
        .collect()
}
