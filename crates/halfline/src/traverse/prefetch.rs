//! Asking memory for nodes and leaves before they are needed.
//!
//! What comes from memory is there in time if it is asked for; what is in a near cache anyway only costs the asking,
//! up to a fifth of a ray's time. Which of both holds depends on the tree, on the rays and on the machine, so for
//! trees of a middle size it is measured as they are cast: of some chunks one half goes with asking and the other
//! without, by turns the first and the second, and what they save on the average decides for the chunks between.

use std::sync::atomic::{AtomicI32, AtomicU32, Ordering};
use std::time::Duration;

use super::packet::RAYS;
use crate::simd::Simd;
use crate::tree::{LeafBlock, Node, NodeRef, Tree};

/// Trees up to this size stay in the second-level caches of today's machines.
const CACHED_BYTES: usize = 512 << 10;

/// Larger trees than this are in no near cache.
const LARGE_BYTES: usize = 16 << 20;

/// Of so many chunks the first two are trials.
const TRIAL_STEP: u32 = 16;

/// How much less time than with asking it must take without, in percent, before it is done without.
const WORTHWHILE: i32 = 5;

/// What the trials of a batch have said so far.
#[derive(Debug, Default)]
pub struct PrefetchTuner {
    chunks: AtomicU32,
    /// The sum of how much less time was taken without asking, in percent.
    saved: AtomicI32,
    trials: AtomicI32,
}

/// Whether a chunk of a batch asks for its cache lines, and the trial that it may be.
#[derive(Clone, Copy)]
pub struct PrefetchChoice<'a> {
    is_on: bool,
    trial: Option<&'a PrefetchTuner>,
}

impl<'a> PrefetchChoice<'a> {
    /// For the next chunk of a batch.
    pub fn of(tree: &Tree, tuner: Option<&'a PrefetchTuner>) -> PrefetchChoice<'a> {
        let bytes = tree.bytes();
        let Some(tuner) = tuner.filter(|_| (CACHED_BYTES..LARGE_BYTES).contains(&bytes)) else {
            return PrefetchChoice { is_on: bytes > CACHED_BYTES, trial: None };
        };
        // Relaxed: the counts are of no consequence but for time.
        let turn = tuner.chunks.fetch_add(1, Ordering::Relaxed) % TRIAL_STEP;
        if turn < 2 {
            return PrefetchChoice { is_on: turn == 0, trial: Some(tuner) };
        }
        let trials = tuner.trials.load(Ordering::Relaxed);
        let is_off = trials > 1 && tuner.saved.load(Ordering::Relaxed) > trials * WORTHWHILE;
        PrefetchChoice { is_on: !is_off, trial: None }
    }

    /// The parts in which so many rays are cast: where each ends, and whether it goes with asking. The second is empty
    /// but for a trial.
    pub fn parts(self, count: usize) -> [(usize, bool); 2] {
        let half = count / 2 / RAYS * RAYS;
        let end = if self.trial.is_some() { half } else { count };
        [(end, self.is_on), (count, self.is_on != self.trial.is_some())]
    }

    /// Hears how long the parts took.
    pub fn finish(self, times: [Duration; 2]) {
        let Some(tuner) = self.trial else { return };
        let [first, second] = times.map(|time| time.as_secs_f64());
        let (with, without) = if self.is_on { (first, second) } else { (second, first) };
        if with > 0.0 {
            // Whatever else the machine did meanwhile counts for no more than this.
            let saved = (100.0 * (1.0 - without / with)).clamp(-50.0, 50.0);
            tuner.saved.fetch_add(saved as i32, Ordering::Relaxed);
            tuner.trials.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Where nodes and leaves lie.
#[derive(Clone, Copy)]
pub struct Prefetcher {
    nodes: usize,
    /// False if nothing is asked for.
    is_on: bool,
    /// From the first node to the first leaf.
    leaves_from_nodes: usize,
}

impl Prefetcher {
    /// That of a tree.
    pub fn of(tree: &Tree, is_on: bool) -> Prefetcher {
        let nodes = tree.nodes.as_ptr().addr();
        let leaves = tree.leaves.blocks.as_ptr().addr();
        Prefetcher { nodes, is_on, leaves_from_nodes: leaves.wrapping_sub(nodes) }
    }

    /// Asks for all cache lines of a node or leaf, without a branch on which it is.
    #[inline(always)]
    pub fn prefetch<S: Simd>(&self, simd: S, place: NodeRef) {
        if !self.is_on {
            return;
        }
        const LINES: usize = size_of::<Node>() / 64;
        let is_leaf = usize::from(place.is_leaf());
        let more = is_leaf * (size_of::<LeafBlock>() - size_of::<Node>());
        let base = self.nodes.wrapping_add(self.leaves_from_nodes & is_leaf.wrapping_neg());
        let address = base.wrapping_add(place.index() * (size_of::<Node>() + more));
        simd.prefetch(address, LINES);
        // The last line of a leaf; of a node one that was asked for already.
        simd.prefetch(address.wrapping_add((LINES - 1) * 64 + more), 1);
    }
}
