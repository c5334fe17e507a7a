//! A pile of sheets, each as wide as the unit cube, much closer to each other than their triangles
//! are wide, and tilted: no plane across an axis runs between two of them.

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::fill::separate_triangles;
use halfline::progress::SharedProgress;

/// By how much a sheet rises from its lowest to its highest corner.
const TILT: f64 = 0.3;

/// A mesh of the kind [`Kind::Layers`](super::Kind::Layers).
pub fn layers(triangles: usize, progress: &SharedProgress) -> Result<Mesh> {
    let pile = Pile::new(triangles.div_ceil(2));
    separate_triangles(triangles, progress, |index| pile.triangle(index))
}

/// As many sheets as each of them has squares, so that both grow like the square root.
struct Pile {
    squares: usize,
    sheets: usize,
}

impl Pile {
    fn new(squares: usize) -> Pile {
        Pile { squares, sheets: (squares as f64).sqrt().round() as usize }
    }

    /// Triangle `index`: each square gives two.
    fn triangle(&self, index: usize) -> [Vec3; 3] {
        // Deal the squares to the sheets, and those of a sheet to its rows, as evenly as it goes.
        let (sheet, in_sheet, squares) = dealt(index / 2, self.squares, self.sheets);
        let rows = (squares as f64).sqrt().round() as usize;
        let (row, column, columns) = dealt(in_sheet, squares, rows);

        let base = (sheet as f64 + 0.5) / self.sheets as f64 * (1.0 - TILT);
        let corner = |i: usize, j: usize| {
            let x = (column + i) as f64 / columns as f64;
            let y = (row + j) as f64 / rows as f64;
            vec3(x, y, base + TILT * (x + y) / 2.0)
        };
        match index % 2 {
            0 => [corner(0, 0), corner(1, 0), corner(1, 1)],
            _ => [corner(0, 0), corner(1, 1), corner(0, 1)],
        }
    }
}

/// The part to which thing `index` of `things` belongs if they are dealt to `parts` in a row, its
/// place there, and how many things that part has.
fn dealt(index: usize, things: usize, parts: usize) -> (usize, usize, usize) {
    let start = |part: usize| (part as u128 * things as u128 / parts as u128) as usize;
    let mut part = (index as u128 * parts as u128 / things as u128) as usize;
    while start(part + 1) <= index {
        part += 1;
    }
    (part, index - start(part), start(part + 1) - start(part))
}

#[cfg(test)]
mod tests {
    use super::dealt;
    use crate::models::{Kind, generate};
    use halfline::progress::NoProgress;

    #[test]
    fn things_are_dealt_evenly_and_in_order() {
        for (things, parts) in [(1, 1), (7, 3), (100, 10), (1001, 32), (5, 5)] {
            let mut expected = (0, 0);
            for index in 0..things {
                let (part, place, size) = dealt(index, things, parts);
                assert_eq!((part, place), expected, "{index} of {things} in {parts}");
                assert!(size == things / parts || size == things.div_ceil(parts));
                expected = if place + 1 == size { (part + 1, 0) } else { (part, place + 1) };
            }
            assert_eq!(expected, (parts, 0));
        }
    }

    #[test]
    fn layers_lie_closer_than_their_triangles_are_wide() {
        // Between its lowest and its highest corner, a square of a sheet has more than one other sheet.
        let mesh = generate(Kind::Layers, 200_000, 0, &NoProgress).unwrap();
        let sheets = (100_000_f64).sqrt();
        for t in 0..mesh.triangle_count() as u32 {
            let corners = mesh.corners(t);
            let heights = corners.map(|p| p.z);
            let rise = heights.iter().copied().fold(0.0, f64::max)
                - heights.iter().copied().fold(1.0, f64::min);
            assert!(rise > 2.0 / sheets, "{t}: {corners:?}");
        }
    }
}
