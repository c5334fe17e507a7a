//! Streams of single rays: many under way at once, each on a walk of its own.
//!
//! A walk stands still for memory at nearly every step, so [`SLOTS`] rays are under way at a time: each step
//! of one ray ends by asking for the cache lines of its next, and while they come the others have
//! their turns. In each turn they are taken by the kind of work that is next:
//!
//! ```text
//! NODE  meet eight boxes at once; push those that are met, the nearest last; pop; prefetch
//! LEAF  hold eight triangles against the ray at once; where none is left, pop and prefetch
//! HIT   take what is certain (`leaf/`); a hit drops all that lies beyond it; pop; prefetch
//! WAIT  for others of which something is open, until double precision has a look at eight pairs
//! END   take the answer; give the slot to the next ray, or to what is left of a packet (`feeder.rs`)
//! ```
//!
//! After each turn the rays are divided by what they popped, without a branch that depends on a
//! ray: such branches cannot be predicted, and cost as much as a node.
//!
//! Different from wavefront tracers (S. Laine, T. Karras, T. Aila, "Megakernels Considered Harmful",
//! HPG 2013): there are few enough rays under way to stay in the first caches.

use std::hint::select_unpredictable;
use std::marker::PhantomData;
use std::time::{Duration, Instant};

use super::cast::Cast;
use super::feeder::Feeder;
use super::leaf::{Candidates, ExactState, OpenPairs, Pairs, RayCursor, RayState};
use super::prefetch::{PrefetchChoice, Prefetcher};
use super::query::Query;
use super::stack::Stacks;
use super::step_limit::StepLimit;
use crate::rays::RootFrame;
use crate::simd::{Job, LANES, Simd, WORDS};
use crate::tree::NodeRef;

/// How many turns a ray may wait for a look in double precision.
pub const MAX_TURNS_WAITED: u32 = 4;

/// Rays under way at a time, each in a slot.
pub const SLOTS: usize = WORDS;

/// The slots of a mask, the first first.
#[inline(always)]
pub fn next_slot(mask: &mut u32) -> Option<usize> {
    if *mask == 0 {
        return None;
    }
    let slot = mask.trailing_zeros() as usize % SLOTS;
    *mask &= *mask - 1;
    Some(slot)
}

/// Casts a batch by the best instruction set that its target has, and puts its answers.
pub fn cast<Q: Query>(cast: Cast) -> Cast {
    cast.target.level.run(Stream::<Q>(cast, PhantomData))
}

/// A batch that is cast as a stream.
struct Stream<'a, Q>(Cast<'a>, PhantomData<Q>);

impl<'a, Q: Query> Job for Stream<'a, Q> {
    type Output = Cast<'a>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Cast<'a> {
        let Stream(mut cast, _) = self;
        let tree = cast.target.tree;
        let root = RootFrame::of(tree);
        let mut feeder = Feeder::<Q>::new(tree.max_stack_size);
        let mut ended = Pairs::none();

        // Slots without a ray stand where those stand whose rays have come to an end.
        let mut stacks = Stacks::new(tree.max_stack_size);
        let mut places = [NodeRef::END.0; SLOTS];
        // On the machine's stack, where they are found without a pointer that would have to be kept at hand.
        let mut rays = [RayState::none(); SLOTS];
        let mut states: [ExactState<Q>; SLOTS] = std::array::from_fn(|_| ExactState::new());
        let mut hits = [(0, Candidates::default()); SLOTS];
        let mut open_pairs = OpenPairs::none();
        let mut turns_waited = 0;
        let mut step_limit = StepLimit::new(tree);

        let choice = PrefetchChoice::of(tree, cast.target.tuner);
        let mut times = [Duration::ZERO; 2];
        for (part, (end, is_on)) in choice.parts(cast.order.count()).into_iter().enumerate() {
            if !feeder.goes_on_to(end) {
                continue;
            }
            let begin = Instant::now();
            let prefetcher = Prefetcher::of(tree, is_on);
            places.fill(NodeRef::END.0);
            rays.fill(RayState::none());
            loop {
                // Divide the slots by what is next.
                let nodes = simd.lt_u32(&places, NodeRef::FIRST_LEAF);
                let leaves = simd.lt_u32(&places, NodeRef::END.0) & !nodes;
                let done = simd.lt_u32(&places, NodeRef::IDLE.0) & !(nodes | leaves);
                if nodes | leaves | done == 0 {
                    if open_pairs.len() == 0 {
                        break;
                    }
                    turns_waited = MAX_TURNS_WAITED;
                }

                cast.work.add_nodes(nodes.count_ones());
                cast.work.add_leaves(leaves.count_ones());
                step_limit.take_turn(&rays, &places);
                if cast.is_recorded() {
                    let mut rest = nodes | leaves;
                    while let Some(slot) = next_slot(&mut rest) {
                        cast.record(NodeRef(places[slot]), &rays[slot]);
                    }
                }

                // Let every ray at a node take a step.
                let mut rest = nodes;
                while let Some(slot) = next_slot(&mut rest) {
                    let node = &tree.nodes[NodeRef(places[slot]).index()];
                    let (entries, refs) = stacks.free(slot);
                    let pushed = rays[slot].traversal.intersect_children(simd, node, entries, refs);
                    places[slot] = stacks.pop_after(slot, pushed);
                    prefetcher.prefetch(simd, NodeRef(places[slot]));
                }

                // Let every ray at a leaf meet its triangles: most have no candidates there, and pop what is next.
                let (mut rest, mut count) = (leaves, 0);
                while let Some(slot) = next_slot(&mut rest) {
                    let (hit, candidates) = &mut hits[count % SLOTS];
                    let block = &tree.leaves.blocks[NodeRef(places[slot]).index()];
                    candidates.find::<S, Q>(simd, &rays[slot], block);
                    *hit = slot as u8;
                    let (is_met, is_single) =
                        (candidates.open != 0, candidates.is_single_and_open());
                    count += usize::from(is_met & !is_single);
                    let lane = candidates.open.trailing_zeros();
                    open_pairs.push_if(is_single, slot, NodeRef(places[slot]).index() as u32, lane);
                    let next = stacks.top(slot);
                    stacks.drop_top_if(slot, !is_met);
                    let here = select_unpredictable(is_single, NodeRef::WAITING.0, places[slot]);
                    places[slot] = select_unpredictable(is_met, here, next);
                    prefetcher.prefetch(simd, NodeRef(places[slot]));
                }

                // Decide the candidates of the others.
                for (slot, candidates) in &hits[..count] {
                    let slot = usize::from(*slot) % SLOTS;
                    let ray = &mut rays[slot];
                    let before = ray.traversal.limit;
                    let index = NodeRef(places[slot]).index();
                    let mut cursor = RayCursor {
                        number: ray.number,
                        parameter: ray.parameter,
                        nearest: &mut ray.nearest,
                        limit: &mut ray.traversal.limit,
                    };
                    let state = &mut states[slot];
                    let open = cast.decide(&mut cursor, state, candidates, index);
                    if ray.traversal.limit < before {
                        stacks.drop_beyond(simd, slot, ray.traversal.limit);
                    }
                    if open != 0 {
                        if open_pairs.is_full() {
                            let slots = (&mut places, &mut rays, &mut states, &mut stacks);
                            decide_open(simd, &cast, (&mut open_pairs, LANES), slots, prefetcher);
                        }
                        open_pairs.push_all(slot, index as u32, open);
                        places[slot] = NodeRef::WAITING.0;
                    } else if state.is_done() {
                        places[slot] = NodeRef::END.0;
                    } else {
                        places[slot] = stacks.pop_after(slot, 0);
                        prefetcher.prefetch(simd, NodeRef(places[slot]));
                    }
                }

                // Let double precision have a look at what is open, if there is enough of it, or it waited for long.
                turns_waited += 1;
                let has_waited = turns_waited > MAX_TURNS_WAITED;
                if (open_pairs.len() >= LANES) | has_waited {
                    turns_waited = 0;
                    if open_pairs.len() != 0 {
                        let slots = (&mut places, &mut rays, &mut states, &mut stacks);
                        let least = if has_waited { 1 } else { LANES };
                        decide_open(simd, &cast, (&mut open_pairs, least), slots, prefetcher);
                    }
                }

                // Take the answers of those that came to an end, and let others begin.
                let mut rest = done;
                while let Some(slot) = next_slot(&mut rest) {
                    let (ray, state) = (&mut rays[slot], &mut states[slot]);
                    cast.finish(simd, ray, state, &mut ended);
                    places[slot] = feeder
                        .next(simd, &mut cast, (&root, prefetcher), ray, state, (&mut stacks, slot))
                        .0;
                }
            }
            times[part] = begin.elapsed();
        }
        cast.finish_pairs(simd, &ended);
        choice.finish(times);
        cast
    }
}

