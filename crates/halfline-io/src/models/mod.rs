//! Generated meshes: the same kind, number and seed give the same bytes on every machine and any
//! number of threads.
//!
//! That is so because only operations whose result IEEE 754 fixes (`+ - * /` and square root) and
//! the functions of the `libm` crate, which is made of such operations, reach a coordinate; and
//! because every random number is a hash of what it is for, not of when it is drawn.
//!
//! The z axis points up in all of them. Surfaces that enclose something are closed, with their
//! front (the side from which a triangle's corners run counter-clockwise) outside.

mod assembly;
mod balls;
mod cube_sphere;
mod echinoid;
mod fill;
mod gears;
mod hall;
mod hall_boards;
mod hall_chandelier;
mod hall_furniture;
mod hall_materials;
mod hall_structure;
mod layers;
mod mount;
mod noise;
mod rings;
mod scan;
mod soup;
mod sphere;
mod sticks;
mod teapot;
mod terrain;
mod tetra;
mod tree;

use std::fmt;
use std::str::FromStr;

use halfline::error::{Error, Result};
use halfline::geometry::Vec3;
use halfline::mesh::Mesh;
use halfline::progress::{Observer, SharedProgress, Stage};

/// What can be generated. The last seven are the scenes of Eric Haines, "A Proposal for Standard
/// Graphics Environments", IEEE Computer Graphics and Applications 7(11), 1987, with the sizes
/// and colours of his Standard Procedural Databases (version 3), curved surfaces tessellated.
///
/// `n` is the wanted number of triangles. A kind that cannot be as small as `n` gives its
/// smallest mesh; the numbers in brackets say how small that is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A fossil sea urchin as a laser scanner would give it: one closed surface, triangles of
    /// even size in shuffled strips, noise on every vertex. Exactly `n` triangles if `n` is even,
    /// `n - 1` if it is odd: a closed surface has an even number (12).
    Scan,
    /// A sphere of radius 1: a cube, its faces gridded, blown up. As many triangles as
    /// [`Kind::Scan`] has (12).
    Sphere,
    /// Triangles that know nothing of each other: random places, directions and shapes in the
    /// unit cube, edges about n^(-1/3) long, so that a half-line crosses about n^(1/3) / 5.
    /// Exactly `n` (1).
    Soup,
    /// A pile of tilted sheets, each as wide as the unit cube and of the square root of n / 2 squares,
    /// and as many sheets: they lie ever closer to each other than their triangles are wide. Exactly
    /// `n` (1).
    Layers,
    /// Long thin sticks, two triangles each, from wall to wall of the unit cube in all directions: what
    /// kd-trees like least. The more there are the thinner they are, up to eight million, so that a
    /// half-line goes about as far as the cube is wide before it hits one. Exactly `n` (1).
    Sticks,
    /// An eroded mountain range over a square of side 2. From 1,000 triangles up within
    /// 2 % of `n`, usually within 0.1 %; below that within its square root (2).
    Terrain,
    /// A museum hall to stand in: walls of two triangles, beams as long as the hall and thin as a
    /// hand, hundreds of planks in one plane, columns, railings, thousands of books, chairs and
    /// rivets, chandeliers, and finely scanned fossils on plinths. Exactly `n` from about 300
    /// triangles up, or one less; below that the next smaller of a few bare halls (10). Planks come
    /// with 60,000 triangles, furniture with half a million.
    Hall,
    /// Haines's sphereflake on a floor: a sphere with nine of a third of its size on it, and so
    /// on. From 600 triangles up within 10 % of `n`, usually within 3 % (116).
    Balls,
    /// Haines's size_factor^3 interlocking gears, 572 triangles each, over a mirror. The size
    /// factor whose number is nearest (574).
    Gears,
    /// Haines's fractal mountain with four glass balls above it. From 1,000 triangles up within
    /// 3 % of `n` (26).
    Mount,
    /// Haines's pyramid of dodecahedral rings, spheres and cylinders, before a wall. From 1,000
    /// triangles up within 10 % of `n`, usually within 3 % (422).
    Rings,
    /// The Utah teapot on a checkerboard, each patch cut into k x k squares; 66 k^2 - 8 k
    /// triangles, and the nearest k (248).
    Teapot,
    /// Haines's Sierpinski tetrahedron; 4^k triangles, and the k nearest in ratio, so between
    /// half and twice `n` (4).
    Tetra,
    /// Haines's tree of conical branches (Aono and Kunii 1984) with spheres at their ends, on a
    /// field. From 600 triangles up within 12 % of `n`, usually within 5 % (58).
    Tree,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Kind; 14] = [
        Kind::Scan,
        Kind::Sphere,
        Kind::Soup,
        Kind::Layers,
        Kind::Sticks,
        Kind::Terrain,
        Kind::Hall,
        Kind::Balls,
        Kind::Gears,
        Kind::Mount,
        Kind::Rings,
        Kind::Teapot,
        Kind::Tetra,
        Kind::Tree,
    ];

    /// The name, as `Display` prints and `FromStr` reads it.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Scan => "scan",
            Kind::Sphere => "sphere",
            Kind::Soup => "soup",
            Kind::Layers => "layers",
            Kind::Sticks => "sticks",
            Kind::Terrain => "terrain",
            Kind::Hall => "hall",
            Kind::Balls => "balls",
            Kind::Gears => "gears",
            Kind::Mount => "mount",
            Kind::Rings => "rings",
            Kind::Teapot => "teapot",
            Kind::Tetra => "tetra",
            Kind::Tree => "tree",
        }
    }

    /// One line that says what it is.
    pub const fn description(self) -> &'static str {
        match self {
            Kind::Scan => "a fossil sea urchin as a laser scanner gives it, closed, finely meshed",
            Kind::Sphere => "a sphere of radius 1",
            Kind::Soup => "unconnected random triangles in the unit cube",
            Kind::Layers => "tilted sheets, stacked ever closer than their triangles are wide",
            Kind::Sticks => "long thin sticks in all directions, what kd-trees like least",
            Kind::Terrain => "an eroded mountain range",
            Kind::Hall => "a museum hall seen from inside: huge walls, thin beams, dense exhibits",
            Kind::Balls => "Haines's sphereflake, mirroring balls on a floor",
            Kind::Gears => "Haines's block of interlocking gears over a mirror",
            Kind::Mount => "Haines's fractal mountain with four glass balls",
            Kind::Rings => "Haines's pyramid of dodecahedral rings",
            Kind::Teapot => "the Utah teapot on a checkerboard, as in Haines's databases",
            Kind::Tetra => "Haines's Sierpinski tetrahedron",
            Kind::Tree => "Haines's tree of conical branches",
        }
    }

    /// True if another seed gives another mesh.
    pub const fn is_random(self) -> bool {
        matches!(
            self,
            Kind::Scan | Kind::Soup | Kind::Sticks | Kind::Terrain | Kind::Hall | Kind::Mount
        )
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Kind {
    type Err = Error;

    fn from_str(name: &str) -> Result<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let names = Kind::ALL.map(Kind::name).join(", ");
            Error::invalid("kind", format!("\"{name}\" is none of {names}"))
        })
    }
}

