//! Where a plane should cut a cell: the surface-area heuristic over bins.
//!
//! Each axis of the cell is divided into [`BINS`] slabs. A reference counts where it starts and
//! where it ends, and its box, chopped at the slabs' sides, widens the box of each slab that it
//! reaches into. Two sweeps over the slabs then give for each plane between them the number of
//! references and the tight box on either side.

use rayon::prelude::*;

use super::reference::Reference;
use crate::tree::{BLOCK_SIZE, Bounds};

const BINS: usize = 32;

/// Above this number of references the bins are filled by several threads.
const PARALLEL_REFERENCES: usize = 1 << 16;

/// A plane and what it would cost.
#[derive(Clone, Copy, Debug)]
pub struct SpatialSplit {
    /// 0, 1 or 2.
    pub axis: usize,
    /// Where the plane cuts the axis.
    pub position: f32,
    /// Half areas of the two sides times their blocks of triangles.
    pub cost: f32,
}

/// The number of blocks that `count` triangles fill.
#[inline(always)]
pub fn blocks(count: usize) -> f32 {
    count.div_ceil(BLOCK_SIZE) as f32
}

/// The slabs of a cell.
struct Grid {
    min: [f32; 3],
    width: [f32; 3],
    inverse_width: [f32; 3],
}

impl Grid {
    fn over(cell: &Bounds) -> Grid {
        let width = [0, 1, 2].map(|axis| (cell.max[axis] - cell.min[axis]) / BINS as f32);
        // An axis that is too short to be divided has inverse 0: all falls into its first bin.
        let inverse = |w: f32| if 1.0 / w < f32::INFINITY { 1.0 / w } else { 0.0 };
        Grid { min: cell.min, width, inverse_width: width.map(inverse) }
    }

    /// The slab that holds `x`. Rounding may put a coordinate on a side into either neighbour:
    /// counts here are estimates, the partition compares with the plane itself.
    #[inline(always)]
    fn bin(&self, axis: usize, x: f32) -> usize {
        (((x - self.min[axis]) * self.inverse_width[axis]) as i32).clamp(0, BINS as i32 - 1)
            as usize
    }

    /// The plane below slab `bin`.
    #[inline(always)]
    fn plane(&self, axis: usize, bin: usize) -> f32 {
        self.min[axis] + bin as f32 * self.width[axis]
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    starts: u32,
    ends: u32,
}

type Bins = [[Bin; BINS]; 3];

const EMPTY_BINS: Bins = [[Bin { bounds: Bounds::EMPTY, starts: 0, ends: 0 }; BINS]; 3];

fn fill(references: &[Reference], grid: &Grid) -> Bins {
    let mut bins = EMPTY_BINS;
    for reference in references {
        let bounds = &reference.bounds;
        for axis in 0..3 {
            let first = grid.bin(axis, bounds.min[axis]);
            let last = grid.bin(axis, bounds.max[axis]);
            let bins = &mut bins[axis];
            bins[first].starts += 1;
            bins[last].ends += 1;
            if first == last {
                bins[first].bounds = bins[first].bounds.union(bounds);
                continue;
            }
            let mut chopped = *bounds;
            for bin in first..last {
                chopped.max[axis] = grid.plane(axis, bin + 1);
                bins[bin].bounds = bins[bin].bounds.union(&chopped);
                chopped.min[axis] = chopped.max[axis];
            }
            chopped.max[axis] = bounds.max[axis];
            bins[last].bounds = bins[last].bounds.union(&chopped);
        }
    }
    bins
}

fn merge(mut a: Bins, b: Bins) -> Bins {
    for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
        a.bounds = a.bounds.union(&b.bounds);
        a.starts += b.starts;
        a.ends += b.ends;
    }
    a
}

/// The cheapest plane across a cell, or `None` if the cell cannot be cut. Of equal ones the first
/// in the order of axes and positions.
pub fn cheapest_plane(references: &[Reference], cell: &Bounds) -> Option<SpatialSplit> {
    let grid = Grid::over(cell);
    let bins = if references.len() > PARALLEL_REFERENCES {
        // Minima, maxima and counts are the same in whatever order threads merge them.
        references
            .par_chunks(PARALLEL_REFERENCES / 4)
            .map(|chunk| fill(chunk, &grid))
            .reduce(|| EMPTY_BINS, merge)
    } else {
        fill(references, &grid)
    };

    let mut cheapest: Option<SpatialSplit> = None;
    for axis in 0..3 {
        if grid.inverse_width[axis] == 0.0 {
            continue;
        }
        let bins = &bins[axis];

        // From the right: what lies above each plane.
        let mut costs_above = [0.0; BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for bin in (1..BINS).rev() {
            bounds = bounds.union(&bins[bin].bounds);
            count += bins[bin].ends as usize;
            costs_above[bin] = bounds.half_area() * blocks(count);
        }

        // From the left: what lies below, and the sum.
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for bin in 1..BINS {
            bounds = bounds.union(&bins[bin - 1].bounds);
            count += bins[bin - 1].starts as usize;
            let cost = bounds.half_area() * blocks(count) + costs_above[bin];
            let position = grid.plane(axis, bin);
            let cuts = cell.min[axis] < position && position < cell.max[axis];
            if cuts && cheapest.is_none_or(|best| cost < best.cost) {
                cheapest = Some(SpatialSplit { axis, position, cost });
            }
        }
    }
    cheapest
}
