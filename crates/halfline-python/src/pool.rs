//! The threads that work for Python.
//!
//! They are not rayon's global ones, since those can neither be changed in number nor be made anew: a
//! child of `fork` has none of its parent's threads, and would wait for them forever. So a pool knows
//! the process that made it, and a child makes its own. Nothing here is ever locked, as a lock that
//! another thread holds at the moment of the fork stays locked in the child.

use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use arc_swap::ArcSwapOption;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// More than any machine has; a limit of rayon's.
const MOST: usize = (1 << 16) - 1;

/// The environment variable that says how many threads there are.
const VARIABLE: &str = "HALFLINE_THREADS";

static CURRENT: ArcSwapOption<Pool> = ArcSwapOption::const_empty();

/// How many threads are wished for; 0 if nobody said.
static WISHED: AtomicUsize = AtomicUsize::new(0);

/// Threads, and when they are of use.
pub struct Pool {
    threads: rayon::ThreadPool,
    /// Whose they are.
    process: u32,
    /// What was wished for when they were made.
    wished: usize,
}

impl Pool {
    /// The pool of this process. To be asked for while attached to the interpreter.
    pub fn current() -> PyResult<Arc<Pool>> {
        let process = std::process::id();
        loop {
            let wished = WISHED.load(Ordering::Relaxed);
            let found = CURRENT.load_full();
            if let Some(pool) = &found
                && pool.process == process
                && pool.wished == wished
            {
                return Ok(pool.clone());
            }
            let made = Arc::new(Pool::new(process, wished)?);
            let before = CURRENT.compare_and_swap(&found, Some(made.clone()));
            let is_ours = before.as_ref().map(Arc::as_ptr) == found.as_ref().map(Arc::as_ptr);
            if let Some(old) = found
                && old.process != process
            {
                // To end its threads would be to wait for what is not there: it stays in memory.
                std::mem::forget(old);
            }
            if is_ours {
                return Ok(made);
            }
        }
    }

    fn new(process: u32, wished: usize) -> PyResult<Pool> {
        let count = if wished > 0 { wished } else { default_count()? };
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(count)
            .thread_name(|number| format!("halfline-{number}"))
            .build()
            .map_err(|error| {
                PyRuntimeError::new_err(format!("cannot start {count} threads: {error}"))
            })?;
        Ok(Pool { threads, process, wished })
    }

    /// The threads.
    pub fn threads(&self) -> &rayon::ThreadPool {
        &self.threads
    }
}

/// What the environment says, or else as many as there are cores that this process may use.
fn default_count() -> PyResult<usize> {
    let Some(text) = std::env::var_os(VARIABLE).filter(|text| !text.is_empty()) else {
        return Ok(std::thread::available_parallelism().map_or(1, NonZero::get));
    };
    let count = text.to_str().and_then(|text| text.trim().parse().ok());
    count.filter(|count| (1..=MOST).contains(count)).ok_or_else(|| {
        PyValueError::new_err(format!(
            "{VARIABLE}: expected a number of threads from 1 to {MOST}, found {text:?}"
        ))
    })
}

/// How many threads work for Python.
#[pyfunction]
pub fn thread_count() -> PyResult<usize> {
    match WISHED.load(Ordering::Relaxed) {
        0 => default_count(),
        wished => Ok(wished),
    }
}

/// Calls that have begun keep their threads; later ones have `count`, or the default again.
#[pyfunction]
#[pyo3(signature = (count, /))]
pub fn set_thread_count(count: Option<i64>) -> PyResult<()> {
    let wished = match count {
        None => 0,
        Some(count) => usize::try_from(count)
            .ok()
            .filter(|count| (1..=MOST).contains(count))
            .ok_or_else(|| {
                PyValueError::new_err(format!(
                    "count: expected a number of threads from 1 to {MOST}, or None, found {count}"
                ))
            })?,
    };
    WISHED.store(wished, Ordering::Relaxed);
    Ok(())
}
