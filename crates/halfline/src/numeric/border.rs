//! The borders of open surfaces, where a contact counts though it is no crossing.
//!
//! A sheet that ends at an edge is crossed there or not, as the infinitesimal happens to point; yet
//! the edge belongs to the closed triangle. What tells it from an edge of a closed surface, which a
//! ray may touch without passing through, is the number of triangles that have it: odd, or even.
//!
//! Edges are the same if their ends lie at the same place, exactly. As in the topology that the crate
//! `halfline-check` finds, all triangles with three distinct finite corners have edges: one whose corners
//! lie on one line may close the gap between a long edge and two short ones.

use super::ray_triangle::{PreparedRay, Touched};
use crate::geometry::{Hit, Vec3};

/// A contact that is no crossing.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Ray parameter.
    pub t: f64,
    /// The face.
    pub face: u32,
    /// Which edge or corner of it.
    pub touched: Touched,
}

/// Makes the crossings of one ray all of its hits: sorts them by t and then by face, and adds the
/// border contacts among `touches`. Repeats of a face are dropped from both.
///
/// Touches at the t of a crossing count for nothing. Of the others at one t, if any lies on the
/// border, that with the lowest face counts.
///
/// `triangles_at` gives triangles, each once, among them all that have the given point as a corner.
pub fn complete_hits(
    ray: &PreparedRay,
    hits: &mut Vec<Hit>,
    first: usize,
    touches: &mut Vec<Touch>,
    corners_of: impl Fn(u32) -> [Vec3; 3],
    triangles_at: impl Fn(Vec3) -> Vec<[Vec3; 3]>,
) {
    sort_crossings(hits, first);
    if touches.is_empty() {
        return;
    }
    touches.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
    touches.dedup_by_key(|touch| touch.face);
    let last = hits.len();
    for group in touches.chunk_by(|a, b| a.t == b.t) {
        let Touch { t, face, .. } = group[0];
        let crossings = &hits[first..last];
        let next = crossings.partition_point(|hit| hit.t < t);
        let is_crossed = crossings.get(next).is_some_and(|hit| hit.t == t);
        if !is_crossed && is_any_on_border(group, &corners_of, &triangles_at) {
            hits.push(ray.hit(face, corners_of(face)));
        }
    }
    if hits.len() > last {
        hits[first..].sort_by(|a, b| a.t.total_cmp(&b.t));
    }
}

/// Sorts the crossings of one ray, and drops the repeats of faces that lie in several cells. By
/// face, never by distance: two faces may be crossed at the same t.
fn sort_crossings(hits: &mut Vec<Hit>, first: usize) {
    hits[first..].sort_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
    // The same face has the same t, so its repeats are neighbours.
    let mut kept = first;
    for i in first..hits.len() {
        if kept == first || hits[kept - 1].face != hits[i].face {
            hits[kept] = hits[i];
            kept += 1;
        }
    }
    hits.truncate(kept);
}

/// A part of a face that can lie on the border: an edge, or a vertex, whose ends are the same.
type Ends = [Vec3; 2];

fn ends_of(corners: [Vec3; 3], touched: Touched) -> Option<Ends> {
    match touched {
        Touched::Inside => None,
        Touched::Edge(i) => Some([corners[(i + 1) % 3], corners[(i + 2) % 3]]),
        Touched::Corner(i) => Some([corners[i]; 2]),
    }
}

#[cold]
fn is_any_on_border(
    touches: &[Touch],
    corners_of: impl Fn(u32) -> [Vec3; 3],
    triangles_at: impl Fn(Vec3) -> Vec<[Vec3; 3]>,
) -> bool {
    // Ask for each edge and vertex once: all triangles around a vertex may touch the ray there.
    let mut parts: Vec<[Place; 2]> = touches
        .iter()
        .filter_map(|touch| ends_of(corners_of(touch.face), touch.touched))
        .map(|[p, q]| [p.place_key(), q.place_key()])
        .map(|[p, q]| if p <= q { [p, q] } else { [q, p] })
        .collect();
    parts.sort_unstable();
    parts.dedup();
    parts.into_iter().any(|[p, q]| {
        let triangles = triangles_at(point(p));
        if p == q { is_border_vertex(p, &triangles) } else { is_border_edge([p, q], &triangles) }
    })
}

