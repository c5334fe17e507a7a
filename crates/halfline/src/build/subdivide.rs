//! Builds the tree: cuts cells, groups triangles, on all threads.

use std::sync::atomic::{AtomicU64, Ordering};

use super::collapse::collapse;
use super::object_split::{divide_into_groups, halve};
use super::parameters::BuildParameters;
use super::partition::cut;
use super::reference::{Reference, bounds_of, references_of};
use super::spatial_split::{blocks, cheapest_plane};
use crate::error::{Error, Result};
use crate::io::advise_huge_pages;
use crate::mesh::Mesh;
use crate::numeric::Frame;
use crate::progress::{Observer, Stage};
use crate::tree::{
    BLOCK_SIZE, Bounds, Children, FacesOnLine, KdTree, LeafBlocks, MAX_DEPTH, Node, Split,
};

/// Planes are used down to this level only. A kd-tree of 2^30 triangles needs half as many.
const PLANE_DEPTH: usize = 64;

/// Groups are chosen by cost down to this level; below, lists are halved, and 32 halvings leave
/// one of 2^32 triangles.
const COST_DEPTH: usize = MAX_DEPTH - 32;

/// Cost of a step from a binary node to its children, in blocks. The tree is walked eight children
/// at a time, and so a binary step is a third of a node's, which costs as much as a block.
const STEP_COST: f32 = 1.0 / 3.0;

/// Subtrees of more references than this are built by several threads.
const PARALLEL_REFERENCES: usize = 1 << 13;

/// Builds the kd-tree over a mesh. The tree depends on the mesh and the parameters only, not on
/// the number of threads.
///
/// # Errors
/// [`Error::Invalid`] for parameters out of range or a mesh of more than 2^29 triangles,
/// [`Error::Interrupted`] if the observer asks for the end.
pub fn build(mesh: &Mesh, parameters: &BuildParameters, observer: &dyn Observer) -> Result<KdTree> {
    parameters.check()?;
    let slots_for = |kept: usize| {
        let spare = (kept as f64 * parameters.spare_references) as usize;
        (kept + spare).min(Node::INDEX_LIMIT)
    };
    if mesh.triangle_count() > Node::INDEX_LIMIT {
        let reason = format!("a tree holds at most {} triangles", Node::INDEX_LIMIT);
        return Err(Error::invalid("mesh", reason));
    }
    let frame = Frame::around(&mesh.bounds());
    observer.check()?;
    let (mut slots, count, skipped) = references_of(mesh, &frame, slots_for);
    observer.check()?;
    let bounds = bounds_of(&slots[..count]);

    let builder = Builder { mesh, frame, parameters, observer, total: count, done: 0.into() };
    builder.report(0);
    let built =
        builder.subdivide(Cell { slots: &mut slots, count, bounds, depth: 0, cut: true })?;
    drop(slots);

    let mut children = Vec::with_capacity(built.children_count());
    let mut references = Vec::with_capacity(built.reference_count());
    advise_huge_pages(children.spare_capacity_mut());
    advise_huge_pages(references.spare_capacity_mut());
    let mut root = built.append_to(&mut children, &mut references);
    let corners = root.bounds.min.into_iter().chain(root.bounds.max);
    let reach = corners.fold(0.0, |reach: f32, x| reach.max(x.abs()));
    let leaves = LeafBlocks::pack(mesh, &frame, &mut root, &mut children, &references);
    let wide = collapse(root, &children, observer)?;
    Ok(KdTree {
        frame,
        root,
        children,
        wide,
        reach,
        leaves,
        references: references.len(),
        on_line: FacesOnLine::new(mesh, &skipped.on_line),
        skipped_zero_area: skipped.zero_area,
        skipped_non_finite: skipped.non_finite,
    })
}

/// A cell that is still to be divided, and the slots that belong to it.
struct Cell<'slots> {
    slots: &'slots mut [Reference],
    count: usize,
    bounds: Bounds,
    depth: usize,
    /// False in a last cell and below: triangles are grouped, not cut.
    cut: bool,
}

/// A finished part of the tree, with indices of its own.
enum Built {
    Subtree { root: Node, children: Vec<Children>, references: Vec<u32> },
    Divided { bounds: Bounds, split: Split, parts: Box<[Built; 2]> },
}

struct Builder<'a> {
    mesh: &'a Mesh,
    frame: Frame,
    parameters: &'a BuildParameters,
    observer: &'a dyn Observer,
    total: usize,
    done: AtomicU64,
}

