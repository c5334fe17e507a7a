//! Many rays at once, each on a walk of its own.
//!
//! A walk waits for memory at nearly every step, so [`SLOTS`] rays are under way at a time: each step
//! of one ray ends by asking for the cache lines of its next, and while they come the others have
//! their turns. In each turn they are taken by the kind of work that is next:
//!
//! ```text
//! NODE  meet eight boxes at once; push those that are met, the nearest last; pop; prefetch
//! LEAF  hold eight triangles against the ray at once; where none is left, pop and prefetch
//! HIT   decide what is left (`cast/`); a hit drops all that waits beyond it; pop; prefetch
//! END   take the answer; give the slot to the next ray, or to what is left of a bundle
//! ```
//!
//! After each turn the rays are divided by what they popped, without a branch that depends on a
//! ray: such branches cannot be predicted, and cost as much as a node.
//!
//! Different from V. Havran's stack: what waits beyond a hit is dropped at the hit, so that what is
//! popped needs no test. Different from wavefront tracers (S. Laine, T. Karras, T. Aila, "Megakernels
//! Considered Harmful", HPG 2013): there are few enough rays under way to stay in the first caches.

use std::ops::Range;

use super::bundle::{Bundle, GROUPS, Mask, RAYS};
use super::cast::{Asked, Batch, Candidates, Cast, Decision, Pairs, RayState, Work};
use super::wide_ray::World;
use crate::simd::{Job, LANES, Simd, WORDS};
use crate::tree::{KdTree, LeafBlock, WideNode, Word, give_up};

/// Rays under way at a time, each in a slot.
const SLOTS: usize = WORDS;

/// All lanes, the first first, as [`Simd::push`] takes them.
const IN_ORDER: u32 = 0o76_543_210;

/// What waits on the walks of all slots, each in a part of its own. Writes are eight wide, so there is
/// that much room at the end of each.
struct Stacks {
    words: Vec<u32>,
    /// Where the ray enters what waits, at least.
    nears: Vec<f32>,
    /// For each slot the place after the last that waits.
    ends: [usize; SLOTS],
    /// Places for each slot.
    room: usize,
}

impl Stacks {
    fn new(most_waiting: usize) -> Stacks {
        // The end of the walk waits below everything else.
        let room = most_waiting + 1 + LANES;
        let words = vec![Word::END.0; room * SLOTS];
        let nears = vec![f32::NEG_INFINITY; room * SLOTS];
        Stacks { words, nears, ends: std::array::from_fn(|slot| slot * room + 1), room }
    }

    /// The eight places after the last that waits.
    #[inline(always)]
    fn free(&mut self, slot: usize) -> (&mut [f32; LANES], &mut [u32; LANES]) {
        let end = self.ends[slot];
        let nears = self.nears[end..].first_chunk_mut();
        let words = self.words[end..].first_chunk_mut();
        let (Some(nears), Some(words)) = (nears, words) else {
            unreachable!("the builder bounds what waits")
        };
        (nears, words)
    }

    /// Takes up what waits last, after so many more have been put there.
    #[inline(always)]
    fn pop_after(&mut self, slot: usize, pushed: usize) -> u32 {
        let last = self.ends[slot] + pushed - 1;
        self.ends[slot] = last;
        self.words[last]
    }

    /// Begins a walk on which so much waits.
    #[inline(always)]
    fn restart(&mut self, slot: usize, waiting: usize) {
        self.ends[slot] = slot * self.room + 1 + waiting;
    }

    /// The places for what waits above the end of the walk.
    fn places(&mut self, slot: usize) -> (&mut [f32], &mut [u32]) {
        let places = slot * self.room + 1..(slot + 1) * self.room;
        (&mut self.nears[places.clone()], &mut self.words[places])
    }

