//! What a ray must do, and whether it did.

use crate::topology::Target;
use halfline::geometry::{Hit, Ray, Vec3};
use halfline::mesh::Mesh;

/// What is wrong with a ray's hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wrong {
    /// The ray hits nothing, though it must.
    pub leak: bool,
    /// The crossings of the ray are even in number, though it begins inside.
    pub parity: bool,
    /// The ray hits something, but behind what it must meet first.
    pub late: bool,
}

/// Judges one ray by its closest hit and its crossings, sorted by t. `certain`: it meets a face at
/// t = 1.
pub fn judge(from_inside: bool, certain: bool, closest: &Hit, crossings: &[Hit]) -> Wrong {
    let first_crossing = crossings.first().map_or(f64::INFINITY, |hit| hit.t);
    let latest = if certain { first_crossing.min(1.0) } else { first_crossing };
    let must_hit = from_inside || latest < f64::INFINITY;
    Wrong {
        leak: must_hit && !closest.is_hit(),
        parity: from_inside && crossings.len().is_multiple_of(2),
        late: closest.is_hit() && closest.t > latest,
    }
}

/// True if it is certain that `ray`, aimed at `target`, meets the target's face at t = 1: its
/// direction is the target less the origin without rounding, the target lies on the face without
/// rounding, and the origin lies off the face's plane.
pub fn certainly_meets(ray: &Ray, target: Target, mesh: &Mesh) -> bool {
    let corners = mesh.corners(target.face());
    let [a, b, c] = corners;
    if ![a, b, c, ray.origin].iter().all(|p| p.to_array().into_iter().all(is_tame)) {
        return false;
    }
    let aim = target.position(mesh);
    let is_exact = match target {
        Target::Vertex { .. } => true,
        Target::EdgeMidpoint { edge, .. } => {
            let (from, to) = (corners[edge as usize], corners[(edge as usize + 1) % 3]);
            // Halving is exact, and so is the sum of the halves if neither half is lost in it.
            (0..3).all(|axis| sum_is_exact(aim[axis], from[axis] * 0.5, to[axis] * 0.5))
        }
    };
    let point = |p: Vec3| robust::Coord3D { x: p.x, y: p.y, z: p.z };
    is_exact
        && (0..3).all(|i| sum_is_exact(aim[i], ray.origin[i], ray.direction[i]))
        && robust::orient3d(point(a), point(b), point(c), point(ray.origin)) != 0.0
}

/// True if `sum` is `a + b` exactly, be it that sum rounded or `b` a difference rounded: Knuth's
/// two-sum finds no error.
fn sum_is_exact(sum: f64, a: f64, b: f64) -> bool {
    let rounded = a + b;
    let b_part = rounded - a;
    let error = (a - (rounded - b_part)) + (b - b_part);
    rounded == sum && error == 0.0
}

/// Zero, or of a size in [2^-200, 2^200]: all its bits lie above 2^-253, those of the products of
/// three differences of such numbers above 2^-759, where `orient3d` is exact.
fn is_tame(coordinate: f64) -> bool {
    const LEAST: f64 = f64::from_bits((1023 - 200) << 52);
    const MOST: f64 = f64::from_bits((1023 + 200) << 52);
    coordinate == 0.0 || (LEAST..=MOST).contains(&coordinate.abs())
}