impl Builder<'_> {
    fn report(&self, references: usize) {
        let done = self.done.fetch_add(references as u64, Ordering::Relaxed) + references as u64;
        self.observer.report(Stage::Build, done.min(self.total as u64), self.total as u64);
    }

    /// Builds the subtree of a cell, in parallel as long as it is large.
    fn subdivide(&self, cell: Cell) -> Result<Built> {
        self.observer.check()?;
        let bounds = cell.bounds;
        if cell.count <= PARALLEL_REFERENCES {
            let references = cell.count;
            let mut children = Vec::new();
            let mut faces = Vec::with_capacity(references + references / 4);
            let root = self.subdivide_serially(cell, &mut children, &mut faces);
            self.report(references);
            return Ok(Built::Subtree { root, children, references: faces });
        }
        let (split, first, second) = self.divide(cell);
        let (first, second) = rayon::join(|| self.subdivide(first), || self.subdivide(second));
        Ok(Built::Divided { bounds, split, parts: Box::new([first?, second?]) })
    }

    fn subdivide_serially(
        &self,
        cell: Cell,
        children: &mut Vec<Children>,
        references: &mut Vec<u32>,
    ) -> Node {
        let bounds = cell.bounds;
        if cell.count <= BLOCK_SIZE {
            let first = references.len() as u32;
            references.extend(cell.slots[..cell.count].iter().map(|r| r.face));
            return Node::leaf(bounds, first, cell.count as u32);
        }
        let (split, first, second) = self.divide(cell);
        let pair = children.len();
        let placeholder = Node::leaf(Bounds::EMPTY, 0, 0);
        children.push(Children([placeholder; 2]));
        let first = self.subdivide_serially(first, children, references);
        let second = self.subdivide_serially(second, children, references);
        children[pair] = Children([first, second]);
        Node::inner(bounds, pair as u32, split)
    }

    /// Divides a cell of more than one block in two: by a plane if that pays and there is room
    /// for the references that it adds, else into groups.
    fn divide<'slots>(&self, cell: Cell<'slots>) -> (Split, Cell<'slots>, Cell<'slots>) {
        let Cell { slots, count, bounds, depth, cut: may_cut } = cell;
        let depth = depth + 1;
        if may_cut && count > self.parameters.last_cell_triangles && depth <= PLANE_DEPTH {
            let whole = bounds.half_area() * (blocks(count) - STEP_COST);
            let plane = cheapest_plane(&slots[..count], &bounds).filter(|s| s.cost < whole);
            let corners_of = |face| self.mesh.corners(face).map(|corner| self.frame.point(corner));
            let cut_here =
                plane.and_then(|s| Some((s, cut(slots, count, s.axis, s.position, corners_of)?)));
            if let Some((plane, sides)) = cut_here {
                let (below, above) = slots.split_at_mut(sides.second_start);
                let side = |slots, i: usize| Cell {
                    slots,
                    count: sides.counts[i],
                    bounds: sides.bounds[i],
                    depth,
                    cut: true,
                };
                let split = Split::Plane { axis: plane.axis, position: plane.position };
                return (split, side(below, 0), side(above, 1));
            }
        }

        let groups = if depth <= COST_DEPTH {
            divide_into_groups(&mut slots[..count])
        } else {
            halve(&slots[..count])
        };
        let (first, second) = slots[..count].split_at_mut(groups.first_count);
        let group = |slots: &'slots mut [Reference]| Cell {
            count: slots.len(),
            bounds: bounds_of(slots),
            slots,
            depth,
            cut: false,
        };
        (Split::Groups { axis: groups.axis }, group(first), group(second))
    }
}

impl Built {
    fn children_count(&self) -> usize {
        match self {
            Built::Subtree { children, .. } => children.len(),
            Built::Divided { parts, .. } => {
                1 + parts.iter().map(Built::children_count).sum::<usize>()
            }
        }
    }

    fn reference_count(&self) -> usize {
        match self {
            Built::Subtree { references, .. } => references.len(),
            Built::Divided { parts, .. } => parts.iter().map(Built::reference_count).sum(),
        }
    }

    /// Appends this part to the whole, depth first, and gives its root.
    fn append_to(self, all_children: &mut Vec<Children>, all_references: &mut Vec<u32>) -> Node {
        match self {
            Built::Subtree { root, children, references } => {
                let children_before = all_children.len() as u32;
                let references_before = all_references.len() as u32;
                let moved = |node: Node| node.moved(children_before, references_before);
                all_children.extend(children.iter().map(|pair| Children(pair.0.map(moved))));
                all_references.extend_from_slice(&references);
                moved(root)
            }
            Built::Divided { bounds, split, parts } => {
                let pair = all_children.len();
                let placeholder = Node::leaf(Bounds::EMPTY, 0, 0);
                all_children.push(Children([placeholder; 2]));
                let [first, second] = *parts;
                let first = first.append_to(all_children, all_references);
                let second = second.append_to(all_children, all_references);
                all_children[pair] = Children([first, second]);
                Node::inner(bounds, pair as u32, split)
            }
        }
    }
}
