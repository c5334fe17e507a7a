//! The hall without its exhibits, in several levels of detail.

use libm::{cos, sin};
use std::f64::consts::PI;

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};

use super::assembly::{Assembly, Shape};
use super::hall_materials::Materials;

/// Half the hall's length, half its width, and the height of its walls.
pub const LENGTH: f64 = 22.5;
pub const WIDTH: f64 = 10.0;
pub const WALL: f64 = 11.6;

/// The nave's columns stand at this distance from the middle, this far from each other.
pub const NAVE: f64 = 6.5;
pub const BAY: f64 = 5.0;
const COLUMNS: i32 = 9;

/// Lower and upper edge of the windows, and half the width of one.
const SILL: f64 = 6.6;
const LINTEL: f64 = 10.6;
const WINDOW: f64 = 1.7;

/// Height of the galleries' floor, and how far from the middle their edge is.
pub const GALLERY: f64 = 5.2;
pub const RAILING: f64 = NAVE + 0.75;

/// Number of exhibits.
pub const PLINTHS: usize = 10;

/// Height of a plinth.
const PLINTH: f64 = 0.62;

/// How much of the hall there is.
pub struct Detail {
    /// Plinths, and fossils on them.
    pub exhibits: bool,
    /// Sides of a column; none without. Arches and the vault's bars have in proportion.
    pub sides: usize,
    /// Planks on floor and walls, joists, pipes and wires.
    pub boards: bool,
    /// Sides of a baluster of the galleries' railing; no galleries without.
    pub baluster: usize,
    /// Books, chairs and rivets.
    pub furniture: bool,
    /// Meridians of a crystal of the chandeliers; no chandeliers without.
    pub crystal: usize,
}

const BARE: Detail =
    Detail { exhibits: false, sides: 0, boards: false, baluster: 0, furniture: false, crystal: 0 };

/// From the barest.
pub const LEVELS: [Detail; 7] = [
    BARE,
    Detail { exhibits: true, ..BARE },
    Detail { exhibits: true, sides: 8, ..BARE },
    Detail { exhibits: true, sides: 8, boards: true, ..BARE },
    Detail { exhibits: true, sides: 16, boards: true, baluster: 4, ..BARE },
    Detail { exhibits: true, sides: 16, boards: true, baluster: 4, furniture: true, crystal: 0 },
    Detail { exhibits: true, sides: 48, boards: true, baluster: 10, furniture: true, crystal: 8 },
];

/// The middle of the top of plinth `index`, and the radius of what stands on it.
pub fn plinth(index: usize) -> (Vec3, f64) {
    let side = if index.is_multiple_of(2) { -1.0 } else { 1.0 };
    let x = (index / 2) as f64 * 8.0 - 16.0 + 0.8 * side;
    (vec3(x, 3.3 * side, PLINTH), 0.9)
}

/// Adds the hall.
pub fn build(scene: &mut Assembly, detail: &Detail, materials: &Materials) -> Result<()> {
    let mut hall = Hall { scene, detail, materials };
    if detail.boards {
        hall.floorboards();
        hall.panelling();
        hall.joists_and_pipes();
        hall.wires();
    }
    hall.shell();
    if detail.exhibits {
        hall.plinths();
    }
    if detail.sides > 0 {
        hall.columns();
        hall.vault();
    }
    if detail.baluster > 0 {
        hall.galleries();
        hall.window_bars();
    }
    if detail.furniture {
        hall.bookcases();
        hall.chairs();
        hall.rivets();
    }
    if detail.crystal > 0 {
        hall.chandeliers();
    }
    Ok(())
}

/// The hall in the making.
pub struct Hall<'a> {
    /// What it is added to.
    pub scene: &'a mut Assembly,
    /// How much of it there is.
    pub detail: &'a Detail,
    /// What it is made of.
    pub materials: &'a Materials,
}

/// The middle of each bay's column.
pub fn bays() -> impl Iterator<Item = f64> {
    (0..COLUMNS).map(|i| BAY * f64::from(i - COLUMNS / 2))
}

