//! Object splits: how triangles are divided into two groups without cutting any.
//!
//! I. Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007: the
//! surface-area heuristic over bins of the boxes' centres. Costs count blocks of triangles, so
//! groups that fill whole blocks are preferred.

use super::primitive_ref::PrimitiveRef;
use super::simd_bounds::{PrimitiveBounds, SimdBounds, UPPER};
use super::spatial_split::{blocks, slab};
use crate::simd::{Job, Level, Simd};

/// An object split of a list: the items at its start, and the rest.
#[derive(Clone, Copy, Debug)]
pub struct ObjectSplit {
    /// The axis along which the groups' centres are ordered.
    pub axis: usize,
    /// The number of items in the first group.
    pub first_count: usize,
    /// Where each group is.
    pub extents: [PrimitiveBounds; 2],
}

/// What can be divided into groups: references, and cells of many.
pub trait Item {
    /// The box of the item.
    fn lanes(&self) -> SimdBounds;

    /// How many triangles the item holds.
    fn triangles(&self) -> usize;
}

impl Item for PrimitiveRef {
    #[inline(always)]
    fn lanes(&self) -> SimdBounds {
        PrimitiveRef::lanes(self)
    }

    #[inline(always)]
    fn triangles(&self) -> usize {
        1
    }
}

/// Where some items are.
#[inline(always)]
fn extent_of<I: Item>(items: &[I]) -> PrimitiveBounds {
    let mut extent = PrimitiveBounds::EMPTY;
    items.iter().for_each(|item| extent.add(&item.lanes()));
    extent
}

/// The bins that centres are counted in.
struct Bins<const BINS: usize> {
    /// Where they begin on each axis, and how many there are for each unit of length: none, if
    /// the centres do not differ.
    low: [f32; UPPER],
    scales: [f32; UPPER],
}

impl<const BINS: usize> Bins<BINS> {
    #[inline(always)]
    fn over(centers: &SimdBounds) -> Bins<BINS> {
        let mut bins = Bins { low: [0.0; UPPER], scales: [0.0; UPPER] };
        for axis in 0..3 {
            let scale = BINS as f32 / -(centers.0[axis] + centers.0[UPPER + axis]);
            if scale > 0.0 && scale < f32::INFINITY {
                bins.scales[axis] = scale;
            }
            bins.low[axis] = centers.0[axis];
        }
        bins
    }

    /// The bin of a box on each axis.
    #[inline(always)]
    fn of(&self, whole: &SimdBounds) -> [usize; 3] {
        let mut bins = [0; UPPER];
        for lane in 0..UPPER {
            let center = whole.0[lane] - whole.0[UPPER + lane];
            bins[lane] = slab((center - self.low[lane]) * self.scales[lane] - 0.5, BINS);
        }
        // As is known of them already; said again, for the sake of the checks of indices.
        [bins[0] as usize % BINS, bins[1] as usize % BINS, bins[2] as usize % BINS]
    }
}

/// Finds two groups of the least cost among `BINS - 1` ways to cut each axis.
struct Divide<'a, I, const BINS: usize> {
    items: &'a mut [I],
    /// Only if they cost no more than this.
    limit: f32,
    /// Where the items' centres are.
    centers: &'a SimdBounds,
}

impl<I: Item, const BINS: usize> Job for Divide<'_, I, BINS> {
    type Output = Option<ObjectSplit>;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> Option<ObjectSplit> {
        let Divide { items, limit, centers } = self;

        // Count the centres in bins of each axis on which they differ.
        let bins = Bins::<BINS>::over(centers);
        let mut boxes = [[SimdBounds::EMPTY; BINS]; 3];
        let mut counts = [[0usize; BINS]; 3];
        let mut total = 0;
        for item in items.iter() {
            let whole = item.lanes();
            let places = bins.of(&whole);
            for axis in 0..3 {
                boxes[axis][places[axis]].widen(&whole);
                counts[axis][places[axis]] += item.triangles();
            }
            total += item.triangles();
        }

        // Find the cheapest place to divide them.
        let mut cheapest: Option<(f32, usize, usize)> = None;
        for axis in (0..3).filter(|&axis| bins.scales[axis] > 0.0) {
            let (boxes, counts) = (&boxes[axis], &counts[axis]);
            let mut costs_above = [0.0; BINS];
            let (mut above, mut count) = (SimdBounds::EMPTY, 0);
            for bin in (1..BINS).rev() {
                above.widen(&boxes[bin]);
                count += counts[bin];
                costs_above[bin] = above.half_area() * blocks(count);
            }
            let (mut below, mut count) = (SimdBounds::EMPTY, 0);
            for bin in 1..BINS {
                below.widen(&boxes[bin - 1]);
                count += counts[bin - 1];
                let cost = below.half_area() * blocks(count) + costs_above[bin];
                let divides = count > 0 && count < total;
                if divides && cheapest.is_none_or(|(best, ..)| cost < best) {
                    cheapest = Some((cost, axis, bin));
                }
            }
        }

        // Reorder. Which group an item belongs to cannot be foreseen, so nothing depends on it but
        // where the next of the first group goes.
        let (_, axis, bin) = cheapest.filter(|&(cost, ..)| cost <= limit)?;
        let mut extents = [PrimitiveBounds::EMPTY; 2];
        let mut first_count = 0;
        for i in 0..items.len() {
            let whole = items[i].lanes();
            let is_first = bins.of(&whole)[axis] < bin;
            extents[0].add_if(is_first, &whole);
            extents[1].add_if(!is_first, &whole);
            items.swap(i, first_count);
            first_count += usize::from(is_first);
        }
        Some(ObjectSplit { axis, first_count, extents })
    }
}

/// Reorders two or more items into two groups, neither empty, of the least cost. `centers` is
/// where their centres are.
pub fn split_objects<I: Item, const BINS: usize>(
    items: &mut [I],
    centers: &SimdBounds,
    level: Level,
) -> ObjectSplit {
    let divided = object_split_within::<I, BINS>(items, f32::INFINITY, centers, level);
    // Where all centres coincide, halve the list.
    divided.unwrap_or_else(|| halve(items))
}

/// Reorders items into two groups as [`split_objects`] does, if the groups' half areas times their
/// blocks of triangles are no more than `limit` in all. Else nothing is changed.
pub fn object_split_within<I: Item, const BINS: usize>(
    items: &mut [I],
    limit: f32,
    centers: &SimdBounds,
    level: Level,
) -> Option<ObjectSplit> {
    level.run(Divide::<I, BINS> { items, limit, centers })
}

/// The first and the second half of the list: for triangles that nothing tells apart, and where a
/// tree would become too deep.
pub fn halve<I: Item>(items: &[I]) -> ObjectSplit {
    let first_count = items.len() / 2;
    let (first, second) = items.split_at(first_count);
    ObjectSplit { axis: 0, first_count, extents: [extent_of(first), extent_of(second)] }
}
