//! Many rays at once, each on a walk of its own.
//!
//! A walk waits for memory at nearly every step, so [`SLOTS`] rays are under way at a time: each step
//! of one ray ends by asking for the cache lines of its next, and while they come the others have
//! their turns. Rays stand in queues by the kind of work that is next:
//!
//! ```text
//! NODE  meet eight boxes at once; push those that are met, the nearest last; pop; prefetch
//! LEAF  filter eight triangles at once; where none is left, pop and prefetch, else on to HIT
//! HIT   decide exactly what is left; a hit drops all that waits beyond it; pop; prefetch
//! END   take the answer; give the slot to the next ray
//! ```
//!
//! After each turn the rays are divided by what they popped, without a branch that depends on a
//! ray: such branches cannot be predicted, and cost as much as a node.
//!
//! Different from V. Havran's stack: what waits beyond a hit is dropped at the hit, so that what is
//! popped needs no test. Different from wavefront tracers (S. Laine, T. Karras, T. Aila, "Megakernels
//! Considered Harmful", HPG 2013): the queues hold few enough rays to stay in the first caches.

use super::leaf_kernel::test;
use super::query::{Query, Search, Shortcut};
use super::wide_ray::{Parameter, RayLanes, WideRay, WideRays, World};
use crate::geometry::{NO_FACE, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::PreparedRay;
use crate::simd::{Job, LANES, Simd};
use crate::tree::{KdTree, LeafBlock, WideNode, Word};

/// Rays under way at a time.
const SLOTS: usize = 32;

/// A batch: rays by number, and what is asked about each.
pub trait Batch {
    /// What is asked.
    type Query: Query + Default;

    /// How many rays there are.
    fn count(&self) -> usize;

    /// A ray; those of one number are always the same.
    fn ray(&self, number: usize) -> Ray;

    /// Takes the answer of a walk whose nearest hit is known to be that of `face`, if that needs no
    /// more than plain arithmetic.
    fn finish_plainly(&mut self, _number: usize, _face: u32, _corners: &[Vec3; 3]) -> bool {
        false
    }

    /// Takes the answer of a walk that met some triangle's line.
    fn finish(&mut self, number: usize, ray: &PreparedRay, query: &mut Self::Query);
}

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

/// A ray on its way.
#[repr(align(64))]
struct Walk {
    wide: WideRay,
    /// What comes next.
    word: Word,
    /// At a leaf, a bit for each triangle that the ray may hit.
    candidates: u32,
    /// A bit for each of those that it hits for certain.
    certain: u32,
    /// Where it hits them, at least and at most.
    low: [f32; LANES],
    high: [f32; LANES],
    /// The nearest hit so far, where it is at least, and in which block and lane it was found. It is
    /// at most at the limit.
    nearest: u32,
    nearest_low: f32,
    place: (u32, u32),
    number: usize,
    stack: Stack,
    parameter: Parameter,
}

/// What only rays need that may hit.
struct Decision<Q> {
    is_prepared: bool,
    /// True if the query knows the walk's nearest hit.
    is_told: bool,
    prepared: PreparedRay,
    query: Q,
}

impl<Q: Query + Default> Decision<Q> {
    fn new() -> Decision<Q> {
        let (prepared, query) = (PreparedRay::default(), Q::default());
        Decision { is_prepared: false, is_told: false, prepared, query }
    }
}

/// Slots by number.
struct Queue {
    slots: [u8; SLOTS + 1],
    length: usize,
}

impl Queue {
    const EMPTY: Queue = Queue { slots: [0; SLOTS + 1], length: 0 };

    /// Writes always and keeps it if told so: no branch depends on the ray.
    #[inline(always)]
    fn push_if(&mut self, slot: u8, is_kept: bool) {
        self.slots[self.length.min(SLOTS)] = slot;
        self.length += usize::from(is_kept);
    }

    #[inline(always)]
    fn slots(&self) -> &[u8] {
        &self.slots[..self.length.min(SLOTS)]
    }

    #[inline(always)]
    fn take(&mut self) -> Queue {
        std::mem::replace(self, Queue::EMPTY)
    }
}

/// Rays by what they wait for.
struct Queues {
    nodes: Queue,
    leaves: Queue,
    ends: Queue,
}

impl Queues {
    #[inline(always)]
    fn push(&mut self, slot: u8, word: Word) {
        self.nodes.push_if(slot, word.is_inner());
        self.leaves.push_if(slot, word.is_leaf());
        self.ends.push_if(slot, word == Word::END);
    }

    fn are_empty(&self) -> bool {
        self.nodes.length + self.leaves.length + self.ends.length == 0
    }
}

/// Rays that were prepared together and wait for slots.
struct Waiting {
    rays: WideRays,
    /// A bit for each that waits.
    lanes: u32,
    /// The number of the first of them, and of the first that is not prepared yet.
    first: usize,
    next: usize,
}

/// A batch that is cast.
pub struct Cast<'a, B> {
    /// The scene's tree.
    pub tree: &'a KdTree,
    /// The scene's mesh.
    pub mesh: &'a Mesh,
    /// The batch.
    pub batch: B,
}