/// Where a point lies, as [`Vec3::place_key`] tells.
type Place = [u64; 3];

fn point(place: Place) -> Vec3 {
    Vec3::from(place.map(f64::from_bits))
}

/// The two corners that are not at `corner`, of each triangle that has edges and a corner there.
fn opposite_ends<'a>(
    corner: Place,
    triangles: &'a [[Vec3; 3]],
) -> impl Iterator<Item = [Place; 2]> + 'a {
    triangles.iter().filter_map(move |corners| {
        if !has_edges(*corners) {
            return None;
        }
        let places = corners.map(Vec3::place_key);
        let i = places.iter().position(|&p| p == corner)?;
        Some([places[(i + 1) % 3], places[(i + 2) % 3]])
    })
}

/// True if the three corners are finite and apart.
pub fn has_edges([a, b, c]: [Vec3; 3]) -> bool {
    [a, b, c].into_iter().all(Vec3::is_finite) && a != b && b != c && c != a
}

/// True if an odd number of the triangles have the edge.
fn is_border_edge([p, q]: [Place; 2], triangles: &[[Vec3; 3]]) -> bool {
    opposite_ends(p, triangles).filter(|ends| ends.contains(&q)).count() % 2 == 1
}

/// True if an odd number of the triangles have some edge that ends at the vertex.
fn is_border_vertex(vertex: Place, triangles: &[[Vec3; 3]]) -> bool {
    let mut ends: Vec<Place> = opposite_ends(vertex, triangles).flatten().collect();
    ends.sort_unstable();
    ends.chunk_by(|a, b| a == b).any(|same| same.len() % 2 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vec3;

    const HUB: Vec3 = Vec3::ZERO;

    fn rim(i: usize) -> Vec3 {
        [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(-1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0)]
            [i % 4]
    }

    /// The first `count` quarters of a square around the hub.
    fn quarters(count: usize) -> Vec<[Vec3; 3]> {
        (0..count).map(|i| [HUB, rim(i), rim(i + 1)]).collect()
    }

    fn edge(p: Vec3, q: Vec3, triangles: &[[Vec3; 3]]) -> bool {
        is_border_edge([p.place_key(), q.place_key()], triangles)
    }

    #[test]
    fn edges_are_of_the_border_if_their_triangles_are_odd_in_number() {
        let three = quarters(3);
        assert!(edge(rim(0), rim(1), &three) && edge(HUB, rim(0), &three));
        assert!(!edge(HUB, rim(1), &three) && !edge(rim(2), HUB, &three));
        let page = [HUB, rim(1), vec3(0.0, 0.0, 1.0)];
        assert!(edge(HUB, rim(1), &[&three[..], &[page]].concat()));
    }

    #[test]
    fn vertices_are_of_the_border_if_an_edge_is() {
        assert!(is_border_vertex(HUB.place_key(), &quarters(3)));
        assert!(!is_border_vertex(HUB.place_key(), &quarters(4)));
        assert!(is_border_vertex(rim(1).place_key(), &quarters(4)));
        // Twice over, nothing is left of the border.
        let twice = [quarters(3), quarters(3)].concat();
        assert!(!is_border_vertex(HUB.place_key(), &twice));
    }

    #[test]
    fn triangles_without_edges_count_for_nothing() {
        let collapsed = [HUB, HUB, rim(1)];
        let infinite = [HUB, rim(1), vec3(f64::INFINITY, 0.0, 0.0)];
        let three = [quarters(3), vec![collapsed, infinite]].concat();
        assert!(!edge(HUB, rim(1), &three));
        // One whose corners lie on one line has edges.
        let on_line = [HUB, rim(1) * 0.5, rim(1)];
        assert!(edge(HUB, rim(1), &[quarters(3), vec![on_line]].concat()));
    }

    #[test]
    fn both_zeros_are_one_place() {
        let negative = -Vec3::ZERO;
        assert!(negative.x.is_sign_negative());
        let mut four = quarters(4);
        four[2][0] = negative;
        assert!(!is_border_vertex(HUB.place_key(), &four));
        assert!(!edge(negative, rim(2), &four));
    }
}
