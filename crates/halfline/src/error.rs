//! The one error type of the library.

use std::path::{Path, PathBuf};

/// What can go wrong. Each variant prints as one line that names the file or argument, the place
/// in it, and the reason.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused to open, read, map or write a file.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },

    /// A file's content breaks its format, or asks for something that is not supported.
    #[error("{}: {place}: {reason}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Where in the file: `line 12`, `byte 1234`, `face 7`, `header`, `accessor 3`.
        place: String,
        /// What is wrong there, and what was expected.
        reason: String,
    },

    /// An argument or a combination of arguments makes no sense.
    #[error("{what}: {reason}")]
    Invalid {
        /// The argument.
        what: String,
        /// What is wrong with it, and what was expected.
        reason: String,
    },

    /// The work was stopped by its [`Observer`](crate::progress::Observer).
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// An [`Error::Io`] about `path`.
    pub fn io(path: &Path, source: std::io::Error) -> Self {
        Error::Io { path: path.to_owned(), source }
    }

    /// An [`Error::Format`] at `place` in `path`.
    pub fn format(path: &Path, place: impl Into<String>, reason: impl Into<String>) -> Self {
        Error::Format { path: path.to_owned(), place: place.into(), reason: reason.into() }
    }

    /// An [`Error::Invalid`] about the argument `what`.
    pub fn invalid(what: impl Into<String>, reason: impl Into<String>) -> Self {
        Error::Invalid { what: what.into(), reason: reason.into() }
    }
}

/// The library's result type.
pub type Result<T> = std::result::Result<T, Error>;
