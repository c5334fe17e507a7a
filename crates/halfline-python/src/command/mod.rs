//! The `halfline` command, which comes with the wheel; nothing else here knows it.

mod cluster;

use std::ffi::OsString;

use halfline_cli::Host;
use pyo3::prelude::*;

use self::cluster::PythonHost;

/// Runs the command with these arguments, the program's name first, and returns its exit code.
/// `connect` is called with the address of a cluster, if one is asked for.
#[pyfunction]
#[pyo3(signature = (arguments, connect=None, /))]
pub fn main(py: Python, arguments: Vec<OsString>, connect: Option<Py<PyAny>>) -> u8 {
    let host = connect.map(PythonHost);
    py.detach(|| halfline_cli::run_with(arguments, host.as_ref().map(|host| host as &dyn Host)))
}
