//! The halfline command; what it does is in the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(halfline_cli::run(std::env::args_os()))
}
