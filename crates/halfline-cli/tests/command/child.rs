//! Commands that are started with the signals as a terminal has them, and watched while they work.

use std::io::Write;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once};
use std::thread::sleep;
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
use signal_hook::flag;

/// Longer than anything takes, however busy the machine is: a hang ends here.
const PATIENCE: Duration = Duration::from_secs(300);

/// From here on children have the default action for signals that this process was started to ignore, as
/// `nohup` does, and a shell that starts a job in the background.
///
/// What is ignored stays so in a child, and what has a handler does not: so the signals get a handler that
/// does nothing. (The mask of blocked signals is emptied in a child by the standard library.)
pub fn set_signals() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let ignored = mask_of("self", "SigIgn:");
        for signal in [SIGHUP, SIGINT, SIGQUIT, SIGTERM] {
            match ignored {
                Some(ignored) if !is_in(ignored, signal) => {}
                Some(_) => {
                    flag::register(signal, Arc::new(AtomicBool::new(false))).unwrap();
                }
                // Where nobody tells, a handler that does what is done without one.
                None => {
                    let yes = Arc::new(AtomicBool::new(true));
                    flag::register_conditional_default(signal, yes).unwrap();
                }
            }
        }
    });
}

/// The numbers of a mask of signals of a process; `None` where the system does not tell.
fn mask_of(process: &str, name: &str) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let mask = status.lines().find_map(|line| line.strip_prefix(name))?;
    Some(u64::from_str_radix(mask.trim(), 16).unwrap())
}

fn is_in(mask: u64, signal: i32) -> bool {
    mask >> (signal - 1) & 1 == 1
}

/// Waits until something is so, and fails with what it waited for if that takes for ever.
#[track_caller]
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < PATIENCE, "waited {PATIENCE:?} until {what}");
        sleep(Duration::from_millis(2));
    }
}

/// A command at work. One that a failed test leaves behind is killed.
pub struct Started {
    child: Option<Child>,
    line: String,
}

impl Started {
    /// Starts what will not end by itself within the test, and waits until it listens to signals. Its
    /// standard input stays open, and empty.
    #[track_caller]
    pub fn new(line: &str, command: Command) -> Started {
        Started::with_stderr(line, command, Stdio::piped())
    }

    /// [`Started::new`] with another stderr than a pipe that is read at the end.
    #[track_caller]
    pub fn with_stderr(line: &str, mut command: Command, stderr: Stdio) -> Started {
        set_signals();
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(stderr);
        let child = command.spawn().unwrap();
        // What it was given of ours must not stay open here.
        drop(command);
        let started = Started { child: Some(child), line: line.into() };
        let process = started.child().id().to_string();
        let start = Instant::now();
        wait_until(&format!("`{line}` listens to signals"), || {
            // Where there is no /proc, two seconds have to do.
            mask_of(&process, "SigCgt:")
                .map_or(start.elapsed().as_secs() >= 2, |caught| is_in(caught, SIGINT))
        });
        started
    }

    fn child(&self) -> &Child {
        self.child.as_ref().unwrap()
    }

    /// Sends a signal, as `kill` knows it.
    #[track_caller]
    pub fn send(&self, name: &str) {
        let process = self.child().id().to_string();
        assert!(Command::new("kill").args([name, &process]).status().unwrap().success());
    }

    /// Gives it the beginning of a mesh on standard input, whose rest it then waits for; meanwhile it does
    /// not ask whether to end.
    pub fn feed(&mut self) {
        /// More than a pipe holds, so that it has begun to read once all is written, and less than it reads
        /// between two questions.
        const BYTES: usize = 512 << 10;
        let line = b"v 0 0 0\n";
        let stdin = self.child.as_mut().unwrap().stdin.as_mut().unwrap();
        stdin.write_all(&line.repeat(BYTES / line.len())).unwrap();
    }

    /// Ends its standard input.
    pub fn end_input(&mut self) {
        self.child.as_mut().unwrap().stdin = None;
    }

    /// True once it has ended.
    pub fn has_ended(&mut self) -> bool {
        self.child.as_mut().unwrap().try_wait().unwrap().is_some()
    }

    /// True if a thread of this name works for it; `None` where the system does not tell.
    pub fn has_thread(&self, name: &str) -> Option<bool> {
        let tasks = std::fs::read_dir(self.place().join("task")).ok()?;
        let names = tasks.filter_map(|task| std::fs::read(task.ok()?.path().join("comm")).ok());
        Some(names.into_iter().any(|found| found.trim_ascii_end() == name.as_bytes()))
    }

    fn place(&self) -> PathBuf {
        format!("/proc/{}", self.child().id()).into()
    }

    /// The state of the process as a letter, and the CPU seconds of all its threads so far; `None` where
    /// the system does not tell.
    fn state(&self) -> Option<(String, f64)> {
        /// The unit of these times, the same on all machines since Linux 2.6.
        const TICKS_PER_SECOND: f64 = 100.0;
        let stat = std::fs::read_to_string(self.place().join("stat")).ok()?;
        // The second field is a name in parentheses, which may hold anything.
        let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
        let ticks = fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap();
        Some((fields[0].into(), ticks / TICKS_PER_SECOND))
    }

    /// The CPU seconds of all its threads so far; 0 where the system does not tell.
    pub fn cpu_seconds(&self) -> f64 {
        self.state().map_or(0.0, |(_, seconds)| seconds)
    }

    /// Waits for its end, and tells what it said and the CPU seconds of its whole life; 0 where the system
    /// does not tell.
    #[track_caller]
    pub fn end(mut self) -> (Output, f64) {
        let what = format!("`{}` ends", self.line);
        // It is looked at once more while its end is not fetched.
        let mut cpu_seconds = 0.0;
        wait_until(&what, || match self.state() {
            Some((state, seconds)) => {
                cpu_seconds = seconds;
                state == "Z"
            }
            None => self.has_ended(),
        });
        (self.child.take().unwrap().wait_with_output().unwrap(), cpu_seconds)
    }
}

impl Drop for Started {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
