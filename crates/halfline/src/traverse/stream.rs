//! Streams of single rays: many under way at once, each on a walk of its own.
//!
//! A walk stands still for memory at nearly every step, so [`SLOTS`] rays are under way at a time: each step
//! of one ray ends by asking for the cache lines of its next, and while they come the others have
//! their turns. In each turn they are taken by the kind of work that is next:
//!
//! ```text
//! NODE  meet eight boxes at once; push those that are met, the nearest last; pop; prefetch
//! LEAF  hold eight triangles against the ray at once; where none is left, pop and prefetch
//! HIT   decide what is left (`leaf/`); a hit drops all that lies beyond it; pop; prefetch
//! END   take the answer; give the slot to the next ray, or to what is left of a packet (`feeder.rs`)
//! ```
//!
//! After each turn the rays are divided by what they popped, without a branch that depends on a
//! ray: such branches cannot be predicted, and cost as much as a node.
//!
//! Different from wavefront tracers (S. Laine, T. Karras, T. Aila, "Megakernels Considered Harmful",
//! HPG 2013): there are few enough rays under way to stay in the first caches.

use std::marker::PhantomData;

use super::cast::Cast;
use super::feeder::Feeder;
use super::leaf::{Candidates, ExactState, Pairs, RayCursor, RayState};
use super::prefetch::Prefetcher;
use super::query::Query;
use super::stack::Stacks;
use super::step_limit::StepLimit;
use crate::rays::RootFrame;
use crate::simd::{Job, Simd, WORDS};
use crate::tree::NodeRef;

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
        let prefetcher = Prefetcher::of(tree);
        let mut feeder = Feeder::<Q>::new(tree.max_stack_size);
        let mut ended = Pairs::none();

        // Slots without a ray stand where those stand whose rays have come to an end.
        let mut stacks = Stacks::new(tree.max_stack_size);
        let mut places = [NodeRef::END.0; SLOTS];
        // On the machine's stack, where they are found without a pointer that would have to be kept at hand.
        let mut rays = [RayState::none(); SLOTS];
        let mut states: [ExactState<Q>; SLOTS] = std::array::from_fn(|_| ExactState::new());
        let mut hits = [(0, Candidates::default()); SLOTS];
        let mut step_limit = StepLimit::new(tree);

        loop {
            // Divide the slots by what is next.
            let nodes = simd.lt_u32(&places, NodeRef::FIRST_LEAF);
            let leaves = simd.lt_u32(&places, NodeRef::END.0) & !nodes;
            let done = simd.lt_u32(&places, NodeRef::IDLE.0) & !(nodes | leaves);
            if nodes | leaves | done == 0 {
                break;
            }

            cast.work.add_nodes(nodes.count_ones());
            cast.work.add_leaves(leaves.count_ones());
            step_limit.take_turn(&rays, nodes | leaves);
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
                let is_hit = candidates.open != 0;
                count += usize::from(is_hit);
                let next = stacks.top(slot);
                stacks.drop_top_if(slot, !is_hit);
                places[slot] = if is_hit { places[slot] } else { next };
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
                if open != 0 {
                    cast.decide_open(simd, cursor, state, index, open);
                }
                if state.is_done() {
                    places[slot] = NodeRef::END.0;
                } else {
                    if ray.traversal.limit < before {
                        stacks.drop_beyond(simd, slot, ray.traversal.limit);
                    }
                    places[slot] = stacks.pop_after(slot, 0);
                    prefetcher.prefetch(simd, NodeRef(places[slot]));
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
        cast.finish_pairs(simd, &ended);
        cast
    }
}
