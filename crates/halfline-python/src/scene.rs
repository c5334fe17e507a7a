//! `halfline._native.Scene`.

use std::path::PathBuf;
use std::sync::Arc;

use halfline::Inside;
use halfline::Preset;
use halfline::columns::{ClosestPointColumns, HitColumns, RayColumns};
use halfline::tree::Verify;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{NumberArray, Places, VectorArray, check_places, image_width, rows_mut};
use crate::call::{Progress, here, on_pool};
use crate::error::exception;
use crate::mesh::Mesh;

/// Up to so many rays are cast by the calling thread, since the library would give all of them to one
/// thread anyway: to wake another takes as long as some hundred rays.
const FEW: usize = 1 << 12;

/// A mesh with its tree, which never change.
#[pyclass(frozen, module = "halfline._native")]
pub struct Scene {
    pub scene: Arc<halfline::Scene>,
}

/// The file of a scene: path, content hash, mesh hash, bytes.
type FileFigures = (PathBuf, String, String, u64);

/// All hits of each ray: splits, t, face, and u and v by turns.
type AllHits<'py> = (
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
);

/// Lends the arguments of a question to the library.
macro_rules! columns {
    ($py:expr, $count:expr, $origins:expr, $directions:expr, $t_min:expr, $t_max:expr) => {
        RayColumns::new(
            $count,
            $origins.column()?,
            $directions.column()?,
            $t_min.column()?,
            $t_max.column()?,
        )
        .map_err(|error| exception($py, error))?
    };
}

/// Asks a question about `count` rays where it is best answered.
macro_rules! ask {
    ($py:expr, $count:expr, $progress:expr, $work:expr) => {
        if $count <= FEW { here($py, $progress, $work) } else { on_pool($py, $progress, $work) }
    };
}

#[pymethods]
#[expect(clippy::too_many_arguments, reason = "they are those of the questions in Python")]
impl Scene {
    #[staticmethod]
    #[pyo3(signature = (mesh, preset, progress=None, /))]
    fn build(py: Python, mesh: &Mesh, preset: &str, progress: Progress) -> PyResult<Scene> {
        let preset: Preset = preset.parse().map_err(|error| exception(py, error))?;
        let mesh = mesh.0.clone();
        let scene = on_pool(py, progress, |observer| {
            halfline::Scene::builder(mesh).preset(preset).observer(observer).build()
        })?;
        Ok(Scene { scene: Arc::new(scene) })
    }

    /// `verify` is True for always, False for never, None for if the file was touched.
    #[staticmethod]
    #[pyo3(signature = (path, verify=None, progress=None, /))]
    fn open(
        py: Python,
        path: PathBuf,
        verify: Option<bool>,
        progress: Progress,
    ) -> PyResult<Scene> {
        let verify = match verify {
            Some(true) => Verify::Always,
            Some(false) => Verify::Never,
            None => Verify::IfTouched,
        };
        let scene =
            on_pool(py, progress, |observer| halfline::Scene::open(&path, verify, observer))?;
        Ok(Scene { scene: Arc::new(scene) })
    }

    #[pyo3(signature = (path, progress=None, /))]
    fn save(&self, py: Python, path: PathBuf, progress: Progress) -> PyResult<()> {
        on_pool(py, progress, |observer| self.scene.save(&path, observer))
    }

    #[getter]
    fn file(&self) -> Option<FileFigures> {
        let file = self.scene.tree_file()?;
        let hashes = [file.content_hash(), file.mesh_hash()].map(|hash| hash.to_string());
        let [content_hash, mesh_hash] = hashes;
        Some((file.path().to_owned(), content_hash, mesh_hash, file.bytes()))
    }

    #[getter]
    fn mesh(&self) -> Mesh {
        Mesh(Arc::clone(self.scene.mesh()))
    }

