//! Builds the tree: divides cells by spatial and object splits, on all threads.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::built::{Built, Counts, Subtree};
use super::coarse_grid::{GridCell, sort_into_cells};
use super::collapse::{Collapsed, collapse};
use super::node::{BinaryNode, BinaryNodeKind, Children, Split};
use super::object_split::{Item, ObjectSplit, halve, object_split_within, split_objects};
use super::partition::{cut, share_out};
use super::primitive_ref::{
    PrimitiveRef, ReferenceBuffer, Skipped, box_of, extent_of_all, references_of,
};
use super::simd_bounds::{PrimitiveBounds, SimdBounds};
use super::spatial_split::{SpatialSplit, blocks, cheapest_plane};
use crate::error::{Error, Result};
use crate::geometry::{NO_FACE, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{Frame, is_zero_area};
use crate::progress::{NoProgress, Observer, Stage};
use crate::simd::Level;
use crate::storage::advise_huge_pages;
use crate::tree::{
    BLOCK_SIZE, Bounds, BuildParameters, CollinearFaces, LeafBlocks, LeafFaces, MAX_STACK_SIZE,
    Tree,
};

/// No leaf lies deeper than this in the binary tree, so no walk of the collapsed one has more than seven times
/// as many references on its stack.
const MAX_DEPTH: usize = 128;

const _: () = assert!(7 * MAX_DEPTH <= MAX_STACK_SIZE);

/// Planes are used down to this level only. A kd-tree of 2^30 triangles needs half as many.
const PLANE_DEPTH: usize = 64;

/// ObjectSplit are chosen by cost down to this level; below, lists are halved, and 32 halvings leave
/// one of 2^32 triangles.
const COST_DEPTH: usize = MAX_DEPTH - 32;

/// Cost of a step from a binary node to its children, in blocks. The tree is walked eight children
/// at a time, and so a binary step is a third of a node's, which costs as much as a block.
const STEP_COST: f32 = 1.0 / 3.0;

/// Subtrees of more references than this are built by several threads.
const PARALLEL_REFERENCES: usize = 1 << 13;

/// Among so few, half as many planes are as good.
const FEW_REFERENCES: usize = 1 << 10;

/// Where both are weighed, an object split may cost this share of what a spatial split costs: their boxes overlap, and
/// below them all the more. Measured; with 1, lines meet 2 % more nodes of a scan.
const OBJECT_SPLIT_SHARE: f32 = 0.95;

/// Bins in which cells of the grid are counted.
const GRID_BINS: usize = 16;

/// Builds the tree over a mesh. The tree depends on the mesh and the parameters only, not on
/// the number of threads, nor on the instruction set that it is built by.
///
/// # Errors
/// [`Error::Invalid`] for parameters out of range or a mesh of more than 2^29 triangles,
/// [`Error::Interrupted`] if the observer asks for the end.
pub fn build(
    mesh: &Mesh,
    parameters: &BuildParameters,
    level: Level,
    observer: &dyn Observer,
) -> Result<Tree> {
    parameters.check()?;
    let triangles = mesh.triangle_count();
    if triangles > BinaryNode::INDEX_LIMIT {
        let reason = format!("a tree holds at most {} triangles", BinaryNode::INDEX_LIMIT);
        return Err(Error::invalid("mesh", reason));
    }
    let slots_for = |kept: usize| {
        let spare = (kept as f64 * parameters.duplication_budget) as usize;
        (kept + spare).min(BinaryNode::INDEX_LIMIT)
    };
    let frame = Frame::around(&mesh.bounds());
    let builder = Builder { mesh, frame, parameters, level, observer, done: 0.into() };
    observer.check()?;
    let (built, skipped) = if parameters.coarse_grid {
        let mut slots = ReferenceBuffer::new(triangles);
        let (mut cells, skipped) = sort_into_cells(mesh, &frame, slots.as_mut());
        let mut extent = PrimitiveBounds::EMPTY;
        cells.iter().for_each(|cell| extent.widen(&cell.extent));
        (builder.build_from(Content::Grid(&mut cells), extent)?, skipped)
    } else {
        let mut slots = ReferenceBuffer::new(slots_for(triangles));
        let skipped = references_of(mesh, &frame, slots.as_mut());
        let count = triangles - skipped.count();
        let slots = &mut slots.as_mut()[..slots_for(count)];
        let extent = extent_of_all(&slots[..count], level);
        (builder.build_from(Content::Space { slots, count }, extent)?, skipped)
    };
    builder.finish(built, &skipped)
}

/// Builds a tree over the faces of a mesh that have no area, but finite corners: segments and points. It has object
/// splits alone, since there is nothing to be cut.
///
/// # Errors
/// As [`build`].
pub fn build_without_area(mesh: &Mesh, parameters: &BuildParameters, level: Level) -> Result<Tree> {
    let frame = Frame::around(&mesh.bounds());
    let observer = &NoProgress;
    let builder = Builder { mesh, frame, parameters, level, observer, done: 0.into() };
    let faces = (0..mesh.triangle_count() as u32).into_par_iter();
    let references: Vec<PrimitiveRef> = faces
        .filter_map(|face| {
            let corners = mesh.corners(face);
            let is_finite = corners.into_iter().all(Vec3::is_finite);
            (is_finite && is_zero_area(corners))
                .then(|| PrimitiveRef::new(face, box_of(&frame, corners)))
        })
        .collect();
    let mut slots = ReferenceBuffer::new(references.len());
    let slots = &mut slots.as_mut()[..references.len()];
    slots.copy_from_slice(&references);
    let extent = extent_of_all(slots, level);
    let built = builder.build_from(Content::ObjectSplitsOnly(slots), extent)?;
    builder.finish(built, &Skipped::default())
}

/// A cell that is still to be divided.
struct Cell<'slots> {
    content: Content<'slots>,
    extent: PrimitiveBounds,
    depth: usize,
}

