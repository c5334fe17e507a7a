//! Where rays that leave a surface start, so that they do not hit it again.
//!
//! M. Pharr, W. Jakob, G. Humphreys, "Physically Based Rendering", fourth edition (2023), sections
//! 6.8.4 to 6.8.6: the point on the surface is known up to a bounded rounding error, and the new
//! ray starts just outside that bound, along the surface's normal. A minimal distance along the
//! ray would not do: at grazing angles it would have to be arbitrarily large.
//!
//! Different here:
//!
//! 1. The bound need not cover what the test of the new ray may get wrong about the same triangle:
//!    on which side a ray starts it decides exactly.
//! 2. What counts is the triangle's exact plane. So the normal has an error bound of its own, and
//!    that of a needle is computed exactly; and to which side a ray goes is decided by an exact
//!    sign, since at grazing angles the rounded normal does not know.
//! 3. Underflow is covered as well.

use super::double_double::UNIT_ROUNDOFF;
use super::edge_function::exact_edge_sign;
use super::exact::{BigFloat, DigitRange, ExactNumber, Expansion};
use super::power_of_two::{exponent_of, scale_vector};
use crate::geometry::Vec3;

/// A bound for the relative error of `operations` roundings in a row (Higham 2002, lemma 3.1).
const fn gamma(operations: u32) -> f64 {
    let nu = operations as f64 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// A point on a surface, as well as doubles know it, from which rays can start that do not hit the
/// same surface again. [`Scene::surface_point`](crate::Scene::surface_point) gives that of a hit.
///
/// ```
/// use halfline::{Mesh, Ray, Scene, vec3};
///
/// let corners = [[0.1, 0.2, 0.3], [1.0, 0.3, 0.7], [0.3, 1.0, 0.9]];
/// let scene = Scene::new(Mesh::new(corners, [[0, 1, 2]])?)?;
/// let ray = Ray::new(vec3(0.5, 0.4, 2.0), vec3(-0.1, 0.02, -3.0));
/// let hit = scene.intersect(&[ray])[0];
/// assert!(hit.is_hit());
///
/// // Mirror the ray: it starts above the triangle and leaves it.
/// let surface = scene.surface_point(&hit);
/// let into = ray.direction.dot(surface.normal);
/// let mirrored = ray.direction - surface.normal * (2.0 * into);
/// let reflected = Ray::new(surface.origin_towards(mirrored), mirrored);
/// assert_eq!(scene.occluded(&[reflected]), [false]);
///
/// // Let it through: the same point, but a start below the triangle.
/// let transmitted = Ray::new(surface.origin_towards(ray.direction), ray.direction);
/// assert_eq!(scene.occluded(&[transmitted]), [false]);
/// # Ok::<(), halfline::Error>(())
/// ```
///
/// # What is promised
///
/// The [origin](SurfacePoint::origin_towards) for a direction lies strictly on that side of the
/// triangle's *exact* plane to which the direction *exactly* goes. A ray from there along the
/// direction, with t from 0, never meets the triangle, at whatever angle: no self-hit. This holds
/// wherever the triangle lies and whatever its size and shape, for a face as small as the smallest
/// doubles and for a needle alike, and for directions no longer than 1, or no longer than 2^1000
/// times the triangle's longest edge: beyond that, the negative t of the plane may round to zero.
///
/// The origin is off the plane by some ten roundoffs (2^-53) of the coordinates along the normal
/// and one of the longest edge: for a model of 2 m, some 10^-15 m; at map coordinates of 5 * 10^6 m,
/// up to 10^-8 m.
///
/// # What is not
///
/// The origin need not lie on the same side of *other* triangles' planes. In a concave fold the ray
/// may hit the neighbour, and rightly so; and right at an edge or a vertex the origin may lie
/// beyond a neighbour by as much as it is off the plane. Faces that share the plane exactly, such
/// as duplicates, are not hit either; those that share it but for rounding may be.
///
/// Within 2^-48 of the largest double, points and origins may come out infinite; rays from there
/// are not [valid](crate::Ray::is_valid) and hit nothing.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// The point, rounded.
    pub point: Vec3,
    /// The unit normal, from where the triangle's corners run counter-clockwise. NaN for a triangle
    /// without area or with infinite coordinates, which no ray hits.
    pub normal: Vec3,
    /// How far along the normal origins lie.
    distance: f64,
    /// How far the normal may be from the exact one, as a vector.
    normal_error: f64,
    /// What decides the sides exactly; without them it is the normal itself.
    corners: Option<[Vec3; 3]>,
}

