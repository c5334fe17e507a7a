//! Cuts a polygon in the plane into triangles by clipping ears.
//!
//! Follows M. Held, "FIST: Fast Industrial-Strength Triangulation of Polygons", Algorithmica 30
//! (2001): an ear is a convex corner whose triangle with its neighbours holds no reflex corner,
//! and the reflex corners lie in a grid, so that a test looks only at those nearby.
//!
//! What is different:
//! - The signs of areas are exact (J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic",
//!   1997, as the crate `robust`), so a simple polygon always has an ear and no repair is needed.
//! - Straight corners count as reflex and are never dropped; see `mod.rs` for the reason.
//! - Corners at the same place are allowed, as in a polygon whose hole is joined to its rim by a
//!   cut: what blocks an ear there is an edge that enters it, not the corner.
//! - After a cut the next corner is passed over, so that a round polygon is cut into well-shaped
//!   triangles and not into a fan.
//! - The work has a budget. A polygon that crosses itself may exhaust it; the rest becomes a fan.

use robust::{Coord, orient2d};

use super::reflex_grid::ReflexGrid;
use halfline::geometry::Vec3;

/// Corners tried, rows of cells searched and corners met there, for each corner of the polygon,
/// before the rest becomes a fan. Simple polygons of a hundred thousand corners, chosen to be hard
/// (combs, spirals, stars, snowflakes), need at most 64.
const BUDGET_PER_CORNER: u64 = 250;

/// The most of all of these for one polygon: a few seconds, in which nobody can stop the work.
const BUDGET_PER_POLYGON: u64 = 500_000_000;

/// In place of the next corner: this one is no longer in the ring.
const UNLINKED: u32 = u32::MAX;

/// The working memory of one polygon.
#[derive(Debug, Default)]
pub(super) struct EarClipping {
    points: Vec<[f64; 2]>,
    previous: Vec<u32>,
    next: Vec<u32>,
    /// True for corners of 180 degrees or more.
    reflex: Vec<bool>,
    grid: ReflexGrid,
    reflex_left: usize,
    /// Corners beside a cut that have not been looked at since.
    neighbours_of_cuts: Vec<u32>,
    budget: u64,
}

impl EarClipping {
    /// Projects a polygon with the given normal so that it turns to the left; `scale` is a power
    /// of two. False if the normal is zero or not finite.
    pub fn project(&mut self, normal: Vec3, corners: &[Vec3], scale: f64) -> bool {
        let size = normal.abs().max_element();
        // A NaN coordinate makes all three sums NaN, and the largest of them as well.
        if !(normal.is_finite() && size > 0.0) || corners.len() >= u32::MAX as usize {
            return false;
        }
        // Leave out the axis nearest to the normal, and move nothing: no coordinate is rounded,
        // so that the signs of areas are those of the corners as they came.
        let axis = (0..3).find(|&axis| normal[axis].abs() == size).unwrap_or(2);
        let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 {
            (u, v) = (v, u);
        }
        self.points.clear();
        self.points.extend(corners.iter().map(|corner| [corner[u] * scale, corner[v] * scale]));
        true
    }

    /// Cuts the projected polygon into triangles and hands their corners to `emit`.
    pub fn clip(&mut self, mut emit: impl FnMut([usize; 3])) {
        // Link the corners into a ring.
        let count = self.points.len() as u32;
        self.previous.clear();
        self.previous.extend((0..count).map(|i| if i == 0 { count - 1 } else { i - 1 }));
        self.next.clear();
        self.next.extend((0..count).map(|i| if i + 1 == count { 0 } else { i + 1 }));

        self.neighbours_of_cuts.clear();

        // Find the reflex corners.
        self.reflex.clear();
        for b in 0..count {
            self.reflex.push(self.turn(b) <= 0.0);
        }
        self.reflex_left = self.reflex.iter().filter(|&&reflex| reflex).count();
        self.grid.build(&self.points, (0..count).filter(|&i| self.reflex[i as usize]));
        self.budget = (BUDGET_PER_CORNER * u64::from(count)).min(BUDGET_PER_POLYGON);

        // Go round the ring and clip ears until a triangle is left.
        let mut left = count;
        let mut b = 0;
        let mut in_vain = 0;
        while left > 3 {
            if self.budget == 0 {
                return self.fan(b, emit);
            }
            if !self.is_ear(b) {
                // A cut may have made ears of its neighbours, even of those passed over.
                if let Some(neighbour) = self.neighbours_of_cuts.pop() {
                    if self.next[neighbour as usize] != UNLINKED {
                        b = neighbour;
                    }
                    continue;
                }
                b = self.next[b as usize];
                in_vain += 1;
                if in_vain < left {
                    continue;
                }
                // A whole round without an ear: the polygon touches or crosses itself. Clip a
                // corner without area, or else any convex one.
                self.budget = self.budget.saturating_sub(u64::from(left));
                match self.corner_to_force(b) {
                    Some(forced) => b = forced,
                    None => return self.fan(b, emit),
                }
            }
            emit([self.previous[b as usize], b, self.next[b as usize]].map(|i| i as usize));
            b = self.unlink(b);
            left -= 1;
            in_vain = 0;
        }
        emit([self.previous[b as usize], b, self.next[b as usize]].map(|i| i as usize));
    }