/// What a cell holds.
enum Content<'slots> {
    /// References at the start of the slots that belong to it; may be cut by a plane.
    Space { slots: &'slots mut [PrimitiveRef], count: usize },
    /// The references of a last cell, or some of them: they are divided by object splits alone.
    ObjectSplitsOnly(&'slots mut [PrimitiveRef]),
    /// Cells of the grid.
    Grid(&'slots mut [GridCell<'slots>]),
}

impl Content<'_> {
    fn count(&self) -> usize {
        match self {
            Content::Space { count, .. } => *count,
            Content::ObjectSplitsOnly(references) => references.len(),
            Content::Grid(cells) => cells.iter().map(Item::triangles).sum(),
        }
    }

    /// The faces of a cell that becomes a leaf.
    fn faces(&self) -> LeafFaces {
        let mut faces = [NO_FACE; BLOCK_SIZE];
        let mut fill = |references: &mut dyn Iterator<Item = &PrimitiveRef>| {
            references.zip(&mut faces).for_each(|(reference, face)| *face = reference.face);
        };
        match self {
            Content::Space { slots, count } => fill(&mut slots[..*count].iter()),
            Content::ObjectSplitsOnly(references) => fill(&mut references.iter()),
            Content::Grid(cells) => fill(&mut cells.iter().flat_map(|c| c.references.iter())),
        }
        faces
    }
}

struct Builder<'a> {
    mesh: &'a Mesh,
    frame: Frame,
    parameters: &'a BuildParameters,
    level: Level,
    observer: &'a dyn Observer,
    done: AtomicU64,
}

