//! A cube's surface, gridded and blown up to a sphere: a closed mesh of any even number of
//! triangles from 12 up.
//!
//! The grid lines are spaced by the tangent of even angles, which keeps the largest cell within
//! 1.4 times the smallest. Each of the 6 k^2 cells is two triangles; to meet the number exactly,
//! some cells, evenly spread, get a vertex in the middle and are four.

use libm::tan;

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};

use super::fill::reserved;
use halfline::geometry::random::Random;

/// Cells along the side of a tile. Triangles are listed tile by tile.
const TILE: usize = 32;

/// How many tiles in a row may change places in [`Order::Shuffled`].
const WINDOW: usize = 12;

/// In which order cells are listed.
#[derive(Clone, Copy)]
pub enum Order {
    /// Cells are listed tile after tile, back and forth.
    Strips,
    /// Cells are listed tile after tile, but near tiles have changed places, as the seed says.
    Shuffled(u64),
}

/// A grid on the sphere.
pub struct CubeSphere {
    /// Cells along an edge of the cube.
    side: usize,
    /// Cells that have a vertex in the middle.
    split: usize,
    /// Coordinate on the cube, from -1 to 1, of each grid line.
    lines: Vec<f64>,
    /// Tiles as (side of the cube, first row, first column).
    tiles: Vec<(u8, u32, u32)>,
}

impl CubeSphere {
    /// The cube itself.
    pub const SMALLEST: usize = 12;

    /// The grid of at most `triangles` triangles that comes nearest.
    pub fn new(triangles: usize, order: Order) -> CubeSphere {
        let mut side = 1;
        // The integer square root, bit by bit.
        let mut step = 1usize << 14;
        while step > 0 {
            if 12 * (side + step) * (side + step) <= triangles {
                side += step;
            }
            step /= 2;
        }
        let cells = 6 * side * side;
        let split = (triangles.saturating_sub(2 * cells) / 2).min(cells);
        let lines = (0..=side)
            .map(|i| {
                // Symmetric about the middle to the bit, so that the six sides agree.
                let angle = (2 * i) as f64 - side as f64;
                tan(std::f64::consts::FRAC_PI_4 * (angle / side as f64))
            })
            .map(|t| t.clamp(-1.0, 1.0))
            .collect();
        CubeSphere { side, split, lines, tiles: tiles(side, order) }
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        2 * (6 * self.side * self.side + self.split)
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.grid_vertices() + self.split
    }

    /// Mean edge length on the sphere of radius 1, were all triangles equilateral.
    pub fn mean_edge(&self) -> f64 {
        let area = 4.0 * std::f64::consts::PI / self.triangle_count() as f64;
        (area * 4.0 / 1.732_050_807_568_877_2).sqrt()
    }

    /// The direction from the centre to vertex `index`.
    pub fn direction(&self, index: usize) -> Vec3 {
        let grid = self.grid_vertices();
        if index < grid {
            let [x, y, z] = self.grid_point(index);
            vec3(self.lines[x], self.lines[y], self.lines[z]).normalized()
        } else {
            let [a, _, c, _] = self.cell_corners(self.split_cell(index - grid)).map(|p| {
                let [x, y, z] = p;
                vec3(self.lines[x], self.lines[y], self.lines[z])
            });
            ((a + c) * 0.5).normalized()
        }
    }

    /// The triangles, seen counter-clockwise from outside. A cell of two is cut along the
    /// diagonal from the first to the third corner if `first_diagonal` says so, else the other.
    pub fn triangles(&self, first_diagonal: impl Fn([u32; 4]) -> bool) -> Result<Vec<[u32; 3]>> {
        let mut triangles = reserved(self.triangle_count())?;
        for &(face, row, column) in &self.tiles {
            let (row, column) = (row as usize, column as usize);
            for i in row..(row + TILE).min(self.side) {
                for j in column..(column + TILE).min(self.side) {
                    let cell = (face as usize * self.side + i) * self.side + j;
                    let corners = self.cell_corners(cell).map(|p| self.grid_index(p) as u32);
                    let [a, b, c, d] = corners;
                    let rank = self.splits_before(cell);
                    if self.splits_before(cell + 1) > rank {
                        let m = (self.grid_vertices() + rank) as u32;
                        triangles.extend([[a, b, m], [b, c, m], [c, d, m], [d, a, m]]);
                    } else if first_diagonal(corners) {
                        triangles.extend([[a, b, c], [a, c, d]]);
                    } else {
                        triangles.extend([[a, b, d], [b, c, d]]);
                    }
                }
            }
        }
        Ok(triangles)
    }

