//! From arguments to an exit code.

use std::ffi::OsString;
use std::io::Write;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};

use crate::arguments::{Arguments, Command};
use crate::commands;
use crate::failure::Failure;
use crate::host::Host;
use crate::interrupt;
use crate::one_line::one_line;
use crate::session::Session;

/// Exit codes, besides 0, clap's 2 and [`interrupt::EXIT_CODE`].
const FAILED: u8 = 1;

/// Does what `arguments` say, the first of which is the program's name, and returns the exit code:
/// 0 done, 1 the input or the work failed (one line on stderr), 2 wrong arguments, 130 interrupted.
///
/// This is the command in all respects: it prints on the process's stdout and stderr, makes rayon's
/// global thread pool of as many threads as `--threads` says, and listens to SIGINT, SIGTERM and
/// SIGHUP. The first signal makes this function return 130; if it cannot within 0.8 seconds, or at the
/// second signal, the process ends. Handlers that the process had are called as well: a host with one
/// that does more than the default should put the default in its place first.
///
/// It is made to be called once in a process. Called again, it does the same, but cannot change
/// the number of threads any more, and says so.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    run_with(arguments, None)
}

/// [`run`] inside of `host`, which can do more than the command by itself.
pub fn run_with(arguments: impl IntoIterator<Item = OsString>, host: Option<&dyn Host>) -> u8 {
    match Arguments::try_parse_from(arguments) {
        Ok(arguments) => outcome(execute(&arguments, host)),
        Err(error) => tell(&error),
    }
}

fn execute(arguments: &Arguments, host: Option<&dyn Host>) -> Result<(), Failure> {
    halfline::quiet_guarded_panics();
    let _listening = interrupt::listen()?;
    let session = Session::start(&arguments.global)?;
    match &arguments.command {
        Command::Render(options) => commands::render::run(options, session, host),
        Command::Info(options) => commands::info::run(options, session),
        Command::Doctor(options) => commands::doctor::run(options, session),
        Command::Query(options) => commands::query::run(options, session),
        Command::Distance(options) => commands::distance::run(options, session),
        Command::Explain(options) => commands::explain::run(options, session),
        Command::Study(options) => commands::study::run(options, session),
        Command::Build(options) => commands::build::run(options, session),
        Command::Generate(options) => commands::generate::run(options, session),
    }
}

/// Says how it ended, unless well.
fn outcome(result: Result<(), Failure>) -> u8 {
    match result {
        Ok(()) => 0,
        Err(Failure::Usage(message)) => {
            tell(&Arguments::command().error(ErrorKind::ValueValidation, message))
        }
        Err(Failure::Work(error))
            if matches!(error, halfline::Error::Interrupted) || interrupt::is_ending() =>
        {
            interrupt::say();
            interrupt::EXIT_CODE
        }
        Err(Failure::Work(error)) => {
            complain(&format!("halfline: error: {}", one_line(&error.to_string())));
            FAILED
        }
    }
}

/// Prints help, the version or what is wrong with the arguments where each belongs. That nobody listens
/// there is no reason to fail.
fn tell(error: &clap::Error) -> u8 {
    let _ = error.print();
    let _ = std::io::stdout().flush();
    // Clap knows 0 and 2 alone.
    error.exit_code() as u8
}

/// Says `line` on stderr; that nobody listens there is no reason to fail.
fn complain(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
