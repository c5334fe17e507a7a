//! Builds that may become too long or too large: foreseen from smaller ones, timed, and given up.
//!
//! The textbook's build asks before each cell that it splits whether to stop; what answers is a
//! [`Limits`], which looks at the clock and at the memory from time to time.

use std::cell::Cell;

use halfline::Mesh;
use halfline::error::Result;
use halfline::explain::Rule;
use halfline::progress::Observer;
use halfline::textbook::{KdTree, Termination};

use super::machine::resident_bytes;
use super::stopwatch::Stopwatch;

/// What a tree may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Seconds of one build.
    pub seconds: f64,
    /// Bytes of one tree.
    pub bytes: f64,
}

/// A build that was not, or not to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// It would take about so many seconds.
    Seconds(f64),
    /// The tree would take about so many bytes.
    Bytes(f64),
    /// It was ended after so many seconds.
    EndedAfter(f64),
    /// It was ended at so many bytes.
    EndedAt(f64),
}

/// What smaller trees of a kind took.
#[derive(Clone, Debug, Default)]
pub struct Experience(Vec<Cost>);

/// What a tree took.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Seconds to build the tree.
    pub seconds: f64,
    /// Bytes of the tree.
    pub bytes: f64,
}

impl Experience {
    /// Remembers what a tree took, or took at least.
    pub fn remember(&mut self, cost: Cost) {
        self.0.push(cost);
    }

    /// What speaks against a tree over so many triangles.
    pub fn refusal(&self, triangles: usize, budget: Budget) -> Option<Refusal> {
        let seconds = self.foreseen(triangles, |cost| cost.seconds)?;
        let bytes = self.foreseen(triangles, |cost| cost.bytes)?;
        if bytes > budget.bytes {
            Some(Refusal::Bytes(bytes))
        } else if seconds > budget.seconds {
            Some(Refusal::Seconds(seconds))
        } else {
            None
        }
    }

    /// What the last tree took, times how n log^2 n grows, or faster if the last two did.
    fn foreseen(&self, triangles: usize, of: impl Fn(&Cost) -> f64) -> Option<f64> {
        let last = self.0.last()?;
        let n_log2_n = |n: usize| n as f64 * (n as f64 + 1.0).log2().powi(2);
        let usual = n_log2_n(triangles) / n_log2_n(last.triangles);
        let observed = match self.0.len().checked_sub(2).map(|i| &self.0[i]) {
            Some(before) if before.triangles < last.triangles && of(before) > 0.0 => {
                let exponent = (of(last) / of(before)).ln()
                    / (last.triangles as f64 / before.triangles as f64).ln();
                (triangles as f64 / last.triangles as f64).powf(exponent)
            }
            _ => 0.0,
        };
        Some(of(last) * usual.max(observed))
    }
}

/// The textbook's tree over `mesh`, and how many seconds it took.
///
/// Foresight may err: a build that takes half as long again as it may is ended, and so is one during
/// which the process grows by more bytes than the tree may have.
///
/// # Errors
/// [`Error::Interrupted`](halfline::Error::Interrupted).
pub fn build_textbook<'mesh>(
    rule: Rule,
    mesh: &'mesh Mesh,
    budget: Budget,
    observer: &dyn Observer,
) -> Result<std::result::Result<(KdTree<'mesh>, f64), Refusal>> {
    let limits = Limits {
        seconds: 1.5 * budget.seconds,
        bytes: budget.bytes,
        started: Stopwatch::start(),
        resident_before: resident_bytes().unwrap_or(0.0),
        cells: Cell::new(0),
        refusal: Cell::new(None),
    };
    let termination = Termination::automatic(mesh.triangle_count());
    let stop = |triangles: usize| limits.are_passed(triangles) || observer.cancelled();
    let tree = KdTree::init_kd_tree_until(mesh, rule.splitting_rule(), &termination, &stop);
    let seconds = limits.started.seconds();
    observer.check()?;
    Ok(match limits.refusal.get() {
        Some(refusal) => Err(refusal),
        None => Ok((tree, seconds)),
    })
}

/// What a build may take, and what it has taken so far.
struct Limits {
    seconds: f64,
    bytes: f64,
    started: Stopwatch,
    resident_before: f64,
    cells: Cell<u64>,
    refusal: Cell<Option<Refusal>>,
}

/// Cells between two looks at the clock, and between two at the memory.
const CLOCK_CELLS: u64 = 64;
const MEMORY_CELLS: u64 = 4096;

/// Cells of more triangles are worth a look at the clock each.
const LARGE_CELL: usize = 10_000;

impl Limits {
    /// True once the build has taken too much; asked before a cell of so many triangles is split.
    fn are_passed(&self, triangles: usize) -> bool {
        let cells = self.cells.get() + 1;
        self.cells.set(cells);
        if self.refusal.get().is_some() {
            return true;
        }
        let seconds = match cells.is_multiple_of(CLOCK_CELLS) || triangles > LARGE_CELL {
            true => self.started.seconds(),
            false => 0.0,
        };
        let bytes = match cells.is_multiple_of(MEMORY_CELLS) {
            true => resident_bytes().unwrap_or(0.0) - self.resident_before,
            false => 0.0,
        };
        if seconds > self.seconds {
            self.refusal.set(Some(Refusal::EndedAfter(seconds)));
        } else if bytes > self.bytes {
            self.refusal.set(Some(Refusal::EndedAt(bytes)));
        }
        self.refusal.get().is_some()
    }
}
