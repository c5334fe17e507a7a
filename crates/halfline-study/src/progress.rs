//! How far a study is, whose parts take very different times.

use halfline::progress::{Observer, Stage};

/// One part of the work. What is done inside of it may ask for the end, and what that reports of its own
/// progress is passed over.
pub struct Part<'a> {
    observer: &'a dyn Observer,
    /// Units of work before this part, in it, and in all.
    before: f64,
    own: f64,
    total: f64,
}

impl<'a> Part<'a> {
    /// The part that has `own` units of work, after `before` of `total` units.
    pub fn new(observer: &'a dyn Observer, before: f64, own: f64, total: f64) -> Part<'a> {
        Part { observer, before, own, total }
    }

    /// Tells that this share of the part is done.
    pub fn advance(&self, share: f64) {
        let done = (self.before + self.own * share.clamp(0.0, 1.0)) / self.total;
        self.observer.report(Stage::Trace, (done * UNITS).round() as u64, UNITS as u64);
    }
}

/// What is reported is whole numbers.
const UNITS: f64 = 10_000.0;

impl Observer for Part<'_> {
    fn cancelled(&self) -> bool {
        self.observer.cancelled()
    }
}
