//! What is joined and laid in the hall: hundreds of planks whose faces lie in one plane, side by side
//! and on top of each other, in that of floor, wall or roof too; pipes, joists and wires as long as
//! the hall.

use halfline::geometry::{Vec3, vec3};

use super::assembly::Shape;
use super::hall_structure::{BAY, Hall, LENGTH, NAVE, WALL, WIDTH, bays};

/// Half the width of the planked floor, and the width and length of a plank of it.
const FLOOR: f64 = 2.4;
const PLANK: f64 = 0.12;
const PLANK_LENGTH: f64 = 2.25;

/// Height, width and thickness of the boards on the long walls.
const PANELLING: f64 = 2.4;
const BOARD: f64 = 0.15;
pub const BOARD_THICKNESS: f64 = 0.02;

impl Hall<'_> {
    /// Planks along the nave, their tops in the plane of the floor, with strips across them whose
    /// tops lie there too. Of faces that coincide, the first is seen: planks come before the floor,
    /// and strips before planks.
    pub fn floorboards(&mut self) {
        let dark = self.materials.oak[2];
        for y in [-FLOOR, FLOOR - 0.06] {
            let (low, high) = (vec3(-LENGTH, y, -0.02), vec3(LENGTH, y + 0.06, 0.0));
            self.scene.block(low, high, dark);
        }
        for x in bays() {
            let (low, high) = (vec3(x - 0.04, -FLOOR, -0.02), vec3(x + 0.04, FLOOR, 0.0));
            self.scene.block(low, high, dark);
        }
        let (rows, columns) = (40, 20);
        for row in 0..rows {
            let shift = if row % 2 == 0 { 0.0 } else { -0.5 };
            let edge = |row: i32| -FLOOR + PLANK * f64::from(row);
            for column in 0..=columns {
                let end = |column: i32| {
                    let x = -LENGTH + PLANK_LENGTH * (f64::from(column) + shift);
                    x.clamp(-LENGTH, LENGTH)
                };
                let (from, to) = (end(column), end(column + 1));
                if from < to {
                    let material = self.materials.oak[((5 * row + 7 * column) % 11 % 2) as usize];
                    let (low, high) = (vec3(from, edge(row), -0.03), vec3(to, edge(row + 1), 0.0));
                    self.scene.block(low, high, material);
                }
            }
        }
    }

    /// Boards on the long walls, their backs in the wall's plane; rails as long as the hall, of which
    /// the lowest shares the front plane of the boards.
    pub fn panelling(&mut self) {
        let [light, warm, dark] = self.materials.oak;
        for side in [-1.0, 1.0] {
            self.on_wall(side, (-LENGTH, LENGTH), (0.0, 0.12), BOARD_THICKNESS, dark);
            for i in 0..300 {
                let x = |i: i32| -LENGTH + BOARD * f64::from(i);
                let material = if i % 3 == 0 { light } else { warm };
                self.on_wall(side, (x(i), x(i + 1)), (0.0, PANELLING), BOARD_THICKNESS, material);
            }
            self.on_wall(side, (-LENGTH, LENGTH), (PANELLING, PANELLING + 0.06), 0.05, dark);
            self.on_wall(side, (-LENGTH, LENGTH), (4.2, 4.23), 0.02, dark);
        }
    }

    /// A block on a long wall.
    fn on_wall(
        &mut self,
        side: f64,
        (x0, x1): (f64, f64),
        (z0, z1): (f64, f64),
        thickness: f64,
        material: u32,
    ) {
        let (back, front) = (side * WIDTH, side * (WIDTH - thickness));
        let (low, high) = (vec3(x0, back.min(front), z0), vec3(x1, back.max(front), z1));
        self.scene.block(low, high, material);
    }

    /// Joists under the aisles' roofs, in whose plane their tops lie, and pipes along the walls.
    pub fn joists_and_pipes(&mut self) {
        let pipe = Shape::cylinder(8);
        for side in [-1.0, 1.0] {
            for i in 0..10 {
                let y = side * (NAVE + 0.6 + 0.3 * f64::from(i));
                let low = vec3(-LENGTH, y - 0.03, WALL - 0.08);
                self.scene.block(low, vec3(LENGTH, y + 0.03, WALL), self.materials.oak[2]);
            }
            for (distance, z, radius) in [(0.10, 0.22, 0.03), (0.10, 0.31, 0.02), (0.14, 4.4, 0.05)]
            {
                let end = |x: f64| (vec3(x, side * (WIDTH - distance), z), radius);
                self.scene.along(&pipe, end(-LENGTH), end(LENGTH), self.materials.brass);
            }
        }
    }

    /// Wires across the nave from capital to capital, and along it from corner to corner.
    pub fn wires(&mut self) {
        let wire = Shape::cylinder(5);
        let mut stretch = |from: Vec3, to: Vec3| {
            self.scene.along(&wire, (from, 0.006), (to, 0.006), self.materials.iron);
        };
        for side in [-1.0, 1.0] {
            let (from, to) = (side * (NAVE - 0.5), -side * (NAVE - 0.5));
            for x in bays().take(8) {
                stretch(vec3(x, from, 10.6), vec3(x + BAY, to, 10.6));
            }
            stretch(vec3(-LENGTH, from, 10.9), vec3(LENGTH, to, 10.9));
            stretch(vec3(-LENGTH, from, 10.9), vec3(LENGTH, from, 11.5));
        }
    }
}
