//! The halfline command: `render`, `info`, `doctor`, `query`, `generate`.
//!
//! Exit codes: 0 done, 1 the input or the work failed (one line on stderr), 2 wrong arguments,
//! 130 interrupted.

mod arguments;
mod commands;
mod engine;
mod failure;
mod global_options;
mod interrupt;
mod npz;
mod output;
mod progress;
mod session;
mod table;
mod tree_options;
mod units;
mod values;

use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use arguments::{Arguments, Command};
use failure::Failure;
use session::Session;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Usage(message)) => {
            let mut command = Arguments::command();
            command.error(clap::error::ErrorKind::ValueValidation, message).exit()
        }
        Err(Failure::Work(halfline::Error::Interrupted)) => {
            complain("halfline: interrupted");
            ExitCode::from(interrupt::EXIT_CODE)
        }
        Err(Failure::Work(error)) => {
            complain(&format!("halfline: error: {}", one_line(&error.to_string())));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let session = Session::start(&arguments.global)?;
    match &arguments.command {
        Command::Render(options) => commands::render::run(options, session),
        Command::Info(options) => commands::info::run(options, session),
        Command::Doctor(options) => commands::doctor::run(options, session),
        Command::Query(options) => commands::query::run(options, session),
        Command::Generate(options) => commands::generate::run(options, session),
    }
}

/// Says `line` on stderr; that nobody listens there is no reason to fail.
fn complain(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// `text` with its control characters escaped: a file's name may hold line breaks, an error
/// message may not.
fn one_line(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut line, c| {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
        line
    })
}

#[cfg(test)]
mod tests {
    use super::one_line;

    #[test]
    fn control_characters_do_not_break_the_line() {
        assert_eq!(one_line("a\nb\t\u{1b}[2J é"), "a\\nb\\t\\u{1b}[2J é");
    }
}
