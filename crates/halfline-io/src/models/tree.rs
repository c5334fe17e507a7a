//! Haines's tree, by Aono and Kunii's method ("Botanical Tree Image Generation", IEEE CG&A 4(5),
//! 1984): a branch is a cone with a sphere on its end, and carries two branches, one turned
//! aside by 40 degrees and 0.65 times as long, the other by 25 degrees and 0.7 times.
//!
//! Cones are closed with discs, which the spheres hide. Each generation has the fourth root of two
//! times as many sides as the next, twice as numerous one.

use libm::{cos, sin};

use halfline::error::Result;
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Mesh;

use super::View;
use super::assembly::{Assembly, Shape, haines_material, nearest_tessellation};
use halfline::progress::SharedProgress;

/// The camera of the Standard Procedural Databases.
pub const VIEW: View = View {
    from: vec3(4.5, 0.4, 2.0),
    at: vec3(0.0, 0.0, 1.5),
    up: vec3(0.0, 0.0, 1.0),
    angle_degrees: 45.0,
};

/// Half the side of the field.
const FIELD: f64 = 50.0;

/// Radius of a branch at its foot in shares of its length, and at its end in shares of its foot.
const WIDTH_RATIO: f64 = 0.15;
const TAPER: f64 = 0.67;

/// For each of the two branches: the angle by which it leans, that by which it is turned about
/// its parent, in degrees, and its length in shares of its parent's.
const BRANCHES: [(f64, f64, f64); 2] = [(40.0, 90.0, 0.65), (25.0, 230.0, 0.70)];

/// The twigs have at least this many sides before another generation is added.
const SIDES: usize = 5;

/// A mesh of the kind [`Kind::Tree`](super::Kind::Tree).
pub fn tree(triangles: usize, progress: &SharedProgress) -> Result<Mesh> {
    let wanted = triangles.saturating_sub(2);
    let mut generations = 1;
    while count(generations + 1, SIDES, SIDES.div_ceil(2)) <= wanted {
        generations += 1;
    }
    let (segments, stacks) = nearest_tessellation(wanted, 3, |a, b| count(generations, a, b));
    let shapes = (0..=generations)
        .map(|generation| {
            let (segments, stacks) = finer(segments, stacks, generations - generation);
            (Shape::cylinder(segments), Shape::sphere(segments, stacks))
        })
        .collect();

    let total = count(generations, segments, stacks) + 2;
    let mut scene = Assembly::new(total / 2 + 4 * (2 << generations) + 4, total)?;
    let green = scene.material(haines_material([0.2, 0.7, 0.2], 1.0, 0.0, 0.0, 1.5));
    let brown = scene.material(haines_material([0.55, 0.4, 0.2], 1.0, 0.0, 0.0, 1.5));
    let corner = |x: f64, y: f64| vec3(FIELD * x, FIELD * y, 0.0);
    scene.quad([corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)], green);
    let growth = Growth { shapes, turns: BRANCHES.map(Turn::new), brown };
    growth.grow(&mut scene, 0, &Place::GROUND, WIDTH_RATIO, progress)?;
    scene.finish()
}

/// The sides and bands of a branch, given those of one `generations` younger.
fn finer(segments: usize, stacks: usize, generations: u32) -> (usize, usize) {
    // The powers of the fourth root of two, in thousandths.
    let part = [1000, 1189, 1414, 1682][generations as usize % 4];
    let scale = |n: usize| ((n << (generations / 4)) * part).div_ceil(1000);
    (scale(segments), scale(stacks))
}

/// Number of the branches' triangles.
fn count(generations: u32, segments: usize, stacks: usize) -> usize {
    (0..=generations)
        .map(|generation| {
            let (segments, stacks) = finer(segments, stacks, generations - generation);
            let branch =
                Shape::cylinder_triangles(segments) + Shape::sphere_triangles(segments, stacks);
            branch << generation
        })
        .sum()
}

/// Where a branch starts, and the images of the x, y and z axis there; z is the branch itself.
struct Place {
    foot: Vec3,
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Place {
    const GROUND: Place = Place {
        foot: Vec3::ZERO,
        x: vec3(1.0, 0.0, 0.0),
        y: vec3(0.0, 1.0, 0.0),
        z: vec3(0.0, 0.0, 1.0),
    };
}

/// How a branch sits on its parent.
struct Turn {
    x: Vec3,
    y: Vec3,
    z: Vec3,
}

impl Turn {
    /// Lean about the x axis, then turn about the z axis, and shrink.
    fn new((lean, about, length): (f64, f64, f64)) -> Turn {
        let (lean, about) = (lean.to_radians(), about.to_radians());
        let (sl, cl, sa, ca) = (sin(lean), cos(lean), sin(about), cos(about));
        let turned = |v: Vec3| vec3(ca * v.x - sa * v.y, sa * v.x + ca * v.y, v.z) * length;
        Turn {
            x: turned(vec3(1.0, 0.0, 0.0)),
            y: turned(vec3(0.0, cl, sl)),
            z: turned(vec3(0.0, -sl, cl)),
        }
    }

    /// The place of the branch on the end of a parent at `place`.
    fn on(&self, place: &Place) -> Place {
        let image = |v: Vec3| place.x * v.x + place.y * v.y + place.z * v.z;
        Place { foot: place.foot + place.z, x: image(self.x), y: image(self.y), z: image(self.z) }
    }
}

struct Growth {
    /// The cone and the sphere of each generation.
    shapes: Vec<(Shape, Shape)>,
    turns: [Turn; 2],
    brown: u32,
}

impl Growth {
    fn grow(
        &self,
        scene: &mut Assembly,
        generation: usize,
        place: &Place,
        radius: f64,
        progress: &SharedProgress,
    ) -> Result<()> {
        let Some((cone, sphere)) = self.shapes.get(generation) else { return Ok(()) };
        progress.check()?;
        let (end, end_radius) = (place.foot + place.z, radius * TAPER);
        scene.along(cone, (place.foot, radius), (end, end_radius), self.brown);
        scene.shape(sphere, self.brown, |p| end + p * end_radius);
        for turn in &self.turns {
            self.grow(scene, generation + 1, &turn.on(place), end_radius, progress)?;
        }
        Ok(())
    }
}