    /// Drops what is entered beyond `limit`, eight at a time.
    #[inline(always)]
    fn drop_beyond<S: Simd>(&mut self, simd: S, slot: usize, limit: f32) {
        // What lies beyond the last that waits is dropped too.
        self.free(slot).0.fill(f32::INFINITY);
        let limit = simd.splat(limit.min(f32::MAX));
        let begin = slot * self.room + 1;
        let (mut kept, mut first) = (begin, begin);
        while first < self.ends[slot] {
            let nears = self.nears[first..].first_chunk().copied();
            let words = self.words[first..].first_chunk().copied();
            let (Some(nears), Some(words)) = (nears, words) else {
                unreachable!("there is room for eight beyond the last that waits")
            };
            let near = simd.load(&nears);
            let (free_nears, free_words) =
                (self.nears[kept..].first_chunk_mut(), self.words[kept..].first_chunk_mut());
            let (Some(free_nears), Some(free_words)) = (free_nears, free_words) else {
                unreachable!("no more are kept than there were")
            };
            kept += simd.compress(near, limit, &words, IN_ORDER, free_nears, free_words);
            first += LANES;
        }
        self.ends[slot] = kept;
    }
}

/// The slots of a mask, the first first.
#[inline(always)]
fn next_slot(mask: &mut u32) -> Option<usize> {
    if *mask == 0 {
        return None;
    }
    let slot = mask.trailing_zeros() as usize % SLOTS;
    *mask &= *mask - 1;
    Some(slot)
}

/// Turns between two looks, at least: looking takes time.
const FEWEST_TURNS: usize = 1 << 12;

/// Gives up where a ray takes more turns than a walk can have steps. In each turn each ray takes a step,
/// so it is enough to look from time to time whether any slot has still the ray that it had.
struct Patience {
    most_turns: usize,
    turns: usize,
    /// The rays that were under way when turns were last counted from zero.
    numbers: [usize; SLOTS],
}

impl Patience {
    fn new(tree: &KdTree) -> Patience {
        let most_turns = FEWEST_TURNS.max(tree.most_wide_steps() + 1);
        Patience { most_turns, turns: 0, numbers: [usize::MAX; SLOTS] }
    }

    /// Counts a turn; `busy` has a bit for each slot whose ray is under way.
    #[inline(always)]
    fn take_turn(&mut self, rays: &[RayState; SLOTS], busy: u32) {
        self.turns += 1;
        if self.turns > self.most_turns {
            self.look(rays, busy);
        }
    }

    #[cold]
    #[inline(never)]
    fn look(&mut self, rays: &[RayState; SLOTS], busy: u32) {
        let is_busy = |slot: usize| busy >> slot & 1 == 1;
        let numbers =
            std::array::from_fn(|slot| if is_busy(slot) { rays[slot].number } else { usize::MAX });
        let stays = |slot: usize| numbers[slot] == self.numbers[slot];
        if (0..SLOTS).any(|slot| is_busy(slot) && stays(slot)) {
            give_up();
        }
        (self.turns, self.numbers) = (0, numbers);
    }
}

/// Rays that wait for slots.
struct Waiting<Q> {
    bundle: Bundle<Q>,
    /// A bit for each that waits.
    rays: Mask,
    /// True for what is left of a bundle that was on its way.
    is_under_way: bool,
    /// How many of the groups that were prepared are still to be looked at, and from which on.
    groups: Range<usize>,
    /// How many at a time.
    together: usize,
    /// The number of the first ray that was not looked at yet.
    next: usize,
    /// How often in turn rays were too different to go as a bundle.
    failures: u32,
    /// Rays that wait for their last answers.
    ended: Pairs,
}

/// Groups that go as a bundle if all those that are looked at together do not.
const FEWER: usize = 2;

