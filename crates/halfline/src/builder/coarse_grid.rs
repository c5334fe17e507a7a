//! Triangles sorted into a grid, so that a tree over its cells saves the upper levels of one over
//! the triangles.
//!
//! K. Garanzha, J. Pantaleoni, D. McAllister, "Simpler and Faster HLBVH with Work Queues", HPG 2011:
//! sort triangles into clusters by where they are, build the top of the tree by the surface-area
//! heuristic over the clusters. They build the rest by the bits of a Morton code; here that is done
//! by the heuristic as well. A cluster is small enough for the nearest cache, and where most of the
//! triangles lie in few cells, these take as long as they would without a grid.

use rayon::prelude::*;

use super::object_split::Item;
use super::primitive_ref::{CHUNK, PrimitiveRef, Skipped, box_of};
use super::simd_bounds::{PrimitiveBounds, SimdBounds};
use crate::geometry::Vec3;
use crate::mesh::Mesh;
use crate::numeric::Frame;

/// Cells on the longest axis, at most.
const MAX_RESOLUTION: f64 = 128.0;

/// In place of the cell of a face that gets no reference.
const NO_CELL: u32 = u32::MAX;

/// The references of the triangles in a cell of the grid.
pub struct GridCell<'slots> {
    /// The references to triangles in the cell.
    pub references: &'slots mut [PrimitiveRef],
    /// Where the triangles are.
    pub extent: PrimitiveBounds,
}

impl Item for GridCell<'_> {
    #[inline(always)]
    fn lanes(&self) -> SimdBounds {
        self.extent.whole
    }

    #[inline(always)]
    fn triangles(&self) -> usize {
        self.references.len()
    }
}

/// A grid of cubes over a mesh.
struct Grid {
    origin: Vec3,
    /// Cells for each unit of length.
    scale: f64,
    cells: [u32; 3],
}

impl Grid {
    /// Cells that hold some hundreds of triangles of a surface, and some dozens of a volume.
    fn over(mesh: &Mesh) -> Grid {
        let (bounds, triangles) = (mesh.bounds(), mesh.triangle_count() as f64);
        let resolution = (triangles / 512.0).sqrt().min((triangles / 32.0).cbrt());
        let resolution = resolution.ceil().clamp(1.0, MAX_RESOLUTION);
        let extent = bounds.extent();
        let scale = resolution / extent.max_element();
        // A scene of no size, or of one beyond all numbers, is one cell.
        let scale = if scale.is_normal() { scale } else { 0.0 };
        let cells = |length: f64| ((length * scale).ceil()).clamp(1.0, resolution) as u32;
        Grid {
            origin: bounds.min,
            scale,
            cells: [cells(extent.x), cells(extent.y), cells(extent.z)],
        }
    }

    fn count(&self) -> usize {
        self.cells.iter().map(|&cells| cells as usize).product()
    }

    /// The cell of a triangle's centre.
    #[inline]
    fn cell_of(&self, [a, b, c]: [Vec3; 3]) -> u32 {
        // Halves cannot overflow.
        let center = a.min(b).min(c) * 0.5 + a.max(b).max(c) * 0.5;
        let place = (center - self.origin) * self.scale;
        // These casts take NaN, of infinity times 0, to 0.
        let [x, y, z] = [place.x as u32, place.y as u32, place.z as u32];
        let [nx, ny, nz] = self.cells;
        (z.min(nz - 1) * ny + y.min(ny - 1)) * nx + x.min(nx - 1)
    }
}

/// Fills the first slots with a reference for each face that can be hit, in the order of cells and,
/// in each, of faces. The cells that hold any, and what was left out.
pub fn sort_into_cells<'slots>(
    mesh: &Mesh,
    frame: &Frame,
    slots: &'slots mut [PrimitiveRef],
) -> (Vec<GridCell<'slots>>, Skipped) {
    // Find each face's cell.
    let grid = Grid::over(mesh);
    let mut cell_of_face: Vec<u32> = bytemuck::allocation::zeroed_vec(mesh.triangle_count());
    crate::storage::advise_huge_pages(&mut cell_of_face);
    let skipped: Vec<Skipped> = cell_of_face
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(chunk, cells)| {
            let mut skipped = Skipped::default();
            for (i, cell) in cells.iter_mut().enumerate() {
                let corners = skipped.or_corners(mesh, (chunk * CHUNK + i) as u32);
                *cell = corners.map_or(NO_CELL, |corners| grid.cell_of(corners));
            }
            skipped
        })
        .collect();
    let skipped = Skipped::all(skipped);

    // Count, and number the cells that hold any.
    let threads = rayon::current_num_threads();
    let share = cell_of_face.len().div_ceil(threads).max(1);
    let counts = cell_of_face
        .par_chunks(share)
        .map(|cells| {
            let mut counts = vec![0u32; grid.count()];
            for &cell in cells {
                if let Some(count) = counts.get_mut(cell as usize) {
                    *count += 1;
                }
            }
            counts
        })
        .reduce(
            || vec![0; grid.count()],
            |mut all, others| {
                all.iter_mut().zip(&others).for_each(|(one, other)| *one += other);
                all
            },
        );
    let mut numbers = vec![NO_CELL; counts.len()];
    let mut cells = Vec::new();
    let mut rest = slots;
    for (cell, &count) in counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
        numbers[cell] = cells.len() as u32;
        let (references, others) = rest.split_at_mut(count as usize);
        rest = others;
        cells.push((GridCell { references, extent: PrimitiveBounds::EMPTY }, 0));
    }

    // Each thread goes through all faces and keeps those of its own cells, some cells in a row.
    let kept = cell_of_face.len() - skipped.count();
    let mut parts = Vec::new();
    let mut unshared = &mut cells[..];
    let mut first = 0;
    for thread in 0..threads {
        let (mut end, mut taken) = (0, 0);
        while end < unshared.len() && (taken < kept.div_ceil(threads) || thread + 1 == threads) {
            taken += unshared[end].0.references.len();
            end += 1;
        }
        let (part, others) = unshared.split_at_mut(end);
        unshared = others;
        parts.push((first, part));
        first += end as u32;
    }
    parts.into_par_iter().for_each(|(first, cells)| {
        for (face, &cell) in cell_of_face.iter().enumerate() {
            let Some(&number) = numbers.get(cell as usize) else { continue };
            let Some((cell, filled)) = cells.get_mut(number.wrapping_sub(first) as usize) else {
                continue;
            };
            let reference =
                PrimitiveRef::new(face as u32, box_of(frame, mesh.corners(face as u32)));
            cell.references[*filled] = reference;
            cell.extent.add(&reference.lanes());
            *filled += 1;
        }
    });
    (cells.into_iter().map(|(cell, _)| cell).collect(), skipped)
}
