//! Triangle meshes: the user's coordinates and faces, untouched and in the user's order.

mod ear_clipping;
pub mod generate;
mod material;
mod reflex_grid;
mod srgb;
mod triangulate;

pub use material::Material;
pub use srgb::{linear_from_srgb, srgb_from_linear};
pub use triangulate::{Triangulator, triangulate};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::{Aabb, Vec3};

/// Vertex coordinates in the precision in which they came.
#[derive(Clone, Debug, PartialEq)]
pub enum Positions {
    /// Single precision, 12 bytes a vertex.
    F32(Vec<[f32; 3]>),
    /// Double precision, 24 bytes a vertex.
    F64(Vec<[f64; 3]>),
}

impl Positions {
    /// Number of vertices.
    pub fn len(&self) -> usize {
        match self {
            Positions::F32(p) => p.len(),
            Positions::F64(p) => p.len(),
        }
    }

    /// True if there is no vertex.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The given coordinates, in single precision if that loses nothing of any of them, else in
    /// double precision.
    pub fn without_loss(coordinates: Vec<[f64; 3]>) -> Positions {
        let fits = |x: f64| f64::from(x as f32) == x || x.is_nan();
        if coordinates.iter().flatten().all(|&x| fits(x)) {
            Positions::F32(coordinates.iter().map(|p| p.map(|x| x as f32)).collect())
        } else {
            Positions::F64(coordinates)
        }
    }

    /// The coordinates of vertex `index`; exact, for single precision widens without rounding.
    #[inline(always)]
    pub fn get(&self, index: usize) -> Vec3 {
        match self {
            Positions::F32(p) => p[index].into(),
            Positions::F64(p) => p[index].into(),
        }
    }
}

/// A triangle mesh.
///
/// Every vertex index in `triangles` is below the number of vertices: [`Mesh::new`] checks it. What
/// is optional is for its maker to fill, with an entry for each triangle or vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    positions: Positions,
    triangles: Vec<[u32; 3]>,
    /// For each triangle the index of the face of the file from which it was cut; `None` if
    /// triangle i is the file's face i.
    pub source_faces: Option<Vec<u32>>,
    /// A colour for each vertex, red green blue alpha, sRGB-encoded.
    pub vertex_colors: Option<Vec<[u8; 4]>>,
    /// The materials that `triangle_materials` points into.
    pub materials: Vec<Material>,
    /// For each triangle an index into `materials`; `None` if all have the default material.
    pub triangle_materials: Option<Vec<u32>>,
}

impl Mesh {
    /// A mesh of the given vertices and triangles.
    ///
    /// # Errors
    /// [`Error::Invalid`] if an index is not below the number of vertices, or there are more than
    /// 2^32 - 2 triangles or vertices.
    pub fn new(positions: Positions, triangles: Vec<[u32; 3]>) -> Result<Mesh> {
        let vertex_count = positions.len();
        if vertex_count >= u32::MAX as usize || triangles.len() >= u32::MAX as usize {
            return Err(Error::invalid("mesh", "more than 2^32 - 2 vertices or triangles"));
        }
        // By the largest index of each chunk first: this runs at the speed of memory.
        let chunk_size = 1 << 14;
        let wrong_chunk = triangles.par_chunks(chunk_size).position_first(|chunk| {
            let largest = chunk.iter().fold(0, |m, &[a, b, c]| m.max(a).max(b).max(c));
            largest as usize >= vertex_count
        });
        if let Some(t) = wrong_chunk.and_then(|chunk| {
            let first = chunk * chunk_size;
            let beyond = |t: &[u32; 3]| t.iter().any(|&i| i as usize >= vertex_count);
            triangles[first..].iter().position(beyond).map(|t| first + t)
        }) {
            return Err(Error::invalid(
                "mesh",
                format!(
                    "triangle {t} = {:?} points past the {vertex_count} vertices",
                    triangles[t]
                ),
            ));
        }
        Ok(Mesh {
            positions,
            triangles,
            source_faces: None,
            vertex_colors: None,
            materials: Vec::new(),
            triangle_materials: None,
        })
    }

    /// The vertices.
    pub fn positions(&self) -> &Positions {
        &self.positions
    }

    /// The triangles, as vertex indices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The corners of triangle `index`.
    ///
    /// # Panics
    /// If there is no triangle `index`: [`NO_FACE`](crate::geometry::NO_FACE), of a miss, is none.
    #[inline(always)]
    pub fn corners(&self, index: u32) -> [Vec3; 3] {
        let [a, b, c] = self.triangles[index as usize];
        [
            self.positions.get(a as usize),
            self.positions.get(b as usize),
            self.positions.get(c as usize),
        ]
    }

    /// The index in the file of the face from which triangle `index` was cut.
    ///
    /// # Panics
    /// If there is no triangle `index`, or `source_faces` is shorter than the triangles.
    pub fn source_face(&self, index: u32) -> u32 {
        self.source_faces.as_ref().map_or(index, |faces| faces[index as usize])
    }

    /// The box around all finite vertices that a triangle uses.
    pub fn bounds(&self) -> Aabb {
        let include = |mut bounds: Aabb, triangle: &[u32; 3]| {
            for &v in triangle {
                let p = self.positions.get(v as usize);
                if p.is_finite() {
                    bounds = bounds.including(p);
                }
            }
            bounds
        };
        self.triangles
            .par_chunks(1 << 14)
            .map(|chunk| chunk.iter().fold(Aabb::EMPTY, include))
            .reduce(|| Aabb::EMPTY, |a, b| a.union(&b))
    }
}