impl Hall<'_> {
    /// Floor and walls, with windows once there are columns to put between them.
    fn shell(&mut self) {
        let (l, w, h) = (LENGTH, WIDTH, WALL);
        self.scene.quad(
            [vec3(-l, -w, 0.0), vec3(l, -w, 0.0), vec3(l, w, 0.0), vec3(-l, w, 0.0)],
            self.materials.floor,
        );
        for x in [-l, l] {
            // The side that faces the hall is the front.
            let s = if x < 0.0 { -w } else { w };
            self.scene.quad(
                [vec3(x, s, 0.0), vec3(x, -s, 0.0), vec3(x, -s, h), vec3(x, s, h)],
                self.materials.wall,
            );
        }
        let windows = self.detail.sides > 0;
        for y in [-w, w] {
            if windows {
                self.wall(y, (-l, l), (0.0, SILL));
                self.wall(y, (-l, l), (LINTEL, h));
                let mut from = -l;
                for x in bays().skip(1).map(|x| x - BAY / 2.0) {
                    self.wall(y, (from, x - WINDOW), (SILL, LINTEL));
                    from = x + WINDOW;
                }
                self.wall(y, (from, l), (SILL, LINTEL));
            } else {
                self.wall(y, (-l, l), (0.0, h));
            }
        }
    }

    /// A part of the long wall at `y`.
    fn wall(&mut self, y: f64, (x0, x1): (f64, f64), (z0, z1): (f64, f64)) {
        let (a, b) = if y < 0.0 { (x1, x0) } else { (x0, x1) };
        self.scene.quad(
            [vec3(a, y, z0), vec3(b, y, z0), vec3(b, y, z1), vec3(a, y, z1)],
            self.materials.wall,
        );
    }

    fn plinths(&mut self) {
        for index in 0..PLINTHS {
            let (top, _) = plinth(index);
            let mut block = |half: f64, z0: f64, z1: f64| {
                let half = vec3(half, half, 0.0);
                let foot = vec3(top.x, top.y, 0.0);
                self.scene.block(
                    foot - half + vec3(0.0, 0.0, z0),
                    foot + half + vec3(0.0, 0.0, z1),
                    self.materials.stone,
                );
            };
            if self.detail.sides > 0 {
                block(0.80, 0.0, 0.12);
                block(0.62, 0.12, PLINTH - 0.08);
                block(0.72, PLINTH - 0.08, PLINTH);
            } else {
                block(0.62, 0.0, PLINTH);
            }
        }
    }

    fn columns(&mut self) {
        // Base mouldings, a shaft that swells and tapers, a bell capital.
        let mut profile = vec![(0.0, 0.30), (0.52, 0.30), (0.56, 0.38), (0.52, 0.46), (0.43, 0.50)];
        profile.extend([(0.47, 0.56), (0.45, 0.62), (0.40, 0.68)]);
        for i in 1..=8 {
            let t = f64::from(i) / 8.0;
            profile.push((0.40 - 0.09 * t * t, 0.68 + 8.92 * t));
        }
        profile.extend([(0.37, 9.64), (0.37, 9.72), (0.32, 9.76), (0.36, 10.1), (0.48, 10.4)]);
        profile.extend([(0.58, 10.52), (0.0, 10.52)]);
        let shaft = Shape::lathe(&profile, self.detail.sides);
        for side in [-1.0, 1.0] {
            for x in bays() {
                let foot = vec3(x, side * NAVE, 0.0);
                self.scene.shape(&shaft, self.materials.stone, |p| foot + p);
                let half = vec3(0.6, 0.6, 0.0);
                self.scene.block(
                    foot - half,
                    foot + half + vec3(0.0, 0.0, 0.30),
                    self.materials.stone,
                );
                self.scene.block(
                    foot - half + vec3(0.0, 0.0, 10.52),
                    foot + half + vec3(0.0, 0.0, 10.76),
                    self.materials.stone,
                );
            }
            // What the columns carry, and the aisle's roof.
            let y = side * NAVE;
            self.beam(y, 11.18, 0.34, 0.42, self.materials.stone);
            self.beam(y, WALL + 0.06, 0.46, 0.06, self.materials.stone);
            let (a, b) = if side < 0.0 { (-WIDTH, y) } else { (y, WIDTH) };
            self.scene.quad(
                [
                    vec3(-LENGTH, b, WALL),
                    vec3(LENGTH, b, WALL),
                    vec3(LENGTH, a, WALL),
                    vec3(-LENGTH, a, WALL),
                ],
                self.materials.wall,
            );
        }
    }

    /// A beam along the whole hall, around the line (y, z).
    fn beam(&mut self, y: f64, z: f64, half_width: f64, half_height: f64, material: u32) {
        self.scene.block(
            vec3(-LENGTH, y - half_width, z - half_height),
            vec3(LENGTH, y + half_width, z + half_height),
            material,
        );
    }

    /// The nave's glass roof, without the glass: ribs, thin bars between them, and bars as long as
    /// the hall.
    fn vault(&mut self) {
        let steps = 2 * self.detail.sides;
        for i in 0..2 * COLUMNS - 1 {
            let x = 0.5 * BAY * f64::from(i + 1 - COLUMNS);
            if i % 2 == 0 {
                self.arch(x, 0.14, 0.24, steps);
            } else {
                self.arch(x, 0.05, 0.12, steps);
            }
        }
        // Both ends are walled up to the vault.
        for x in [-LENGTH, LENGTH] {
            self.arch(x, 0.14, 0.24, steps);
            let spring = vec3(x, 0.0, WALL);
            let middle = self.scene.vertex(spring);
            let rim: Vec<u32> = (0..=steps)
                .map(|i| {
                    let angle = PI * i as f64 / steps as f64;
                    let rise = if i == 0 || i == steps { 0.0 } else { sin(angle) };
                    self.scene.vertex(spring + vec3(0.0, -NAVE * cos(angle), NAVE * rise))
                })
                .collect();
            for pair in rim.windows(2) {
                let corners =
                    if x < 0.0 { [middle, pair[1], pair[0]] } else { [middle, pair[0], pair[1]] };
                self.scene.triangle(corners, self.materials.wall);
            }
        }
        if self.detail.baluster > 0 {
            for i in 0..8 * (COLUMNS - 1) {
                if i % 4 != 0 {
                    self.arch(BAY * (f64::from(i) / 8.0 - 4.0), 0.012, 0.03, steps);
                }
            }
        }
        let bars = 15;
        for i in 1..bars {
            let angle = PI * f64::from(i) / f64::from(bars);
            let (y, z) = (-NAVE * cos(angle), WALL + 0.12 + NAVE * sin(angle));
            self.beam(y, z, 0.035, 0.035, self.materials.iron);
        }
    }

    /// Half a ring across the nave, of rectangular section, closed at its ends.
    fn arch(&mut self, x: f64, half_width: f64, half_depth: f64, steps: usize) {
        let spring = vec3(x, 0.0, WALL + 0.12);
        let mut positions = Vec::with_capacity(4 * (steps + 1));
        let mut triangles = Vec::with_capacity(8 * steps + 4);
        for i in 0..=steps {
            let angle = PI * i as f64 / steps as f64;
            let out = vec3(0.0, -cos(angle), sin(angle));
            let wide = vec3(half_width, 0.0, 0.0);
            let (inner, outer) = (out * (NAVE - half_depth), out * (NAVE + half_depth));
            positions.extend([inner - wide, inner + wide, outer + wide, outer - wide]);
        }
        for i in 0..steps as u32 {
            for j in 0..4 {
                let (a, b) = (4 * i + j, 4 * i + (j + 1) % 4);
                triangles.extend([[a, b + 4, b], [a, a + 4, b + 4]]);
            }
        }
        let last = 4 * steps as u32;
        triangles.extend([[0, 1, 2], [0, 2, 3]]);
        triangles.extend([[last, last + 2, last + 1], [last, last + 3, last + 2]]);
        let shape = Shape { positions, triangles };
        self.scene.shape(&shape, self.materials.iron, |p| spring + p);
    }

    /// Galleries over the aisles, with railings.
    fn galleries(&mut self) {
        let profile = [
            (0.0, 0.0),
            (0.035, 0.0),
            (0.035, 0.06),
            (0.018, 0.09),
            (0.030, 0.26),
            (0.014, 0.48),
            (0.014, 0.62),
            (0.026, 0.68),
            (0.014, 0.74),
            (0.014, 0.88),
            (0.0, 0.88),
        ];
        let baluster = Shape::lathe(&profile, self.detail.baluster);
        for side in [-1.0, 1.0] {
            let (inner, outer) = (side * RAILING, side * WIDTH);
            self.scene.block(
                vec3(-LENGTH, inner.min(outer), GALLERY - 0.25),
                vec3(LENGTH, inner.max(outer), GALLERY),
                self.materials.stone,
            );
            let rail = inner + 0.08 * side;
            self.beam(rail, GALLERY + 0.92, 0.045, 0.04, self.materials.brass);
            for i in 0..280 {
                let foot = vec3(0.16 * (f64::from(i) - 139.5), rail, GALLERY);
                self.scene.shape(&baluster, self.materials.iron, |p| foot + p);
            }
        }
    }

    /// The bars of the windows.
    fn window_bars(&mut self) {
        for y in [-WIDTH, WIDTH] {
            for x in bays().skip(1).map(|x| x - BAY / 2.0) {
                for i in 0..=4 {
                    let at = x + WINDOW * (f64::from(i) / 2.0 - 1.0);
                    self.scene.block(
                        vec3(at - 0.03, y - 0.04, SILL),
                        vec3(at + 0.03, y + 0.04, LINTEL),
                        self.materials.iron,
                    );
                }
                for i in 0..=5 {
                    let at = SILL + (LINTEL - SILL) * f64::from(i) / 5.0;
                    self.scene.block(
                        vec3(x - WINDOW, y - 0.03, at - 0.02),
                        vec3(x + WINDOW, y + 0.03, at + 0.02),
                        self.materials.iron,
                    );
                }
            }
        }
    }
}
