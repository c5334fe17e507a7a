//! What all subcommands share: threads, progress, interruption, and how results are told.

use std::error::Error as _;
use std::path::Path;
use std::time::Instant;

use halfline::progress::{Observer, Stage};
use halfline::{Error, Mesh};
use serde::Serialize;

use crate::failure::Failure;
use crate::global_options::GlobalOptions;
use crate::progress::{self, Progress};
use crate::report::Report;
use crate::{input, left_out, output};

/// One run of the command.
pub struct Session {
    progress: Progress,
    quiet: bool,
    json: bool,
}

impl Session {
    /// Sets up threads and progress as `options` wish.
    pub fn start(options: &GlobalOptions) -> Result<Session, Failure> {
        make_threads(options.threads.into())?;
        Ok(Session {
            progress: Progress::start(options.quiet),
            quiet: options.quiet,
            json: options.json,
        })
    }

    /// Who hears of progress.
    pub fn observer(&self) -> &dyn Observer {
        &self.progress
    }

    /// True if figures are to be told as JSON.
    pub fn wants_json(&self) -> bool {
        self.json
    }

    /// From here on progress is that of `stage`.
    pub fn begin(&self, stage: Stage) {
        self.progress.begin(stage, progress::name(stage));
    }

    /// Does `work`, which is `stage`, and tells its result and how many seconds it took.
    pub fn timed<T>(
        &self,
        stage: Stage,
        work: impl FnOnce(&dyn Observer) -> halfline::error::Result<T>,
    ) -> Result<(T, f64), Failure> {
        self.timed_as(stage, progress::name(stage), work)
    }

    /// [`Session::timed`], for a stage that people know as `name`.
    pub fn timed_as<T>(
        &self,
        stage: Stage,
        name: &'static str,
        work: impl FnOnce(&dyn Observer) -> halfline::error::Result<T>,
    ) -> Result<(T, f64), Failure> {
        self.progress.begin(stage, name);
        let start = Instant::now();
        let result = work(self.observer())?;
        let seconds = start.elapsed().as_secs_f64();
        self.observer().check()?;
        Ok((result, seconds))
    }

    /// Reads a mesh from a file or standard input, and tells how many seconds it took.
    pub fn load(&self, path: &Path) -> Result<(Mesh, f64), Failure> {
        self.timed(Stage::Load, |observer| match input::is_stdin(path) {
            true => {
                let (name, most) = (input::name(path), input::MOST_STDIN_BYTES);
                halfline_io::load_stream(name, std::io::stdin(), most, observer)
                    .map_err(left_out::explained)
            }
            false => halfline_io::load(path, observer).map_err(left_out::explained),
        })
    }

    /// Prints `report`: its figures if JSON is wanted, otherwise its text, unless that is to be quiet.
    pub fn tell<R: Report>(self, report: &R) -> Result<(), Failure> {
        match self.json {
            true => self.tell_figures(report),
            false => self.tell_text(|| report.to_text(), R::IS_THE_RESULT),
        }
    }

    /// Prints `figures` as JSON.
    pub fn tell_figures(self, figures: &impl Serialize) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(figures).expect("figures are plain data");
        // The bar must be gone before anything else is printed on the same terminal.
        drop(self.progress);
        output::print(&(json + "\n"))
    }

    /// Prints `text`: always if it `is_the_result`, or unless quiet if it only speaks of a result that
    /// lies in a file.
    pub fn tell_text(
        self,
        text: impl FnOnce() -> String,
        is_the_result: bool,
    ) -> Result<(), Failure> {
        drop(self.progress);
        match is_the_result || !self.quiet {
            true => output::print(&text()),
            false => Ok(()),
        }
    }
}

/// Makes the process's pool of `wanted` threads, or of one for each core if 0.
fn make_threads(wanted: usize) -> Result<(), Failure> {
    let Err(error) = rayon::ThreadPoolBuilder::new().num_threads(wanted).build_global() else {
        return Ok(());
    };
    // The pool is the process's for good, and whoever came first made it.
    let made_before = error.source().is_none();
    let there = rayon::current_num_threads();
    match made_before {
        true if wanted == 0 || wanted == there => Ok(()),
        true => {
            let reason = format!("{wanted} is too late: this process works with {there} already");
            Err(Error::invalid("--threads", reason).into())
        }
        false => Err(Error::invalid("--threads", error.to_string()).into()),
    }
}

/// The most memory that the process has held so far, where the system tells it.
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kibibytes = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(kibibytes.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()? * 1024)
}