impl<B: Batch> Job for Cast<'_, B> {
    type Output = B;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> B {
        let (tree, root) = (self.tree, self.tree.wide.root);
        let world = World { frame: tree.frame, root: tree.root.bounds, reach: tree.reach };
        let memory = Memory::of(tree);
        let mut waiting = Waiting { rays: WideRays::none(), lanes: 0, first: 0, next: 0 };

        // Give each slot a ray.
        let mut queues = Queues { nodes: Queue::EMPTY, leaves: Queue::EMPTY, ends: Queue::EMPTY };
        let mut walks: Vec<Walk> = Vec::with_capacity(SLOTS);
        let mut decisions: Vec<Decision<B::Query>> = Vec::with_capacity(SLOTS);
        while walks.len() < SLOTS
            && let Some((number, wide, parameter)) = self.next_ray(simd, &world, &mut waiting)
        {
            queues.push(walks.len() as u8, root);
            let stack = Stack::new(tree.wide.most_waiting);
            walks.push(Walk {
                wide: *wide,
                word: root,
                candidates: 0,
                certain: 0,
                low: [0.0; LANES],
                high: [0.0; LANES],
                nearest: NO_FACE,
                nearest_low: f32::INFINITY,
                place: (0, 0),
                number,
                stack,
                parameter,
            });
            decisions.push(Decision::new());
        }

        while !queues.are_empty() {
            // Let every ray at a node take a step.
            let nodes = queues.nodes.take();
            for &slot in nodes.slots() {
                let walk = &mut walks[usize::from(slot)];
                let node = &tree.wide.nodes[walk.word.index()];
                let (nears, words) = walk.stack.free();
                walk.stack.waiting += walk.wide.push_children(simd, node, nears, words);
                walk.word = walk.stack.pop();
                memory.prefetch(simd, walk.word);
            }
            for &slot in nodes.slots() {
                queues.push(slot, walks[usize::from(slot)].word);
            }

            // And every ray at a leaf: most have no candidates there, and take up what is next.
            let leaves = queues.leaves.take();
            let mut hits = Queue::EMPTY;
            for &slot in leaves.slots() {
                let walk = &mut walks[usize::from(slot)];
                let block = &tree.leaves.blocks[walk.word.index()];
                let verdict = test(simd, &walk.wide, &block.corners);
                simd.store(verdict.low, &mut walk.low);
                simd.store(verdict.high, &mut walk.high);
                (walk.candidates, walk.certain) = (verdict.candidates, verdict.certain);
                let is_hit = walk.candidates != 0;
                hits.push_if(slot, is_hit);
                walk.stack.waiting -= usize::from(!is_hit);
                let next = Word(walk.stack.words[walk.stack.waiting]);
                walk.word = if is_hit { walk.word } else { next };
                memory.prefetch(simd, walk.word);
            }
            for &slot in hits.slots() {
                let (walk, decision) =
                    (&mut walks[usize::from(slot)], &mut decisions[usize::from(slot)]);
                self.decide(simd, walk, decision);
                memory.prefetch(simd, walk.word);
            }
            for &slot in leaves.slots() {
                queues.push(slot, walks[usize::from(slot)].word);
            }

            // Take the answers of those that came to an end, and let others begin.
            let ends = queues.ends.take();
            for &slot in ends.slots() {
                let (walk, decision) =
                    (&mut walks[usize::from(slot)], &mut decisions[usize::from(slot)]);
                self.finish(walk, decision);
                if let Some((number, wide, parameter)) = self.next_ray(simd, &world, &mut waiting) {
                    walk.wide.copy_from(simd, wide);
                    (walk.number, walk.parameter) = (number, parameter);
                    walk.word = root;
                    (walk.nearest, walk.nearest_low) = (NO_FACE, f32::INFINITY);
                    walk.stack.waiting = 1;
                    queues.push(slot, root);
                }
            }
        }
        self.batch
    }
}

