//! How a mesh's triangles hang together, and what keeps them from bounding a solid.
//!
//! Vertices count as one if they lie at the same place, exactly: a file that repeats a vertex for
//! every triangle describes the same surface as one that does not. On top of places:
//!
//! 1. `faces.rs` tells what each face is. Those that are not finite, and those with two corners in
//!    one place, border on nothing and take no part in what follows. A face whose three corners
//!    are apart but on one line has no area either, yet it may close the gap between a long edge
//!    and two short ones, and takes part.
//! 2. `edges.rs` puts the edges of all faces side by side and counts how many faces each has.
//! 3. `components.rs` counts the pieces.
//!
//! The work is linear in the triangles but for the sorting of vertices and of faces as numbers of
//! 64 bits, which is also all that cannot be interrupted in between. Beyond the mesh it holds at
//! most 37 bytes for a triangle and 20 for a vertex at a time, and keeps 4 for an edge and 4 for a
//! place, by which [`watertight`](crate::watertight) aims.

mod components;
mod edges;
mod faces;
mod found;
mod places;

pub use found::Found;

use halfline::error::{Error, Result};
use halfline::geometry::Vec3;
use halfline::mesh::Mesh;
use halfline::progress::{Observer, SharedProgress, Stage};

use faces::FaceKind;

/// Faces or vertices of one task: about a millisecond of work.
const CHUNK: usize = 1 << 14;

/// How many passes there are over all vertices, and over all faces.
const VERTEX_PASSES: usize = 3;
const FACE_PASSES: usize = 5;

/// Half-edges are numbered with 31 bits. As many triangles as a tree takes.
const MOST_TRIANGLES: usize = 1 << 29;

/// Half-edge `slot` of a face runs from its corner `slot` to the next one; both are numbered
/// `3 * face + slot`.
type Corner = u32;

/// No corner.
const NO_CORNER: Corner = u32::MAX;

/// The progress of an examination, in elements passed.
fn begin<'a>(observer: &'a dyn Observer, mesh: &Mesh) -> SharedProgress<'a> {
    let (vertices, faces) = (mesh.positions().len(), mesh.triangle_count());
    let total = VERTEX_PASSES * vertices + FACE_PASSES * faces;
    SharedProgress::new(observer, Stage::Examine, total)
}

/// What [`examine`] finds.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Triangles, whatever they are.
    pub triangles: usize,
    /// Vertices, whatever they are.
    pub vertices: usize,
    /// Vertices that lie exactly where one before them does.
    pub duplicate_vertices: usize,
    /// Vertices that are no corner of any triangle.
    pub unreferenced_vertices: usize,
    /// Faces with a corner that is infinite or NaN.
    pub non_finite_faces: Found,
    /// Faces whose corners lie on one line, exactly.
    pub degenerate_faces: Found,
    /// Faces with the same three corners, in any order, as one before them. Those with two corners
    /// in one place are not looked at.
    pub duplicate_faces: Found,
    /// Edges between different places.
    pub edges: usize,
    /// Edges of one face: the border of the surface.
    pub open_edges: Found,
    /// Edges of three or more faces.
    pub non_manifold_edges: Found,
    /// Edges of two faces that run along them the same way: one of them is inside out.
    pub inconsistent_edges: Found,
    /// Edges of an odd number of faces, open ones included.
    pub odd_edges: usize,
    /// Edges along which not as many faces run one way as the other, open ones included.
    pub unbalanced_edges: usize,
    /// Pieces, of faces that share vertices.
    pub components: usize,
    /// Faces that take part: finite, and with their corners in three places.
    pub surface_faces: usize,
    /// The volume inside if the surface is [closed](Topology::is_closed) and
    /// [consistent](Topology::is_consistent); negative if it is inside out.
    pub signed_volume: f64,
    /// `signed_volume` errs by no more.
    pub signed_volume_error: f64,
    /// For each edge one of its half-edges.
    edge_corners: Vec<Corner>,
    /// For each place that has edges a corner that lies there.
    place_corners: Vec<Corner>,
}

/// To which side the fronts of a closed surface look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// The fronts look away from what the surface encloses.
    Outward,
    /// The fronts look towards what the surface encloses: it is inside out.
    Inward,
    /// The surface encloses nothing, or too little to tell in double precision.
    Neither,
}

impl Topology {
    /// True if every edge has an even number of faces, and there is an edge. Then a half-line that
    /// begins on no face crosses the surface an odd number of times for a beginning inside, an
    /// even number for one outside, whatever its direction.
    pub fn is_closed(&self) -> bool {
        self.edges > 0 && self.odd_edges == 0
    }

    /// True if of the faces of every edge that is not open as many run one way as the other.
    pub fn is_consistent(&self) -> bool {
        self.unbalanced_edges == self.open_edges.count
    }

