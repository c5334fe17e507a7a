//! How far the work is, on stderr: a bar on a terminal, now and then a line elsewhere.
//!
//! Workers only store numbers; one thread of its own looks at them and draws, so that reporting
//! costs a worker nothing and a silent stage still shows that time passes.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use halfline::progress::{Observer, Stage};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::{interrupt, units};

/// Stages shorter than this leave no trace on a terminal.
const PATIENCE: Duration = Duration::from_millis(300);
const FRAME: Duration = Duration::from_millis(80);
/// When a log file first hears of a long stage; then after twice the time, up to [`LONGEST`].
const LINE: Duration = Duration::from_secs(10);
const LONGEST: Duration = Duration::from_secs(60);
/// A guess from less than this is not worth showing.
const GUESS: Duration = Duration::from_millis(800);

/// What a person sees of the work, and the person's wish to end it.
pub struct Progress {
    board: Arc<Board>,
    drawer: Option<JoinHandle<()>>,
}

/// Written by the workers, read by the drawer.
#[derive(Default)]
struct Board {
    /// Counts the stages begun; what the drawer draws changes when this does.
    turn: AtomicUsize,
    stage: AtomicUsize,
    name: Mutex<&'static str>,
    done: AtomicU64,
    total: AtomicU64,
    closed: Mutex<bool>,
    bell: Condvar,
}

impl Progress {
    /// Shows progress on stderr, or not if `quiet`.
    pub fn start(quiet: bool) -> Progress {
        let board = Arc::new(Board::default());
        let drawer = (!quiet).then(|| {
            let board = Arc::clone(&board);
            let terminal = std::io::stderr().is_terminal()
                && std::env::var_os("TERM").is_none_or(|term| term != "dumb");
            std::thread::spawn(move || if terminal { board.draw() } else { board.log() })
        });
        Progress { board, drawer }
    }

    /// From here on reports are about `stage`, which people know as `name`.
    pub fn begin(&self, stage: Stage, name: &'static str) {
        *self.board.name.lock().unwrap_or_else(PoisonError::into_inner) = name;
        self.board.done.store(0, Ordering::Relaxed);
        self.board.total.store(0, Ordering::Relaxed);
        self.board.stage.store(stage as usize, Ordering::Relaxed);
        self.board.turn.fetch_add(1, Ordering::Release);
    }
}

impl Observer for Progress {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        // A library call may pass through stages that the command did not name.
        if self.board.stage.load(Ordering::Relaxed) != stage as usize {
            self.begin(stage, name(stage));
        }
        self.board.total.store(total, Ordering::Relaxed);
        self.board.done.fetch_max(done, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        interrupt::cancelled()
    }
}

impl Drop for Progress {
    /// Leaves a clean line behind.
    fn drop(&mut self) {
        *self.board.closed.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.board.bell.notify_all();
        if let Some(drawer) = self.drawer.take() {
            let _ = drawer.join();
        }
    }
}

impl Board {
    /// Waits for `time` at most; false once there is nothing more to show.
    fn wait(&self, time: Duration) -> bool {
        let closed = self.closed.lock().unwrap_or_else(PoisonError::into_inner);
        let (closed, _) = self
            .bell
            .wait_timeout_while(closed, time, |closed| !*closed)
            .unwrap_or_else(PoisonError::into_inner);
        !*closed && !interrupt::cancelled()
    }

    fn name(&self) -> &'static str {
        *self.name.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn draw(&self) {
        let mut bar: Option<ProgressBar> = None;
        let (mut turn, mut began) = (0, Instant::now());
        while self.wait(FRAME) {
            let now = self.turn.load(Ordering::Acquire);
            if now != turn {
                (turn, began) = (now, Instant::now());
                bar.take().inspect(ProgressBar::finish_and_clear);
            }
            if turn == 0 || began.elapsed() < PATIENCE {
                continue;
            }
            let total = self.total.load(Ordering::Relaxed);
            let bar = bar.get_or_insert_with(|| {
                ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr())
                    .with_elapsed(began.elapsed())
                    .with_style(spinner_style())
                    .with_prefix(self.name())
            });
            if total > 0 && bar.length().is_none() {
                bar.set_style(bar_style());
            }
            if total > 0 {
                bar.set_length(total);
                bar.set_position(self.done.load(Ordering::Relaxed).min(total));
            }
            bar.tick();
        }
        bar.take().inspect(ProgressBar::finish_and_clear);
    }

    fn log(&self) {
        let (mut turn, mut began) = (0, Instant::now());
        let mut next = LINE;
        while self.wait(FRAME) {
            let now = self.turn.load(Ordering::Acquire);
            if now != turn {
                (turn, began, next) = (now, Instant::now(), LINE);
            }
            if turn == 0 || began.elapsed() < next {
                continue;
            }
            next += next.min(LONGEST);
            let (done, total) =
                (self.done.load(Ordering::Relaxed), self.total.load(Ordering::Relaxed));
            let passed = began.elapsed().as_secs_f64();
            let far = if done > 0 && done <= total {
                let share = done as f64 / total as f64;
                let left = units::rough_seconds(passed * (1.0 - share) / share);
                format!("{:.0} %, {left} left", share * 100.0)
            } else {
                units::rough_seconds(passed)
            };
            let _ = writeln!(std::io::stderr(), "halfline: {}: {far}", self.name());
        }
    }
}

/// What a stage is usually called.
pub fn name(stage: Stage) -> &'static str {
    match stage {
        Stage::Load => "load",
        Stage::Examine => "examine",
        Stage::Build => "build",
        Stage::Trace => "trace",
        Stage::Write => "write",
        _ => "work",
    }
}

fn bar_style() -> ProgressStyle {
    ProgressStyle::with_template("  {prefix:<8.cyan.bold} {bar:36.cyan/dim} {percent:>3} %  {left}")
        .expect("the template is a constant")
        .progress_chars("━╸─")
        .with_key("left", |state: &ProgressState, out: &mut dyn std::fmt::Write| {
            if state.elapsed() >= GUESS && state.pos() > 0 {
                let _ = write!(out, "{} left", units::rough_seconds(state.eta().as_secs_f64()));
            }
        })
}

fn spinner_style() -> ProgressStyle {
    ProgressStyle::with_template("  {prefix:<8.cyan.bold} {spinner:.cyan} {passed}")
        .expect("the template is a constant")
        .with_key("passed", |state: &ProgressState, out: &mut dyn std::fmt::Write| {
            let _ = write!(out, "{}", units::rough_seconds(state.elapsed().as_secs_f64()));
        })
}
