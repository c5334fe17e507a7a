//! An end to walks that go in circles, as in a tree file that was damaged.

use super::leaf::RayState;
use super::stream::{MAX_TURNS_WAITED, SLOTS};
use crate::tree::{NodeRef, Tree, panic_corrupt_tree};

/// Turns between two looks, at least: looking takes time.
const MIN_TURNS: usize = 1 << 12;

/// Panics where a ray takes more turns than a walk can have steps. In each turn each ray takes a step, or waits for one of
/// a few turns, so it is enough to look from time to time whether any slot has still the ray that it had.
pub struct StepLimit {
    max_turns: usize,
    turns: usize,
    /// The rays that were under way when turns were last counted from zero.
    numbers: [usize; SLOTS],
}

impl StepLimit {
    /// The limit for walks through a tree.
    pub fn new(tree: &Tree) -> StepLimit {
        let turns_a_step = MAX_TURNS_WAITED as usize + 2;
        let max_turns = MIN_TURNS.max(tree.max_steps() + 1) * turns_a_step;
        StepLimit { max_turns, turns: 0, numbers: [usize::MAX; SLOTS] }
    }

    /// Counts a turn, given the rays and where each is.
    #[inline(always)]
    pub fn take_turn(&mut self, rays: &[RayState; SLOTS], places: &[u32; SLOTS]) {
        self.turns += 1;
        if self.turns > self.max_turns {
            self.look(rays, places);
        }
    }

    #[cold]
    #[inline(never)]
    fn look(&mut self, rays: &[RayState; SLOTS], places: &[u32; SLOTS]) {
        // At a node, in a leaf, or waiting for a look in double precision there.
        let is_busy =
            |slot: usize| places[slot] < NodeRef::END.0 || places[slot] == NodeRef::WAITING.0;
        let numbers =
            std::array::from_fn(|slot| if is_busy(slot) { rays[slot].number } else { usize::MAX });
        let stays = |slot: usize| numbers[slot] == self.numbers[slot];
        if (0..SLOTS).any(|slot| is_busy(slot) && stays(slot)) {
            panic_corrupt_tree();
        }
        (self.turns, self.numbers) = (0, numbers);
    }
}
