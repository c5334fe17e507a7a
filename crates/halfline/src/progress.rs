//! How long work tells of itself, and how it is stopped.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::{Error, Result};

/// The long stages of the work. There may be more of them in time.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Reading a mesh file, or generating a mesh.
    Load,
    /// Finding how a mesh's triangles hang together.
    Examine,
    /// Building the tree.
    Build,
    /// Casting rays.
    Trace,
    /// Writing a result.
    Write,
}

/// Is told of progress and may ask for the end. Called from any thread, so it must be quick.
///
/// ```
/// use std::sync::atomic::{AtomicBool, Ordering};
///
/// use halfline::Observer;
/// use halfline::progress::Stage;
///
/// /// Prints how far the work is, until somebody sets the flag.
/// struct Printer<'a> {
///     stop: &'a AtomicBool,
/// }
///
/// impl Observer for Printer<'_> {
///     fn report(&self, stage: Stage, done: u64, total: u64) {
///         eprintln!("{stage:?}: {done} of {total}");
///     }
///
///     fn cancelled(&self) -> bool {
///         self.stop.load(Ordering::Relaxed)
///     }
/// }
/// ```
pub trait Observer: Sync {
    /// `done` of `total` units of `stage` are finished. Within one stage `done` never falls by
    /// the same caller; several threads may report out of order.
    fn report(&self, stage: Stage, done: u64, total: u64) {
        let _ = (stage, done, total);
    }

    /// True once the work should end. Asked at least every few milliseconds of work.
    fn cancelled(&self) -> bool {
        false
    }

    /// `Err(Error::Interrupted)` once the work should end.
    fn check(&self) -> Result<()> {
        if self.cancelled() { Err(Error::Interrupted) } else { Ok(()) }
    }
}

/// Hears nothing and never stops the work.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoProgress;

impl Observer for NoProgress {}

/// How far one stage is, when several threads work on it: a sum of finished units that each adds to.
pub struct SharedProgress<'a> {
    observer: &'a dyn Observer,
    stage: Stage,
    done: AtomicU64,
    total: u64,
}

impl SharedProgress<'_> {
    /// Nothing of `total` units yet.
    pub fn new(observer: &dyn Observer, stage: Stage, total: usize) -> SharedProgress<'_> {
        SharedProgress { observer, stage, done: AtomicU64::new(0), total: total as u64 }
    }

    /// Reports that so many more units are done; `Err(Error::Interrupted)` if the work should end. To
    /// be called every few milliseconds.
    pub fn advance(&self, units: usize) -> Result<()> {
        let done = self.done.fetch_add(units as u64, Ordering::Relaxed) + units as u64;
        self.observer.report(self.stage, done.min(self.total), self.total);
        self.check()
    }

    /// `Err(Error::Interrupted)` once the work should end.
    pub fn check(&self) -> Result<()> {
        self.observer.check()
    }

    /// Reports that all is done, units that needed no work included.
    pub fn finish(&self) {
        self.observer.report(self.stage, self.total, self.total);
    }
}

/// Shows one step of a stage to its observer as a part of the whole, so that the whole does not
/// start again from zero when the next step begins.
pub struct Part<'a> {
    /// Is told of the whole.
    pub observer: &'a dyn Observer,
    /// Units of the whole that were done before this step.
    pub before: u64,
    /// Units of the whole that this step amounts to.
    pub share: u64,
    /// Units of the whole.
    pub total: u64,
}

impl Observer for Part<'_> {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        let share = u128::from(self.share) * u128::from(done) / u128::from(total.max(1));
        self.observer.report(stage, self.before + share as u64, self.total);
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}