    #[getter]
    fn preset(&self) -> &'static str {
        self.scene.build_parameters().preset_name()
    }

    /// The figures of the tree that are not those of the mesh.
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let statistics = on_pool(py, None, |_| self.scene.guarded(|| Ok(self.scene.statistics())))?;
        let tree = PyDict::new(py);
        tree.set_item("depth", statistics.depth)?;
        tree.set_item("nodes", statistics.nodes)?;
        tree.set_item("spatial_splits", statistics.spatial_splits)?;
        tree.set_item("object_splits", statistics.object_splits)?;
        tree.set_item("leaves", statistics.leaves)?;
        tree.set_item("children_per_node", statistics.children_per_node)?;
        tree.set_item("leaves_by_size", statistics.leaves_by_size)?;
        tree.set_item("references", statistics.references)?;
        tree.set_item("references_per_triangle", statistics.references_per_triangle)?;
        tree.set_item("sah_cost", statistics.sah_cost)?;
        tree.set_item("bytes", statistics.bytes)?;
        tree.set_item("bytes_per_triangle", statistics.bytes_per_triangle)?;

        let [degenerate, non_finite] =
            [self.scene.tree().skipped_zero_area, self.scene.tree().skipped_non_finite];
        let info = PyDict::new(py);
        info.set_item("skipped", degenerate + non_finite)?;
        info.set_item("skipped_degenerate", degenerate)?;
        info.set_item("skipped_non_finite", non_finite)?;
        info.set_item("preset", self.scene.build_parameters().preset_name())?;
        info.set_item("tree", tree)?;
        info.set_item("build_seconds", self.scene.build_time().as_secs_f64())?;
        Ok(info)
    }

    #[pyo3(signature = (origins, directions, t_min, t_max, t, face, uv, progress=None, /))]
    fn intersect(
        &self,
        py: Python,
        origins: VectorArray,
        directions: VectorArray,
        t_min: NumberArray,
        t_max: NumberArray,
        mut t: Places<f64>,
        mut face: Places<i64>,
        mut uv: Places<f64>,
        progress: Progress,
    ) -> PyResult<()> {
        let width = image_width(&t);
        let (t, face, uv) = (t.as_slice_mut()?, face.as_slice_mut()?, uv.as_slice_mut()?);
        let (uv, count) = (rows_mut(uv)?, t.len());
        check_places(count, &[face.len(), uv.len()])?;
        let rays = columns!(py, count, origins, directions, t_min, t_max).with_image_width(width);
        let hits = HitColumns { t, face, uv };
        ask!(py, count, progress, |observer| self
            .scene
            .observed(observer)
            .intersect_columns(&rays, hits))
    }

    #[pyo3(signature = (origins, directions, t_min, t_max, flags, progress=None, /))]
    fn occluded(
        &self,
        py: Python,
        origins: VectorArray,
        directions: VectorArray,
        t_min: NumberArray,
        t_max: NumberArray,
        mut flags: Places<bool>,
        progress: Progress,
    ) -> PyResult<()> {
        let width = image_width(&flags);
        let flags = flags.as_slice_mut()?;
        let count = flags.len();
        let rays = columns!(py, count, origins, directions, t_min, t_max).with_image_width(width);
        ask!(py, count, progress, |observer| self
            .scene
            .observed(observer)
            .occluded_columns(&rays, flags))
    }

    #[pyo3(signature = (origins, directions, t_min, t_max, counts, progress=None, /))]
    fn count_intersections(
        &self,
        py: Python,
        origins: VectorArray,
        directions: VectorArray,
        t_min: NumberArray,
        t_max: NumberArray,
        mut counts: Places<i64>,
        progress: Progress,
    ) -> PyResult<()> {
        let width = image_width(&counts);
        let counts = counts.as_slice_mut()?;
        let count = counts.len();
        let rays = columns!(py, count, origins, directions, t_min, t_max).with_image_width(width);
        ask!(py, count, progress, |observer| {
            self.scene.observed(observer).count_intersections_columns(&rays, counts)
        })
    }

    #[pyo3(signature = (points, max_distance, distance, point, face, uv, feature, progress=None, /))]
    fn closest_points(
        &self,
        py: Python,
        points: VectorArray,
        max_distance: NumberArray,
        mut distance: Places<f64>,
        mut point: Places<f64>,
        mut face: Places<i64>,
        mut uv: Places<f64>,
        mut feature: Places<u8>,
        progress: Progress,
    ) -> PyResult<()> {
        let (distance, face) = (distance.as_slice_mut()?, face.as_slice_mut()?);
        let (point, uv) = (rows_mut(point.as_slice_mut()?)?, rows_mut(uv.as_slice_mut()?)?);
        let (feature, count) = (feature.as_slice_mut()?, distance.len());
        check_places(count, &[point.len(), face.len(), uv.len(), feature.len()])?;
        let (points, max_distance) = (points.column()?, max_distance.column()?);
        let nearest = ClosestPointColumns { distance, point, face, uv, feature };
        ask!(py, count, progress, |observer| {
            self.scene.observed(observer).closest_points_columns(points, max_distance, nearest)
        })
    }

    #[pyo3(signature = (points, distance, progress=None, /))]
    fn signed_distance(
        &self,
        py: Python,
        points: VectorArray,
        mut distance: Places<f64>,
        progress: Progress,
    ) -> PyResult<()> {
        let (points, distance) = (points.column()?, distance.as_slice_mut()?);
        ask!(py, distance.len(), progress, |observer| {
            self.scene.observed(observer).signed_distances_columns(points, distance)
        })
    }

    #[pyo3(signature = (points, numbers, progress=None, /))]
    fn winding_number(
        &self,
        py: Python,
        points: VectorArray,
        mut numbers: Places<f64>,
        progress: Progress,
    ) -> PyResult<()> {
        let (points, numbers) = (points.column()?, numbers.as_slice_mut()?);
        ask!(py, numbers.len(), progress, |observer| {
            self.scene.observed(observer).winding_numbers_columns(points, numbers)
        })
    }

    #[pyo3(signature = (points, rule, flags, progress=None, /))]
    fn contains(
        &self,
        py: Python,
        points: VectorArray,
        rule: &str,
        mut flags: Places<bool>,
        progress: Progress,
    ) -> PyResult<()> {
        let rule: Inside = rule.parse().map_err(|error| exception(py, error))?;
        let (points, flags) = (points.column()?, flags.as_slice_mut()?);
        ask!(py, flags.len(), progress, |observer| {
            self.scene.observed(observer).contains_columns(points, rule, flags)
        })
    }

    #[pyo3(signature = (count, origins, directions, t_min, t_max, progress=None, /))]
    fn intersect_all<'py>(
        &self,
        py: Python<'py>,
        count: usize,
        origins: VectorArray,
        directions: VectorArray,
        t_min: NumberArray,
        t_max: NumberArray,
        progress: Progress,
    ) -> PyResult<AllHits<'py>> {
        let rays = columns!(py, count, origins, directions, t_min, t_max);
        let all = ask!(py, count, progress, |observer| {
            self.scene.observed(observer).intersect_all_columns(&rays)
        })?;
        Ok((
            PyArray1::from_vec(py, all.splits),
            PyArray1::from_vec(py, all.t),
            PyArray1::from_vec(py, all.face),
            PyArray1::from_vec(py, all.uv.into_flattened()),
        ))
    }
}