impl SurfacePoint {
    /// The point of a triangle with barycentric weights `u` and `v` of the second and third corner,
    /// as in a [`Hit`](crate::Hit): u, v and 1 - u - v in [0, 1], but for rounding.
    pub fn on_triangle(corners: [Vec3; 3], u: f64, v: f64) -> SurfacePoint {
        let [a, b, c] = corners;
        let (normal, normal_error) = unit_normal(corners);
        let w = 1.0 - u - v;
        let point = a * w + b * u + c * v;

        // Let N be the exact unit normal, and h = N . a, the same for all points of the plane. The
        // two subtractions that gave w left the sum of weights at 1 + e, where e is at most two
        // roundoffs; with these weights the exact sum is off the plane by |e h|, and |h| is no
        // larger than the sum of terms below, but for a factor of 1 + e. One product and two
        // additions follow: five roundoffs of that sum, and a sixth for all products of errors,
        // among them that the shift is along the rounded normal, by at least 1 - 2^-20 of its
        // length. In an axis along which N and the rounded normal point to different sides, where
        // |N| is within the normal's error, the last rounding of the origin goes to the wrong side,
        // by a step and a half: that takes three more roundoffs, and one for what it leaves out.
        let terms = (a * w).abs() + (b * u).abs() + (c * v).abs();
        let slopes = normal.abs() + Vec3::splat(normal_error);
        let point_error = (terms * gamma(10)).dot(slopes);
        // Where all terms are zero, as in a coordinate plane, doubles must tell on which side the
        // start lies nevertheless: otherwise exact arithmetic would have to, which takes longer.
        let longest = (b - a).abs().max((c - a).abs()).max_element().min(f64::MAX);
        let distance = point_error + longest * UNIT_ROUNDOFF + UNDERFLOW_ERROR;
        SurfacePoint { point, normal, distance, normal_error, corners: Some(corners) }
    }

    /// A point of the plane of all p with `normal . p = height`, for a unit normal, found as
    /// `origin + t * direction` with `t = (height - normal . origin) / (normal . direction)`.
    /// `ray_length` is `t` times the length of the direction.
    pub fn on_plane(point: Vec3, normal: Vec3, ray_length: f64) -> SurfacePoint {
        // The largest coordinate of the point is m, the ray's length l, so the origin's length is
        // at most sqrt(3) m + l. The scalar product takes three roundoffs of it, the difference one
        // of l, the scalar product with the direction three of l, the quotient one, product and
        // sum for the point two of l + sqrt(3) m: less than 10 m and 11 l. The rest is for the
        // normal's length and products of errors.
        let scale = point.abs().max_element() + ray_length;
        let distance = scale * gamma(16) + UNDERFLOW_ERROR;
        SurfacePoint { point, normal, distance, normal_error: 0.0, corners: None }
    }

    /// Where a ray along `direction`, of whatever length, starts: just off the surface, on the side
    /// to which the ray goes. Along the surface exactly, either side will do.
    pub fn origin_towards(&self, direction: Vec3) -> Vec3 {
        let side = if self.goes_behind(direction) { -1.0 } else { 1.0 };
        let mut origin = self.point;
        for axis in 0..3 {
            let outward = side * self.normal[axis];
            // The sum rounds to nearest, which could take the shift away again.
            origin[axis] += outward * self.distance;
            if outward > 0.0 {
                origin[axis] = origin[axis].next_up();
            } else if outward < 0.0 {
                origin[axis] = origin[axis].next_down();
            }
        }
        origin
    }

    /// True if the direction goes to the side away from the exact normal; false for NaN.
    fn goes_behind(&self, direction: Vec3) -> bool {
        // Three roundings, the normal's error, and a rounding of this bound itself. After an
        // overflow both sides are infinite, or the product NaN, and nothing is certain.
        let product = direction.dot(self.normal);
        let size = direction.abs().dot(Vec3::splat(1.0));
        let error = size * (self.normal_error + gamma(5)) + UNDERFLOW_ERROR;
        if product.abs() > error { product < 0.0 } else { self.goes_behind_exactly(direction) }
    }

