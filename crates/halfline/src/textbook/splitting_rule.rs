//! Where the textbook splits a cell: in the middle, at the median, or where the surface-area heuristic
//! expects the least cost (V. Havran, "Heuristic Ray Shooting Algorithms", PhD thesis, Prague 2000,
//! section 4.2).

use super::{halves, next_axis};
use crate::geometry::Aabb;

/// Where to split a cell.
pub trait SplittingRule {
    /// The planes at which `cell`, whose triangles have these `boxes`, may be split, as (axis,
    /// coordinate), the best one first; `by_turns` is the axis whose turn it is.
    fn splitting_planes(&self, cell: &Aabb, boxes: &[Aabb], by_turns: usize) -> Vec<(usize, f64)>;
}

/// In the middle of the cell, on each axis by turns.
pub struct Middle;

impl SplittingRule for Middle {
    fn splitting_planes(&self, cell: &Aabb, _: &[Aabb], by_turns: usize) -> Vec<(usize, f64)> {
        axes_from(by_turns).map(|axis| (axis, cell.center()[axis])).to_vec()
    }
}

/// So that each side gets half of the triangles, on each axis by turns.
pub struct ObjectMedian;

impl SplittingRule for ObjectMedian {
    fn splitting_planes(&self, cell: &Aabb, boxes: &[Aabb], by_turns: usize) -> Vec<(usize, f64)> {
        let median = |axis: usize| {
            // The center of a large triangle may lie outside of the cell.
            let (low, high) = (cell.min[axis], cell.max[axis]);
            let center = |b: &Aabb| b.center()[axis].clamp(low, high);
            let mut centers: Vec<f64> = boxes.iter().map(center).collect();
            let middle = centers.len() / 2;
            *centers.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        axes_from(by_turns).map(|axis| (axis, median(axis))).to_vec()
    }
}

/// Where the expected cost is least: a ray that meets the cell meets a part of it with a
/// probability proportional to the part's surface area (Goldsmith and Salmon 1987; MacDonald and
/// Booth 1990).
pub struct SurfaceArea {
    /// Cost of a step to a child cell, in units of one triangle test.
    pub traversal_cost: f64,
}

impl SurfaceArea {
    /// The cheapest plane on `axis`, as (cost, coordinate), by a sweep over the boxes' ends.
    fn cheapest_plane(&self, cell: &Aabb, boxes: &[Aabb], axis: usize) -> Option<(f64, f64)> {
        let (low, high) = (cell.min[axis], cell.max[axis]);
        let sorted = |mut ends: Vec<f64>| {
            ends.sort_unstable_by(f64::total_cmp);
            ends
        };
        let starts = sorted(boxes.iter().map(|b| b.min[axis].max(low)).collect());
        let ends = sorted(boxes.iter().map(|b| b.max[axis].min(high)).collect());
        let mut cheapest: Option<(f64, f64)> = None;
        for planes in [&starts, &ends] {
            // How many boxes start at or before the plane, and how many end before it.
            let (mut started, mut ended) = (0, 0);
            for &plane in planes.iter().filter(|&&plane| low < plane && plane < high) {
                started += starts[started..].iter().take_while(|&&start| start <= plane).count();
                ended += ends[ended..].iter().take_while(|&&end| end < plane).count();
                let (below, above) = (started as f64, (ends.len() - ended) as f64);
                let [left, right] = halves(cell, axis, plane);
                let tests = left.surface_area() * below + right.surface_area() * above;
                let cost = self.traversal_cost + tests / cell.surface_area();
                if cheapest.is_none_or(|(least, _)| cost < least) {
                    cheapest = Some((cost, plane));
                }
            }
        }
        cheapest
    }
}

impl SplittingRule for SurfaceArea {
    /// The cheapest plane on each axis, the cheapest of all first; only those that are cheaper than
    /// to leave the cell whole.
    fn splitting_planes(&self, cell: &Aabb, boxes: &[Aabb], by_turns: usize) -> Vec<(usize, f64)> {
        let cost_of_leaf = boxes.len() as f64;
        let plane_on = |axis| {
            let (cost, plane) = self.cheapest_plane(cell, boxes, axis)?;
            (cost < cost_of_leaf).then_some((cost, axis, plane))
        };
        let mut planes: Vec<_> = axes_from(by_turns).into_iter().filter_map(plane_on).collect();
        planes.sort_by(|a, b| a.0.total_cmp(&b.0));
        planes.into_iter().map(|(_, axis, plane)| (axis, plane)).collect()
    }
}

/// All three axes, beginning with this one.
fn axes_from(axis: usize) -> [usize; 3] {
    [axis, next_axis(axis), next_axis(next_axis(axis))]
}
