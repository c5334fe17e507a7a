//! What the readers of files tell of their progress, in bytes.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::Result;
use crate::progress::{Observer, Stage};

/// A sum of finished bytes that several threads add to.
pub struct ByteProgress<'a> {
    observer: &'a dyn Observer,
    stage: Stage,
    total: u64,
    done: AtomicU64,
}

impl<'a> ByteProgress<'a> {
    /// Nothing done yet of `total` bytes of `stage`.
    pub fn new(observer: &'a dyn Observer, stage: Stage, total: usize) -> ByteProgress<'a> {
        ByteProgress { observer, stage, total: total as u64, done: AtomicU64::new(0) }
    }

    /// Reports `bytes` more; an error if the work should end. To be called every few milliseconds.
    pub fn add(&self, bytes: usize) -> Result<()> {
        let done = self.done.fetch_add(bytes as u64, Ordering::Relaxed) + bytes as u64;
        self.observer.report(self.stage, done.min(self.total), self.total);
        self.observer.check()
    }

    /// An error if the work should end.
    pub fn check(&self) -> Result<()> {
        self.observer.check()
    }

    /// Reports that all is done, bytes that needed no reading included.
    pub fn finish(&self) {
        self.observer.report(self.stage, self.total, self.total);
    }
}

/// Shows one step of a stage to its observer as a part of the whole, so that the whole does not
/// start again from zero when the next step begins.
pub struct Portion<'a> {
    /// Who is told.
    pub observer: &'a dyn Observer,
    /// Units of the whole that were done before this step.
    pub before: u64,
    /// Units of the whole that this step amounts to.
    pub share: u64,
    /// The whole.
    pub total: u64,
}

impl Observer for Portion<'_> {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        let part = u128::from(self.share) * u128::from(done) / u128::from(total.max(1));
        self.observer.report(stage, self.before + part as u64, self.total);
    }

    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}