impl<B: Batch> Job for Cast<'_, B> {
    type Output = (B, Work);

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> (B, Work) {
        let tree = self.tree;
        let world = World { frame: tree.frame, root: tree.root.bounds, reach: tree.reach };
        let memory = Memory::of(tree);
        let bundle = Bundle::new(tree.wide.most_waiting);
        let mut waiting = Waiting {
            bundle,
            rays: 0,
            is_under_way: false,
            groups: 0..0,
            together: 1,
            next: 0,
            failures: 0,
            ended: Pairs::none(),
        };

        // Slots without a ray stand where those stand whose rays have come to an end.
        let mut stacks = Stacks::new(tree.wide.most_waiting);
        let mut words = [Word::END.0; SLOTS];
        // On the stack, where they are found without a pointer that would have to be kept at hand.
        let mut rays = [RayState::none(); SLOTS];
        let mut decisions: [Decision<B::Query>; SLOTS] = std::array::from_fn(|_| Decision::new());
        let mut hits = [(0, Candidates::default()); SLOTS];
        let mut patience = Patience::new(tree);

        loop {
            // Divide the slots by what is next.
            let inner = simd.lt_u32(&words, Word::FIRST_LEAF);
            let leaves = simd.lt_u32(&words, Word::END.0) & !inner;
            let ended = simd.lt_u32(&words, Word::IDLE.0) & !(inner | leaves);
            if inner | leaves | ended == 0 {
                break;
            }

            self.work.add_nodes(inner.count_ones());
            self.work.add_leaves(leaves.count_ones());
            patience.take_turn(&rays, inner | leaves);
            if B::IS_WATCHED {
                let mut rest = inner | leaves;
                while let Some(slot) = next_slot(&mut rest) {
                    self.batch.watch(Word(words[slot]), &rays[slot]);
                }
            }

            // Let every ray at a node take a step.
            let mut rest = inner;
            while let Some(slot) = next_slot(&mut rest) {
                let node = &tree.wide.nodes[Word(words[slot]).index()];
                let (nears, free) = stacks.free(slot);
                let pushed = rays[slot].wide.push_children(simd, node, nears, free);
                words[slot] = stacks.pop_after(slot, pushed);
                memory.prefetch(simd, Word(words[slot]));
            }

            // And every ray at a leaf: most have no candidates there, and take up what is next.
            let (mut rest, mut count) = (leaves, 0);
            while let Some(slot) = next_slot(&mut rest) {
                let (hit, candidates) = &mut hits[count % SLOTS];
                let block = &tree.leaves.blocks[Word(words[slot]).index()];
                candidates.find(simd, &rays[slot], block);
                *hit = slot as u8;
                let is_hit = candidates.open != 0;
                count += usize::from(is_hit);
                let next = stacks.words[stacks.ends[slot] - 1];
                stacks.ends[slot] -= usize::from(!is_hit);
                words[slot] = if is_hit { words[slot] } else { next };
                memory.prefetch(simd, Word(words[slot]));
            }
            for (slot, candidates) in &hits[..count] {
                let slot = usize::from(*slot) % SLOTS;
                let ray = &mut rays[slot];
                let before = ray.wide.limit;
                let index = Word(words[slot]).index();
                let mut asked = Asked {
                    number: ray.number,
                    parameter: ray.parameter,
                    found: &mut ray.found,
                    limit: &mut ray.wide.limit,
                };
                let decision = &mut decisions[slot];
                let open = self.decide(&mut asked, decision, candidates, index);
                if open != 0 {
                    self.decide_open(simd, asked, decision, index, open);
                }
                if decision.is_done() {
                    words[slot] = Word::END.0;
                } else {
                    if ray.wide.limit < before {
                        stacks.drop_beyond(simd, slot, ray.wide.limit);
                    }
                    words[slot] = stacks.pop_after(slot, 0);
                    memory.prefetch(simd, Word(words[slot]));
                }
            }

            // Take the answers of those that came to an end, and let others begin.
            let mut rest = ended;
            while let Some(slot) = next_slot(&mut rest) {
                let (ray, decision) = (&mut rays[slot], &mut decisions[slot]);
                self.finish(simd, ray, decision, &mut waiting.ended);
                words[slot] = self
                    .next_ray(simd, &world, memory, &mut waiting, ray, decision, &mut stacks, slot)
                    .0;
            }
        }
        self.finish_pairs(simd, &waiting.ended);
        (self.batch, self.work)
    }
}