    fn grid_vertices(&self) -> usize {
        6 * self.side * self.side + 2
    }

    /// Number of cells before `cell` that have a vertex in the middle.
    fn splits_before(&self, cell: usize) -> usize {
        let cells = (6 * self.side * self.side) as u128;
        (cell as u128 * self.split as u128 / cells) as usize
    }

    /// The cell with the middle vertex number `rank`: the last one with `splits_before == rank`.
    fn split_cell(&self, rank: usize) -> usize {
        let cells = (6 * self.side * self.side) as u128;
        ((rank as u128 + 1) * cells).div_ceil(self.split as u128) as usize - 1
    }

    /// The corners of a cell as points of the cube's grid, counter-clockwise from outside.
    fn cell_corners(&self, cell: usize) -> [[usize; 3]; 4] {
        let k = self.side;
        let (face, i, j) = (cell / (k * k), cell / k % k, cell % k);
        // Side 2 a is where axis a is k, side 2 a + 1 where it is 0; rows along the next axis but
        // one, columns along the next.
        let (axis, high) = (face / 2, face % 2 == 0);
        let point = |row: usize, column: usize| {
            let mut p = [0; 3];
            p[axis] = if high { k } else { 0 };
            p[(axis + 1) % 3] = column;
            p[(axis + 2) % 3] = row;
            p
        };
        let corners = [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
        if high { corners } else { [corners[0], corners[3], corners[2], corners[1]] }
    }

    /// The index of a point of the cube's surface: layer by layer from z = 0 upwards, the first
    /// and the last layer row by row, the others once around.
    fn grid_index(&self, [x, y, z]: [usize; 3]) -> usize {
        let k = self.side;
        let layer = (k + 1) * (k + 1);
        if z == 0 {
            return y * (k + 1) + x;
        }
        let base = layer + (z - 1) * 4 * k;
        if z == k {
            return base + y * (k + 1) + x;
        }
        base + if y == 0 && x < k {
            x
        } else if x == k && y < k {
            k + y
        } else if y == k && x > 0 {
            2 * k + (k - x)
        } else {
            3 * k + (k - y)
        }
    }

    /// The inverse of [`CubeSphere::grid_index`].
    fn grid_point(&self, index: usize) -> [usize; 3] {
        let k = self.side;
        let layer = (k + 1) * (k + 1);
        let flat = |i: usize, z: usize| [i % (k + 1), i / (k + 1), z];
        if index < layer {
            return flat(index, 0);
        }
        let (z, around) = ((index - layer) / (4 * k) + 1, (index - layer) % (4 * k));
        if z >= k {
            return flat(index - layer - (k - 1) * 4 * k, k);
        }
        match around / k {
            0 => [around, 0, z],
            1 => [k, around - k, z],
            2 => [3 * k - around, k, z],
            _ => [0, 4 * k - around, z],
        }
    }
}

/// The tiles of all six sides.
fn tiles(side: usize, order: Order) -> Vec<(u8, u32, u32)> {
    let across = side.div_ceil(TILE);
    let mut tiles = Vec::with_capacity(6 * across * across);
    for face in 0..6 {
        for row in 0..across {
            for i in 0..across {
                let column = if row.is_multiple_of(2) { i } else { across - 1 - i };
                tiles.push((face, (row * TILE) as u32, (column * TILE) as u32));
            }
        }
    }
    if let Order::Shuffled(seed) = order {
        for (index, window) in tiles.chunks_mut(WINDOW).enumerate() {
            // Fisher and Yates.
            let mut random = Random::new(seed, index as u64);
            for i in (1..window.len()).rev() {
                window.swap(i, (random.bits() % (i as u64 + 1)) as usize);
            }
        }
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_grid_index_names_its_point() {
        for triangles in [12, 48, 108, 300, 12 * 33 * 33] {
            let grid = CubeSphere::new(triangles, Order::Strips);
            for index in 0..grid.grid_vertices() {
                assert_eq!(grid.grid_index(grid.grid_point(index)), index);
            }
        }
    }

    #[test]
    fn every_middle_vertex_lies_in_the_cell_that_lists_it() {
        let grid = CubeSphere::new(1000, Order::Strips);
        for rank in 0..grid.split {
            let cell = grid.split_cell(rank);
            assert_eq!(grid.splits_before(cell), rank);
            assert_eq!(grid.splits_before(cell + 1), rank + 1);
        }
    }
}