/// A place to look from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye.
    pub from: Vec3,
    /// A point in the middle of the picture.
    pub at: Vec3,
    /// What is up in the picture.
    pub up: Vec3,
    /// Angle between the picture's lower and upper edge, in degrees.
    pub angle_degrees: f64,
}

/// From where to look at a mesh of this kind, where there is a better place than the automatic
/// one: the camera of the Standard Procedural Databases (meant for a square picture) for Haines's
/// scenes, a place inside the hall, one low over the terrain, one from which the scan shows best.
pub fn suggested_view(kind: Kind) -> Option<View> {
    match kind {
        Kind::Scan => Some(scan::VIEW),
        Kind::Sphere | Kind::Soup | Kind::Layers | Kind::Sticks => None,
        Kind::Terrain => Some(terrain::VIEW),
        Kind::Hall => Some(hall::VIEW),
        Kind::Balls => Some(balls::VIEW),
        Kind::Gears => Some(gears::VIEW),
        Kind::Mount => Some(mount::VIEW),
        Kind::Rings => Some(rings::view()),
        Kind::Teapot => Some(teapot::VIEW),
        Kind::Tetra => Some(tetra::VIEW),
        Kind::Tree => Some(tree::VIEW),
    }
}

/// A mesh of the given kind with about the given number of triangles; [`Kind`] says how near it
/// comes. Reports [`Stage::Load`](halfline::progress::Stage) in triangles to `observer`.
///
/// Coordinates are single precision. The seed changes only the kinds for which
/// [`Kind::is_random`]. `Mesh::materials` is set where the scene has colours of its own.
///
/// # Errors
/// [`Error::Invalid`] if `triangles` is zero, more than a mesh can hold, or more than there is
/// memory for; [`Error::Interrupted`] if `observer` asks for the end.
pub fn generate(kind: Kind, triangles: usize, seed: u64, observer: &dyn Observer) -> Result<Mesh> {
    if triangles == 0 {
        return Err(Error::invalid("number of triangles", "zero, but at least one is needed"));
    }
    if triangles > MAX_TRIANGLES {
        return Err(Error::invalid(
            "number of triangles",
            format!("{triangles} is more than the {MAX_TRIANGLES} that can be generated"),
        ));
    }
    let progress = &SharedProgress::new(observer, Stage::Load, triangles);
    progress.check()?;
    let mesh = match kind {
        Kind::Scan => scan::scan(triangles, seed, progress),
        Kind::Sphere => sphere::sphere(triangles, progress),
        Kind::Soup => soup::soup(triangles, seed, progress),
        Kind::Layers => layers::layers(triangles, progress),
        Kind::Sticks => sticks::sticks(triangles, seed, progress),
        Kind::Terrain => terrain::terrain(triangles, seed, progress),
        Kind::Hall => hall::hall(triangles, seed, progress),
        Kind::Balls => balls::balls(triangles, progress),
        Kind::Gears => gears::gears(triangles, progress),
        Kind::Mount => mount::mount(triangles, seed, progress),
        Kind::Rings => rings::rings(triangles, progress),
        Kind::Teapot => teapot::teapot(triangles, progress),
        Kind::Tetra => tetra::tetra(triangles, progress),
        Kind::Tree => tree::tree(triangles, progress),
    }?;
    progress.finish();
    Ok(mesh)
}

/// A mesh indexes with 32 bits and the soup has three vertices a triangle; 2^30 also leaves room
/// for kinds that come out larger than asked.
const MAX_TRIANGLES: usize = 1 << 30;

#[cfg(test)]
mod tests;