impl<B: Batch> Cast<'_, B> {
    /// Gives a slot the next ray that meets the root's box, and returns where it begins; the end if
    /// there is none.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn next_ray<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        memory: Memory,
        waiting: &mut Waiting<B::Query>,
        ray: &mut RayState,
        decision: &mut Decision<B::Query>,
        stacks: &mut Stacks,
        slot: usize,
    ) -> Word {
        while waiting.rays == 0 {
            if waiting.groups.is_empty() {
                if waiting.next >= self.batch.count() {
                    return Word::IDLE;
                }
                self.prepare_next(simd, world, waiting);
            } else {
                self.cast_next(simd, world, memory, waiting);
            }
        }
        let number = waiting.rays.trailing_zeros() as usize % RAYS;
        waiting.rays &= waiting.rays - 1;
        let bundle = &mut waiting.bundle;
        if waiting.is_under_way {
            bundle.hand_over(simd, number, ray, decision);
            let (nears, words) = stacks.places(slot);
            let count = bundle.copy_waiting(words, nears);
            stacks.restart(slot, count);
            Word(stacks.pop_after(slot, 0))
        } else {
            let group = &bundle.groups[number / LANES];
            let (wide, parameter) = group.lane(number % LANES);
            ray.restart(simd, bundle.first + number, wide, parameter);
            stacks.restart(slot, 0);
            self.tree.wide.root
        }
    }

    /// Prepares the next rays.
    #[inline(always)]
    fn prepare_next<S: Simd>(&self, simd: S, world: &World, waiting: &mut Waiting<B::Query>) {
        let first = waiting.next;
        waiting.next = self.batch.count().min(first + RAYS);
        waiting.bundle.first = first;
        let count = (waiting.next - first).div_ceil(LANES);
        for group in 0..count {
            let begin = first + group * LANES;
            let numbers = begin..waiting.next.min(begin + LANES);
            self.prepare_rays(simd, world, &mut waiting.bundle.groups[group], numbers);
        }
        waiting.groups = 0..count;
        waiting.together = GROUPS;
    }

    /// Casts as many of the rays that were prepared as go together as a bundle; the others are to go by
    /// themselves.
    #[inline(always)]
    fn cast_next<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        memory: Memory,
        waiting: &mut Waiting<B::Query>,
    ) {
        let bundle = &mut waiting.bundle;
        let is_tried = waiting.failures < 8 || (bundle.first / RAYS).is_multiple_of(8);
        let is_tried = is_tried && self.can_bundle();
        let all = &mut waiting.groups;
        let mut part = all.start..all.end.min(all.start + waiting.together);
        let mut is_coherent = false;
        if is_tried {
            is_coherent = part.len() == waiting.together && bundle.is_coherent(simd, world, &part);
            if !is_coherent && waiting.together > FEWER {
                waiting.together = FEWER;
                part = all.start..all.end.min(all.start + FEWER);
                is_coherent = part.len() == FEWER && bundle.is_coherent(simd, world, &part);
            }
        }
        all.start = part.end;
        if is_coherent {
            waiting.failures = 0;
            waiting.rays = self.cast_bundle(simd, memory, bundle, &part);
        } else {
            waiting.failures += u32::from(is_tried);
            waiting.rays = 0;
            for group in part {
                bundle.groups[group].write_rays(simd);
                waiting.rays |= Mask::from(bundle.groups[group].met) << (group * LANES);
            }
        }
        waiting.is_under_way = is_coherent;
    }
}

/// Trees up to this size stay in the second-level caches of today's machines, and asking for what is
/// there only takes time.
const CACHED_BYTES: usize = 512 << 10;

/// Where nodes and leaves lie.
#[derive(Clone, Copy)]
pub struct Memory {
    nodes: usize,
    /// False if all lies in the caches anyway.
    is_large: bool,
    /// From the first node to the first leaf.
    leaves_from_nodes: usize,
}

impl Memory {
    fn of(tree: &KdTree) -> Memory {
        let nodes = tree.wide.nodes.as_ptr().addr();
        let leaves = tree.leaves.blocks.as_ptr().addr();
        let is_large = tree.bytes() > CACHED_BYTES;
        Memory { nodes, is_large, leaves_from_nodes: leaves.wrapping_sub(nodes) }
    }

    /// Asks for all cache lines of a node or leaf, without a branch on which it is.
    #[inline(always)]
    pub fn prefetch<S: Simd>(&self, simd: S, word: Word) {
        if !self.is_large {
            return;
        }
        const LINES: usize = size_of::<WideNode>() / 64;
        let is_leaf = usize::from(word.is_leaf());
        let more = is_leaf * (size_of::<LeafBlock>() - size_of::<WideNode>());
        let base = self.nodes.wrapping_add(self.leaves_from_nodes & is_leaf.wrapping_neg());
        let place = base.wrapping_add(word.index() * (size_of::<WideNode>() + more));
        simd.prefetch(place, LINES);
        // The last line of a leaf; of a node one that was asked for already.
        simd.prefetch(place.wrapping_add((LINES - 1) * 64 + more), 1);
    }
}
