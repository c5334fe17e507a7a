//! Calls that may take long: other Python threads run meanwhile, Ctrl-C ends them, and they tell how
//! far they are.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

use halfline::error::Result;
use halfline::progress::{Observer, Stage};
use pyo3::prelude::*;

use crate::error::exception;
use crate::pool::Pool;

/// How often a waiting call looks for signals and tells of its progress.
const TICK: Duration = Duration::from_millis(20);

/// Whom Python wants to hear of progress: called with the stage, what is done, and the total.
pub type Progress<'py> = Option<Bound<'py, PyAny>>;

/// Does `work` on the threads of [`Pool`], detached from the interpreter. This thread waits, and
/// attaches itself every [`TICK`] to run the handlers of signals and to call `progress`. If either
/// raises, the work is asked to end; when it has, that exception is the answer.
pub fn on_pool<T: Send>(
    py: Python,
    progress: Progress,
    work: impl FnOnce(&dyn Observer) -> Result<T> + Send,
) -> PyResult<T> {
    let pool = Pool::current()?;
    let progress = progress.map(Bound::unbind);
    let listener = Listener::default();
    let ending = Ending::default();
    let mut result = None;
    let raised = py.detach(|| {
        pool.threads().in_place_scope(|scope| {
            let (result, ending, listener) = (&mut result, &ending, &listener);
            scope.spawn(move |_| {
                let _told = TellsWhenDropped(ending);
                *result = Some(work(listener));
            });
            while !ending.wait() {
                let tick = Python::attach(|py| {
                    py.check_signals()?;
                    listener.tell(py, progress.as_ref())
                });
                if let Err(raised) = tick {
                    listener.cancelled.store(true, Ordering::Relaxed);
                    return Some(raised);
                }
            }
            None
        })
    });
    if let Some(raised) = raised {
        return Err(raised);
    }
    let answer = result.expect("a scope waits for what it spawns");
    let answer = answer.map_err(|error| exception(py, error))?;
    listener.tell(py, progress.as_ref())?;
    Ok(answer)
}

/// Does `work`, which takes a few milliseconds at most and needs no other threads, on this one.
pub fn here<T: Send>(
    py: Python,
    progress: Progress,
    work: impl FnOnce(&dyn Observer) -> Result<T> + Send,
) -> PyResult<T> {
    let listener = Listener::default();
    let answer = py.detach(|| work(&listener)).map_err(|error| exception(py, error))?;
    listener.tell(py, progress.map(Bound::unbind).as_ref())?;
    Ok(answer)
}

/// Whether the work has ended, by itself or by a panic.
#[derive(Default)]
struct Ending {
    is_over: Mutex<bool>,
    changed: Condvar,
}

impl Ending {
    /// Waits for a [`TICK`] at most; true if the work has ended.
    fn wait(&self) -> bool {
        let is_over = self.is_over.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.changed.wait_timeout_while(is_over, TICK, |is_over| !*is_over);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

struct TellsWhenDropped<'a>(&'a Ending);

impl Drop for TellsWhenDropped<'_> {
    fn drop(&mut self) {
        *self.0.is_over.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.changed.notify_one();
    }
}

/// Hears of the work, and stops it.
#[derive(Default)]
struct Listener {
    cancelled: AtomicBool,
    /// One more than the number of the stage; 0 before any.
    stage: AtomicU64,
    done: AtomicU64,
    total: AtomicU64,
}

/// The stages, and what Python calls them.
const STAGES: [(Stage, &str); 5] = [
    (Stage::Load, "load"),
    (Stage::Examine, "examine"),
    (Stage::Build, "build"),
    (Stage::Trace, "trace"),
    (Stage::Write, "write"),
];

impl Listener {
    /// Calls `progress`, if there is any and something to tell.
    fn tell(&self, py: Python, progress: Option<&Py<PyAny>>) -> PyResult<()> {
        let stage = self.stage.load(Ordering::Acquire);
        let (Some(progress), Some(stage)) = (progress, stage.checked_sub(1)) else {
            return Ok(());
        };
        let (_, name) = STAGES[stage as usize];
        let total = self.total.load(Ordering::Relaxed);
        let done = self.done.load(Ordering::Relaxed).min(total);
        progress.call1(py, (name, done, total))?;
        Ok(())
    }
}

impl Observer for Listener {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        let number = STAGES.iter().position(|(known, _)| *known == stage);
        let number = number.map_or(0, |number| number as u64 + 1);
        if self.stage.load(Ordering::Relaxed) != number {
            self.done.store(0, Ordering::Relaxed);
            self.total.store(total, Ordering::Relaxed);
            self.stage.store(number, Ordering::Release);
        }
        self.total.store(total, Ordering::Relaxed);
        // Threads report out of order.
        self.done.fetch_max(done, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}
