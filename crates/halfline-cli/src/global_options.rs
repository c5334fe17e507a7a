//! What can be said to every subcommand.

use clap::Args;

/// Options that every subcommand takes.
#[derive(Debug, Args)]
#[command(next_help_heading = "Everywhere")]
pub struct GlobalOptions {
    /// No progress and no summary; errors still speak
    #[arg(long, global = true)]
    pub quiet: bool,

    /// Print all figures as one JSON object on stdout, and nothing else there
    #[arg(long, global = true)]
    pub json: bool,

    /// Threads to work with; 0 for all that the machine has
    #[arg(long, global = true, value_name = "N", default_value_t = 0, hide_default_value = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub threads: u16,
}