    /// Takes a corner out of the ring; returns the corner to look at next.
    fn unlink(&mut self, b: u32) -> u32 {
        let (a, c) = (self.previous[b as usize], self.next[b as usize]);
        self.next[a as usize] = c;
        self.previous[c as usize] = a;
        self.next[b as usize] = UNLINKED;
        self.neighbours_of_cuts.extend([a, c]);
        if self.reflex[b as usize] {
            self.reflex[b as usize] = false;
            self.reflex_left -= 1;
        }
        for i in [a, c] {
            if self.reflex[i as usize] && self.turn(i) > 0.0 {
                self.reflex[i as usize] = false;
                self.reflex_left -= 1;
            }
        }
        // Sort the reflex corners anew once most in the grid are no longer reflex: the cost of
        // all these sorts is at most that of two.
        if self.reflex_left < self.grid.len() / 2 {
            let reflex = &self.reflex;
            self.grid.shrink(&self.points, |i| reflex[i as usize]);
        }
        self.next[c as usize]
    }

    /// Triangles from `b` to the rest of the ring.
    fn fan(&self, b: u32, mut emit: impl FnMut([usize; 3])) {
        let mut c = self.next[b as usize];
        let mut d = self.next[c as usize];
        while d != b {
            emit([b, c, d].map(|i| i as usize));
            (c, d) = (d, self.next[d as usize]);
        }
    }

    /// A straight corner or, failing that, a convex one, whatever lies in its triangle.
    fn corner_to_force(&self, start: u32) -> Option<u32> {
        let mut convex = None;
        let mut b = start;
        loop {
            let turn = self.turn(b);
            if turn == 0.0 {
                return Some(b);
            }
            if turn > 0.0 && convex.is_none() {
                convex = Some(b);
            }
            b = self.next[b as usize];
            if b == start {
                return convex;
            }
        }
    }

    /// True if the corner `b` can be cut off.
    fn is_ear(&mut self, b: u32) -> bool {
        self.budget = self.budget.saturating_sub(1);
        if self.reflex[b as usize] || self.turn(b) <= 0.0 {
            return false;
        }
        let (a, c) = (self.previous[b as usize], self.next[b as usize]);
        let ring = [a, b, c];
        let triangle = ring.map(|i| self.points[i as usize]);
        // The edges before a and after c must not start into the triangle.
        if self.enters_corner(triangle, 0, self.previous[a as usize])
            || self.enters_corner(triangle, 2, self.next[c as usize])
        {
            return false;
        }
        let mut steps = 0;
        let free = self.grid.none_in(triangle, &mut steps, |p| {
            self.reflex[p as usize] && !ring.contains(&p) && self.blocks(triangle, p)
        });
        self.budget = self.budget.saturating_sub(steps);
        free
    }

    /// True if the corner `p` or one of its edges lies inside the triangle or on its open edge
    /// from corner 2 to corner 0, the diagonal.
    fn blocks(&self, triangle: [[f64; 2]; 3], p: u32) -> bool {
        let [a, b, c] = triangle;
        let point = self.points[p as usize];
        let (ab, bc, ca) = (area(a, b, point), area(b, c, point), area(c, a, point));
        if ab < 0.0 || bc < 0.0 || ca < 0.0 {
            return false;
        }
        let neighbours = [self.previous[p as usize], self.next[p as usize]];
        if let Some(corner) = triangle.iter().position(|&q| q == point) {
            return neighbours.iter().any(|&n| self.enters_corner(triangle, corner, n));
        }
        let crosses = |p, q| neighbours.iter().any(|&n| area(p, q, self.points[n as usize]) > 0.0);
        if ca == 0.0 {
            true
        } else if ab == 0.0 {
            crosses(a, b)
        } else if bc == 0.0 {
            crosses(b, c)
        } else {
            true
        }
    }

    /// True if an edge from the triangle's corner to `n` starts strictly inside the triangle.
    fn enters_corner(&self, triangle: [[f64; 2]; 3], corner: usize, n: u32) -> bool {
        let n = self.points[n as usize];
        let [here, after, before] = [0, 1, 2].map(|step| triangle[(corner + step) % 3]);
        area(here, after, n) > 0.0 && area(here, n, before) > 0.0
    }

    /// The sign of the turn at the corner `b`: positive to the left, zero straight on or back.
    fn turn(&self, b: u32) -> f64 {
        let [a, b, c] =
            [self.previous[b as usize], b, self.next[b as usize]].map(|i| self.points[i as usize]);
        area(a, b, c)
    }
}

/// Twice the area of the triangle, with an exact sign: positive if it turns to the left.
fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}
