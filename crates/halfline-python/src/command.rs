//! The `halfline` command, which comes with the wheel.

use pyo3::exceptions::PyNotImplementedError;
use pyo3::prelude::*;

/// Runs the command with these arguments, the program's name first, and returns its exit code.
// PLUG: `halfline_cli::run(arguments)` goes here, detached from the interpreter; the dependency on
// halfline-cli, and `arguments: Vec<OsString>`.
#[pyfunction]
#[pyo3(signature = (arguments, /))]
pub fn main(arguments: Vec<String>) -> PyResult<u8> {
    let _ = arguments;
    Err(PyNotImplementedError::new_err("the command is not part of the package yet"))
}
