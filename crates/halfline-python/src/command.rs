//! The `halfline` command, which comes with the wheel.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command with these arguments, the program's name first, and returns its exit code.
#[pyfunction]
#[pyo3(signature = (arguments, /))]
pub fn main(py: Python, arguments: Vec<OsString>) -> u8 {
    py.detach(|| halfline_cli::run(arguments))
}
