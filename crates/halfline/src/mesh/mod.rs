//! Triangle meshes: the user's coordinates and faces, untouched and in the user's order.

mod material;
mod srgb;

pub use material::Material;
pub use srgb::{linear_from_srgb, srgb_from_linear};

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::{Aabb, Vec3};
pub use crate::storage::Buffer;

/// Triangles or vertices that a thread goes through at a time.
const CHUNK: usize = 1 << 14;

/// Vertex coordinates in the precision in which they came.
#[derive(Clone, Debug, PartialEq)]
pub enum Positions {
    /// Single precision, 12 bytes a vertex.
    F32(Buffer<[f32; 3]>),
    /// Double precision, 24 bytes a vertex.
    F64(Buffer<[f64; 3]>),
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
            Positions::F64(coordinates.into())
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

impl From<Buffer<[f32; 3]>> for Positions {
    fn from(positions: Buffer<[f32; 3]>) -> Positions {
        Positions::F32(positions)
    }
}

impl From<Buffer<[f64; 3]>> for Positions {
    fn from(positions: Buffer<[f64; 3]>) -> Positions {
        Positions::F64(positions)
    }
}

impl From<Vec<[f32; 3]>> for Positions {
    fn from(positions: Vec<[f32; 3]>) -> Positions {
        Positions::F32(positions.into())
    }
}

impl From<Vec<[f64; 3]>> for Positions {
    fn from(positions: Vec<[f64; 3]>) -> Positions {
        Positions::F64(positions.into())
    }
}

impl<const N: usize> From<[[f32; 3]; N]> for Positions {
    fn from(positions: [[f32; 3]; N]) -> Positions {
        Vec::from(positions).into()
    }
}

impl<const N: usize> From<[[f64; 3]; N]> for Positions {
    fn from(positions: [[f64; 3]; N]) -> Positions {
        Vec::from(positions).into()
    }
}

/// A triangle mesh.
///
/// ```
/// use halfline::Mesh;
///
/// let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(square, [[0, 1, 2], [0, 2, 3]])?;
/// assert_eq!(mesh.triangle_count(), 2);
///
/// let error = Mesh::new(square, [[0, 1, 4]]).unwrap_err();
/// assert_eq!(error.to_string(), "mesh: triangle 0 = [0, 1, 4] points past the 4 vertices");
/// # Ok::<(), halfline::Error>(())
/// ```
///
/// Every vertex index in `triangles` is below the number of vertices: [`Mesh::new`] checks it. What
/// is optional is for its maker to fill, with an entry for each triangle or vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    positions: Positions,
    triangles: Buffer<[u32; 3]>,
    /// For each triangle the index of the face of the file from which it was cut; `None` if
    /// triangle i is the file's face i.
    pub source_faces: Option<Buffer<u32>>,
    /// A colour for each vertex, red green blue alpha, sRGB-encoded.
    pub vertex_colors: Option<Buffer<[u8; 4]>>,
    /// The materials that `triangle_materials` points into.
    pub materials: Vec<Material>,
    /// For each triangle an index into `materials`; `None` if all have the default material.
    pub triangle_materials: Option<Buffer<u32>>,
}

impl Mesh {
    /// A mesh of the given vertices, in either precision, and of triangles of three vertex indices each. Arrays
    /// are taken, and vectors without a copy.
    ///
    /// # Errors
    /// [`Error::Invalid`] if an index is not below the number of vertices, or there are more than
    /// 2^32 - 2 triangles or vertices.
    pub fn new(
        positions: impl Into<Positions>,
        triangles: impl Into<Buffer<[u32; 3]>>,
    ) -> Result<Mesh> {
        Mesh::checked(positions.into(), triangles.into())
    }

