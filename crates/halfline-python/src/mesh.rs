//! `halfline._native.Mesh`.

use std::path::PathBuf;
use std::sync::Arc;

use halfline::Error;
use halfline::error::Result;
use halfline::mesh::{Material, Positions};
use halfline::numeric::SurfacePoint;
use halfline::progress::Observer;
use halfline::storage::Buffer;
use halfline_io::models::{self, Kind};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use crate::arrays::{ColumnArray, FaceArray, Places, VectorArray, check_places, rows, rows_mut};
use crate::call::{Progress, on_pool};

/// Rows that are gone through between two looks at whether the work should end.
const CHUNK: usize = 1 << 14;

/// Vertices and triangles, which never change.
#[pyclass(frozen, module = "halfline._native")]
pub struct Mesh(pub Arc<halfline::Mesh>);

/// Base colour, metallic, roughness, transmission, index of refraction.
type MaterialNumbers = ([f32; 4], f32, f32, f32, f32);

/// What a mesh may have beside vertices and faces, to be pickled: source faces, colours of vertices,
/// materials of triangles, and materials.
type Extras<'py> = (
    Option<Bound<'py, PyArray1<u32>>>,
    Option<Bound<'py, PyArray1<u8>>>,
    Option<Bound<'py, PyArray1<u32>>>,
    Vec<MaterialNumbers>,
);

#[pymethods]
impl Mesh {
    #[staticmethod]
    #[pyo3(signature = (path, progress=None, /))]
    fn load(py: Python, path: PathBuf, progress: Progress) -> PyResult<Mesh> {
        on_pool(py, progress, |observer| halfline_io::load(&path, observer)).map(Mesh::new)
    }

    #[staticmethod]
    #[pyo3(signature = (kind, triangles, seed, progress=None, /))]
    fn generate(
        py: Python,
        kind: &str,
        triangles: usize,
        seed: u64,
        progress: Progress,
    ) -> PyResult<Mesh> {
        on_pool(py, progress, |observer| {
            models::generate(kind.parse::<Kind>()?, triangles, seed, observer)
        })
        .map(Mesh::new)
    }

    #[staticmethod]
    #[pyo3(signature = (vertices, faces, /))]
    fn from_arrays(py: Python, vertices: VectorArray, faces: FaceArray) -> PyResult<Mesh> {
        macro_rules! with_faces {
            ($faces:expr) => {{
                let faces = rows($faces.as_slice()?)?;
                match &vertices {
                    ColumnArray::Single(array) => {
                        let vertices = rows(array.as_slice()?)?;
                        on_pool(py, None, |observer| {
                            mesh_of(vertices, |v| Positions::F32(v.into()), faces, observer)
                        })
                    }
                    ColumnArray::Double(array) => {
                        let vertices = rows(array.as_slice()?)?;
                        on_pool(py, None, |observer| {
                            mesh_of(vertices, |v| Positions::F64(v.into()), faces, observer)
                        })
                    }
                    ColumnArray::Same(_) => {
                        Err(PyValueError::new_err("vertices: expected an array of rows"))
                    }
                }
            }};
        }
        match &faces {
            FaceArray::U32(faces) => with_faces!(faces),
            FaceArray::I32(faces) => with_faces!(faces),
            FaceArray::U64(faces) => with_faces!(faces),
            FaceArray::I64(faces) => with_faces!(faces),
        }
        .map(Mesh::new)
    }

    #[getter]
    fn vertices(slf: &Bound<Self>) -> MeshArray {
        MeshArray { mesh: slf.get().0.clone(), part: Part::Vertices }
    }

    #[getter]
    fn faces(slf: &Bound<Self>) -> MeshArray {
        MeshArray { mesh: slf.get().0.clone(), part: Part::Faces }
    }

    #[getter]
    fn vertex_count(&self) -> usize {
        self.0.positions().len()
    }

    #[getter]
    fn triangle_count(&self) -> usize {
        self.0.triangle_count()
    }

    #[getter]
    fn is_single_precision(&self) -> bool {
        matches!(self.0.positions(), Positions::F32(_))
    }

    fn bounds(&self, py: Python) -> PyResult<Option<[[f64; 3]; 2]>> {
        let bounds = on_pool(py, None, |_| Ok(self.0.bounds()))?;
        Ok((!bounds.is_empty()).then(|| [bounds.min.to_array(), bounds.max.to_array()]))
    }

