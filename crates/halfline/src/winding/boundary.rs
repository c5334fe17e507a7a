//! The net boundary of a mesh: the edges that its faces do not traverse as often forwards as backwards, as
//! closed walks.
//!
//! Vertices are one where their coordinates are equal, both zeros being one. Nearly all edges of an indexed mesh
//! cancel by the numbers of their vertices, and those that are left by where these lie. At each vertex as many net
//! edges end as begin, since each face is a closed walk itself; so net edges fall into closed walks.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::hierarchy::Hierarchy;
use crate::geometry::Vec3;
use crate::mesh::Mesh;
use crate::numeric::{WINDING_DIRECTION, facing_sign, has_edges, is_zero_area};

/// The net boundary of a mesh, ready to be seen from points: [`Scene::boundary`](crate::Scene::boundary) makes it
/// once.
#[derive(Debug)]
pub struct Boundary {
    pub(super) hierarchy: Hierarchy,
    pub(super) has_parallel_faces: bool,
    build_time: Duration,
}

impl Boundary {
    /// Finds the boundary of a mesh.
    pub fn new(mesh: &Mesh) -> Boundary {
        let start = Instant::now();
        let (edges, has_parallel_faces) = net_edges_by_number(mesh);
        let hierarchy = Hierarchy::new(&closed_walks(mesh, &edges));
        Boundary { hierarchy, has_parallel_faces, build_time: start.elapsed() }
    }

    /// How many net edges there are, each as often as its multiplicity; none if the mesh is closed and oriented
    /// alike.
    pub fn edge_count(&self) -> usize {
        self.hierarchy.edge_count()
    }

    /// The net edges from their first to their second end, closed walk after closed walk, each as often as its
    /// multiplicity.
    pub fn edges(&self) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        self.hierarchy.edges()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.hierarchy.bytes()
    }

    /// How long it took to find.
    pub fn build_time(&self) -> Duration {
        self.build_time
    }
}

/// A net edge: the smaller and the larger number of its ends, and how often it is traversed from the smaller to the
/// larger, less how often the other way.
type NetEdge = (u32, u32, i32);

/// Faces that a thread goes through at a time.
const CHUNK: usize = 1 << 14;

/// The edges that do not cancel by the numbers of their vertices, and whether a triangle with area is parallel to the
/// direction of the crossings.
fn net_edges_by_number(mesh: &Mesh) -> (Vec<NetEdge>, bool) {
    // Gather the edges of all faces, each as one number, by whether they go from the smaller vertex to the larger.
    let chunks: Vec<([Vec<u64>; 2], bool)> = mesh
        .triangles()
        .par_chunks(CHUNK)
        .map(|triangles| {
            let mut edges = [Vec::new(), Vec::new()];
            let mut has_parallel = false;
            for triangle in triangles {
                let corners = triangle.map(|vertex| mesh.positions().get(vertex as usize));
                if !has_edges(corners) {
                    continue;
                }
                has_parallel |=
                    facing_sign(WINDING_DIRECTION, corners) == 0 && !is_zero_area(corners);
                for i in 0..3 {
                    let (from, to) = (triangle[i], triangle[(i + 1) % 3]);
                    let key = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
                    edges[usize::from(from > to)].push(key);
                }
            }
            (edges, has_parallel)
        })
        .collect();
    let has_parallel = chunks.iter().any(|(_, has_parallel)| *has_parallel);
    let [mut forwards, mut backwards] = [0, 1].map(|side: usize| {
        let parts: Vec<&[u64]> = chunks.iter().map(|(edges, _)| &edges[side][..]).collect();
        parts.concat()
    });
    drop(chunks);
    forwards.par_sort_unstable();
    backwards.par_sort_unstable();

    // Merge the two, and keep what does not cancel.
    let (mut net, mut i, mut j) = (Vec::new(), 0, 0);
    while i < forwards.len() || j < backwards.len() {
        let key = match (forwards.get(i), backwards.get(j)) {
            (Some(&a), Some(&b)) => a.min(b),
            (Some(&a), None) => a,
            (None, Some(&b)) => b,
            (None, None) => break,
        };
        let (first, second) = (i, j);
        while forwards.get(i) == Some(&key) {
            i += 1;
        }
        while backwards.get(j) == Some(&key) {
            j += 1;
        }
        let count = (i - first) as i32 - (j - second) as i32;
        if count != 0 {
            net.push(((key >> 32) as u32, key as u32, count));
        }
    }
    (net, has_parallel)
}

/// The closed walks that are left when edges cancel by where their ends lie. The last vertex of each is its first.
fn closed_walks(mesh: &Mesh, edges: &[NetEdge]) -> Vec<Vec<Vec3>> {
    // Number the places of the vertices.
    let mut vertices: Vec<u32> = edges.iter().flat_map(|&(a, b, _)| [a, b]).collect();
    vertices.par_sort_unstable();
    vertices.dedup();
    // Read once: what lies in a file may change.
    let mut by_place: Vec<([u64; 3], u32)> = vertices
        .iter()
        .enumerate()
        .map(|(i, &vertex)| (mesh.positions().get(vertex as usize).place_key(), i as u32))
        .collect();
    by_place.par_sort_unstable();
    let (mut places, mut place_of) = (Vec::<[u64; 3]>::new(), vec![0_u32; vertices.len()]);
    for (place, i) in by_place {
        if places.last() != Some(&place) {
            places.push(place);
        }
        place_of[i as usize] = places.len() as u32 - 1;
    }

    // Let edges cancel, and direct those that are left.
    let mut between: Vec<NetEdge> = edges
        .iter()
        .map(|&(a, b, count)| {
            let [a, b] = [a, b].map(|v| vertices.partition_point(|&other| other < v));
            let (a, b) = (place_of[a], place_of[b]);
            if a <= b { (a, b, count) } else { (b, a, -count) }
        })
        .collect();
    between.par_sort_unstable();
    let mut directed: Vec<(u32, u32, i32)> = Vec::new();
    for same in between.chunk_by(|p, q| (p.0, p.1) == (q.0, q.1)) {
        let (a, b, _) = same[0];
        let count: i32 = same.iter().map(|edge| edge.2).sum();
        if count > 0 && a != b {
            directed.push((a, b, count));
        } else if count < 0 && a != b {
            directed.push((b, a, -count));
        }
    }
    directed.sort_unstable();

    // Walk from each edge on, as long as there is one to go.
    let mut next = vec![0; places.len() + 1];
    for &(from, _, _) in &directed {
        next[from as usize + 1] += 1;
    }
    for place in 0..places.len() {
        next[place + 1] += next[place];
    }
    let ends = next[1..].to_vec();
    let point = |place: u32| Vec3::from(places[place as usize].map(f64::from_bits));
    let mut walks = Vec::new();
    for first in 0..directed.len() {
        while directed[first].2 > 0 {
            let mut at = directed[first].0;
            let mut walk = vec![point(at)];
            loop {
                let edge = &mut next[at as usize];
                while *edge < ends[at as usize] && directed[*edge].2 == 0 {
                    *edge += 1;
                }
                if *edge == ends[at as usize] {
                    break;
                }
                directed[*edge].2 -= 1;
                at = directed[*edge].1;
                walk.push(point(at));
            }
            walks.push(walk);
        }
    }
    walks
}
