//! Where a plane should cut a cell: the surface-area heuristic over bins.
//!
//! Each axis of the cell is divided into [`BINS`] slabs. A reference counts where it starts and
//! where it ends, and its box, chopped at the slabs' sides, widens the box of each slab that it
//! reaches into. Two sweeps over the slabs then give for each plane between them the number of
//! references and the tight box on either side.

use rayon::prelude::*;

use super::lane_box::{LaneBox, UPPER};
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
        slab(((x - self.min[axis]) * self.inverse_width[axis]) - 0.5, BINS)
    }

    /// The plane below slab `bin`.
    #[inline(always)]
    fn plane(&self, axis: usize, bin: usize) -> f32 {
        self.min[axis] + bin as f32 * self.width[axis]
    }
}

/// The integer nearest to `x`, at least zero and below `count`, a power of two. A cast would look
/// for NaN and infinities, of which there are none, and cost as much as the rest of the search.
#[inline(always)]
pub fn slab(x: f32, count: usize) -> usize {
    // From here on single-precision numbers have their units in the lowest bit.
    const UNITS: f32 = 8_388_608.0;
    let last = (count - 1) as f32;
    let x = if x < last { x } else { last };
    let x = if x > 0.0 { x } else { 0.0 };
    (x + UNITS).to_bits() as usize & (count - 1)
}

/// The slabs of an axis: a box each, and how many references start and end there.
#[derive(Clone, Copy)]
struct Slabs {
    boxes: [LaneBox; BINS],
    starts: [u32; BINS],
    ends: [u32; BINS],
}

const EMPTY_SLABS: [Slabs; 3] =
    [Slabs { boxes: [LaneBox::EMPTY; BINS], starts: [0; BINS], ends: [0; BINS] }; 3];

fn fill(references: &[Reference], grid: &Grid) -> [Slabs; 3] {
    let mut slabs = EMPTY_SLABS;
    let [x, y, z] = &mut slabs;
    for reference in references {
        let whole = LaneBox::of(&reference.bounds);
        count::<0>(x, &reference.bounds, whole, grid);
        count::<1>(y, &reference.bounds, whole, grid);
        count::<2>(z, &reference.bounds, whole, grid);
    }
    slabs
}

/// Counts a reference along an axis. That is a constant, so that chopping a box changes a register: to
/// change it in memory and read it again would take longer than all the rest.
#[inline(always)]
fn count<const AXIS: usize>(slabs: &mut Slabs, bounds: &Bounds, whole: LaneBox, grid: &Grid) {
    let first = grid.bin(AXIS, bounds.min[AXIS]);
    let last = grid.bin(AXIS, bounds.max[AXIS]);
    slabs.starts[first] += 1;
    slabs.ends[last] += 1;
    let mut chopped = whole;
    for bin in first..last {
        let plane = grid.plane(AXIS, bin + 1);
        chopped.0[UPPER + AXIS] = -plane;
        slabs.boxes[bin].widen(&chopped);
        chopped.0[AXIS] = plane;
    }
    chopped.0[UPPER + AXIS] = whole.0[UPPER + AXIS];
    slabs.boxes[last].widen(&chopped);
}

fn merge(mut a: [Slabs; 3], b: [Slabs; 3]) -> [Slabs; 3] {
    for (a, b) in a.iter_mut().zip(&b) {
        for bin in 0..BINS {
            a.boxes[bin].widen(&b.boxes[bin]);
            a.starts[bin] += b.starts[bin];
            a.ends[bin] += b.ends[bin];
        }
    }
    a
}

/// The cheapest plane across a cell, or `None` if the cell cannot be cut. Of equal ones the first
/// in the order of axes and positions.
pub fn cheapest_plane(references: &[Reference], cell: &Bounds) -> Option<SpatialSplit> {
    let grid = Grid::over(cell);
    let slabs = if references.len() > PARALLEL_REFERENCES {
        // Minima, maxima and counts are the same in whatever order threads merge them.
        references
            .par_chunks(PARALLEL_REFERENCES / 4)
            .map(|chunk| fill(chunk, &grid))
            .reduce(|| EMPTY_SLABS, merge)
    } else {
        fill(references, &grid)
    };

    let mut cheapest: Option<SpatialSplit> = None;
    for axis in 0..3 {
        if grid.inverse_width[axis] == 0.0 {
            continue;
        }
        let bins = &slabs[axis];

        // From the right: what lies above each plane.
        let mut costs_above = [0.0; BINS];
        let (mut above, mut count) = (LaneBox::EMPTY, 0);
        for bin in (1..BINS).rev() {
            above.widen(&bins.boxes[bin]);
            count += bins.ends[bin] as usize;
            costs_above[bin] = above.bounds().half_area() * blocks(count);
        }

        // From the left: what lies below, and the sum.
        let (mut below, mut count) = (LaneBox::EMPTY, 0);
        for bin in 1..BINS {
            below.widen(&bins.boxes[bin - 1]);
            count += bins.starts[bin - 1] as usize;
            let cost = below.bounds().half_area() * blocks(count) + costs_above[bin];
            let position = grid.plane(axis, bin);
            let cuts = cell.min[axis] < position && position < cell.max[axis];
            if cuts && cheapest.is_none_or(|best| cost < best.cost) {
                cheapest = Some(SpatialSplit { axis, position, cost });
            }
        }
    }
    cheapest
}
