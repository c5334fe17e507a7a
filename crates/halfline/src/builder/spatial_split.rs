//! Where a plane should cut a cell: the surface-area heuristic over bins.
//!
//! Each axis of the cell is divided into slabs. A reference counts where it starts and where it
//! ends, and its box, chopped at the slabs' sides, widens the box of each slab that it reaches
//! into. Two sweeps over the slabs then give for each plane between them the number of references
//! and the tight box on either side.
//!
//! Most references reach into one slab or two, in no order that a processor could foresee. So the
//! first slab and the last are always widened, and only between them there is a loop.

use rayon::prelude::*;

use super::primitive_ref::PrimitiveRef;
use super::simd_bounds::{SimdBounds, UPPER};
use crate::simd::{Job, Level, Simd};
use crate::tree::{BLOCK_SIZE, Bounds};

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
struct Grid<const BINS: usize> {
    /// False for an axis that is too short to be divided.
    divides: [bool; 3],
    /// A side of the cell, in the lanes of a box, and slabs for each unit of length from there.
    origin: SimdBounds,
    scale: [f32; 8],
    /// The slabs of each axis, reaching to infinity along the others.
    slabs: [[SimdBounds; BINS]; 3],
}

impl<const BINS: usize> Grid<BINS> {
    #[inline(always)]
    fn over(cell: &Bounds) -> Grid<BINS> {
        let mut grid = Grid {
            divides: [false; 3],
            origin: SimdBounds([0.0; 8]),
            scale: [0.0; 8],
            slabs: [[SimdBounds::ALL; BINS]; 3],
        };
        for axis in 0..3 {
            let width = (cell.max[axis] - cell.min[axis]) / BINS as f32;
            // Of an axis that is too short to be divided all falls into the first slab.
            let inverse = if 1.0 / width < f32::INFINITY { 1.0 / width } else { 0.0 };
            grid.divides[axis] = inverse > 0.0;
            grid.origin.0[axis] = cell.min[axis];
            grid.origin.0[UPPER + axis] = -cell.min[axis];
            grid.scale[axis] = inverse;
            grid.scale[UPPER + axis] = -inverse;
            for bin in 0..BINS {
                grid.slabs[axis][bin].0[axis] = cell.min[axis] + bin as f32 * width;
                grid.slabs[axis][bin].0[UPPER + axis] =
                    -(cell.min[axis] + (bin + 1) as f32 * width);
            }
        }
        grid
    }

    /// In the lanes of each side the slab that holds it. Rounding may put a coordinate on a plane into
    /// either neighbour: counts here are estimates, the partition compares with the plane itself.
    #[inline(always)]
    fn bins(&self, part: &SimdBounds) -> [u32; 8] {
        let mut bins = [0; 8];
        for lane in 0..8 {
            let x = (part.0[lane] - self.origin.0[lane]) * self.scale[lane];
            bins[lane] = slab(x - 0.5, BINS);
        }
        bins
    }

    /// The plane below slab `bin`.
    #[inline(always)]
    fn plane(&self, axis: usize, bin: usize) -> f32 {
        self.slabs[axis][bin].0[axis]
    }
}

/// The integer nearest to `x`, at least zero and below `count`, a power of two. A cast would look
/// for NaN and infinities, of which there are none, and cost as much as the rest of the search.
#[inline(always)]
pub fn slab(x: f32, count: usize) -> u32 {
    // From here on single-precision numbers have their units in the lowest bit.
    const UNITS: f32 = 8_388_608.0;
    let last = (count - 1) as f32;
    let x = if x < last { x } else { last };
    let x = if x > 0.0 { x } else { 0.0 };
    (x + UNITS).to_bits() & (count as u32 - 1)
}

/// What lies in the slabs of an axis: of references that start in each the part in it, of those
/// that reach further what lies there, and how many start and end in each.
#[derive(Clone, Copy)]
struct Filled<const BINS: usize> {
    heads: [SimdBounds; BINS],
    tails: [SimdBounds; BINS],
    starts: [u32; BINS],
    ends: [u32; BINS],
}

impl<const BINS: usize> Filled<BINS> {
    const EMPTY: Filled<BINS> = Filled {
        heads: [SimdBounds::EMPTY; BINS],
        tails: [SimdBounds::EMPTY; BINS],
        starts: [0; BINS],
        ends: [0; BINS],
    };

