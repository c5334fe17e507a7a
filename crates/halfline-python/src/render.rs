//! Pictures: `halfline._native.Picture`, of which rows can be traced apart, and
//! `halfline._native.Rendering`, what comes out.

use std::io::BufWriter;
use std::path::PathBuf;
use std::sync::Arc;

use halfline::Error;
use halfline::error::Result;
use halfline::geometry::NO_FACE;
use halfline::storage::AtomicFile;
use halfline_render::{Plan, Rows, assemble, write_png};
use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::call::{Progress, on_pool};
use crate::scene::Scene;
use crate::settings::{Settings, renamed};

/// A picture that is planned: its rows can be traced in any order, here or elsewhere.
#[pyclass(frozen, module = "halfline._native")]
pub struct Picture(Plan<Arc<halfline::Scene>>);

#[pymethods]
impl Picture {
    #[new]
    #[pyo3(signature = (scene, settings, /))]
    fn new(py: Python, scene: &Scene, settings: &Settings) -> PyResult<Picture> {
        let scene = Arc::clone(&scene.scene);
        let planned = on_pool(py, None, |_| Ok(Plan::new(scene, &settings.0)))?;
        planned.map(Picture).map_err(|error| renamed(py, error))
    }

    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.0.settings().width, self.0.settings().height)
    }

    /// Rows `first..end`, as bytes for [`Rendering::assemble`].
    #[pyo3(signature = (first, end, progress=None, /))]
    fn trace_rows<'py>(
        &self,
        py: Python<'py>,
        first: u32,
        end: u32,
        progress: Progress,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = on_pool(py, progress, |observer| {
            Ok(self.0.trace_rows(first..end, observer)?.to_bytes())
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Traces all rows, and puts them together.
    #[pyo3(signature = (progress=None, /))]
    fn trace(&self, py: Python, progress: Progress) -> PyResult<Rendering> {
        let rendering = on_pool(py, progress, |observer| {
            let settings = self.0.settings();
            assemble(settings, [self.0.trace_rows(0..settings.height, observer)?])
        })?;
        Ok(Rendering(rendering))
    }
}

/// A picture that is finished.
#[pyclass(frozen, module = "halfline._native")]
pub struct Rendering(halfline_render::Rendering);

/// The layers of a picture, flat: linear colours, depth, normals, faces, and steps.
type Layers<'py> = (
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<i64>>,
    Option<Bound<'py, PyArray1<f32>>>,
);

#[pymethods]
impl Rendering {
    /// The picture that rows make together.
    #[staticmethod]
    #[pyo3(signature = (settings, parts, /))]
    fn assemble(py: Python, settings: &Settings, parts: Vec<Vec<u8>>) -> PyResult<Rendering> {
        let rendering = on_pool(py, None, |_| {
            let rows: Result<Vec<Rows>> =
                parts.iter().map(|bytes| Rows::from_bytes(bytes)).collect();
            assemble(&settings.0, rows?)
        })?;
        Ok(Rendering(rendering))
    }

    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.0.width, self.0.height)
    }

    /// Eight-bit sRGB colours, flat, and how many there are for a pixel: three if nothing is
    /// transparent.
    fn pixels<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray1<u8>>, usize)> {
        let (pixels, channels) = on_pool(py, None, |_| Ok(self.0.to_bytes()))?;
        Ok((PyArray1::from_vec(py, pixels), channels))
    }

    fn layers<'py>(&self, py: Python<'py>) -> Layers<'py> {
        let picture = &self.0;
        let face =
            picture.face.iter().map(|&face| if face == NO_FACE { -1 } else { i64::from(face) });
        (
            PyArray1::from_slice(py, picture.color.as_flattened()),
            PyArray1::from_slice(py, &picture.depth),
            PyArray1::from_slice(py, picture.normal.as_flattened()),
            PyArray1::from_iter(py, face),
            picture.steps.as_ref().map(|steps| PyArray1::from_slice(py, steps.as_flattened())),
        )
    }

    /// Rays by what they were for.
    fn rays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let rays = self.0.statistics.rays;
        let counts = PyDict::new(py);
        counts.set_item("primary", rays.primary)?;
        counts.set_item("occlusion", rays.occlusion)?;
        counts.set_item("shadow", rays.shadow)?;
        counts.set_item("reflection", rays.reflection)?;
        counts.set_item("refraction", rays.refraction)?;
        Ok(counts)
    }

    /// Writes a PNG or an OpenEXR, as `is_exr` says, beside `path` and renames it.
    #[pyo3(signature = (path, is_exr, /))]
    fn save(&self, py: Python, path: PathBuf, is_exr: bool) -> PyResult<()> {
        on_pool(py, None, |_| {
            let mut file = AtomicFile::create(&path)?;
            let written = match is_exr {
                true => self.0.write_exr(&mut file),
                false => self.0.write_png(BufWriter::new(&mut file)),
            };
            written.map_err(|error| Error::io(&path, error))?;
            file.commit()
        })
    }
}

/// Eight-bit sRGB pixels of three or four channels as PNG.
#[pyfunction]
#[pyo3(signature = (pixels, width, height, channels, /))]
pub fn encode_png<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArrayDyn<u8>,
    width: u32,
    height: u32,
    channels: usize,
) -> PyResult<Bound<'py, PyBytes>> {
    let pixels = pixels.as_slice()?;
    let mut bytes = Vec::new();
    py.detach(|| write_png(&mut bytes, width, height, pixels, channels))?;
    Ok(PyBytes::new(py, &bytes))
}