    /// Writes the points of hits and the unit normals there; NaN for misses.
    fn surface(
        &self,
        py: Python,
        face: PyReadonlyArrayDyn<i64>,
        uv: PyReadonlyArrayDyn<f64>,
        mut points: Places<f64>,
        mut normals: Places<f64>,
    ) -> PyResult<()> {
        let (face, uv) = (face.as_slice()?, rows::<_, 2>(uv.as_slice()?)?);
        let (points, normals) =
            (rows_mut::<_, 3>(points.as_slice_mut()?)?, rows_mut::<_, 3>(normals.as_slice_mut()?)?);
        check_places(face.len(), &[uv.len(), points.len(), normals.len()])?;
        let one = |face: i64, [u, v]: [f64; 2], point: &mut [f64; 3], normal: &mut [f64; 3]| {
            let face = u32::try_from(face).ok();
            let face = face.filter(|&face| (face as usize) < self.0.triangle_count());
            let surface = face.map(|face| SurfacePoint::on_triangle(self.0.corners(face), u, v));
            let nowhere = [f64::NAN; 3];
            *point = surface.as_ref().map_or(nowhere, |surface| surface.point.to_array());
            *normal = surface.as_ref().map_or(nowhere, |surface| surface.normal.to_array());
        };
        if face.len() <= CHUNK {
            py.detach(|| {
                for (((face, uv), point), normal) in face.iter().zip(uv).zip(points).zip(normals) {
                    one(*face, *uv, point, normal);
                }
            });
            return Ok(());
        }
        on_pool(py, None, |observer| {
            let parts = face.par_chunks(CHUNK).zip(uv.par_chunks(CHUNK));
            let places = points.par_chunks_mut(CHUNK).zip(normals.par_chunks_mut(CHUNK));
            parts.zip(places).try_for_each(|((face, uv), (points, normals))| {
                for (((face, uv), point), normal) in face.iter().zip(uv).zip(points).zip(normals) {
                    one(*face, *uv, point, normal);
                }
                observer.check()
            })
        })
    }

    /// Writes where rays along `directions` leave the surface at hits; NaN for misses.
    fn origins_towards(
        &self,
        py: Python,
        face: PyReadonlyArrayDyn<i64>,
        uv: PyReadonlyArrayDyn<f64>,
        directions: PyReadonlyArrayDyn<f64>,
        mut origins: Places<f64>,
    ) -> PyResult<()> {
        let (face, uv) = (face.as_slice()?, rows::<_, 2>(uv.as_slice()?)?);
        let directions = rows::<_, 3>(directions.as_slice()?)?;
        let origins = rows_mut::<_, 3>(origins.as_slice_mut()?)?;
        check_places(face.len(), &[uv.len(), directions.len(), origins.len()])?;
        let one = |face: i64, [u, v]: [f64; 2], direction: [f64; 3]| {
            let face = u32::try_from(face).ok();
            let face = face.filter(|&face| (face as usize) < self.0.triangle_count());
            face.map_or([f64::NAN; 3], |face| {
                let surface = SurfacePoint::on_triangle(self.0.corners(face), u, v);
                surface.origin_towards(direction.into()).to_array()
            })
        };
        on_pool(py, None, |observer| {
            let parts = face.par_chunks(CHUNK).zip(uv.par_chunks(CHUNK));
            let parts = parts.zip(directions.par_chunks(CHUNK)).zip(origins.par_chunks_mut(CHUNK));
            parts.try_for_each(|(((face, uv), directions), origins)| {
                for (((face, uv), direction), origin) in
                    face.iter().zip(uv).zip(directions).zip(origins)
                {
                    *origin = one(*face, *uv, *direction);
                }
                observer.check()
            })
        })
    }

    /// Writes the mesh as binary PLY.
    #[pyo3(signature = (path, progress=None, /))]
    fn save(&self, py: Python, path: PathBuf, progress: Progress) -> PyResult<()> {
        on_pool(py, progress, |observer| halfline_io::save_ply(&self.0, &path, observer))
    }