impl Builder<'_> {
    fn report(&self, references: usize) {
        let done = self.done.fetch_add(references as u64, Ordering::Relaxed) + references as u64;
        let total = self.mesh.triangle_count() as u64;
        self.observer.report(Stage::Build, done.min(total), total);
    }

    fn build_from(&self, content: Content, extent: PrimitiveBounds) -> Result<Built> {
        self.observer.check()?;
        self.report(0);
        self.subdivide(Cell { content, extent, depth: 0 })
    }

    /// Builds the subtree of a cell, in parallel as long as it is large.
    fn subdivide(&self, cell: Cell) -> Result<Built> {
        self.observer.check()?;
        let count = cell.content.count();
        if count <= PARALLEL_REFERENCES {
            let mut subtree = Subtree {
                children: Vec::with_capacity(count / 4),
                leaves: Vec::with_capacity(count / 4),
                references: 0,
            };
            let root = self.subdivide_serially(cell, &mut subtree);
            self.report(count);
            return Ok(Built::Subtree(root, subtree));
        }
        let bounds = cell.extent.whole.bounds();
        let (split, first, second) = self.divide(cell);
        let (first, second) = rayon::join(|| self.subdivide(first), || self.subdivide(second));
        Ok(Built::Divided { bounds, split, parts: Box::new([first?, second?]) })
    }

    fn subdivide_serially(&self, cell: Cell, subtree: &mut Subtree) -> BinaryNode {
        let bounds = cell.extent.whole.bounds();
        let count = cell.content.count();
        if count <= BLOCK_SIZE {
            let leaf = subtree.leaves.len() as u32;
            subtree.leaves.push(cell.content.faces());
            subtree.references += count;
            return BinaryNode::leaf(bounds, leaf, count as u32);
        }
        let (split, first, second) = self.divide(cell);
        let pair = subtree.children.len();
        let placeholder = BinaryNode::leaf(Bounds::EMPTY, 0, 0);
        subtree.children.push(Children([placeholder; 2]));
        let first = self.subdivide_serially(first, subtree);
        let second = self.subdivide_serially(second, subtree);
        subtree.children[pair] = Children([first, second]);
        BinaryNode::inner(bounds, pair as u32, split)
    }

    /// Divides a cell of more than one block in two: by a plane if that pays and there is room
    /// for the references that it adds, else by an object split.
    fn divide<'slots>(&self, cell: Cell<'slots>) -> (Split, Cell<'slots>, Cell<'slots>) {
        let Cell { content, extent, depth } = cell;
        let depth = depth + 1;
        let references = match content {
            Content::Space { slots, count } => match self.cut(slots, count, &extent, depth) {
                Ok(parts) => return parts,
                Err(references) => references,
            },
            Content::ObjectSplitsOnly(references) => references,
            Content::Grid([cell]) => std::mem::take(&mut cell.references),
            Content::Grid(cells) => {
                // Below this level halving leaves single cells soon enough for object splits by cost.
                let object_split = if depth <= PLANE_DEPTH {
                    split_objects::<_, GRID_BINS>(cells, &centers_of(cells), self.level)
                } else {
                    halve(cells)
                };
                return object_split_cells(cells, object_split, depth, Content::Grid);
            }
        };
        let object_split = if depth > COST_DEPTH {
            halve(references)
        } else {
            let divide = match self.parameters.object_bins {
                8 => split_objects::<_, 8>,
                16 => split_objects::<_, 16>,
                _ => split_objects::<_, 32>,
            };
            divide(references, &extent.centers, self.level)
        };
        object_split_cells(references, object_split, depth, Content::ObjectSplitsOnly)
    }

    /// Divides a cell whose parts may be divided likewise; its references, if that does not pay or is
    /// not possible.
    fn cut<'slots>(
        &self,
        slots: &'slots mut [PrimitiveRef],
        count: usize,
        extent: &PrimitiveBounds,
        depth: usize,
    ) -> std::result::Result<(Split, Cell<'slots>, Cell<'slots>), &'slots mut [PrimitiveRef]> {
        if count <= self.parameters.spatial_split_min_triangles || depth > PLANE_DEPTH {
            return Err(&mut slots[..count]);
        }
        let bounds = extent.whole.bounds();
        let whole = bounds.half_area() * (blocks(count) - STEP_COST);
        let plane = self.cheapest_plane(&slots[..count], &bounds).filter(|s| s.cost < whole);
        let corners_of = |face| {
            // Written out, since the compiler leaves array::map a call.
            let [a, b, c] = self.mesh.corners(face);
            [self.frame.point(a), self.frame.point(b), self.frame.point(c)]
        };
        let object_split = self.parameters.weigh_object_splits.then(|| {
            let limit = plane.map_or(whole, |plane| OBJECT_SPLIT_SHARE * plane.cost);
            let object_split_within = match self.parameters.object_bins {
                8 => object_split_within::<_, 8>,
                16 => object_split_within::<_, 16>,
                _ => object_split_within::<_, 32>,
            };
            object_split_within(&mut slots[..count], limit, &extent.centers, self.level)
        });
        let divided = match (object_split.flatten(), plane) {
            (Some(ObjectSplit { axis, first_count, extents }), _) => {
                Some((Split::Object { axis }, share_out(slots, first_count, count, extents)))
            }
            (None, Some(SpatialSplit { axis, position, .. })) => {
                cut(slots, count, axis, position, corners_of, self.level)
                    .map(|sides| (Split::Spatial { axis, position }, sides))
            }
            (None, None) => None,
        };
        let Some((split, sides)) = divided else { return Err(&mut slots[..count]) };
        let (first, second) = slots.split_at_mut(sides.second_start);
        let side = |slots, i: usize| Cell {
            content: Content::Space { slots, count: sides.counts[i] },
            extent: sides.extents[i],
            depth,
        };
        Ok((split, side(first, 0), side(second, 1)))
    }

    fn cheapest_plane(&self, references: &[PrimitiveRef], cell: &Bounds) -> Option<SpatialSplit> {
        let few = references.len() <= FEW_REFERENCES;
        let cheapest_plane = match self.parameters.spatial_bins {
            16 => cheapest_plane::<16>,
            32 if few => cheapest_plane::<16>,
            32 => cheapest_plane::<32>,
            _ => cheapest_plane::<64>,
        };
        cheapest_plane(references, cell, self.level)
    }

    /// The tree of what was built.
    fn finish(&self, built: Built, skipped: &Skipped) -> Result<Tree> {
        let Counts { pairs, leaves, references } = built.counts();
        let mut children = filled(pairs, Children([BinaryNode::leaf(Bounds::EMPTY, 0, 0); 2]));
        let mut faces = filled(leaves, [NO_FACE; BLOCK_SIZE]);
        let root = built.place(&mut children, &mut faces, 0, 0);
        let corners = root.bounds.min.into_iter().chain(root.bounds.max);
        let reach = corners.fold(0.0, |reach: f32, x| reach.max(x.abs()));
        let (leaves, collapsed) = rayon::join(
            || LeafBlocks::pack(self.mesh, &self.frame, &faces),
            || collapse(root, &children, self.observer),
        );
        let Collapsed { root: top, nodes, max_stack_size } = collapsed?;
        let [spatial_splits, object_splits] = count_splits(root, &children);
        Ok(Tree {
            frame: self.frame,
            bounds: root.bounds,
            root: top,
            nodes,
            max_stack_size,
            reach,
            leaves,
            references,
            spatial_splits,
            object_splits,
            collinear: CollinearFaces::new(self.mesh, &skipped.collinear),
            skipped_zero_area: skipped.zero_area,
            skipped_non_finite: skipped.non_finite,
        })
    }
}

