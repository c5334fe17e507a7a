//! The hall's chandeliers: most of its smallest triangles, hung in the air.

use libm::{cos, sin};
use std::f64::consts::{PI, TAU};

use halfline::geometry::{Vec3, vec3};

use super::assembly::Shape;
use super::hall_structure::{Hall, NAVE, WALL};

impl Hall<'_> {
    /// Three chandeliers: two rings of lights, and chains of crystals between them.
    pub fn chandeliers(&mut self) {
        let crystal = Shape::sphere(self.detail.crystal, self.detail.crystal.div_ceil(2) + 1);
        let bulb = Shape::sphere(16, 10);
        let rod = Shape::cylinder(12);
        let brass = self.materials.brass;
        for x in [-10.0, 0.0, 10.0] {
            let middle = vec3(x, 0.0, 8.6);
            let top = middle + vec3(0.0, 0.0, 1.5);
            let ridge = vec3(x, 0.0, WALL + 0.12 + NAVE);
            self.scene.along(&rod, (top, 0.02), (ridge, 0.02), brass);
            self.scene.shape(&bulb, brass, |p| top + p * 0.12);
            for (radius, height, lights) in [(1.5, 0.0, 24), (0.9, 0.6, 14)] {
                let ring = torus(radius, 0.03, 96, 10);
                let level = middle + vec3(0.0, 0.0, height);
                self.scene.shape(&ring, brass, |p| level + p);
                for i in 0..lights {
                    let angle = TAU * f64::from(i) / f64::from(lights);
                    let out = vec3(cos(angle), sin(angle), 0.0);
                    let foot = level + out * radius + vec3(0.0, 0.0, 0.03);
                    let wick = foot + vec3(0.0, 0.0, 0.16);
                    self.scene.along(&rod, (foot, 0.018), (wick, 0.018), self.materials.wall);
                    self.scene.shape(&bulb, self.materials.crystal, |p| {
                        wick + vec3(0.028 * p.x, 0.028 * p.y, 0.028 + 0.045 * p.z)
                    });
                    if i % 2 == 0 {
                        self.scene.along(&rod, (level + out * radius, 0.008), (top, 0.008), brass);
                    }
                    // From every light one chain of crystals up to the rod's end, and one that
                    // sags to the next light.
                    let next = TAU * f64::from(i + 1) / f64::from(lights);
                    let beside = level + vec3(cos(next), sin(next), 0.0) * radius;
                    self.chain(&crystal, level + out * radius, top, 0.35, 40);
                    self.chain(&crystal, level + out * radius, beside, 0.18, 12);
                }
            }
            // The bowl of crystals below.
            for i in 1..12 {
                let angle = 0.5 * PI * f64::from(i) / 12.0;
                let count = 6 * (12 - i);
                for j in 0..count {
                    let turn = TAU * f64::from(j) / f64::from(count);
                    let at = vec3(
                        1.1 * cos(angle) * cos(turn),
                        1.1 * cos(angle) * sin(turn),
                        -0.7 * sin(angle),
                    );
                    self.scene.shape(&crystal, self.materials.crystal, |p| middle + at + p * 0.03);
                }
            }
        }
    }

    /// Crystals on a line that sags.
    fn chain(&mut self, crystal: &Shape, from: Vec3, to: Vec3, sag: f64, count: i32) {
        for i in 0..count {
            let t = (f64::from(i) + 0.5) / f64::from(count);
            let at = from + (to - from) * t - vec3(0.0, 0.0, 4.0 * sag * t * (1.0 - t));
            self.scene.shape(crystal, self.materials.crystal, |p| at + p * 0.014);
        }
    }
}

/// A torus about the z axis.
fn torus(radius: f64, thickness: f64, around: u32, across: u32) -> Shape {
    let mut positions = Vec::with_capacity((around * across) as usize);
    let mut triangles = Vec::with_capacity(2 * (around * across) as usize);
    for i in 0..around {
        let turn = TAU * f64::from(i) / f64::from(around);
        for j in 0..across {
            let angle = TAU * f64::from(j) / f64::from(across);
            let distance = radius + thickness * cos(angle);
            positions.push(vec3(
                distance * cos(turn),
                distance * sin(turn),
                thickness * sin(angle),
            ));
            let (k, m) = ((i + 1) % around, (j + 1) % across);
            let corner = |i: u32, j: u32| i * across + j;
            triangles.push([corner(i, j), corner(k, j), corner(k, m)]);
            triangles.push([corner(i, j), corner(k, m), corner(i, m)]);
        }
    }
    Shape { positions, triangles }
}
