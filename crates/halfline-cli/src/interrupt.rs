//! Ctrl-C: the first asks the work to end, the second ends the process.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use halfline::Error;

use crate::temporary;

/// What the process answers after it was interrupted: 128 + SIGINT, as shells expect it.
pub const EXIT_CODE: u8 = 130;

/// How long the work may take to end by itself. A promise of one second, less a margin for the
/// process to end; code that cannot ask (a slow disk, a decoder of some other crate) is cut off.
const PATIENCE: Duration = Duration::from_millis(800);

static CANCELLED: AtomicBool = AtomicBool::new(false);

/// True once the user wants the work to end.
pub fn cancelled() -> bool {
    CANCELLED.load(Ordering::Relaxed)
}

/// The number of the run that signals are for; 0 while there is none.
static RUN: AtomicU64 = AtomicU64::new(0);

/// As long as this lives, signals end the work instead of the process.
pub struct Listening;

impl Drop for Listening {
    fn drop(&mut self) {
        RUN.store(0, Ordering::Relaxed);
    }
}

/// From here on SIGINT, SIGTERM and SIGHUP end the work instead of the process.
pub fn listen() -> Result<Listening, Error> {
    /// How often there was a run; handlers stay for good after the first.
    static RUNS: Mutex<u64> = Mutex::new(0);
    let mut runs = RUNS.lock().unwrap_or_else(PoisonError::into_inner);
    // The run is known before the first signal can come for it.
    CANCELLED.store(false, Ordering::Relaxed);
    SAID.reset();
    RUN.store(*runs + 1, Ordering::Relaxed);
    let listening = Listening;
    if *runs == 0 {
        listen_for(on_signal)
            .map_err(|error| Error::invalid("signals", format!("cannot listen: {error}")))?;
    }
    *runs += 1;
    Ok(listening)
}

/// Asks the work to end; false if there is none.
fn on_signal() -> bool {
    let run = RUN.load(Ordering::Relaxed);
    if run == 0 {
        return false;
    }
    if CANCELLED.swap(true, Ordering::Relaxed) {
        end_now();
    }
    std::thread::spawn(move || {
        std::thread::sleep(PATIENCE);
        // A host goes on after the work has ended.
        if RUN.load(Ordering::Relaxed) == run {
            end_now();
        }
    });
    true
}

/// True once the process ends without waiting for the work, whose files are being taken away.
static ENDING: AtomicBool = AtomicBool::new(false);

/// True if the work may fail only because the process ends.
pub fn is_ending() -> bool {
    ENDING.load(Ordering::SeqCst)
}

/// Ends the process without waiting for the work.
fn end_now() -> ! {
    ENDING.store(true, Ordering::SeqCst);
    halfline::storage::abandon_all();
    temporary::remove_all();
    say();
    std::process::exit(EXIT_CODE.into())
}

/// Whether the run has said that it was interrupted. The work and a signal may notice at the same time.
static SAID: Announcement = Announcement(Mutex::new(false));

/// Says on stderr that the run was interrupted, unless it has been said.
pub fn say() {
    SAID.make(|| {
        let mut stderr = std::io::stderr();
        let clear_bar = if stderr.is_terminal() { "\r\x1b[2K" } else { "" };
        // That nobody listens there is no reason to fail.
        let _ = writeln!(stderr, "{clear_bar}halfline: interrupted");
    });
}

/// What is said once, whoever comes first.
struct Announcement(Mutex<bool>);

impl Announcement {
    fn said(&self) -> MutexGuard<'_, bool> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says it, unless it has been said. It has been once this returns, so that whoever comes second may
    /// end the process.
    fn make(&self, say: impl FnOnce()) {
        let mut said = self.said();
        if !std::mem::replace(&mut *said, true) {
            say();
        }
    }

    /// It may be said again.
    fn reset(&self) {
        *self.said() = false;
    }
}

/// Calls `on_signal` at each signal; one that it does not want does what it did before.
#[cfg(unix)]
fn listen_for(on_signal: fn() -> bool) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut wanted = vec![SIGHUP, SIGTERM, SIGINT];
    // `nohup` starts us with SIGHUP ignored, and means it.
    wanted.retain(|&signal| signal != SIGHUP || !is_in_mask("SigIgn:", signal));
    // Handlers of the host are called in any case; only the default action is not.
    let of_host: Vec<i32> =
        wanted.iter().copied().filter(|&signal| is_in_mask("SigCgt:", signal)).collect();
    let mut signals = signal_hook::iterator::Signals::new(wanted)?;
    let listen = move || {
        for signal in signals.forever() {
            if !on_signal() && !of_host.contains(&signal) {
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        }
    };
    std::thread::Builder::new().name("signals".into()).spawn(listen).map(drop)
}

/// Whether `signal` is in a mask of the process; false where the system does not tell.
#[cfg(unix)]
fn is_in_mask(name: &str, signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status
        .lines()
        .find_map(|line| line.strip_prefix(name))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(not(unix))]
fn listen_for(on_signal: fn() -> bool) -> std::io::Result<()> {
    ctrlc::set_handler(move || {
        if !on_signal() {
            std::process::exit(EXIT_CODE.into());
        }
    })
    .map_err(std::io::Error::other)
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;
    use std::sync::atomic::AtomicUsize;

    use super::*;

    #[test]
    fn of_many_who_notice_at_once_one_says_it_and_all_know_that_it_is_said() {
        const MANY: usize = 8;
        let (announcement, said) = (Announcement(Mutex::new(false)), AtomicUsize::new(0));
        for round in 1..=100 {
            let start = Barrier::new(MANY);
            std::thread::scope(|scope| {
                for _ in 0..MANY {
                    scope.spawn(|| {
                        start.wait();
                        announcement.make(|| {
                            std::thread::yield_now();
                            said.fetch_add(1, Ordering::Relaxed);
                        });
                        assert_eq!(said.load(Ordering::Relaxed), round);
                    });
                }
            });
            announcement.reset();
        }
    }
}
