//! Who gives rays to the slots of a stream.
//!
//! Rays are prepared sixty-four at a time. All of them, or sixteen, that are near to each other all the way go
//! as one packet, and only what is left of it comes to the slots; the others go there at once.

use std::ops::Range;

use super::cast::Cast;
use super::leaf::{ExactState, RayState};
use super::packet::{Mask, OCTETS, PacketBounds, RAYS, RayPacket, is_packet_of_use};
use super::prefetch::Prefetcher;
use super::query::{Query, QueryKind};
use super::stack::Stacks;
use crate::rays::{RootFrame, prepare_octets};
use crate::simd::{LANES, Simd};
use crate::tree::NodeRef;

/// Octets that go as a packet if all those that are looked at together do not.
const FEWER_OCTETS: usize = 2;

/// How often in a row rays may be too different to go as a packet before only one in [`TRIED_AGAIN`] is tried.
const MAX_FAILURES: u32 = 8;

/// Of so many times sixty-four rays, one is tried after [`MAX_FAILURES`].
const TRIED_AGAIN: usize = 8;

/// Where all hits are asked for, rays go through everything on their way: they go together if they meet no more
/// leaves than this of each surface, since there they would not all meet the same.
const MOST_LEAVES: f32 = 24.0;

/// The rays that are prepared, and have no slot yet.
pub struct Feeder<Q> {
    packet: RayPacket<Q>,
    /// A bit for each that has no slot yet.
    rays: Mask,
    /// True for what is left of a packet that was on its way.
    is_under_way: bool,
    /// The octets that were prepared and not yet looked at.
    octets: Range<usize>,
    /// How many octets are looked at together.
    together: usize,
    /// How many rays were prepared, in the order in which they are cast.
    next: usize,
    /// Where that ends for now.
    end: usize,
    /// How often in a row rays were too different to go as a packet.
    failures: u32,
}

impl<Q: Query> Feeder<Q> {
    /// A feeder that has no rays yet, for a tree whose walks need so much of a stack.
    pub fn new(max_stack_size: usize) -> Feeder<Q> {
        Feeder {
            packet: RayPacket::new(max_stack_size),
            rays: 0,
            is_under_way: false,
            octets: 0..0,
            together: 1,
            next: 0,
            end: 0,
            failures: 0,
        }
    }

    /// Gives rays up to this one, of those that are cast. Returns false if there are none.
    pub fn goes_on_to(&mut self, end: usize) -> bool {
        self.end = end;
        self.next < end
    }

    /// Gives a slot the next ray that meets the box of all that can be hit, and returns where it begins, or
    /// [`NodeRef::IDLE`] if there is none.
    #[inline(always)]
    pub fn next<S: Simd>(
        &mut self,
        simd: S,
        cast: &mut Cast,
        (root, prefetcher): (&RootFrame, Prefetcher),
        ray: &mut RayState,
        state: &mut ExactState<Q>,
        (stacks, slot): (&mut Stacks, usize),
    ) -> NodeRef {
        while self.rays == 0 {
            if !self.octets.is_empty() {
                self.cast_next(simd, cast, root, prefetcher);
            } else if self.next < self.end && !cast.answers.are_cancelled() {
                self.prepare_next(simd, cast, root);
            } else {
                return NodeRef::IDLE;
            }
        }
        let number = self.rays.trailing_zeros() as usize % RAYS;
        self.rays &= self.rays - 1;
        let packet = &mut self.packet;
        if self.is_under_way {
            packet.hand_over(simd, number, ray, state);
            let (entries, refs) = stacks.places(slot);
            let size = packet.stack.copy_to(entries, refs);
            stacks.restart(slot, size);
            NodeRef(stacks.pop_after(slot, 0))
        } else {
            let octet = &packet.octets[number / LANES];
            let (traversal, parameter) = octet.lane(number % LANES);
            ray.restart(simd, octet.first + number % LANES, traversal, parameter);
            stacks.restart(slot, 0);
            cast.target.tree.root
        }
    }

    /// Prepares the next rays.
    #[inline(always)]
    fn prepare_next<S: Simd>(&mut self, simd: S, cast: &Cast, root: &RootFrame) {
        let first = self.next;
        self.next = self.end.min(first + RAYS);
        let octets = &mut self.packet.octets;
        let count =
            prepare_octets(simd, octets, (&cast.source, &cast.order), first..self.next, root);
        self.octets = 0..count;
        self.together = OCTETS;
    }

    /// Casts as many of the rays that were prepared as go together as a packet; the others are to go by
    /// themselves.
    #[inline(always)]
    fn cast_next<S: Simd>(
        &mut self,
        simd: S,
        cast: &mut Cast,
        root: &RootFrame,
        prefetcher: Prefetcher,
    ) {
        let packet = &mut self.packet;
        let is_tried =
            self.failures < MAX_FAILURES || self.next.div_ceil(RAYS).is_multiple_of(TRIED_AGAIN);
        let is_tried = is_tried && is_packet_of_use(cast.target.tree);
        let all = &mut self.octets;
        let mut part = all.start..all.end.min(all.start + self.together);
        let mut bounds = None;
        if is_tried {
            if part.len() == self.together {
                bounds = PacketBounds::of(simd, &packet.octets[part.clone()], root);
            }
            if bounds.is_none() && self.together > FEWER_OCTETS {
                self.together = FEWER_OCTETS;
                part = all.start..all.end.min(all.start + FEWER_OCTETS);
                if part.len() == FEWER_OCTETS {
                    bounds = PacketBounds::of(simd, &packet.octets[part.clone()], root);
                }
            }
        }
        if Q::KIND == QueryKind::All {
            let leaves = cast.target.tree.leaves.blocks.len();
            bounds = bounds.filter(|bounds| bounds.leaves_of(leaves, root) <= MOST_LEAVES);
        }
        all.start = part.end;
        self.is_under_way = bounds.is_some();
        if let Some(bounds) = bounds {
            self.failures = 0;
            self.rays = packet.cast(simd, cast, prefetcher, bounds, part);
        } else {
            self.failures += u32::from(is_tried);
            self.rays = 0;
            for octet in part {
                packet.octets[octet].write_rays(simd);
                self.rays |= Mask::from(packet.octets[octet].met) << (octet * LANES);
            }
        }
    }
}
