//! The judge of closest points in rational arithmetic. It shares no code with what it judges, and has another rule:
//! of the corners, the feet on the lines of edges and the foot on the plane, those that lie in the triangle, it takes
//! the nearest.

use halfline::geometry::Feature;
use halfline::{ClosestPoint, Mesh, Vec3};
use num_traits::{One, Signed, Zero};

use crate::common::exact::{Point, Q, dot, exact, exact_double, minus, nearest_double};

/// What is exactly known of a closest point.
pub struct Expected {
    pub face: u32,
    pub squared_distance: Q,
    pub point: Point,
    pub weights: [Q; 3],
}

/// The nearest point of one triangle: its weights, itself, and the square of its distance.
fn nearest_of_triangle(p: &Point, corners: &[Point; 3]) -> ([Q; 3], Point, Q) {
    let zero = Q::zero;
    let mut candidates: Vec<[Q; 3]> = Vec::new();
    for i in 0..3 {
        let mut weights = [zero(), zero(), zero()];
        weights[i] = Q::one();
        candidates.push(weights);
    }
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let along = minus(&corners[j], &corners[i]);
        let square = dot(&along, &along);
        if !square.is_zero() {
            let share = dot(&minus(p, &corners[i]), &along) / square;
            if share.is_positive() && share < Q::one() {
                let mut weights = [zero(), zero(), zero()];
                weights[i] = Q::one() - &share;
                weights[j] = share;
                candidates.push(weights);
            }
        }
    }
    // The foot on the plane solves two linear equations.
    let (e, f) = (minus(&corners[1], &corners[0]), minus(&corners[2], &corners[0]));
    let d = minus(p, &corners[0]);
    let (ee, ef, ff) = (dot(&e, &e), dot(&e, &f), dot(&f, &f));
    let determinant = &ee * &ff - &ef * &ef;
    if !determinant.is_zero() {
        let (de, df) = (dot(&d, &e), dot(&d, &f));
        let u = (&de * &ff - &df * &ef) / &determinant;
        let v = (&df * &ee - &de * &ef) / &determinant;
        let w = Q::one() - &u - &v;
        if u.is_positive() && v.is_positive() && w.is_positive() {
            candidates.push([w, u, v]);
        }
    }
    let measured = candidates.into_iter().map(|weights| {
        let point = [0, 1, 2].map(|axis| {
            (0..3).map(|i| &weights[i] * &corners[i][axis]).fold(Q::zero(), |sum, x| sum + x)
        });
        let away = minus(p, &point);
        let square = dot(&away, &away);
        (weights, point, square)
    });
    measured.min_by(|one, other| one.2.cmp(&other.2)).expect("three corners at least")
}

/// The closest point of the mesh.
pub fn closest_point(mesh: &Mesh, p: Vec3) -> Option<Expected> {
    let is_finite = |v: &Vec3| v.to_array().into_iter().all(f64::is_finite);
    if !is_finite(&p) {
        return None;
    }
    let p = exact(p);
    let mut nearest: Option<Expected> = None;
    for face in 0..mesh.triangle_count() as u32 {
        let corners = mesh.corners(face);
        if !corners.iter().all(is_finite) {
            continue;
        }
        let (weights, point, squared_distance) = nearest_of_triangle(&p, &corners.map(exact));
        if nearest.as_ref().is_none_or(|nearest| squared_distance < nearest.squared_distance) {
            nearest = Some(Expected { face, squared_distance, point, weights });
        }
    }
    nearest
}

/// True if `root` is the double nearest to the root of `square`.
fn is_nearest_root(root: f64, square: &Q) -> bool {
    if !root.is_finite() {
        let limit = exact_double(f64::MAX) + exact_double(2f64.powi(970));
        return root > 0.0 && *square >= &limit * &limit;
    }
    let half = exact_double(0.5);
    let middle = |x: f64, y: f64| (exact_double(x) + exact_double(y)) * &half;
    let above = middle(root, root.next_up());
    let below = if root > 0.0 { middle(root.next_down(), root) } else { Q::zero() };
    &below * &below <= *square && *square <= &above * &above
}

impl Expected {
    /// What is wrong with an answer, if anything.
    pub fn complaint(&self, answer: &ClosestPoint) -> Option<String> {
        if answer.face != self.face {
            return Some(format!("face {}, expected {}", answer.face, self.face));
        }
        if !is_nearest_root(answer.distance, &self.squared_distance) {
            let root = nearest_double(&self.squared_distance).sqrt();
            return Some(format!("distance {:e}, expected about {root:e}", answer.distance));
        }
        for axis in 0..3 {
            let expected = nearest_double(&self.point[axis]);
            if answer.point[axis] != expected {
                return Some(format!("point {:?}, expected {expected:e}", answer.point));
            }
        }
        let positive = self.weights.iter().filter(|weight| weight.is_positive()).count();
        let feature = [Feature::Vertex, Feature::Edge, Feature::Face][positive - 1];
        if answer.feature != feature {
            return Some(format!("feature {:?}, expected {feature:?}", answer.feature));
        }
        let weights = [nearest_double(&self.weights[1]), nearest_double(&self.weights[2])];
        if [answer.u, answer.v] != weights {
            return Some(format!("weights {:?}, expected {weights:?}", [answer.u, answer.v]));
        }
        None
    }
}
