//! Files that appear whole or not at all.

use std::io::Write;
use std::path::PathBuf;

use halfline::Error;
use halfline::storage::AtomicFile;
use pyo3::prelude::*;

use crate::call::on_pool;

/// Writes `content` beside `path`, and renames it once it is on the disk.
#[pyfunction]
#[pyo3(signature = (path, content, /))]
pub fn write_file(py: Python, path: PathBuf, content: &[u8]) -> PyResult<()> {
    on_pool(py, None, |_| {
        let mut file = AtomicFile::create(&path)?;
        file.write_all(content).map_err(|error| Error::io(&path, error))?;
        file.commit()
    })
}
