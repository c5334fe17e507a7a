//! The textbook's cells, split only where a ray comes: a tree over millions of triangles would take
//! minutes, and one ray sees a few dozen cells of it. They are those of
//! [`KdTree::init_kd_tree`](crate::textbook::KdTree::init_kd_tree), to the bit.

use super::rule::Rule;
use crate::error::Result;
use crate::geometry::Aabb;
use crate::mesh::Mesh;
use crate::progress::Observer;
use crate::textbook::{
    self, Split, Termination, boxes_of, root_cell, split_cell, terminate_construction,
};

/// Which side of its parent's plane a cell is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The side of the lower coordinates.
    Below,
    /// The side of the higher coordinates.
    Above,
}

/// A cell of space.
#[derive(Clone, Debug)]
pub struct Cell {
    /// The cell of which it is a part; `None` for the root.
    pub parent: Option<(usize, Side)>,
    /// Levels below the root.
    pub depth: usize,
    /// The box of the cell.
    pub bounds: Aabb,
    /// How many triangles reach into the cell.
    pub triangle_count: usize,
    /// What is known of the cell.
    pub content: Content,
    /// The axis on which it is split if the rule goes by turns.
    by_turns: usize,
}

impl Cell {
    /// A cell of the textbook that was not split so far.
    fn new(cell: textbook::Cell, parent: Option<(usize, Side)>) -> Cell {
        let textbook::Cell { bounds, triangles, depth, by_turns } = cell;
        let triangle_count = triangles.len();
        let content = Content::Unknown { triangles };
        Cell { parent, depth, bounds, triangle_count, content, by_turns }
    }
}

/// What is known of a cell.
#[derive(Clone, Debug)]
pub enum Content {
    /// No ray came here, so it was not split.
    Unknown {
        /// The triangles that reach into it.
        triangles: Vec<u32>,
    },
    /// The cell is not split.
    Leaf {
        /// The triangles that reach into it.
        triangles: Vec<u32>,
    },
    /// The cell is split in two.
    Inner {
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// Where the plane cuts that axis.
        plane: f64,
        /// The numbers of the cells below and above the plane.
        children: [usize; 2],
    },
}

/// The cells that were needed so far, by number; the root is cell 0.
pub struct Cells<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// When no cell is split any more.
    pub termination: Termination,
    rule: Rule,
    observer: &'a dyn Observer,
    boxes: Vec<Aabb>,
    cells: Vec<Cell>,
}

impl<'a> Cells<'a> {
    /// The root alone.
    pub fn new(
        mesh: &'a Mesh,
        rule: Rule,
        termination: Termination,
        observer: &'a dyn Observer,
    ) -> Result<Cells<'a>> {
        observer.check()?;
        let boxes = boxes_of(mesh);
        let root = Cell::new(root_cell(mesh, &boxes), None);
        Ok(Cells { mesh, termination, rule, observer, boxes, cells: vec![root] })
    }

    /// A cell as far as it is known.
    pub fn get(&self, number: usize) -> &Cell {
        &self.cells[number]
    }

    /// A cell, split or found to be a leaf. The observer is asked before it is split.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn visit(&mut self, number: usize) -> Result<&Cell> {
        if let Content::Unknown { triangles } = &mut self.cells[number].content {
            let triangles = std::mem::take(triangles);
            self.cells[number].content = self.divide(number, triangles)?;
        }
        Ok(&self.cells[number])
    }

    fn divide(&mut self, number: usize, triangles: Vec<u32>) -> Result<Content> {
        let Cell { depth, bounds, by_turns, .. } = self.cells[number];
        let cell = textbook::Cell { bounds, triangles, depth, by_turns };
        let stop = |_: usize| self.observer.cancelled();
        if terminate_construction(&cell, &self.termination, &stop) {
            // Whole because that is enough, or because the observer wants the end.
            self.observer.check()?;
            return Ok(Content::Leaf { triangles: cell.triangles });
        }
        let rule = self.rule.splitting_rule();
        let Some(Split { axis, coordinate, parts }) = split_cell(&cell, &self.boxes, rule) else {
            return Ok(Content::Leaf { triangles: cell.triangles });
        };
        let first = self.cells.len();
        for (part, side) in parts.into_iter().zip([Side::Below, Side::Above]) {
            self.cells.push(Cell::new(part, Some((number, side))));
        }
        Ok(Content::Inner { axis, plane: coordinate, children: [first, first + 1] })
    }

    /// All cells that are known.
    pub fn into_cells(self) -> Vec<Cell> {
        self.cells
    }
}