    #[cold]
    fn goes_behind_exactly(&self, direction: Vec3) -> bool {
        if !direction.is_finite() || !self.normal.is_finite() {
            return false;
        }
        match self.corners {
            Some([a, b, c]) => exact_edge_sign(a, direction, b, c) < 0,
            None => {
                let digits = DigitRange::of(&[direction, self.normal]);
                if DigitRange::suits_expansions(digits, DigitRange::OF_ONE) {
                    exact_product_sign::<Expansion>(direction, self.normal) < 0
                } else {
                    exact_product_sign::<BigFloat>(direction, self.normal) < 0
                }
            }
        }
    }
}

/// The sign of `a . b`.
fn exact_product_sign<N: ExactNumber>(a: Vec3, b: Vec3) -> i8 {
    (0..3).fold(N::default(), |sum, i| sum.plus(&N::difference(a[i], 0.0).scaled(b[i]))).sign()
}

/// What underflow may add, in 2^-1074: half a step for each of three products in each coordinate of
/// a point, and as much for the shift and its length; less than 5, and three steps are left.
const UNDERFLOW_ERROR: f64 = f64::from_bits(8);

/// The unit normal of a triangle by the right-hand rule, and a bound for the length of its
/// difference from the exact one. NaN if the triangle has none.
fn unit_normal([a, b, c]: [Vec3; 3]) -> (Vec3, f64) {
    // Bring the largest coordinate of each edge into [1, 2), which changes only lengths. Where an
    // edge overflows, take a quarter of it.
    let scaled_edge = |corner: Vec3| {
        let edge = corner - a;
        let edge = if edge.is_finite() { edge } else { corner * 0.25 - a * 0.25 };
        scale_vector(edge, -exponent_of(edge.abs().max_element()))
    };
    let (p, q) = (scaled_edge(b), scaled_edge(c));

    // Compute the vector product, and its permanents for the error.
    let product = p.cross(q);
    let (p, q) = (p.abs(), q.abs());
    let mut permanents = Vec3::ZERO;
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        permanents[axis] = p[next] * q[last] + p[last] * q[next];
    }
    let length = product.length();
    let error = 2.0 * MINOR_ERROR * permanents.length() / length + NORMALIZATION_ERROR;
    if error <= MAX_NORMAL_ERROR && length > MIN_LENGTH {
        return (product / length, error);
    }
    (exact_unit_normal([a, b, c]), NORMALIZATION_ERROR + gamma(2))
}

/// The unit normal of a triangle, from a vector product whose coordinates are rounded only in the end.
#[cold]
fn exact_unit_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    const NONE: Vec3 = Vec3::splat(f64::NAN);
    if ![a, b, c].into_iter().all(Vec3::is_finite) {
        return NONE;
    }
    let component = |axis: usize| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let ab = |i: usize| BigFloat::difference(b[i], a[i]);
        let ac = |i: usize| BigFloat::difference(c[i], a[i]);
        ab(next).times(&ac(last)).minus(&ab(last).times(&ac(next)))
    };
    let product = [0, 1, 2].map(component);

    // Divide by the largest coordinate, which may itself be out of range.
    let mut largest = &product[0];
    for other in &product[1..] {
        if other.sign() != 0 && (largest.sign() == 0 || other.quotient(largest).abs() > 1.0) {
            largest = other;
        }
    }
    if largest.sign() == 0 {
        return NONE;
    }
    let sign = f64::from(largest.sign());
    Vec3::from([0, 1, 2].map(|i| sign * product[i].quotient(largest))).normalized()
}

/// Relative error, in terms of the permanent, of a 2 x 2 determinant of rounded differences:
/// `ccwerrboundA` of Shewchuk's `orient2d`, rounded up. The direction of a vector is off by at most
/// the relative error of its length; where that is no more than [`MAX_NORMAL_ERROR`], the doubling
/// covers that the length is the computed one, as well as what underflows.
const MINOR_ERROR: f64 = 4.0 * UNIT_ROUNDOFF;

/// Of a vector divided by its length: three roundings in the square, halved by the root, the
/// root's, and the quotient's.
const NORMALIZATION_ERROR: f64 = gamma(4);

/// Up to here a computed normal will do: a unit vector that is off by this reaches along the exact
/// one at least 1 - 2^-20.
const MAX_NORMAL_ERROR: f64 = 1.0 / 1024.0;

/// The square of a longer vector is clear of underflow.
const MIN_LENGTH: f64 = f64::from_bits((1023 - 400) << 52);
