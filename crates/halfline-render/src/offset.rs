//! Where rays that leave a surface start, so that they do not hit it again.
//!
//! pbrt-v4, sections 6.8.4 to 6.8.6: the point on the surface is known up to a bounded rounding
//! error, and the new ray starts just outside that bound, along the surface's normal. A
//! minimal distance along the ray would not do: at grazing angles it would have to be
//! arbitrarily large. Different from pbrt, the bound also covers what the intersection test of
//! the next ray may get wrong about this same triangle.

use halfline::geometry::Vec3;

/// A bound for the relative error of `operations` roundings in a row (Higham 2002, lemma 3.1).
const fn gamma(operations: u32) -> f64 {
    let nu = operations as f64 * (f64::EPSILON / 2.0);
    nu / (1.0 - nu)
}

/// A point interpolated on a triangle, its unit normal by the right-hand rule, and how far the
/// true plane may be from it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    pub(crate) point: Vec3,
    pub(crate) normal: Vec3,
    distance_error: f64,
}

impl SurfacePoint {
    /// The point with barycentric weights `u` and `v` of the second and third corner.
    pub(crate) fn on_triangle(corners: [Vec3; 3], u: f64, v: f64) -> SurfacePoint {
        let [a, b, c] = corners;
        let (edge_1, edge_2) = (b - a, c - a);
        let scaled_normal = edge_1.cross(edge_2);
        let normal = scaled_normal.normalized();
        let w = 1.0 - u - v;
        let point = a * w + b * u + c * v;

        // Two additions after one product each, and the two subtractions that gave w: six
        // roundings, and one for the sum below.
        let terms = (a * w).abs() + (b * u).abs() + (c * v).abs();
        let point_error = terms.dot(normal.abs()) * gamma(7);

        // A test computes the distance as edge_2 . (s x edge_1) / |normal| with s from the
        // corner to the ray's origin, thus |s| <= the longer edge: eight roundings of terms no
        // larger than |edge_1| |edge_2| |s|. For needles this bound grows beyond measure; but a
        // start further off than a millionth of the edge would be seen.
        let (length_1, length_2) = (edge_1.length(), edge_2.length());
        let longest = length_1.max(length_2);
        let test_error = length_1 * length_2 * longest * gamma(8) / scaled_normal.length();
        // The difference s itself starts from rounded coordinates.
        let origin_error = point.abs().dot(normal.abs()) * gamma(2);
        let seen = longest * (0.5_f64).powi(20);
        SurfacePoint {
            point,
            normal,
            distance_error: point_error + origin_error + test_error.min(seen),
        }
    }

    /// A point computed on a plane from a ray's parameter.
    pub(crate) fn on_plane(point: Vec3, normal: Vec3, ray_length: f64) -> SurfacePoint {
        // Product and sum for the point, and as many for its distance along the ray.
        let scale = point.abs().max_element() + ray_length;
        SurfacePoint { point, normal, distance_error: scale * gamma(16) }
    }

    /// Where a ray along `direction` starts: on the side of the surface to which it goes.
    pub(crate) fn origin_towards(&self, direction: Vec3) -> Vec3 {
        let side = if direction.dot(self.normal) < 0.0 { -1.0 } else { 1.0 };
        let shift = self.normal * (side * self.distance_error);
        let mut origin = self.point + shift;
        // The sum rounds to nearest, which could take the shift away again.
        for axis in 0..3 {
            if shift[axis] > 0.0 {
                origin[axis] = origin[axis].next_up();
            } else if shift[axis] < 0.0 {
                origin[axis] = origin[axis].next_down();
            }
        }
        origin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::geometry::vec3;

    /// The start must lie strictly on the ray's side of the exact plane. The plane's sign is
    /// computed without rounding: the corners' coordinates are chosen so that an integer holds it.
    #[test]
    fn starts_lie_on_their_side_of_the_plane() {
        let corners = [
            vec3(1_000_003.0, 5.0, -7.0),
            vec3(1_000_019.0, -11.0, 3.0),
            vec3(999_983.0, 2.0, 13.0),
        ];
        let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        for i in 0..1000 {
            let u = f64::from(i) / 1000.0;
            let v = (1.0 - u) * (f64::from(i * 37 % 1000) / 1000.0);
            let at = SurfacePoint::on_triangle(corners, u, v);
            for direction in [n, -n, vec3(0.3, 0.2, 0.9), vec3(-0.3, 0.5, -0.1)] {
                let origin = at.origin_towards(direction);
                // Exact to 2^-60: the differences have few bits, their products are summed in
                // twice the precision.
                let distance = exact_dot(n, origin - corners[0]);
                assert_eq!(distance > 0.0, direction.dot(n) > 0.0, "u {u} v {v}");
                assert!((origin - at.point).length() < 1e-8);
            }
        }
    }

    fn exact_dot(a: Vec3, b: Vec3) -> f64 {
        let mut sum = 0.0;
        let mut rest = 0.0;
        for axis in 0..3 {
            let product = a[axis] * b[axis];
            rest += f64::mul_add(a[axis], b[axis], -product);
            let next = sum + product;
            let virtual_part = next - sum;
            rest += (sum - (next - virtual_part)) + (product - virtual_part);
            sum = next;
        }
        sum + rest
    }
}
