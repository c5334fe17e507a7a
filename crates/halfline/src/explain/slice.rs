//! The two-dimensional picture of the lecture: where a plane cuts the cells, and the mesh.

use rayon::prelude::*;

use super::cells::{Cells, Content};
use crate::error::{Error, Result};
use crate::geometry::Vec3;
use crate::mesh::Mesh;

/// A plane perpendicular to an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlicePlane {
    /// 0, 1 or 2 for x, y or z.
    pub axis: usize,
    /// Where it cuts that axis.
    pub coordinate: f64,
}

/// A point of the picture: the coordinates along the two other axes, in the order of the axes.
pub type Point = [f64; 2];

/// A rectangle: lowest and highest corner.
pub type Rectangle = [Point; 2];

/// A cell as the plane cuts it.
#[derive(Clone, Debug, PartialEq)]
pub struct SliceCell {
    /// The number of the cell.
    pub cell: usize,
    /// Levels below the root.
    pub depth: usize,
    /// Where the plane cuts it.
    pub rectangle: Rectangle,
    /// How many triangles reach into it.
    pub triangle_count: usize,
    /// False if it is split further, in parts too small to show.
    pub is_leaf: bool,
}

/// What a plane cuts.
#[derive(Clone, Debug)]
pub struct Slice {
    /// The plane.
    pub plane: SlicePlane,
    /// The root's box.
    pub rectangle: Rectangle,
    /// The cells that are not split further, or not shown so; together they fill the root's box.
    pub cells: Vec<SliceCell>,
    /// The mesh: a segment for each triangle that the plane passes through.
    pub segments: Vec<[Point; 2]>,
}

impl SlicePlane {
    /// The axes of the picture.
    pub fn axes(&self) -> [usize; 2] {
        match self.axis {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        }
    }

    /// Where a point lies in the picture.
    pub fn project(&self, point: Vec3) -> Point {
        self.axes().map(|axis| point[axis])
    }
}

impl Slice {
    /// Cuts the cells with a plane. Cells of which both sides are shorter than `smallest` are not split
    /// further, nor are those `most_levels` below the root.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the plane does not meet the root's box; [`Error::Interrupted`].
    pub fn through(
        cells: &mut Cells,
        plane: SlicePlane,
        smallest: f64,
        most_levels: usize,
    ) -> Result<Slice> {
        let bounds = cells.get(0).bounds;
        let (low, high) = (bounds.min[plane.axis], bounds.max[plane.axis]);
        if !(low <= plane.coordinate && plane.coordinate <= high) {
            let name = ["x", "y", "z"][plane.axis];
            let place = plane.coordinate;
            let reason = match bounds.is_empty() {
                true => "the mesh has no triangles to cut".to_string(),
                false => format!("{place} is outside of the mesh: {name} is from {low} to {high}"),
            };
            return Err(Error::invalid("slice", reason));
        }
        let project = |number: usize, cells: &Cells| {
            let bounds = cells.get(number).bounds;
            [plane.project(bounds.min), plane.project(bounds.max)]
        };
        let mut slice = Slice {
            plane,
            rectangle: project(0, cells),
            cells: Vec::new(),
            segments: segments(cells.mesh, &plane),
        };
        let mut waiting = vec![0];
        while let Some(number) = waiting.pop() {
            let rectangle = project(number, cells);
            let [[left, bottom], [right, top]] = rectangle;
            let is_small = right - left < smallest && top - bottom < smallest;
            let is_deep = cells.get(number).depth >= most_levels;
            if !is_small
                && !is_deep
                && let Content::Inner { axis, plane: at, children: [below, above] } =
                    cells.visit(number)?.content
            {
                // A cell above its plane holds what lies in the plane.
                let is_across = axis == plane.axis;
                if !is_across || plane.coordinate >= at {
                    waiting.push(above);
                }
                if !is_across || plane.coordinate < at {
                    waiting.push(below);
                }
                continue;
            }
            let cell = cells.get(number);
            slice.cells.push(SliceCell {
                cell: number,
                depth: cell.depth,
                rectangle,
                triangle_count: cell.triangle_count,
                is_leaf: matches!(cell.content, Content::Leaf { .. }),
            });
        }
        Ok(slice)
    }
}

/// Where the plane cuts triangles. One that lies in the plane gives its edges.
fn segments(mesh: &Mesh, plane: &SlicePlane) -> Vec<[Point; 2]> {
    let of_face = |face: u32| {
        let corners = mesh.corners(face);
        let is_finite = corners.into_iter().all(Vec3::is_finite);
        let mut ends = Vec::new();
        for i in 0..3 * usize::from(is_finite) {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            let (a, b) = (p[plane.axis] - plane.coordinate, q[plane.axis] - plane.coordinate);
            if a == 0.0 {
                ends.push(plane.project(p));
            }
            if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                ends.push(plane.project(p + (q - p) * (a / (a - b))));
            }
        }
        match ends[..] {
            [p, q] => vec![[p, q]],
            [p, q, r] => vec![[p, q], [q, r], [r, p]],
            _ => Vec::new(),
        }
    };
    (0..mesh.triangle_count() as u32).into_par_iter().flat_map_iter(of_face).collect()
}
