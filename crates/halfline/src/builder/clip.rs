//! The two parts of a triangle on either side of a plane, within a cell.
//!
//! I. E. Sutherland, G. W. Hodgman, "Reentrant polygon clipping", CACM 17 (1974), in double
//! precision, and conservatively: every plane is moved outwards by [`CLIP_ERROR`] before clipping,
//! and the resulting box is rounded outwards. So a part is called empty only if it is.

use crate::geometry::Vec3;
use crate::numeric::{FRAME_ERROR, round_down, round_up};
use crate::tree::Bounds;

/// Corners of a clipped polygon lie this near to where they should. A corner of the triangle is
/// off by [`FRAME_ERROR`]; each of the seven clips computes new corners on the line between two
/// old ones, off by as much and a few roundings of coordinates of that size: below 8 more each,
/// 57 in all. Four times that leaves room for the roundings of moving the planes.
const CLIP_ERROR: f64 = 4.0 * 57.0 * FRAME_ERROR;

/// A triangle gains at most one corner by each of seven clips.
const MAX_CORNERS: usize = 10;

/// A convex polygon.
struct Polygon {
    corners: [Vec3; MAX_CORNERS],
    count: usize,
}

impl Polygon {
    /// The part with `sign * coordinate <= sign * limit`, where sign is 1 or -1.
    fn clipped(&self, axis: usize, limit: f64, sign: f64) -> Polygon {
        let mut clipped = Polygon { corners: self.corners, count: 0 };
        for i in 0..self.count {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % self.count]);
            let (from_out, to_out) = (sign * (from[axis] - limit), sign * (to[axis] - limit));
            if from_out <= 0.0 {
                clipped.push(from);
            }
            if (from_out < 0.0 && to_out > 0.0) || (from_out > 0.0 && to_out < 0.0) {
                let share = (limit - from[axis]) / (to[axis] - from[axis]);
                clipped.push(from + (to - from) * share);
            }
        }
        clipped
    }

    fn push(&mut self, corner: Vec3) {
        // Rounding could make a polygon that is thinner than CLIP_ERROR zigzag across a plane, so
        // that it gains more corners than a convex one can. Such corners add nothing to the box
        // beyond CLIP_ERROR: they lie on the lines between the others.
        if self.count < MAX_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    /// The box around the polygon, widened by [`CLIP_ERROR`] and rounded outwards.
    fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for axis in 0..3 {
            let (low, high) = self
                .corners()
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), corner| {
                    (low.min(corner[axis]), high.max(corner[axis]))
                });
            bounds.min[axis] = round_down(low - CLIP_ERROR);
            bounds.max[axis] = round_up(high + CLIP_ERROR);
        }
        bounds
    }
}

/// The boxes of the parts of a triangle in `bounds` that lie below and above the plane; `None` for
/// a part that is empty. `corners` are in frame coordinates.
pub fn split_triangle(
    corners: [Vec3; 3],
    bounds: &Bounds,
    axis: usize,
    plane: f32,
) -> [Option<Bounds>; 2] {
    // Clip the triangle to the box that it was referenced by, where it reaches out of it.
    let [a, b, c] = corners;
    let mut polygon = Polygon { corners: [a; MAX_CORNERS], count: 3 };
    polygon.corners[..3].copy_from_slice(&[a, b, c]);
    for side in 0..3 {
        for (limit, sign) in [(bounds.min[side], -1.0), (bounds.max[side], 1.0)] {
            let limit = f64::from(limit) + sign * CLIP_ERROR;
            if polygon.corners().iter().any(|corner| sign * corner[side] > sign * limit) {
                polygon = polygon.clipped(side, limit, sign);
            }
        }
    }

    // Clip the rest to either side of the plane.
    [1.0, -1.0].map(|sign| {
        let part = polygon.clipped(axis, f64::from(plane) + sign * CLIP_ERROR, sign);
        let mut side = *bounds;
        if sign > 0.0 {
            side.max[axis] = plane;
        } else {
            side.min[axis] = plane;
        }
        let part = part.bounds().intersection(&side);
        (!part.is_empty()).then_some(part)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vec3;

    const CUBE: Bounds = Bounds { min: [-1.0; 3], max: [1.0; 3] };

    #[test]
    fn a_right_triangle_is_cut_tightly() {
        let corners = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(-1.0, 1.0, 0.0)];
        let [below, above] = split_triangle(corners, &CUBE, 0, 0.5).map(|b| b.expect("not empty"));
        assert_eq!((below.min[0], below.max[0]), (-1.0, 0.5));
        assert_eq!((above.min[0], above.max[0]), (0.5, 1.0));
        // On x >= 0.5 the triangle reaches up to y = -0.5 only.
        assert!(above.max[1] >= -0.5 && above.max[1] < -0.499_99, "{above:?}");
    }

    #[test]
    fn a_part_outside_of_the_cell_is_empty() {
        // The diagonal triangle passes the cell's upper corner; above x = 0.5 it has left the cell.
        let cell = Bounds { min: [0.0, 0.0, -1.0], max: [1.0, 0.25, 1.0] };
        let corners = [vec3(0.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(0.9, 1.0, 0.1)];
        let [below, above] = split_triangle(corners, &cell, 0, 0.5);
        assert!(below.is_some() && above.is_none(), "{below:?} {above:?}");
    }

    /// Points of the triangle are in one of the parts' boxes, whatever the plane.
    #[test]
    fn no_point_is_lost() {
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
        };
        for round in 0..20_000 {
            // Every other triangle is a sliver; every third plane touches a corner.
            let mut a = vec3(random(), random(), random());
            let mut b = vec3(random(), random(), random());
            let thin = if round % 2 == 0 { 1.0 } else { 1e-15 };
            let mut c = a + (b - a) * random() + vec3(random(), random(), random()) * thin;
            let axis = round % 3;
            if round % 7 == 0 {
                // Level but for a few roundings, at a height where a box may end.
                let (height, level) = (f64::from(random() as f32), (axis + 1) % 3);
                for corner in [&mut a, &mut b, &mut c] {
                    corner[level] = height + (random() * 1.5).round() * FRAME_ERROR;
                }
            }
            let plane = if round % 5 == 0 { a[axis] } else { random() } as f32;
            let cell = Bounds {
                min: [0, 1, 2].map(|_| round_down(random() - 0.5)),
                max: [0, 1, 2].map(|_| round_up(random() + 0.5)),
            };
            if !(cell.min[axis] < plane && plane < cell.max[axis]) {
                continue;
            }
            let parts = split_triangle([a, b, c], &cell, axis, plane);
            for _ in 0..20 {
                let (u, v) = (random().abs(), random().abs());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let p = a * (1.0 - u - v) + b * u + c * v;
                let inside = |b: &Bounds| {
                    (0..3).all(|i| f64::from(b.min[i]) <= p[i] && p[i] <= f64::from(b.max[i]))
                };
                if inside(&cell) {
                    assert!(parts.iter().flatten().any(inside), "{p:?} of {a:?} {b:?} {c:?}");
                }
            }
        }
    }
}
