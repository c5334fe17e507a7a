//! The library's errors as Python's exceptions.

use halfline::Error;
use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyValueError};
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
        Error::Io { path, source } => match source.raw_os_error() {
            // Python chooses the subclass by the number.
            Some(number) => match system_text(py, number) {
                Ok(text) => PyOSError::new_err((number, text, path.into_os_string())),
                Err(error) => error,
            },
            // Where the library itself found the reason, there is its kind.
            None => {
                let text = format!("{}: {source}", path.display());
                let exception = PyErr::from(std::io::Error::new(source.kind(), text));
                let named = exception.value(py).setattr("filename", path.into_os_string());
                named.err().unwrap_or(exception)
            }
        },
        Error::Format { .. } => FormatError::new_err(error.to_string()),
        Error::Invalid { .. } => PyValueError::new_err(error.to_string()),
    }
}

/// What Python says about an error of the system.
fn system_text(py: Python, number: i32) -> PyResult<String> {
    py.import("os")?.call_method1("strerror", (number,))?.extract()
}