impl<B: Batch> Cast<'_, B> {
    /// The next ray that meets the root's box, and its number.
    #[inline(always)]
    fn next_ray<'w, S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        waiting: &'w mut Waiting,
    ) -> Option<(usize, &'w WideRay, Parameter)> {
        while waiting.lanes == 0 {
            if waiting.next >= self.batch.count() {
                return None;
            }
            self.prepare_next(simd, world, waiting);
        }
        let lane = waiting.lanes.trailing_zeros() as usize;
        waiting.lanes &= waiting.lanes - 1;
        let (wide, parameter) = waiting.rays.lane(lane);
        Some((waiting.first + lane, wide, parameter))
    }

    /// Prepares the next eight rays.
    #[inline(always)]
    fn prepare_next<S: Simd>(&mut self, simd: S, world: &World, waiting: &mut Waiting) {
        waiting.first = waiting.next;
        waiting.next = self.batch.count().min(waiting.first + LANES);
        let mut lanes: RayLanes = [[0.0; LANES]; 8];
        for number in waiting.first..waiting.next {
            let (lane, ray) = (number - waiting.first, self.batch.ray(number));
            for axis in 0..3 {
                lanes[axis][lane] = ray.origin[axis];
                lanes[3 + axis][lane] = ray.direction[axis];
            }
            (lanes[6][lane], lanes[7][lane]) = (ray.t_min, ray.t_max);
        }
        waiting.rays.set(simd, &lanes, world);
        let in_use = (1 << (waiting.next - waiting.first)) - 1;
        waiting.lanes = waiting.rays.met & in_use;
        let mut single = waiting.rays.single & in_use;
        while single != 0 {
            let lane = single.trailing_zeros() as usize;
            single &= single - 1;
            if !waiting.rays.set_single(lane, &self.batch.ray(waiting.first + lane), world) {
                waiting.lanes &= !(1 << lane);
            }
        }
    }

    /// Decides the candidates of the leaf that a ray has come to, and takes up what is next.
    #[inline(always)]
    fn decide<S: Simd>(&mut self, simd: S, walk: &mut Walk, decision: &mut Decision<B::Query>) {
        let block = &self.tree.leaves.blocks[walk.word.index()];
        let before = walk.wide.limit;
        let mut open = walk.candidates;
        match B::Query::SHORTCUT {
            Shortcut::None => {}
            Shortcut::Any => {
                if walk.certain != 0 {
                    decision.is_prepared = true;
                    decision.query.settle(NO_FACE, [Vec3::ZERO; 3]);
                    walk.word = Word::END;
                    return;
                }
            }
            Shortcut::Nearest => {
                open = 0;
                while walk.candidates != 0 {
                    let lane = walk.candidates.trailing_zeros() as usize;
                    walk.candidates &= walk.candidates - 1;
                    let (face, low, high) = (block.faces[lane], walk.low[lane], walk.high[lane]);
                    if face == walk.nearest || face == NO_FACE || low > walk.wide.limit {
                        continue;
                    }
                    if walk.certain >> lane & 1 == 1 && high < walk.nearest_low {
                        (walk.nearest, walk.nearest_low, walk.wide.limit) = (face, low, high);
                        walk.place = (walk.word.index() as u32, lane as u32);
                        decision.is_told = false;
                    } else {
                        open |= 1 << lane;
                    }
                }
            }
        }
        if open != 0 {
            self.decide_exactly(walk, decision, block, open);
            if decision.query.is_done() {
                walk.word = Word::END;
                return;
            }
        }
        if walk.wide.limit < before {
            walk.stack.drop_beyond(simd, walk.wide.limit);
        }
        walk.word = walk.stack.pop();
    }

    /// Decides triangles of a block of which single precision is not certain.
    #[inline(never)]
    fn decide_exactly(
        &mut self,
        walk: &mut Walk,
        decision: &mut Decision<B::Query>,
        block: &LeafBlock,
        mut open: u32,
    ) {
        let tree = self.tree;
        self.prepare(walk, decision);
        let Decision { prepared, query, is_told, .. } = decision;
        if walk.nearest != NO_FACE && !*is_told {
            query.restart();
            let (block, lane) = (&tree.leaves.blocks[walk.place.0 as usize], walk.place.1 as usize);
            let corners = tree.leaves.corners(self.mesh, &tree.frame, block, lane);
            prepared.meet_line_then(corners, walk.nearest, query);
        }
        *is_told = true;
        while open != 0 {
            let lane = open.trailing_zeros() as usize;
            open &= open - 1;
            if block.faces[lane] == NO_FACE {
                continue;
            }
            let corners = tree.leaves.corners(self.mesh, &tree.frame, block, lane);
            prepared.meet_line_then(corners, block.faces[lane], query);
        }
        if B::Query::SHORTCUT == Shortcut::Nearest {
            let (face, bounds) = query.nearest();
            if face != NO_FACE {
                (walk.nearest, walk.nearest_low) = (face, walk.parameter.lower(bounds.low));
                walk.wide.limit = walk.parameter.limit(bounds.high);
            }
        }
    }

    #[inline(always)]
    fn prepare(&self, walk: &Walk, decision: &mut Decision<B::Query>) {
        if !decision.is_prepared {
            decision.prepared.set(&self.batch.ray(walk.number));
            decision.is_prepared = true;
        }
    }

    /// Takes the answer of a walk that is over.
    #[inline(always)]
    fn finish(&mut self, walk: &Walk, decision: &mut Decision<B::Query>) {
        if B::Query::SHORTCUT == Shortcut::Nearest && walk.nearest != NO_FACE && !decision.is_told {
            let block = &self.tree.leaves.blocks[walk.place.0 as usize];
            let lane = walk.place.1 as usize;
            let corners = self.tree.leaves.corners(self.mesh, &self.tree.frame, block, lane);
            if self.batch.finish_plainly(walk.number, walk.nearest, &corners) {
                if decision.is_prepared {
                    decision.query.restart();
                    decision.is_prepared = false;
                }
                return;
            }
            self.prepare(walk, decision);
            decision.query.settle(walk.nearest, corners);
        }
        if decision.is_prepared {
            self.batch.finish(walk.number, &decision.prepared, &mut decision.query);
            decision.query.restart();
            (decision.is_prepared, decision.is_told) = (false, false);
        }
    }
}

/// Trees up to this size stay in the second-level caches of today's machines, and asking for what is
/// there only takes time.
const CACHED_BYTES: usize = 512 << 10;

/// Where nodes and leaves lie.
#[derive(Clone, Copy)]
struct Memory {
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
    fn prefetch<S: Simd>(&self, simd: S, word: Word) {
        if !self.is_large {
            return;
        }
        const LINES: usize = size_of::<LeafBlock>() / 64;
        let is_leaf = usize::from(word.is_leaf());
        let size =
            size_of::<WideNode>() + is_leaf * (size_of::<LeafBlock>() - size_of::<WideNode>());
        let base = self.nodes.wrapping_add(self.leaves_from_nodes & is_leaf.wrapping_neg());
        simd.prefetch(base.wrapping_add(word.index() * size), LINES);
    }
}
