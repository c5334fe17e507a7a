//! The rule that says which point of a triangle is nearest: one point against one closed triangle.
//!
//! C. Ericson, "Real-Time Collision Detection", 2004, section 5.1.5, finds the part of a triangle (a corner, an
//! edge, the inside) that holds the point nearest to p by the signs of products. So does this, but on the
//! coordinates as given and with exact signs. With q on a corner or an edge, q is nearest if no corner lies
//! further in the direction p - q, which is linear; the conditions are:
//!
//! ```text
//! corner a   (p - a)·(b - a) <= 0  and  (p - a)·(c - a) <= 0
//! edge ab    (p - a)·(b - a) > 0,  (p - b)·(a - b) > 0  and  n·((b - a) × (p - a)) <= 0
//! inside     otherwise                                       n = (b - a) × (c - a)
//! ```
//!
//! Different here: corners are asked first, then edges, in order, so that the part is known where several hold
//! the same point; and the conditions say the same of triangles without area, of which a corner or an edge holds
//! the nearest point always.
//!
//! Comparisons and answers come by a ladder: doubles with a bound on their error ([`region`]), double-doubles
//! with one ([`measure`]), big floats ([`exact`]). Answers are the doubles nearest to the exact ones, so they do
//! not depend on the rung.

mod exact;
mod measure;
mod region;

use std::cmp::Ordering;

use crate::geometry::{ClosestPoint, Feature, Vec3};
use exact::Exactly;
use measure::Measure;
pub use measure::MeasureErrors;

/// Which part of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// This corner.
    Corner(usize),
    /// The edge from this corner to the next, without its ends.
    Edge(usize),
    /// Neither corner nor edge.
    Inside,
}

/// The part of a face that holds the point nearest to a given one, exactly known.
#[derive(Clone, Copy, Debug)]
pub struct NearestPart {
    /// The face.
    pub face: u32,
    /// Its corners.
    pub corners: [Vec3; 3],
    /// The part.
    pub region: Region,
    /// Bounds of the distance.
    pub low: f64,
    /// Not below it.
    pub high: f64,
}

impl NearestPart {
    /// The part of a face with finite corners that holds the point nearest to `p`, which is finite.
    pub fn of(p: Vec3, face: u32, corners: [Vec3; 3]) -> NearestPart {
        let region =
            region::certain_region(p, corners).unwrap_or_else(|| Exactly::new(p, corners).region());
        let (low, high) = region::distance_bounds(p, corners, region);
        NearestPart { face, corners, region, low, high }
    }

    /// True if this is nearer to `p` than another, or as near and of a lower face.
    #[inline]
    pub fn is_before(&self, p: Vec3, other: &NearestPart) -> bool {
        if self.high < other.low {
            return true;
        }
        if self.low > other.high {
            return false;
        }
        self.order(p, other).is_lt()
    }

    /// The order by exact distance from `p`, then by face.
    fn order(&self, p: Vec3, other: &NearestPart) -> Ordering {
        let by_face = self.face.cmp(&other.face);
        if self.is_same_place(other) {
            return by_face;
        }
        let measured = [self, other].map(|part| Measure::new(p, part.corners, part.region));
        if let [Some(one), Some(two)] = &measured
            && let Some(order) = one.distance.compare(&two.distance)
        {
            return order;
        }
        let [one, two] =
            [self, other].map(|part| Exactly::new(p, part.corners).squared_distance(part.region));
        one.compare(&two).then(by_face)
    }

    /// True if the nearest points are one since they are the same corner, or on the same edge.
    fn is_same_place(&self, other: &NearestPart) -> bool {
        let ends = |part: &NearestPart, i: usize| (part.corners[i], part.corners[(i + 1) % 3]);
        match (self.region, other.region) {
            (Region::Corner(i), Region::Corner(j)) => self.corners[i] == other.corners[j],
            (Region::Edge(i), Region::Edge(j)) => {
                let ((a, b), (c, d)) = (ends(self, i), ends(other, j));
                (a == c && b == d) || (a == d && b == c)
            }
            _ => false,
        }
    }

    /// The nearest point and all that is told of it.
    pub fn closest_point(&self, p: Vec3) -> ClosestPoint {
        let NearestPart { face, corners, region, .. } = *self;
        let feature = match region {
            Region::Corner(_) => Feature::Vertex,
            Region::Edge(_) => Feature::Edge,
            Region::Inside => Feature::Face,
        };
        let measure = Measure::new(p, corners, region);
        let quick = measure.as_ref().map(Measure::rounded).unwrap_or_default();
        let exactly = Exactly::new(p, corners);
        let more_closely = || measure.as_ref()?.distance_from(&exactly.offsets(region));
        let distance =
            quick.distance.or_else(more_closely).unwrap_or_else(|| exactly.distance(region));
        let mut point = Vec3::ZERO;
        for axis in 0..3 {
            let [a, b, c] = [corners[0][axis], corners[1][axis], corners[2][axis]];
            point[axis] = match quick.point[axis] {
                Some(coordinate) => coordinate,
                // As in a plane across an axis.
                None if a == b && b == c => a + 0.0,
                None => exactly.coordinate(region, axis),
            };
        }
        let u = quick.weights[0].unwrap_or_else(|| exactly.weight(region, 1));
        let v = quick.weights[1].unwrap_or_else(|| exactly.weight(region, 2));
        ClosestPoint { distance, point, face, u, v, feature }
    }
}

/// Distance, point and weights of the second and third corner, as far as they are known.
#[derive(Clone, Copy, Debug, Default)]
struct Rounded {
    distance: Option<f64>,
    point: [Option<f64>; 3],
    weights: [Option<f64>; 2],
}