    fn extras<'py>(&self, py: Python<'py>) -> Extras<'py> {
        let mesh = &self.0;
        let numbers = |numbers: &Buffer<u32>| PyArray1::from_slice(py, numbers);
        let materials = mesh.materials.iter().map(|material| {
            let Material { base_color, metallic, roughness, transmission, ior } = *material;
            (base_color, metallic, roughness, transmission, ior)
        });
        (
            mesh.source_faces.as_ref().map(numbers),
            mesh.vertex_colors.as_ref().map(|c| PyArray1::from_slice(py, c.as_flattened())),
            mesh.triangle_materials.as_ref().map(numbers),
            materials.collect(),
        )
    }

    /// This mesh with other extras, which must have been got from [`Mesh::extras`].
    fn with_extras(&self, extras: Extras) -> PyResult<Mesh> {
        let (source_faces, vertex_colors, triangle_materials, materials) = extras;
        let mut mesh = halfline::Mesh::clone(&self.0);
        let (triangles, vertices) = (mesh.triangle_count(), mesh.positions().len());
        if let Some(source_faces) = source_faces {
            mesh.source_faces = Some(source_faces.to_vec()?.into());
            check_places(triangles, &[source_faces.len()?])?;
        }
        if let Some(vertex_colors) = vertex_colors {
            mesh.vertex_colors = Some(rows(&vertex_colors.to_vec()?)?.to_vec().into());
            check_places(vertices * 4, &[vertex_colors.len()?])?;
        }
        if let Some(triangle_materials) = triangle_materials {
            let numbers = triangle_materials.to_vec()?;
            check_places(triangles, &[numbers.len()])?;
            if numbers.iter().any(|&number| number as usize >= materials.len()) {
                return Err(PyValueError::new_err("a triangle's material is none of the mesh"));
            }
            mesh.triangle_materials = Some(numbers.into());
        }
        mesh.materials = materials
            .into_iter()
            .map(|(base_color, metallic, roughness, transmission, ior)| Material {
                base_color,
                metallic,
                roughness,
                transmission,
                ior,
            })
            .collect();
        Ok(Mesh::new(mesh))
    }
}

impl Mesh {
    fn new(mesh: halfline::Mesh) -> Mesh {
        Mesh(Arc::new(mesh))
    }
}

/// A mesh of copies of these rows.
fn mesh_of<V: Copy + Sync, F: Copy + Sync + TryInto<u32> + std::fmt::Display>(
    vertices: &[[V; 3]],
    positions: impl FnOnce(Vec<[V; 3]>) -> Positions,
    faces: &[[F; 3]],
    observer: &dyn Observer,
) -> Result<halfline::Mesh> {
    let count = vertices.len();
    let mut triangles = Vec::with_capacity(faces.len());
    for faces in faces.chunks(CHUNK) {
        observer.check()?;
        for face in faces {
            let corners = face.map(|index| index.try_into().unwrap_or(u32::MAX));
            if corners.iter().any(|&corner| corner as usize >= count) {
                let ([a, b, c], number) = (face, triangles.len());
                return Err(Error::invalid(
                    "faces",
                    format!(
                        "row {number} is [{a}, {b}, {c}], but the {count} vertices have indices \
                         from 0 to {}",
                        count as i64 - 1
                    ),
                ));
            }
            triangles.push(corners);
        }
    }
    let mut copy = Vec::with_capacity(count);
    for vertices in vertices.chunks(CHUNK) {
        observer.check()?;
        copy.extend_from_slice(vertices);
    }
    halfline::Mesh::new(positions(copy), triangles)
}

/// The array of a mesh, for NumPy to look at where it lies: what NumPy makes of this holds it, and so
/// the mesh.
#[pyclass(frozen, module = "halfline._native")]
pub struct MeshArray {
    mesh: Arc<halfline::Mesh>,
    part: Part,
}

#[derive(Clone, Copy)]
enum Part {
    Vertices,
    Faces,
}

#[pymethods]
impl MeshArray {
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let order = if cfg!(target_endian = "little") { "<" } else { ">" };
        let (address, count, kind) = match (self.part, self.mesh.positions()) {
            (Part::Faces, _) => {
                let triangles = self.mesh.triangles();
                (triangles.as_ptr().expose_provenance(), triangles.len(), "u4")
            }
            (Part::Vertices, Positions::F32(p)) => (p.as_ptr().expose_provenance(), p.len(), "f4"),
            (Part::Vertices, Positions::F64(p)) => (p.as_ptr().expose_provenance(), p.len(), "f8"),
        };
        let is_read_only = true;
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("shape", (count, 3))?;
        interface.set_item("typestr", format!("{order}{kind}"))?;
        interface.set_item("data", (address, is_read_only))?;
        Ok(interface)
    }
}
