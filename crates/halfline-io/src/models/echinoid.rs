//! The shape of a regular sea urchin's shell, as a radius for each direction.
//!
//! Such a shell is five double columns of large plates (interambulacra), each plate with a
//! tubercle that once bore a spine, between five double columns of small plates (ambulacra) with
//! pairs of pores. Plates grow out of the apex, so their size is in proportion to the column's
//! width: they are the cells of a grid in longitude and in Mercator's latitude, which keeps
//! shapes. The plan is then bent, worn and pitted by noise, as a fossil is.

use libm::{acos, atan2, log};
use std::f64::consts::TAU;

use halfline::geometry::{Vec3, vec3};

use super::noise::{Noise, mix_linear, smooth_step};

/// Share of a fifth of the turn that one column of the interambulacrum takes, and of one of the
/// ambulacrum.
const BROAD: f64 = 0.325;
const NARROW: f64 = 0.5 - BROAD;

/// Height of a plate in shares of its width.
const ASPECT: f64 = 0.80;

/// Secondary tubercles in the ring around a primary one.
const RING: f64 = 15.0;

/// The shell's surface.
pub struct Echinoid {
    bend: Noise,
    wear: Noise,
    crust: Noise,
    grain: Noise,
    /// Edge length of the mesh that shall show it, at radius 1. Finer detail is left out.
    edge: f64,
}

impl Echinoid {
    /// The urchin that belongs to `seed`, for a mesh with edges about `edge` long.
    pub fn new(seed: u64, edge: f64) -> Echinoid {
        Echinoid {
            bend: Noise::new(seed, 0),
            wear: Noise::new(seed, 1),
            crust: Noise::new(seed, 2),
            grain: Noise::new(seed, 3),
            edge,
        }
    }

    /// How much of a feature of the given size the mesh can carry.
    fn carried(&self, size: f64) -> f64 {
        smooth_step(1.0, 2.5, size / self.edge)
    }

    /// The point of the surface in a direction from the centre. One point for each direction, so
    /// the surface cannot meet itself.
    pub fn point(&self, direction: Vec3) -> Vec3 {
        // Look the plan up a little aside, so that nothing is quite regular.
        let aside =
            self.bend.vector(direction * 1.4) * 0.055 + self.bend.vector(direction * 5.0) * 0.008;
        let plan = (direction + aside).normalized();
        let across = (plan.x * plan.x + plan.y * plan.y).sqrt().max(1e-9);
        let polar = acos(plan.z.clamp(-1.0, 1.0));
        let fifths = atan2(plan.y, plan.x) * 5.0 / TAU + 5.0;
        // Mercator's latitude: the logarithm of the tangent of half the polar angle.
        let mercator = log(across / (1.0 + plan.z).max(1e-9));

        let worn = smooth_step(0.18, 0.60, self.wear.fractal(direction * 1.9, 3));
        let relief = self.plates(fifths, mercator, across, polar) * mix_linear(1.0, 0.28, worn);
        let radius = self.base(polar, fifths, direction) + relief + self.surface(direction, worn);
        flatten(direction * radius)
    }

    /// The shell without its plates.
    fn base(&self, polar: f64, fifths: f64, direction: Vec3) -> f64 {
        // Lobes: the ambulacra stand back a little, most at the equator.
        let along = (fifths - fifths.floor() - 0.5).abs() * 2.0;
        let lobes =
            -0.022 * smooth_step(0.55, 1.0, along) * smooth_step(0.15, 0.8, polar.min(3.0 - polar));
        // The opening at the apex, with a rim, and the mouth below.
        let apex = 0.018 * bump((polar - 0.19) / 0.09) - 0.10 * smooth_step(0.16, 0.03, polar);
        let mouth = -0.42 * smooth_step(2.50, 2.95, polar) + 0.03 * bump((polar - 2.46) / 0.16);
        1.0 + lobes + apex + mouth + 0.035 * self.wear.at(direction * 1.1 + vec3(3.0, 1.0, 2.0))
    }

    /// The relief of plates, tubercles and pores.
    fn plates(&self, fifths: f64, mercator: f64, across: f64, polar: f64) -> f64 {
        let shown = smooth_step(0.16, 0.30, polar) * smooth_step(2.62, 2.42, polar);
        if shown == 0.0 {
            return 0.0;
        }
        let place = fifths - fifths.floor() - 0.5;
        let (side, from_middle) = (if place < 0.0 { 0.0 } else { 0.5 }, place.abs());
        // Half a plate's width on the sphere of radius 1 is the unit of length in its own frame.
        let relief = if from_middle < BROAD {
            let rows = mercator / (ASPECT * BROAD * TAU / 5.0) + side;
            let up = 2.0 * ASPECT * (rows - rows.floor() - 0.5);
            let right = 2.0 * from_middle / BROAD - 1.0;
            let unit = 0.5 * BROAD * TAU / 5.0 * across;
            unit * self.broad_plate(right, up, unit)
        } else {
            let rows = mercator / (ASPECT * NARROW * TAU / 5.0) + side;
            let up = 2.0 * ASPECT * (rows - rows.floor() - 0.5);
            let right = 2.0 * (from_middle - BROAD) / NARROW - 1.0;
            let unit = 0.5 * NARROW * TAU / 5.0 * across;
            unit * self.narrow_plate(right, up, unit)
        };
        shown * relief
    }

