//! What a build without some features says of what it lacks.

use halfline::Error;

#[cfg(not(feature = "default"))]
pub use subcommand::{Options, run};

const HOW_TO_GET_IT: &str =
    "`make release` or `cargo build --release --package halfline-cli` builds all of halfline";

/// The error about `what`, which this build lacks.
pub fn lacking(what: &str) -> Error {
    Error::invalid(what, format!("this build of halfline lacks it; {HOW_TO_GET_IT}"))
}

/// Adds to the error about a file of a format which this build lacks how to get it.
pub fn explained(error: Error) -> Error {
    match error {
        Error::Format { path, place, reason } if reason.contains("without its feature") => {
            Error::Format { path, place, reason: format!("{reason}; {HOW_TO_GET_IT}") }
        }
        other => other,
    }
}

/// What stands in the place of a subcommand.
#[cfg(not(feature = "default"))]
mod subcommand {
    use std::ffi::OsString;

    use clap::Args;

    use crate::failure::Failure;
    use crate::session::Session;

    /// Whatever is said to it.
    #[derive(Debug, Args)]
    #[command(after_help = "This build of halfline lacks it.")]
    pub struct Options {
        #[arg(hide = true, allow_hyphen_values = true)]
        arguments: Vec<OsString>,
    }

    /// Refuses.
    pub fn run(_options: &Options, _session: Session) -> Result<(), Failure> {
        Err(super::lacking("this subcommand").into())
    }
}