    fn checked(positions: Positions, triangles: Buffer<[u32; 3]>) -> Result<Mesh> {
        let vertex_count = positions.len();
        if vertex_count >= u32::MAX as usize || triangles.len() >= u32::MAX as usize {
            return Err(Error::invalid("mesh", "more than 2^32 - 2 vertices or triangles"));
        }
        // By the largest index of each chunk first: this runs at the speed of memory.
        let wrong_chunk = triangles.par_chunks(CHUNK).position_first(|chunk| {
            let largest = chunk.iter().fold(0, |m, &[a, b, c]| m.max(a).max(b).max(c));
            largest as usize >= vertex_count
        });
        if let Some(t) = wrong_chunk.and_then(|chunk| {
            let first = chunk * CHUNK;
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
        Ok(Mesh::unchecked(positions, triangles))
    }

    /// A mesh whose indices were checked before.
    pub(crate) fn unchecked(positions: Positions, triangles: Buffer<[u32; 3]>) -> Mesh {
        Mesh {
            positions,
            triangles,
            source_faces: None,
            vertex_colors: None,
            materials: Vec::new(),
            triangle_materials: None,
        }
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

    /// For each vertex whether a triangle uses it.
    fn used_vertices(&self) -> Vec<bool> {
        let used: Vec<AtomicBool> = (0..self.positions.len()).map(|_| false.into()).collect();
        self.triangles.par_chunks(CHUNK).for_each(|chunk| {
            for &v in chunk.as_flattened() {
                // Most have been seen before, and who only looks takes no memory away from others.
                let used = &used[v as usize];
                if !used.load(Ordering::Relaxed) {
                    used.store(true, Ordering::Relaxed);
                }
            }
        });
        used.into_iter().map(AtomicBool::into_inner).collect()
    }

    /// Goes in parallel through all finite vertices that a triangle uses, each once: `include` takes
    /// one in, beginning with `none`, and `unite` puts two parts together, in any grouping.
    pub fn fold_vertices<T: Copy + Send + Sync>(
        &self,
        none: T,
        include: impl Fn(T, Vec3) -> T + Sync,
        unite: impl Fn(T, T) -> T + Send + Sync,
    ) -> T {
        let used = self.used_vertices();
        used.par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, used)| {
                let numbered = used.iter().enumerate().filter(|(_, used)| **used);
                numbered
                    .map(|(i, _)| self.positions.get(chunk * CHUNK + i))
                    .filter(|p| p.is_finite())
                    .fold(none, &include)
            })
            .reduce(|| none, unite)
    }

    /// The box around all finite vertices that a triangle uses.
    pub fn bounds(&self) -> Aabb {
        self.fold_vertices(Aabb::EMPTY, |bounds, p| bounds.including(p), |a, b| a.union(&b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vec3;

    #[test]
    fn every_finite_vertex_that_is_used_counts_once() {
        // More than one thread takes at a time; every vertex is in three triangles or in none.
        let count = 3 * CHUNK as u32;
        let mut positions: Vec<[f64; 3]> =
            (0..count).map(|i| [f64::from(i), -1.0, f64::from(i % 7)]).collect();
        let unused = [0, count / 2, count - 1];
        for i in unused {
            positions[i as usize] = [1e9; 3];
        }
        positions[5] = [f64::NAN, 1e9, 0.0];
        positions[CHUNK + 1] = [1e9, f64::INFINITY, 0.0];
        let used: Vec<u32> = (0..count).filter(|i| !unused.contains(i)).collect();
        let triangles: Vec<_> = (0..used.len())
            .map(|i| [0, 1, 2].map(|corner| used[(i + corner) % used.len()]))
            .collect();
        let mesh = Mesh::new(Positions::F64(positions.into()), triangles).unwrap();

        let seen = mesh.fold_vertices(0, |n, _| n + 1, |a, b| a + b);
        assert_eq!(seen, used.len() - 2);
        let last = f64::from(count - 2);
        let bounds = Aabb { min: vec3(1.0, -1.0, 0.0), max: vec3(last, -1.0, 6.0) };
        assert_eq!(mesh.bounds(), bounds);
    }
}