    /// A plate of the interambulacrum, `right` from -1 to 1.
    fn broad_plate(&self, right: f64, up: f64, unit: f64) -> f64 {
        let from_center = (right * right + up * up).sqrt();
        // A sunken disc, a truncated cone in it, and a knob with a dimple on the cone.
        let disc = -0.07 * smooth_step(0.74, 0.64, from_center);
        let cone = 0.30 * smooth_step(0.52, 0.235, from_center);
        let platform = 0.02 * bump((from_center - 0.245) / 0.04);
        let knob = dome(from_center / 0.185) * 0.20 - 0.07 * bump(from_center / 0.06);
        let coarse = disc + cone * self.carried(0.5 * unit);
        let fine = (platform + knob) * self.carried(0.25 * unit);

        // A ring of small tubercles around the disc.
        let bead_size = TAU * 0.80 / RING;
        let carried = self.carried(0.5 * bead_size * unit);
        let beads = if carried > 0.0 && (from_center - 0.80).abs() < 0.5 * bead_size {
            let turn = atan2(up, right) / TAU * RING;
            let beside = (turn - turn.round()) * bead_size;
            let beyond = from_center - 0.80;
            let distance = (beside * beside + beyond * beyond).sqrt();
            bead(distance / (0.47 * bead_size)) * 0.085 * carried
        } else {
            0.0
        };
        // Smaller ones in the corners that the ring leaves free.
        let corner = granules(right, up, 0.19);
        let grains =
            0.045 * corner * smooth_step(0.93, 1.0, from_center) * self.carried(0.1 * unit);
        coarse + fine + beads + grains + self.seam(right, up, unit)
    }

    /// A plate of the ambulacrum, `right` from -1 beside the interambulacrum to 1 in the middle.
    fn narrow_plate(&self, right: f64, up: f64, unit: f64) -> f64 {
        let tubercle = ((right - 0.38) * (right - 0.38) + up * up).sqrt();
        let boss = 0.20 * smooth_step(0.50, 0.20, tubercle) + 0.20 * dome(tubercle / 0.24)
            - 0.07 * smooth_step(0.62, 0.52, tubercle);
        // A pair of pores, the outer one a slit.
        let pore = |x: f64, width: f64, height: f64| {
            let (dx, dy) = ((right - x) / width, (up + 0.1) / height);
            bump((dx * dx + dy * dy).sqrt())
        };
        let pores = pore(-0.72, 0.15, 0.30) + pore(-0.34, 0.13, 0.22);
        let wall = 0.06 * bump((right + 0.53) / 0.10) * bump((up + 0.1) / 0.4);
        boss * self.carried(0.4 * unit)
            + (wall - 0.30 * pores) * self.carried(0.25 * unit)
            + self.seam(right, up, unit)
    }

    /// The groove between plates.
    fn seam(&self, right: f64, up: f64, unit: f64) -> f64 {
        let inside = (1.0 - right.abs()).min(ASPECT - up.abs());
        -0.055 * smooth_step(0.075, 0.0, inside) * self.carried(0.1 * unit)
    }

    /// What time has done: dents, cracks, crust on what is worn, and grain.
    fn surface(&self, direction: Vec3, worn: f64) -> f64 {
        let crust = match worn * self.carried(0.1) {
            0.0 => 0.0,
            weight => 0.016 * weight * self.crust.fractal(direction * 9.0, 4),
        };
        let fragile = smooth_step(-0.1, 0.25, self.wear.at(direction * 1.3 + vec3(5.0, 8.0, 1.0)));
        let crack = match fragile * self.carried(0.02) {
            0.0 => 0.0,
            weight => {
                let vein = self.crust.fractal(direction * 2.3 + vec3(9.0, 4.0, 6.0), 3).abs();
                -0.016 * weight * smooth_step(0.016, 0.0, vein)
            }
        };
        let pits = match self.carried(0.02) {
            0.0 => 0.0,
            weight => -0.010 * weight * smooth_step(0.42, 0.75, self.grain.at(direction * 34.0)),
        };
        let grain = match self.carried(0.012) {
            0.0 => 0.0,
            weight => 0.0016 * weight * self.grain.fractal(direction * 70.0, 2),
        };
        crust + crack + pits + grain
    }
}

/// The shell is low, and lower below than above; both halves meet with the same tangent.
fn flatten(p: Vec3) -> Vec3 {
    vec3(p.x, p.y, p.z * if p.z > 0.0 { 0.70 } else { 0.50 })
}

/// 1 at 0, 0 from -1 down and 1 up, smooth.
fn bump(t: f64) -> f64 {
    let s = (1.0 - t * t).max(0.0);
    s * s
}

/// The height of half a ball over its middle plane, its edge a little softened.
fn dome(t: f64) -> f64 {
    let s = (1.0 - t * t).max(0.0);
    s.sqrt() * smooth_step(0.0, 0.25, s)
}

/// A small tubercle: a mound with a knob.
fn bead(t: f64) -> f64 {
    0.6 * bump(t) + 0.6 * dome(t / 0.5)
}

/// A hexagonal pattern of mounds, `size` apart.
fn granules(x: f64, y: f64, size: f64) -> f64 {
    let row = (y / (size * 0.866)).round();
    let shift = if row as i64 & 1 == 0 { 0.0 } else { 0.5 };
    let dx = x / size - shift;
    let dx = dx - dx.round();
    let dy = y / size - 0.866 * row;
    bump((dx * dx + dy * dy).sqrt() / 0.5)
}
