//! The library's errors as Python's exceptions.

use std::io::ErrorKind;

use halfline::Error;
use pyo3::exceptions::{PyIsADirectoryError, PyKeyboardInterrupt, PyOSError, PyValueError};
use pyo3::prelude::*;

pyo3::create_exception!(
    halfline,
    FormatError,
    PyValueError,
    "A file is not what its format says, or holds what is not supported.\n\n\
     The message is one line that names the file, the place in it, and the reason."
);

/// The exception that tells of `error`.
pub fn exception(py: Python, error: Error) -> PyErr {
    match error {
        Error::Interrupted => PyKeyboardInterrupt::new_err(()),
        Error::Io { path, source } => match number_of(py, &source) {
            // Python chooses the subclass by the number.
            Some(number) => match system_text(py, number) {
                Ok(text) => PyOSError::new_err((number, text, path.into_os_string())),
                Err(error) => error,
            },
            None if source.kind() == std::io::ErrorKind::IsADirectory => {
                PyIsADirectoryError::new_err(format!("{}: {source}", path.display()))
            }
            None => PyOSError::new_err(format!("{}: {source}", path.display())),
        },
        Error::Format { .. } => FormatError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// The number of an error: the system's, or that of the one which the library finds out by itself.
fn number_of(py: Python, error: &std::io::Error) -> Option<i32> {
    error.raw_os_error().or_else(|| match error.kind() {
        ErrorKind::IsADirectory => py.import("errno").ok()?.getattr("EISDIR").ok()?.extract().ok(),
        _ => None,
    })
}

/// What Python says about an error of the system.
fn system_text(py: Python, number: i32) -> PyResult<String> {
    py.import("os")?.call_method1("strerror", (number,))?.extract()
}
