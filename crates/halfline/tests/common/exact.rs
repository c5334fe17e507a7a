//! The judge in rational arithmetic: for any coordinates, and slow. It shares no code with what it
//! judges.

use std::cell::OnceCell;
use std::collections::HashSet;

use halfline::{Mesh, Ray, Vec3};
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use super::contact::ExactContact;

pub type Q = BigRational;
pub type Point = [Q; 3];

pub fn exact_double(x: f64) -> Q {
    Q::from_float(x).expect("finite")
}

pub fn exact(v: Vec3) -> Point {
    v.to_array().map(exact_double)
}

pub fn minus(a: &Point, b: &Point) -> Point {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

pub fn cross(a: &Point, b: &Point) -> Point {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

pub fn dot(a: &Point, b: &Point) -> Q {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// The exact t, u, v of the line's meeting with the closed triangle: solves
/// origin + t direction = a + u (b - a) + v (c - a) by Cramer's rule.
pub fn meeting(ray: &Ray, corners: [Vec3; 3]) -> Option<[Q; 3]> {
    meeting_of_points(&exact(ray.origin), &exact(ray.direction), &corners.map(exact))
}

/// [`meeting`] for coordinates that no double may hold.
pub fn meeting_of_points(
    origin: &Point,
    direction: &Point,
    [a, b, c]: &[Point; 3],
) -> Option<[Q; 3]> {
    let (ab, ac, ao) = (minus(b, a), minus(c, a), minus(origin, a));
    let normal = cross(&ab, &ac);
    let determinant = -dot(direction, &normal);
    if determinant.is_zero() {
        return None;
    }
    let weight = |numerator: Q| Some(-numerator / &determinant).filter(|w| !w.is_negative());
    let u = weight(dot(direction, &cross(&ao, &ac)))?;
    let v = weight(dot(direction, &cross(&ab, &ao)))?;
    let t = dot(&ao, &normal) / &determinant;
    (&u + &v <= Q::from_integer(1.into())).then_some([t, u, v])
}

/// True if the line crosses the triangle once its origin is moved by the infinitesimal
/// (e, e^2, e^3). That adds `(e, e^2, e^3) . (p - q) x direction` to the side of the edge from p to
/// q on which the line passes, so the components of that product decide where the side is zero.
pub fn crosses(ray: &Ray, corners: [Vec3; 3]) -> bool {
    let (origin, direction) = (exact(ray.origin), exact(ray.direction));
    let corners = corners.map(|corner| minus(&exact(corner), &origin));
    let sides = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let (p, q) = (&corners[i], &corners[j]);
        let moved = cross(&minus(p, q), &direction);
        let terms = [dot(&direction, &cross(p, q))].into_iter().chain(moved);
        terms.map(|term| term.cmp(&Q::zero())).find(|order| order.is_ne())
    });
    sides[0].is_some() && sides[0] == sides[1] && sides[1] == sides[2]
}

/// True if the corners run counter-clockwise for someone who looks along the direction.
pub fn is_front(ray: &Ray, corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(exact);
    dot(&exact(ray.direction), &cross(&minus(&b, &a), &minus(&c, &a))).is_negative()
}

/// Every contact of the line along `ray` with the mesh at a t that a double can hold, whatever the
/// ray's own range; none if origin or direction are not finite, or the direction is zero.
pub fn contacts(mesh: &Mesh, ray: &Ray) -> Vec<ExactContact> {
    let is_finite = |v: Vec3| v.to_array().into_iter().all(f64::is_finite);
    if !is_finite(ray.origin) || !is_finite(ray.direction) {
        return Vec::new();
    }
    let open_edges = OnceCell::new();
    let border = || open_edges.get_or_init(|| border(mesh));
    let contact = |face: u32| {
        let corners = mesh.corners(face);
        if !corners.into_iter().all(is_finite) {
            return None;
        }
        let [t, u, v] = meeting(ray, corners)?;
        let is_on_border = is_on_border(corners, &u, &v, border);
        let [t, u, v] = [t, u, v].map(|x| nearest_double(&x));
        let is_crossing = crosses(ray, corners);
        t.is_finite().then_some(ExactContact { face, t, u, v, is_crossing, is_on_border })
    };
    (0..mesh.triangle_count() as u32).filter_map(contact).collect()
}

/// A place of the mesh: the bits of its coordinates, and +0 for either zero.
type Place = [u64; 3];

fn place(point: Vec3) -> Place {
    point.to_array().map(|x| (x + 0.0).to_bits())
}

/// The edges, in both directions, that an odd number of triangles have whose corners are finite and
/// in three places.
fn border(mesh: &Mesh) -> HashSet<[Place; 2]> {
    let mut odd = HashSet::new();
    for face in 0..mesh.triangle_count() as u32 {
        let corners = mesh.corners(face);
        let places = corners.map(place);
        let apart = HashSet::from(places).len() == 3;
        if apart && corners.iter().all(|v| v.to_array().into_iter().all(f64::is_finite)) {
            for [i, j] in [[0, 1], [1, 0], [1, 2], [2, 1], [2, 0], [0, 2]] {
                // One more makes it even, and one more than that odd again.
                if !odd.remove(&[places[i], places[j]]) {
                    odd.insert([places[i], places[j]]);
                }
            }
        }
    }
    odd
}

/// True if the point of a triangle with these weights of its second and third corner is inside an
/// edge of the border, or is the end of one. The border is asked for only where it is needed.
fn is_on_border<'a>(
    corners: [Vec3; 3],
    u: &Q,
    v: &Q,
    border: impl Fn() -> &'a HashSet<[Place; 2]>,
) -> bool {
    let weights = [Q::from_integer(1.into()) - u - v, u.clone(), v.clone()];
    let ends: Vec<Place> = weights
        .iter()
        .zip(corners)
        .filter(|(weight, _)| !weight.is_zero())
        .map(|(_, corner)| place(corner))
        .collect();
    match *ends {
        [corner] => border().iter().any(|[from, _]| *from == corner),
        [p, q] => border().contains(&[p, q]),
        _ => false,
    }
}

/// Round to nearest, ties to even, by bisection over exact comparisons.
pub fn nearest_double(value: &Q) -> f64 {
    if value.is_zero() {
        return 0.0;
    }
    let mut best = value.to_f64().expect("a quotient");
    if best.is_infinite() {
        // What lies less than half a step beyond the largest double is rounded down to it.
        let [largest, half_step] =
            [f64::MAX, 2f64.powi(970)].map(|x| Q::from_float(x).expect("finite"));
        return if value.abs() < largest + half_step { f64::MAX.copysign(best) } else { best };
    }
    for _ in 0..4 {
        for candidate in [best.next_down(), best.next_up()] {
            if candidate.is_infinite() {
                continue;
            }
            let distance = |x: f64| (Q::from_float(x).expect("finite") - value).abs();
            let (new, old) = (distance(candidate), distance(best));
            if new < old || (new == old && candidate.to_bits() & 1 == 0) {
                best = candidate;
            }
        }
    }
    // No negative zero, also where a negative value is nearest to zero.
    best + 0.0
}