    /// Counts a reference that reaches from slab `first` to slab `last`.
    #[inline(always)]
    fn count(&mut self, whole: &SimdBounds, slabs: &[SimdBounds; BINS], first: u32, last: u32) {
        // As is known of them already; said again, for the sake of the checks of indices.
        let (first, last) = (first as usize % BINS, last as usize % BINS);
        self.starts[first] += 1;
        self.ends[last] += 1;
        self.heads[first].widen(&whole.intersection(&slabs[first]));
        self.tails[last].widen(&whole.intersection(&slabs[last]));
        for bin in first + 1..last {
            self.tails[bin].widen(&whole.intersection(&slabs[bin]));
        }
    }

    /// What lies in a slab.
    #[inline(always)]
    fn part(&self, bin: usize) -> SimdBounds {
        let mut part = self.heads[bin];
        part.widen(&self.tails[bin]);
        part
    }

    fn merge(&mut self, other: &Filled<BINS>) {
        for bin in 0..BINS {
            self.heads[bin].widen(&other.heads[bin]);
            self.tails[bin].widen(&other.tails[bin]);
            self.starts[bin] += other.starts[bin];
            self.ends[bin] += other.ends[bin];
        }
    }
}

/// Counts references in the slabs.
struct Fill<'a, const BINS: usize> {
    references: &'a [PrimitiveRef],
    grid: &'a Grid<BINS>,
    axes: &'a mut [Filled<BINS>; 3],
}

impl<const BINS: usize> Job for Fill<'_, BINS> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let slabs = &self.grid.slabs;
        let [x, y, z] = self.axes;
        for reference in self.references {
            let whole = reference.lanes();
            let bins = self.grid.bins(&whole);
            x.count(&whole, &slabs[0], bins[0], bins[UPPER]);
            y.count(&whole, &slabs[1], bins[1], bins[UPPER + 1]);
            z.count(&whole, &slabs[2], bins[2], bins[UPPER + 2]);
        }
    }
}

/// Finds the cheapest plane between the slabs.
struct Sweep<'a, const BINS: usize> {
    cell: &'a Bounds,
    grid: &'a Grid<BINS>,
    axes: &'a [Filled<BINS>; 3],
}

impl<const BINS: usize> Job for Sweep<'_, BINS> {
    type Output = Option<SpatialSplit>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Option<SpatialSplit> {
        let Sweep { cell, grid, axes } = self;
        let mut cheapest: Option<SpatialSplit> = None;
        for axis in 0..3 {
            if !grid.divides[axis] {
                continue;
            }
            let filled = &axes[axis];

            // From the right: what lies above each plane.
            let mut costs_above = [0.0; BINS];
            let (mut above, mut count) = (SimdBounds::EMPTY, 0);
            for bin in (1..BINS).rev() {
                above.widen(&filled.part(bin));
                count += filled.ends[bin] as usize;
                costs_above[bin] = above.half_area() * blocks(count);
            }

            // From the left: what lies below, and the sum.
            let (mut below, mut count) = (SimdBounds::EMPTY, 0);
            for bin in 1..BINS {
                below.widen(&filled.part(bin - 1));
                count += filled.starts[bin - 1] as usize;
                let cost = below.half_area() * blocks(count) + costs_above[bin];
                let position = grid.plane(axis, bin);
                let cuts = cell.min[axis] < position && position < cell.max[axis];
                if cuts && cheapest.is_none_or(|best| cost < best.cost) {
                    cheapest = Some(SpatialSplit { axis, position, cost });
                }
            }
        }
        cheapest
    }
}

/// The cheapest plane across a cell between `BINS` slabs, or `None` if the cell cannot be cut. Of
/// equal ones the first in the order of axes and positions.
pub fn cheapest_plane<const BINS: usize>(
    references: &[PrimitiveRef],
    cell: &Bounds,
    level: Level,
) -> Option<SpatialSplit> {
    let grid = Grid::<BINS>::over(cell);
    let fill = |references: &[PrimitiveRef]| {
        let mut axes = [Filled::EMPTY; 3];
        level.run(Fill { references, grid: &grid, axes: &mut axes });
        axes
    };
    let axes = if references.len() > PARALLEL_REFERENCES {
        // Minima, maxima and counts are the same in whatever order threads merge them.
        references.par_chunks(PARALLEL_REFERENCES / 4).map(fill).reduce(
            || [Filled::EMPTY; 3],
            |mut all, others| {
                all.iter_mut().zip(&others).for_each(|(one, other)| one.merge(other));
                all
            },
        )
    } else {
        fill(references)
    };
    level.run(Sweep { cell, grid: &grid, axes: &axes })
}