/// How many spatial splits and how many object splits there are in a binary tree.
fn count_splits(root: BinaryNode, children: &[Children]) -> [usize; 2] {
    let mut counts = [0; 2];
    for node in children.iter().flat_map(|pair| pair.0).chain([root]) {
        match node.kind() {
            BinaryNodeKind::Leaf { .. } => {}
            BinaryNodeKind::Inner { split: Split::Spatial { .. }, .. } => counts[0] += 1,
            BinaryNodeKind::Inner { split: Split::Object { .. }, .. } => counts[1] += 1,
        }
    }
    counts
}

/// Where the centres of cells' boxes are.
fn centers_of(cells: &[GridCell]) -> SimdBounds {
    let mut extent = PrimitiveBounds::EMPTY;
    cells.iter().for_each(|cell| extent.add(&cell.lanes()));
    extent.centers
}

/// The two cells of an object split.
fn object_split_cells<'slots, I>(
    items: &'slots mut [I],
    split: ObjectSplit,
    depth: usize,
    content: impl Fn(&'slots mut [I]) -> Content<'slots>,
) -> (Split, Cell<'slots>, Cell<'slots>) {
    let ObjectSplit { axis, first_count, extents } = split;
    let (first, second) = items.split_at_mut(first_count);
    let cell = |items, extent| Cell { content: content(items), extent, depth };
    (Split::Object { axis }, cell(first, extents[0]), cell(second, extents[1]))
}

/// An array that all threads have filled, and so found memory for.
fn filled<T: Copy + Send + Sync>(count: usize, item: T) -> Vec<T> {
    let mut items = Vec::with_capacity(count);
    advise_huge_pages(items.spare_capacity_mut());
    (0..count).into_par_iter().with_min_len(1 << 12).map(|_| item).collect_into_vec(&mut items);
    items
}
