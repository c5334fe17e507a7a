//! Where rays that leave a surface start, so that they do not hit it again.
//!
//! pbrt-v4, sections 6.8.4 to 6.8.6: the point on the surface is known up to a bounded rounding
//! error, and the new ray starts just outside that bound, along the surface's normal. A
//! minimal distance along the ray would not do: at grazing angles it would have to be
//! arbitrarily large. Different from pbrt, the bound need not cover what the test of the new ray
//! may get wrong about this same triangle: on which side a ray starts it decides exactly.

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

        // The point lies on the plane for whatever u and v, so only what is rounded from here on
        // counts. The two subtractions that gave w left an error of at most a roundoff of 1 each,
        // and an error d moves the point by d |n . a| off the plane; n . a is the same for all
        // points of the plane, hence no larger than the sum of terms below. One product and two
        // additions follow: five roundoffs of that sum, and two for the sum itself.
        let terms = (a * w).abs() + (b * u).abs() + (c * v).abs();
        let point_error = terms.dot(normal.abs()) * gamma(7);
        // Where all terms are zero, as in a coordinate plane, the start must lie off the plane
        // nevertheless, by a length whose products with the edges do not underflow.
        let longest = edge_1.length().max(edge_2.length());
        SurfacePoint { point, normal, distance_error: point_error + longest * gamma(1) }
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
    use crate::sampling::Sampler;
    use halfline::geometry::{Ray, vec3};
    use halfline::mesh::Positions;
    use halfline::{Mesh, Scene};

    /// A ray from a triangle never hits that triangle, whatever its place, size and shape: also in
    /// coordinate planes, far from the origin and for needles.
    #[test]
    fn rays_do_not_hit_the_triangle_they_start_on() {
        let sampler = Sampler::new(1, 2, 3);
        let mut dimension = 0;
        let mut random = || {
            dimension += 1;
            let [x, y] = sampler.square(dimension, 0, 1);
            let [z, share] = sampler.square(dimension, 1, 2);
            (vec3(x, y, z) * 2.0 - Vec3::splat(1.0), share)
        };
        for round in 0..2000 {
            let size = [1e-20, 1.0, 1e20][round % 3];
            let thickness = [1.0, 1e-6, 1e-9][round / 3 % 3];
            let place = [0.0, 1.0, 1e6][round / 9 % 3];
            let offset = random().0 * (size * place);
            let mut edges = [random().0, random().0];
            edges[1] = edges[0] * random().1 + edges[1] * thickness;
            if round % 5 == 0 {
                edges = edges.map(|edge| vec3(edge.x, 0.0, edge.z));
            }
            let flat = round % 10 == 0;
            let offset = if flat { vec3(offset.x, 0.0, offset.z) } else { offset };
            let [b, c] = edges.map(|edge| offset + edge * size);
            let corners = [offset, b, c];
            let positions = Positions::F64(corners.map(|corner| corner.to_array()).to_vec());
            let scene = Scene::new(Mesh::new(positions, vec![[0, 1, 2]]).unwrap()).unwrap();
            for _ in 0..10 {
                let ((direction, u), (_, share)) = (random(), random());
                let at = SurfacePoint::on_triangle(corners, u, (1.0 - u) * share);
                let direction = direction.normalized();
                let ray = Ray::new(at.origin_towards(direction), direction);
                assert!(!scene.any(&ray), "round {round}: {ray:?} on {corners:?}");
            }
        }
    }

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
