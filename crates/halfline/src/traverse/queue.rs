//! Many rays at once, each on a walk of its own.
//!
//! A walk waits for memory at nearly every step, so [`SLOTS`] rays are under way at a time: each step
//! of one ray ends by asking for the cache lines of its next, and while they come the others have
//! their turns. Rays stand in queues by the kind of work that is next:
//!
//! ```text
//! NODE  meet eight boxes at once; push those that are met, the nearest last; pop; prefetch
//! LEAF  hold eight triangles against the ray at once; where none is left, pop and prefetch
//! HIT   decide what is left (`cast.rs`); a hit drops all that waits beyond it; pop; prefetch
//! END   take the answer; give the slot to the next ray, or to what is left of a bundle
//! ```
//!
//! After each turn the rays are divided by what they popped, without a branch that depends on a
//! ray: such branches cannot be predicted, and cost as much as a node.
//!
//! Different from V. Havran's stack: what waits beyond a hit is dropped at the hit, so that what is
//! popped needs no test. Different from wavefront tracers (S. Laine, T. Karras, T. Aila, "Megakernels
//! Considered Harmful", HPG 2013): the queues hold few enough rays to stay in the first caches.

use super::bundle::{Bundle, RAYS};
use super::cast::{Batch, Candidates, Cast, Decision, Ended, RayState};
use super::wide_ray::World;
use crate::simd::{Job, LANES, Simd};
use crate::tree::{KdTree, LeafBlock, WideNode, Word};

/// Rays under way at a time.
const SLOTS: usize = 32;

/// All lanes, the first first, as [`Simd::push`] takes them.
const IN_ORDER: u32 = 0o76_543_210;

/// What waits on the walk of one ray. Writes are eight wide, so there is that much room at the end.
struct Stack {
    words: Vec<u32>,
    /// Where the ray enters what waits, at least.
    nears: Vec<f32>,
    waiting: usize,
}

impl Stack {
    fn new(most_waiting: usize) -> Stack {
        // The end of the walk waits below everything else.
        let room = most_waiting + 1 + LANES;
        Stack { words: vec![Word::END.0; room], nears: vec![f32::NEG_INFINITY; room], waiting: 1 }
    }

    /// The eight places from the first free one on.
    #[inline(always)]
    fn free(&mut self) -> (&mut [f32; LANES], &mut [u32; LANES]) {
        let nears = self.nears[self.waiting..].first_chunk_mut();
        let words = self.words[self.waiting..].first_chunk_mut();
        let (Some(nears), Some(words)) = (nears, words) else {
            unreachable!("the builder bounds what waits")
        };
        (nears, words)
    }

    #[inline(always)]
    fn pop(&mut self) -> Word {
        self.waiting -= 1;
        Word(self.words[self.waiting])
    }

    /// Drops what is entered beyond `limit`, eight at a time.
    #[inline(always)]
    fn drop_beyond<S: Simd>(&mut self, simd: S, limit: f32) {
        // What lies beyond the last that waits is dropped too.
        self.free().0.fill(f32::INFINITY);
        let limit = simd.splat(limit.min(f32::MAX));
        let (mut kept, mut first) = (1, 1);
        while first < self.waiting {
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
            kept += simd.push(near, limit, &words, IN_ORDER, free_nears, free_words);
            first += LANES;
        }
        self.waiting = kept;
    }
}

/// A ray and what waits for it.
struct Walk {
    ray: RayState,
    /// What comes next.
    word: Word,
    stack: Stack,
}

/// Slots by what their rays wait for: the kind of the [`Word`] that is next.
struct Queues {
    slots: [[u8; ROOM]; 4],
    lengths: [usize; 4],
}

/// Room in a queue, a power of two, so that no index can be out of bounds.
const ROOM: usize = 2 * SLOTS;

impl Queues {
    const EMPTY: Queues = Queues { slots: [[0; ROOM]; 4], lengths: [0; 4] };

    /// No branch depends on the ray.
    #[inline(always)]
    fn push(&mut self, slot: u8, word: Word) {
        let kind = word.kind();
        let length = &mut self.lengths[kind];
        self.slots[kind][*length % ROOM] = slot;
        *length += 1;
    }

    /// The slots of a kind.
    #[inline(always)]
    fn of(&self, kind: usize) -> &[u8] {
        &self.slots[kind][..self.lengths[kind].min(ROOM)]
    }

    #[inline(always)]
    fn are_empty(&self) -> bool {
        self.lengths == [0; 4]
    }
}

/// Rays that wait for slots.
struct Waiting<Q> {
    bundle: Bundle<Q>,
    /// A bit for each that waits.
    lanes: u32,
    /// True for what is left of a bundle that was on its way.
    is_under_way: bool,
    /// The number of the first ray that was not looked at yet.
    next: usize,
    /// Groups of rays that in turn were too different to go as a bundle.
    failures: u32,
    /// Rays that wait for their last answers.
    ended: Ended,
}

