//! Points spread evenly over a surface.
//!
//! Stratified by area: all triangles in a row make a line as long as their area, each point lies at random
//! in its own of n equal parts of the line, and then at random in the triangle there (R. Osada et al.,
//! "Shape Distributions", TOG 2002, section 3.1). Two passes over the triangles; no table of their areas.

use halfline::Mesh;
use halfline::geometry::Vec3;
use halfline::geometry::random::Random;

/// `count` points on `mesh`, in the order of its faces; `None` if it has no area, or more than a double
/// can tell.
pub fn spread(mesh: &Mesh, count: usize, seed: u64) -> Option<Vec<[f64; 3]>> {
    let faces = 0..mesh.triangle_count() as u32;
    let total: f64 = faces.clone().map(|face| area(mesh.corners(face))).sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    // Where on the line point number i lies.
    let place = |number: usize| {
        let mut random = Random::new(seed, number as u64);
        let at = (number as f64 + random.unit()) / count as f64 * total;
        (at, random)
    };
    let mut points = Vec::with_capacity(count);
    let (mut passed, mut last) = (0.0, None);
    let mut next = place(0);
    for face in faces {
        let corners = mesh.corners(face);
        let size = area(corners);
        if size == 0.0 {
            continue;
        }
        passed += size;
        last = Some(corners);
        while points.len() < count && next.0 < passed {
            points.push(within(corners, &mut next.1));
            next = place(points.len());
        }
    }
    // The last place may have been rounded up to the end of the line.
    while let Some(corners) = last
        && points.len() < count
    {
        points.push(within(corners, &mut next.1));
        next = place(points.len());
    }
    Some(points)
}

/// The area of a triangle; 0 of one that is not finite.
fn area([a, b, c]: [Vec3; 3]) -> f64 {
    let area = (b - a).cross(c - a).length() / 2.0;
    if [a, b, c].iter().all(|corner| corner.is_finite()) { area } else { 0.0 }
}

/// A point of a triangle, uniform in its area.
fn within([a, b, c]: [Vec3; 3], random: &mut Random) -> [f64; 3] {
    let (mut u, mut v) = (random.unit(), random.unit());
    // The half of the parallelogram beyond the triangle is turned onto it.
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    // On a plane across an axis, exactly.
    (a + (b - a) * u + (c - a) * v).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_get_points_by_their_area() {
        let nan = f64::NAN;
        let corners = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 5.0],
            [3.0, 0.0, 5.0],
            [0.0, 1.0, 5.0],
            [nan, 0.0, 0.0],
        ];
        let mesh = Mesh::new(corners, [[0, 1, 2], [0, 1, 1], [3, 4, 5], [6, 1, 2]]).unwrap();
        let points = spread(&mesh, 4000, 7).unwrap();
        assert_eq!(points.len(), 4000);
        let (low, high) = points.split_at(1000);
        assert!(low.iter().all(|p| p[2] == 0.0 && p[0] + p[1] <= 1.0 + 1e-12));
        assert!(high.iter().all(|p| p[2] == 5.0));
        let middle = low.iter().map(|p| p[0]).sum::<f64>() / 1000.0;
        assert!((middle - 1.0 / 3.0).abs() < 0.03, "{middle}");
        assert_eq!(spread(&mesh, 4000, 7).unwrap(), points);
        assert_ne!(spread(&mesh, 4000, 8).unwrap(), points);
    }

    #[test]
    fn what_has_no_area_has_no_points() {
        let mesh = Mesh::new([[0.0, 0.0, 0.0], [1e200, 0.0, 0.0], [0.0, 1e200, 0.0]], [[0, 1, 1]]);
        assert_eq!(spread(&mesh.unwrap(), 5, 0), None);
        let mesh = Mesh::new([[0.0, 0.0, 0.0], [1e200, 0.0, 0.0], [0.0, 1e200, 0.0]], [[0, 1, 2]]);
        assert_eq!(spread(&mesh.unwrap(), 5, 0), None);
    }
}
