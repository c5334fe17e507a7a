//! The hall's furniture: thousands of small things that stand close to each other on large ones.

use halfline::geometry::random::mix;
use halfline::geometry::{Vec3, vec3};

use super::assembly::Shape;
use super::hall_boards::BOARD_THICKNESS;
use super::hall_structure::{BAY, GALLERY, Hall, LENGTH, RAILING, WIDTH, bays};

/// Half the width of a bookcase, its depth, the distance of its shelves, and how thick they are.
const CASE: f64 = 1.5;
const DEPTH: f64 = 0.32;
const SHELF: f64 = 0.35;
const WOOD: f64 = 0.025;
const SHELVES: i32 = 6;

/// A book's size along the shelf, towards the reader and upwards; which of the materials it has.
struct Book {
    width: f64,
    depth: f64,
    height: f64,
    material: usize,
}

impl Book {
    fn new(number: u64) -> Book {
        let bits = mix(number);
        let share = |shift: u32| (bits >> shift & 0xff) as f64 / 255.0;
        // Volumes of one work stand together.
        let work = mix(number / 7);
        Book {
            width: 0.022 + 0.034 * share(0),
            depth: 0.17 + 0.09 * share(8),
            height: 0.20 + 0.10 * (work & 0xff) as f64 / 255.0,
            material: (work >> 8) as usize % 3,
        }
    }
}

impl Hall<'_> {
    /// A case full of books in each bay of both walls.
    pub fn bookcases(&mut self) {
        let mut number = 0;
        for side in [-1.0, 1.0] {
            for middle in bays().skip(1).map(|x| x - BAY / 2.0) {
                self.bookcase(side, middle, &mut number);
            }
        }
    }

    /// A case, its back on the boards of the wall, and its books, which are counted.
    fn bookcase(&mut self, side: f64, middle: f64, number: &mut u64) {
        let back = side * (WIDTH - BOARD_THICKNESS);
        let wood = self.materials.oak[2];
        let mut board = |(x0, x1): (f64, f64), (z0, z1): (f64, f64)| {
            let front = back - side * DEPTH;
            let low = vec3(middle + x0, back.min(front), z0);
            self.scene.block(low, vec3(middle + x1, back.max(front), z1), wood);
        };
        let floor = |shelf: i32| f64::from(shelf) * SHELF;
        board((-CASE - WOOD, -CASE), (0.0, floor(SHELVES) + WOOD));
        board((CASE, CASE + WOOD), (0.0, floor(SHELVES) + WOOD));
        for shelf in 0..=SHELVES {
            board((-CASE, CASE), (floor(shelf), floor(shelf) + WOOD));
        }

        let cube = Shape::cube();
        for shelf in 0..SHELVES {
            let foot = floor(shelf) + WOOD;
            let mut x = -CASE;
            loop {
                *number += 1;
                let Book { width, depth, height, material } = Book::new(*number);
                // Most stand side by side; a few lean on the one before.
                let lean = if number.is_multiple_of(13) { 0.2 * height } else { 0.0 };
                if x + width + lean > CASE {
                    break;
                }
                let front = back - side * depth;
                let corner = vec3(middle + x + lean, back.min(front), foot);
                self.scene.shape(&cube, self.materials.books[material], |p| {
                    corner + vec3(width * p.x - lean * p.z, depth * p.y, height * p.z)
                });
                x += width + lean;
            }
        }
    }

    /// Chairs along both sides of the nave, before the columns.
    pub fn chairs(&mut self) {
        let rod = Shape::cylinder(6);
        let wood = self.materials.oak[0];
        for side in [-1.0, 1.0] {
            for i in 0..57 {
                let foot = vec3(0.75 * f64::from(i - 28), 5.0 * side, 0.0);
                // y leads away from the nave.
                let at = |x: f64, y: f64, z: f64| foot + vec3(x, side * y, z);
                let mut stick = |from: Vec3, to: Vec3| {
                    self.scene.along(&rod, (from, 0.014), (to, 0.018), wood);
                };
                for x in [-1.0, 1.0] {
                    for y in [-1.0, 1.0] {
                        stick(at(0.22 * x, 0.22 * y, 0.0), at(0.18 * x, 0.18 * y, 0.44));
                    }
                    stick(at(0.19 * x, 0.19, 0.47), at(0.19 * x, 0.28, 0.92));
                }
                let mut board = |a: Vec3, b: Vec3| self.scene.block(a.min(b), a.max(b), wood);
                board(at(-0.22, -0.22, 0.44), at(0.22, 0.22, 0.47));
                for slat in 0..4 {
                    let z = 0.56 + 0.1 * f64::from(slat);
                    let y = 0.19 + 0.2 * (z - 0.44);
                    board(at(-0.19, y, z - 0.02), at(0.19, y + 0.012, z + 0.02));
                }
            }
        }
    }

    /// Two rows of rivets along each gallery's edge.
    pub fn rivets(&mut self) {
        let rivet = Shape::sphere(5, 3);
        for side in [-1.0, 1.0] {
            for below in [0.05, 0.20] {
                for i in 1..450 {
                    let at = vec3(0.1 * f64::from(i) - LENGTH, side * RAILING, GALLERY - below);
                    self.scene.shape(&rivet, self.materials.iron, |p| at + p * 0.012);
                }
            }
        }
    }
}
