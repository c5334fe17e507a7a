//! Ctrl-C: the first asks the work to end, the second ends the process.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

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

/// From here on SIGINT, SIGTERM and SIGHUP end the work instead of the process.
pub fn listen() -> std::io::Result<()> {
    listen_for(|| {
        if CANCELLED.swap(true, Ordering::Relaxed) {
            end_now();
        }
        std::thread::spawn(|| {
            std::thread::sleep(PATIENCE);
            end_now();
        });
    })
}

/// Ends the process without waiting for the work.
fn end_now() -> ! {
    halfline::io::abandon_all();
    let mut stderr = std::io::stderr();
    let clear_bar = if stderr.is_terminal() { "\r\x1b[2K" } else { "" };
    let _ = writeln!(stderr, "{clear_bar}halfline: interrupted");
    std::process::exit(EXIT_CODE.into())
}

#[cfg(unix)]
fn listen_for(mut on_signal: impl FnMut() + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    // `nohup` starts us with SIGHUP ignored, and means it.
    if !ignored_at_start(SIGHUP) {
        signals.add_signal(SIGHUP)?;
    }
    std::thread::Builder::new()
        .name("signals".into())
        .spawn(move || signals.forever().for_each(|_| on_signal()))
        .map(drop)
}

/// Whether our parent had `signal` ignored; false where the system does not tell.
#[cfg(unix)]
fn ignored_at_start(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(not(unix))]
fn listen_for(on_signal: impl FnMut() + Send + 'static) -> std::io::Result<()> {
    ctrlc::set_handler(on_signal).map_err(std::io::Error::other)
}