/// Where rays are under way, and where they are: places, rays, what was decided of them, and stacks.
type Slots<'a, Q> = (
    &'a mut [u32; SLOTS],
    &'a mut [RayState; SLOTS],
    &'a mut [ExactState<Q>; SLOTS],
    &'a mut Stacks,
);

/// Decides the pairs that wait, eight at a time as long as there are so many or `least`, in a function of its own: it is
/// rarer than all else, and would be in the way.
#[inline(always)]
fn decide_open<S: Simd, Q: Query>(
    simd: S,
    cast: &Cast,
    (open_pairs, least): (&mut OpenPairs, usize),
    slots: Slots<Q>,
    prefetcher: Prefetcher,
) {
    simd.outlined(DecideOpen { cast, open_pairs, least, slots, prefetcher });
}

struct DecideOpen<'a, 'b, Q> {
    cast: &'a Cast<'b>,
    open_pairs: &'a mut OpenPairs,
    least: usize,
    slots: Slots<'a, Q>,
    prefetcher: Prefetcher,
}

impl<Q: Query> Job for DecideOpen<'_, '_, Q> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let DecideOpen { cast, open_pairs, least, slots, prefetcher } = self;
        let (places, rays, states, stacks) = slots;
        let blocks = &cast.target.tree.leaves.blocks;
        loop {
            let pairs = open_pairs.first(blocks, |slot| rays[slot % SLOTS].number);
            let look = cast.refine(simd, &pairs);
            for pair in 0..open_pairs.len().min(LANES) {
                let slot = open_pairs.owner(pair) % SLOTS;
                let (ray, state) = (&mut rays[slot], &mut states[slot]);
                let before = ray.traversal.limit;
                if !state.is_done() {
                    let place =
                        (pairs.blocks[pair] as usize, pairs.triangles[pair] as usize % LANES);
                    let cursor = RayCursor {
                        number: ray.number,
                        parameter: ray.parameter,
                        nearest: &mut ray.nearest,
                        limit: &mut ray.traversal.limit,
                    };
                    cast.take_look(simd, cursor, state, (&look, pair), place);
                }
                if ray.traversal.limit < before {
                    stacks.drop_beyond(simd, slot, ray.traversal.limit);
                }
                if open_pairs.is_last_of_owner(pair) {
                    if state.is_done() {
                        places[slot] = NodeRef::END.0;
                    } else {
                        places[slot] = stacks.pop_after(slot, 0);
                        prefetcher.prefetch(simd, NodeRef(places[slot]));
                    }
                }
            }
            open_pairs.drop_first();
            if open_pairs.len() < least {
                break;
            }
        }
    }
}
