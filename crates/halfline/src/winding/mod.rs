//! Winding numbers, and what is inside: how often a surface winds around a point.
//!
//! Martens, Trettner, Bessmeltsev, "The Antipodal Method for the Generalized Winding Number" (SIGGRAPH
//! 2026): the winding number of p, the sum of the signed solid angles of all triangles over that of the sphere,
//! is the number of signed crossings of one ray from p along a direction d, and a share of the boundary alone:
//! over its net edges (a, b) the sum of the solid angles of the spherical triangles (-d, a - p, b - p).
//! Different here:
//!
//! 1. Crossings are those of all hits (`traverse/crossing_sum.rs`), each decided exactly; the angles of edges
//!    that the ray passes through or nearly so are on the side that the crossings took
//!    (`numeric/solid_angle.rs`). So without a boundary the number is an exact integer, and with one it is
//!    right within a bound for all points.
//! 2. The boundary is summed over a hierarchy (`hierarchy.rs`) with a bound, and for [`Scene::contains`] no more
//!    closely than the answer needs.
//!
//! [`Scene::contains`]: crate::Scene::contains

mod boundary;
mod hierarchy;
mod multipole;

pub use boundary::Boundary;
pub use hierarchy::{Precision, Share};

use std::str::FromStr;

use crate::batch::in_chunks;
use crate::error::{Error, Result};
use crate::geometry::{Ray, Vec3};
use crate::numeric::WINDING_DIRECTION;
use crate::progress::Observer;
use crate::rays::{Column, RayColumns, RaySource, Vectors};
use crate::traverse::{
    AllContacts, Answers, CancelCheck, Cast, Caster, CrossingSum, CrossingSums, SignedCrossing,
    Target, cast, is_on_face,
};

/// What is inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Inside {
    /// Points whose winding number is above one half.
    #[default]
    Winding,
    /// Points from which a ray has an odd number of crossings: for surfaces whose triangles are not oriented
    /// alike. On open surfaces it depends on the ray.
    Parity,
}

impl FromStr for Inside {
    type Err = Error;

    /// The rule of a name, "winding" or "parity".
    fn from_str(name: &str) -> Result<Inside> {
        match name {
            "winding" => Ok(Inside::Winding),
            "parity" => Ok(Inside::Parity),
            _ => {
                let found = format!("expected 'winding' or 'parity', found '{name}'");
                Err(Error::invalid("rule", found))
            }
        }
    }
}

/// The parts of a point's winding number: [`Scene::explain_winding`](crate::Scene::explain_winding) gives them.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WindingParts {
    /// The direction of the ray whose crossings are counted.
    pub direction: Vec3,
    /// The faces that the ray crosses, by face, each with 1 if it leaves a solid there and -1 if it enters one.
    pub crossings: Vec<(u32, i8)>,
    /// The boundary's share.
    pub boundary: f64,
    /// The exact share differs by at most this.
    pub boundary_error: f64,
    /// The winding number: the sum of the signs and of the boundary's share; NaN for a point that is not finite.
    pub winding_number: f64,
    /// True if the point lies on a triangle that can be hit. Then the winding number is that of one of the
    /// sides, or, on the border, between them.
    pub is_on_surface: bool,
}

/// Points that a thread takes at a time: a ray for each.
const CHUNK: usize = 1 << 12;

/// Points seen from the boundary between two looks at the observer.
const POINTS_PER_CHECK: usize = 1 << 7;

/// What points are asked about.
#[derive(Clone, Copy)]
pub struct WindingTarget<'a> {
    /// The tree and the mesh.
    pub target: Target<'a>,
    /// The mesh's boundary.
    pub boundary: &'a Boundary,
}

