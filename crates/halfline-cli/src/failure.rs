//! How a run of the command fails.

use halfline::Error;

/// Why a subcommand ends without its result.
#[derive(Debug)]
pub enum Failure {
    /// The arguments make no sense together.
    Usage(String),
    /// The input or the work failed, or the user ended it.
    Work(Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        Failure::Work(error)
    }
}
