//! A uniform grid over the reflex corners of a polygon, for the ear test.

/// Corners sorted by grid cell.
#[derive(Debug, Default)]
pub(super) struct ReflexGrid {
    /// Cells along each axis.
    sides: [usize; 2],
    origin: [f64; 2],
    cells_per_unit: [f64; 2],
    /// Cell (x, y) holds `items[starts[y * sides[0] + x]..starts[y * sides[0] + x + 1]]`.
    starts: Vec<u32>,
    items: Vec<u32>,
    scratch: Vec<u32>,
}

/// Most cells along an axis.
const MAX_SIDE: usize = 1 << 16;

/// Where a triangle's edge meets the border of a row is known to within this share of the largest
/// coordinate in cells: two differences, a quotient, a product and a sum are rounded, of numbers
/// of up to twice that size, and the corners themselves: less than 2^4 halves of 2^-52.
const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

impl ReflexGrid {
    /// Number of corners in the grid.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Sorts the given corners into about one cell each.
    pub fn build(&mut self, points: &[[f64; 2]], corners: impl Iterator<Item = u32>) {
        self.scratch.clear();
        self.scratch.extend(corners);
        self.sort(points);
    }

    /// Keeps only the corners for which `keep` is true.
    pub fn shrink(&mut self, points: &[[f64; 2]], keep: impl Fn(u32) -> bool) {
        self.scratch.clear();
        self.scratch.extend(self.items.iter().copied().filter(|&i| keep(i)));
        self.sort(points);
    }

    fn sort(&mut self, points: &[[f64; 2]]) {
        let count = self.scratch.len();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for &i in &self.scratch {
            for axis in 0..2 {
                low[axis] = low[axis].min(points[i as usize][axis]);
                high[axis] = high[axis].max(points[i as usize][axis]);
            }
        }
        // Square cells, about as many as corners; along a line, a row of them.
        self.origin = low;
        let extents = [0, 1].map(|axis| high[axis] - low[axis]);
        for axis in 0..2 {
            let aspect = extents[axis] / extents[1 - axis];
            let cells = (count as f64 * aspect).sqrt() as usize;
            self.sides[axis] = cells.clamp(1, count.clamp(1, MAX_SIDE));
            self.cells_per_unit[axis] = self.sides[axis] as f64 / extents[axis];
        }
        // An axis without extent has one cell, and any scale will do.
        for (axis, extent) in extents.into_iter().enumerate() {
            if extent == 0.0 {
                let other = self.cells_per_unit[1 - axis];
                self.cells_per_unit[axis] = if other.is_finite() { other } else { 1.0 };
            }
        }

        // Counting sort: count, sum up, place.
        let cells = self.sides[0] * self.sides[1];
        self.starts.clear();
        self.starts.resize(cells + 1, 0);
        for &i in &self.scratch {
            let cell = self.cell_of(points[i as usize]);
            self.starts[cell] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.items.clear();
        self.items.resize(count, 0);
        for n in 0..count {
            let i = self.scratch[n];
            let cell = self.cell_of(points[i as usize]);
            self.starts[cell] -= 1;
            self.items[self.starts[cell] as usize] = i;
        }
    }

    /// The point in units of cells.
    fn in_cells(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (point[axis] - self.origin[axis]) * self.cells_per_unit[axis])
    }

    /// The nearest cell along an axis; cell 0 for NaN.
    fn clamp_to_cell(&self, axis: usize, position: f64) -> usize {
        (position as usize).min(self.sides[axis] - 1)
    }

    fn cell_of(&self, point: [f64; 2]) -> usize {
        let [x, y] = self.in_cells(point);
        self.clamp_to_cell(1, y) * self.sides[0] + self.clamp_to_cell(0, x)
    }

    /// True if `blocks` is false for every corner in the cells that the triangle touches. Adds
    /// the number of cells and corners looked at to `steps`.
    pub fn none_in(
        &self,
        triangle: [[f64; 2]; 3],
        steps: &mut u64,
        blocks: impl Fn(u32) -> bool,
    ) -> bool {
        if self.items.is_empty() {
            return true;
        }
        let corners = triangle.map(|point| self.in_cells(point));
        let low = corners[0][1].min(corners[1][1]).min(corners[2][1]);
        let high = corners[0][1].max(corners[1][1]).max(corners[2][1]);
        let rounding = ROUNDING * corners.iter().flatten().fold(0.0, |size, x| x.abs().max(size));
        for row in self.clamp_to_cell(1, low)..=self.clamp_to_cell(1, high) {
            let (bottom, top) = (row as f64 - rounding, (row + 1) as f64 + rounding);
            let Some((left, right)) = extent_in_row(corners, bottom, top) else {
                continue;
            };
            let columns =
                self.clamp_to_cell(0, left - rounding)..=self.clamp_to_cell(0, right + rounding);
            let first = self.starts[row * self.sides[0] + columns.start()] as usize;
            let last = self.starts[row * self.sides[0] + columns.end() + 1] as usize;
            // The cells of a row lie side by side in memory.
            for &i in &self.items[first..last] {
                *steps += 1;
                if blocks(i) {
                    return false;
                }
            }
            *steps += 1;
        }
        true
    }
}

/// The interval of x that the triangle covers between `bottom` and `top`, if any.
fn extent_in_row(corners: [[f64; 2]; 3], bottom: f64, top: f64) -> Option<(f64, f64)> {
    if corners.iter().flatten().any(|x| !x.is_finite()) {
        return Some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for edge in 0..3 {
        let (p, q) = (corners[edge], corners[(edge + 1) % 3]);
        let (p, q) = if p[1] <= q[1] { (p, q) } else { (q, p) };
        if q[1] < bottom || p[1] > top {
            continue;
        }
        // Only edges that are not level are cut, so the division is by a positive number.
        let at = |y: f64| p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
        let x0 = if p[1] < bottom { at(bottom) } else { p[0] };
        let x1 = if q[1] > top { at(top) } else { q[0] };
        left = left.min(x0).min(x1);
        right = right.max(x0).max(x1);
    }
    (left <= right).then_some((left, right))
}
