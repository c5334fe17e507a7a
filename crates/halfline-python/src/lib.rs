//! `halfline._native`, what the Python package in `python/halfline` is made of: it converts and
//! forwards. Arguments are checked there, where the messages are easier to make, but for
//! the settings of pictures.

mod arrays;
mod call;
mod command;
mod error;
mod explanation;
mod file;
mod mesh;
mod pool;
mod render;
mod scene;
mod settings;

/// The compiled part of halfline. Use the package `halfline`; nothing here is meant to last.
#[pyo3::pymodule(gil_used = false)]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::command::main;
    #[pymodule_export]
    use crate::error::FormatError;
    #[pymodule_export]
    use crate::explanation::Explanation;
    #[pymodule_export]
    use crate::file::write_file;
    #[pymodule_export]
    use crate::mesh::{Mesh, MeshArray};
    #[pymodule_export]
    use crate::pool::{set_thread_count, thread_count};
    #[pymodule_export]
    use crate::render::{Picture, Rendering, encode_png};
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::settings::Settings;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // What a damaged tree file leads to becomes an exception, and needs no message besides.
        halfline::quiet_guarded_panics();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