    /// Where the fronts look, of a surface that is closed and consistent.
    pub fn facing(&self) -> Option<Facing> {
        (self.is_closed() && self.is_consistent()).then(|| {
            // NaN, of a volume that overflows, is neither.
            if self.signed_volume > self.signed_volume_error {
                Facing::Outward
            } else if self.signed_volume < -self.signed_volume_error {
                Facing::Inward
            } else {
                Facing::Neither
            }
        })
    }

    /// Places less edges plus faces: 2 for what can be blown up to a sphere, 0 for a torus.
    pub fn euler_characteristic(&self) -> i64 {
        self.place_corners.len() as i64 - self.edges as i64 + self.surface_faces as i64
    }

    /// How many places there are to aim at: the vertices and the middles of the edges.
    pub fn target_count(&self) -> usize {
        self.place_corners.len() + self.edge_corners.len()
    }

    /// The target number `index`: a face and which of its corners, or of its edges, counted from
    /// the one between the first two corners.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn target(&self, index: usize) -> Target {
        match self.place_corners.get(index) {
            Some(&corner) => Target::Vertex { face: corner / 3, corner: corner % 3 },
            None => {
                let corner = self.edge_corners[index - self.place_corners.len()];
                Target::EdgeMidpoint { face: corner / 3, edge: corner % 3 }
            }
        }
    }
}

/// A place on the surface where rays are likeliest to slip through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A vertex.
    Vertex {
        /// A face that has the vertex.
        face: u32,
        /// Which corner of the face the vertex is.
        corner: u32,
    },
    /// The middle of an edge.
    EdgeMidpoint {
        /// A face that has the edge.
        face: u32,
        /// Which edge of the face it is: that from the corner of this number to the next.
        edge: u32,
    },
}

/// Finds how the triangles of `mesh` hang together. Reports
/// [`Stage::Examine`].
///
/// # Errors
/// [`Error::Invalid`] for a mesh of more than 2^29 triangles, and [`Error::Interrupted`].
pub fn examine(mesh: &Mesh, observer: &dyn Observer) -> Result<Topology> {
    let (triangles, vertices) = (mesh.triangle_count(), mesh.positions().len());
    if triangles > MOST_TRIANGLES {
        return Err(Error::invalid("mesh", "more than 2^29 triangles"));
    }
    let progress = &begin(observer, mesh);

    // Find which vertices are one, and what each face is.
    let places = places::find(mesh.positions(), progress)?;
    let faces = faces::examine(mesh, &places.of_vertex, progress)?;
    let duplicate_faces = faces::duplicates(mesh, &places.of_vertex, &faces.kinds, progress)?;

    // Follow the edges, and what they connect.
    let edges = edges::examine(mesh, &places.of_vertex, &faces.kinds, progress)?;
    let pieces = components::find(mesh, &places.of_vertex, &faces.kinds, progress)?;
    progress.finish();

    Ok(Topology {
        triangles,
        vertices,
        duplicate_vertices: places.duplicates,
        unreferenced_vertices: faces.unreferenced_vertices,
        non_finite_faces: faces.non_finite,
        degenerate_faces: faces.degenerate,
        duplicate_faces,
        edges: edges.corners.len(),
        open_edges: edges.open,
        non_manifold_edges: edges.non_manifold,
        inconsistent_edges: edges.inconsistent,
        odd_edges: edges.odd,
        unbalanced_edges: edges.unbalanced,
        components: pieces.count,
        surface_faces: faces.kinds.iter().filter(|kind| kind.takes_part()).count(),
        signed_volume: faces.signed_volume,
        signed_volume_error: faces.signed_volume_error,
        edge_corners: edges.corners,
        place_corners: pieces.place_corners,
    })
}

/// Calls `use_face` with the index and the places of the corners of every face of a chunk of
/// faces, beginning at `first`, that takes part.
fn for_each_surface_face(
    first: usize,
    triangles: &[[u32; 3]],
    kinds: &[FaceKind],
    place_of_vertex: &[u32],
    mut use_face: impl FnMut(u32, [u32; 3]),
) {
    for (offset, triangle) in triangles.iter().enumerate() {
        if kinds[first + offset].takes_part() {
            use_face((first + offset) as u32, triangle.map(|v| place_of_vertex[v as usize]));
        }
    }
}

impl Target {
    /// The face.
    pub fn face(self) -> u32 {
        match self {
            Target::Vertex { face, .. } | Target::EdgeMidpoint { face, .. } => face,
        }
    }

    /// Where it is: the vertex, or the middle of an edge in double precision.
    pub fn position(self, mesh: &Mesh) -> Vec3 {
        let corners = mesh.corners(self.face());
        match self {
            Target::Vertex { corner, .. } => corners[corner as usize],
            Target::EdgeMidpoint { edge, .. } => {
                // Halves first: the sum of two coordinates may overflow.
                corners[edge as usize] * 0.5 + corners[(edge as usize + 1) % 3] * 0.5
            }
        }
    }
}