impl WindingTarget<'_> {
    /// The winding number of each point; NaN for one that is not finite.
    pub fn winding_numbers(
        &self,
        points: Vectors,
        numbers: &mut [f64],
        observer: &dyn Observer,
    ) -> Result<()> {
        self.for_each(points, numbers, observer, |point, crossings| {
            if !point.is_finite() {
                return f64::NAN;
            }
            f64::from(crossings.signed) + self.share(point, Precision::Fine).share
        })
    }

    /// Whether each point is inside, or on the surface; false for one that is not finite.
    pub fn contains(
        &self,
        points: Vectors,
        rule: Inside,
        flags: &mut [bool],
        observer: &dyn Observer,
    ) -> Result<()> {
        self.for_each(points, flags, observer, |point, crossings| {
            if !point.is_finite() {
                return false;
            }
            let is_inside = match rule {
                Inside::Winding => self.winds(point, crossings.signed),
                Inside::Parity => crossings.count % 2 == 1,
            };
            is_inside || self.is_on_surface(point, crossings.is_on_surface)
        })
    }

    /// The parts of the winding number of a point.
    pub fn explain(&self, point: Vec3) -> WindingParts {
        let ray = Ray::new(point, WINDING_DIRECTION);
        let (crossings, is_met) = Caster::new(self.target).signed_crossings(&ray);
        let is_finite = point.is_finite();
        let Share { share, error } =
            if is_finite { self.share(point, Precision::Fine) } else { Share::default() };
        let signed = |crossing: &SignedCrossing| (crossing.face, crossing.sign);
        let sum: i32 = crossings.iter().map(|crossing| i32::from(crossing.sign)).sum();
        WindingParts {
            direction: WINDING_DIRECTION,
            crossings: crossings.iter().map(signed).collect(),
            boundary: share,
            boundary_error: error,
            winding_number: if is_finite { f64::from(sum) + share } else { f64::NAN },
            is_on_surface: is_finite && self.is_on_surface(point, is_met),
        }
    }

    fn share(&self, point: Vec3, precision: Precision) -> Share {
        self.boundary.hierarchy.share(point, precision)
    }

    /// True if the winding number of a point is above one half: the boundary is looked at until that is
    /// certain. Where even every edge by itself leaves it open, the winding number is as good as one half, and
    /// not above.
    fn winds(&self, point: Vec3, crossings: i32) -> bool {
        for precision in [Precision::Coarse, Precision::Fine, Precision::Exhaustive] {
            let Share { share, error } = self.share(point, precision);
            let above = f64::from(crossings) - 0.5 + share;
            if above.abs() > error {
                return above > 0.0;
            }
        }
        false
    }

    /// True if a point lies on a triangle, one that its ray meets or one along the ray.
    fn is_on_surface(&self, point: Vec3, is_met: bool) -> bool {
        let Target { tree, mesh, .. } = self.target;
        is_met || self.boundary.has_parallel_faces && is_on_face(tree, mesh, point)
    }

    /// Counts the crossings of a ray from each point, and puts what `answer` makes of them.
    fn for_each<A: Send>(
        &self,
        points: Vectors,
        places: &mut [A],
        observer: &dyn Observer,
        answer: impl Fn(Vec3, CrossingSum) -> A + Sync,
    ) -> Result<()> {
        let (direction, from, to) = (
            Column::Same(WINDING_DIRECTION.to_array()),
            Column::Same(0.0),
            Column::Same(f64::INFINITY),
        );
        let rays = RayColumns::new(places.len(), points, direction, from, to)?;
        let rays = RaySource::Columns(rays);
        let parts = places.chunks_mut(CHUNK).collect();
        let chunks = in_chunks(
            self.target,
            (rays, CHUNK),
            parts,
            observer,
            |target, rays, places: &mut [A]| {
                let mut sums = vec![CrossingSum::default(); rays.len()];
                let (crossings, cancel) = (Vec::new(), CancelCheck::new(observer));
                let answers =
                    Answers::Crossings(CrossingSums { sums: &mut sums, crossings, cancel });
                cast::<AllContacts>(Cast::new(target, rays, answers));
                for (number, (place, sum)) in places.iter_mut().zip(sums).enumerate() {
                    if number % POINTS_PER_CHECK == 0 {
                        observer.check()?;
                    }
                    *place = answer(rays.ray(number).origin, sum);
                }
                Ok(())
            },
        )?;
        chunks.into_iter().collect()
    }
}