impl<B: Batch> Job for Cast<'_, B> {
    type Output = B;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> B {
        let tree = self.tree;
        let world = World { frame: tree.frame, root: tree.root.bounds, reach: tree.reach };
        let memory = Memory::of(tree);
        let bundle = Bundle::new(tree.wide.most_waiting);
        let mut waiting = Waiting {
            bundle,
            lanes: 0,
            is_under_way: false,
            next: 0,
            failures: 0,
            ended: Ended::none(),
        };

        // Slots without a ray stand where those stand whose rays have come to an end.
        let mut walks: Vec<Walk> = Vec::with_capacity(SLOTS);
        let mut decisions: Vec<Decision<B::Query>> = Vec::with_capacity(SLOTS);
        let (mut now, mut next) =
            (&mut Queues { ..Queues::EMPTY }, &mut Queues { ..Queues::EMPTY });
        for slot in 0..SLOTS {
            let stack = Stack::new(tree.wide.most_waiting);
            walks.push(Walk { ray: RayState::none(), word: Word::END, stack });
            decisions.push(Decision::new());
            now.push(slot as u8, Word::END);
        }
        let mut hits = [(0, Candidates::default()); ROOM];

        while !now.are_empty() {
            // Let every ray at a node take a step.
            for &slot in now.of(Word::INNER) {
                let walk = &mut walks[usize::from(slot)];
                let node = &tree.wide.nodes[walk.word.index()];
                let (nears, words) = walk.stack.free();
                walk.stack.waiting += walk.ray.wide.push_children(simd, node, nears, words);
                walk.word = walk.stack.pop();
                memory.prefetch(simd, walk.word);
            }
            for &slot in now.of(Word::INNER) {
                next.push(slot, walks[usize::from(slot)].word);
            }

            // And every ray at a leaf: most have no candidates there, and take up what is next.
            let mut count = 0;
            for &slot in now.of(Word::LEAF) {
                let walk = &mut walks[usize::from(slot)];
                let (hit, candidates) = &mut hits[count % ROOM];
                candidates.find(simd, &walk.ray, &tree.leaves.blocks[walk.word.index()]);
                *hit = slot;
                let is_hit = candidates.open != 0;
                count += usize::from(is_hit);
                walk.stack.waiting -= usize::from(!is_hit);
                let word = Word(walk.stack.words[walk.stack.waiting]);
                walk.word = if is_hit { walk.word } else { word };
                memory.prefetch(simd, walk.word);
            }
            for (slot, candidates) in &hits[..count.min(ROOM)] {
                let slot = *slot;
                let walk = &mut walks[usize::from(slot)];
                let before = walk.ray.wide.limit;
                let decision = &mut decisions[usize::from(slot)];
                if self.decide(&mut walk.ray, decision, candidates, walk.word.index()) {
                    walk.word = Word::END;
                } else {
                    if walk.ray.wide.limit < before {
                        walk.stack.drop_beyond(simd, walk.ray.wide.limit);
                    }
                    walk.word = walk.stack.pop();
                    memory.prefetch(simd, walk.word);
                }
            }
            for &slot in now.of(Word::LEAF) {
                next.push(slot, walks[usize::from(slot)].word);
            }

            // Take the answers of those that came to an end, and let others begin.
            for &slot in now.of(Word::ENDED) {
                let (walk, decision) =
                    (&mut walks[usize::from(slot)], &mut decisions[usize::from(slot)]);
                self.finish(simd, &walk.ray, decision, &mut waiting.ended);
                if self.next_ray(simd, &world, memory, &mut waiting, walk, decision) {
                    next.push(slot, walk.word);
                }
            }
            now.lengths = [0; 4];
            std::mem::swap(&mut now, &mut next);
        }
        self.finish_ended(simd, &mut waiting.ended);
        self.batch
    }
}

impl<B: Batch> Cast<'_, B> {
    /// Gives a slot the next ray that meets the root's box; false if there is none.
    #[inline(always)]
    fn next_ray<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        memory: Memory,
        waiting: &mut Waiting<B::Query>,
        walk: &mut Walk,
        decision: &mut Decision<B::Query>,
    ) -> bool {
        while waiting.lanes == 0 {
            if waiting.next >= self.batch.count() {
                return false;
            }
            self.next_group(simd, world, memory, waiting);
        }
        let lane = waiting.lanes.trailing_zeros() as usize;
        waiting.lanes &= waiting.lanes - 1;
        let bundle = &mut waiting.bundle;
        if waiting.is_under_way {
            std::mem::swap(&mut walk.ray, &mut bundle.rays[lane]);
            std::mem::swap(decision, &mut bundle.decisions[lane]);
            walk.stack.waiting =
                1 + bundle.copy_waiting(&mut walk.stack.words[1..], &mut walk.stack.nears[1..]);
            walk.word = walk.stack.pop();
        } else {
            let (wide, parameter) = bundle.groups[lane / LANES].lane(lane % LANES);
            walk.ray.restart(simd, bundle.first + lane, wide, parameter);
            walk.stack.waiting = 1;
            walk.word = self.tree.wide.root;
        }
        true
    }

    /// Prepares the next rays, and casts them as a bundle if they are alike.
    #[inline(always)]
    fn next_group<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        memory: Memory,
        waiting: &mut Waiting<B::Query>,
    ) {
        let bundle = &mut waiting.bundle;
        let first = waiting.next;
        waiting.next = self.batch.count().min(first + RAYS);
        bundle.first = first;
        waiting.lanes = 0;
        waiting.is_under_way = false;
        for half in 0..2 {
            let begin = first + half * LANES;
            let end = waiting.next.min(begin + LANES);
            if begin < end {
                waiting.lanes |=
                    self.prepare_rays(simd, world, bundle, half, begin..end) << (half * LANES);
            }
        }
        let is_tried = waiting.failures < 4 || (first / RAYS).is_multiple_of(8);
        if is_tried && waiting.lanes == (1 << RAYS) - 1 && self.can_bundle() {
            if bundle.is_coherent(simd, world) {
                waiting.failures = 0;
                waiting.lanes = self.cast_bundle(simd, memory, bundle, &mut waiting.ended);
                waiting.is_under_way = true;
            } else {
                waiting.failures += 1;
            }
        }
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
