//! How the triangles of a last cell are divided into groups.
//!
//! I. Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007: the
//! surface-area heuristic over bins of the boxes' centres. Costs count blocks of triangles, so
//! groups that fill whole blocks are preferred.

use super::lane_box::LaneBox;
use super::reference::Reference;
use super::spatial_split::{blocks, slab};

const BINS: usize = 16;

/// Two groups: the references at the start of the list, and the rest.
#[derive(Clone, Copy, Debug)]
pub struct Groups {
    /// The axis along which the groups' centres are ordered.
    pub axis: usize,
    /// The number of references in the first group.
    pub first_count: usize,
}

/// Twice the centre of a reference's box.
#[inline(always)]
fn center(reference: &Reference, axis: usize) -> f32 {
    reference.bounds.min[axis] + reference.bounds.max[axis]
}

/// Reorders two or more references into two groups, neither empty, of the least cost.
pub fn divide_into_groups(references: &mut [Reference]) -> Groups {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for reference in references.iter() {
        for axis in 0..3 {
            let center = center(reference, axis);
            low[axis] = if center < low[axis] { center } else { low[axis] };
            high[axis] = if center > high[axis] { center } else { high[axis] };
        }
    }

    // Count the centres in bins of each axis on which they differ.
    let scales = [0, 1, 2].map(|axis| bin_scale(low[axis], high[axis]));
    let mut boxes = [[LaneBox::EMPTY; BINS]; 3];
    let mut counts = [[0usize; BINS]; 3];
    for reference in references.iter() {
        let whole = LaneBox::of(&reference.bounds);
        for axis in 0..3 {
            let scale = scales[axis].unwrap_or(0.0);
            let bin = bin_of(center(reference, axis), low[axis], scale);
            boxes[axis][bin].widen(&whole);
            counts[axis][bin] += 1;
        }
    }

    // Find the cheapest place to divide them.
    let mut cheapest: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| scales[axis].is_some()) {
        let (boxes, counts) = (&boxes[axis], &counts[axis]);
        let mut costs_above = [0.0; BINS];
        let (mut above, mut count) = (LaneBox::EMPTY, 0);
        for bin in (1..BINS).rev() {
            above.widen(&boxes[bin]);
            count += counts[bin];
            costs_above[bin] = above.bounds().half_area() * blocks(count);
        }
        let (mut below, mut count) = (LaneBox::EMPTY, 0);
        for bin in 1..BINS {
            below.widen(&boxes[bin - 1]);
            count += counts[bin - 1];
            let cost = below.bounds().half_area() * blocks(count) + costs_above[bin];
            let divides = count > 0 && count < references.len();
            if divides && cheapest.is_none_or(|(best, ..)| cost < best) {
                cheapest = Some((cost, axis, bin));
            }
        }
    }

    // Reorder; where all centres coincide, halve the list.
    let Some((_, axis, bin)) = cheapest else { return halve(references) };
    let scale = scales[axis].unwrap_or(0.0);
    let mut first_count = 0;
    for i in 0..references.len() {
        if bin_of(center(&references[i], axis), low[axis], scale) < bin {
            references.swap(i, first_count);
            first_count += 1;
        }
    }
    Groups { axis, first_count }
}

/// The first and the second half of the list: for triangles that nothing tells apart, and where a
/// tree would become too deep.
pub fn halve(references: &[Reference]) -> Groups {
    Groups { axis: 0, first_count: references.len() / 2 }
}

/// Bins for each unit of length; `None` if the centres do not differ.
fn bin_scale(low: f32, high: f32) -> Option<f32> {
    let scale = BINS as f32 / (high - low);
    (scale < f32::INFINITY && high > low).then_some(scale)
}

#[inline(always)]
fn bin_of(center: f32, low: f32, scale: f32) -> usize {
    slab((center - low) * scale - 0.5, BINS)
}
