//! Packets: many rays as one, where they are alike.
//!
//! A. Reshetov, A. Soupikov, J. Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005, and
//! I. Wald, "Realtime Ray Tracing and Interactive Global Illumination", 2004: rays from one eye, or to
//! one light, pass through the same nodes. So the children of a node are first held against bounds of
//! all rays (`bounds.rs`), at the cost of two single rays. What is left, and not met by all of
//! them for certain, is held against the rays themselves when its turn comes, eight at a time. In a leaf
//! a frustum around the rays passes over most triangles; each of the others is held against eight rays at a
//! time, or each ray against all of them, whatever is less work (`leaf.rs`).
//!
//! Different here: a packet that falls apart goes on as single rays from where it is.

mod bounds;
mod hits;
mod leaf;
mod stack;

use std::ops::Range;

use super::cast::Cast;
use super::leaf::{ExactState, OpenPairs, RayState};
use super::prefetch::Prefetcher;
use super::query::{Query, QueryKind};
use crate::rays::{ALL, RayFields, RayOctet};
use crate::simd::{Job, LANES, Simd};
use crate::tree::{Node, NodeRef, Tree, panic_corrupt_tree};

pub use bounds::PacketBounds;
use hits::PacketHits;
use stack::{PacketStack, Popped};

/// Octets that are looked at together: the rays of a tile of 8 by 8 pixels.
pub const OCTETS: usize = 8;

/// Rays that are looked at together.
pub const RAYS: usize = OCTETS * LANES;

/// A bit for each ray.
pub type Mask = u64;

/// Steps after which it is asked whether a packet is still worth it.
const FEW_STEPS: u32 = 12;

/// How many rays must have taken part in each step, on the average.
const FEW_RAYS: u32 = 4;

/// Rays, and what is known of them.
pub struct RayPacket<Q> {
    /// As they were prepared.
    pub octets: [RayOctet; OCTETS],
    /// What they come to next.
    pub stack: PacketStack,
    hits: PacketHits,
    /// What they may need to decide exactly.
    states: Vec<ExactState<Q>>,
    /// What double precision is to have a look at.
    open_pairs: OpenPairs,
    /// Beyond this no ray matters.
    limit: f32,
}

/// Whether packets are of any use for a tree.
pub fn is_packet_of_use(tree: &Tree) -> bool {
    tree.root.is_node()
}

/// The lanes of an octet in a mask.
#[inline(always)]
fn lanes_of(mask: Mask, octet: usize) -> u32 {
    (mask >> (octet * LANES)) as u32 & ALL
}

/// The bits of an octet's lanes.
#[inline(always)]
fn bits_of(lanes: u32, octet: usize) -> Mask {
    Mask::from(lanes) << (octet * LANES)
}

/// The rays of some octets.
#[inline(always)]
fn rays_of(octets: &Range<usize>) -> Mask {
    (Mask::MAX >> (RAYS - octets.len() * LANES)) << (octets.start * LANES)
}

impl<Q: Query> RayPacket<Q> {
    /// Room for rays in a tree whose walks need so much of a stack.
    pub fn new(max_stack_size: usize) -> RayPacket<Q> {
        RayPacket {
            octets: std::array::from_fn(|_| RayOctet::none()),
            stack: PacketStack::new(max_stack_size),
            hits: PacketHits::new(),
            states: (0..RAYS).map(|_| ExactState::new()).collect(),
            open_pairs: OpenPairs::none(),
            limit: 0.0,
        }
    }

    /// The number of a ray in the batch.
    #[inline(always)]
    fn number(&self, ray: usize) -> usize {
        self.octets[ray / LANES].first + ray % LANES
    }

    /// Hands a ray over to a walk of its own, with what it may need to decide.
    #[inline(always)]
    pub fn hand_over<S: Simd>(
        &mut self,
        simd: S,
        number: usize,
        ray: &mut RayState,
        state: &mut ExactState<Q>,
    ) {
        let (octet, lane) = (number / LANES, number % LANES);
        self.octets[octet].write_rays(simd);
        let (traversal, parameter) = self.octets[octet].lane(lane);
        ray.restart(simd, self.number(number), traversal, parameter);
        ray.traversal.limit = self.hits.limits[octet][lane];
        ray.nearest = self.hits.nearest(octet, lane);
        if Q::KIND == QueryKind::All || self.hits.decided >> number & 1 == 1 {
            std::mem::swap(state, &mut self.states[number]);
            state.query_has_nearest = self.hits.query_has_nearest >> number & 1 == 1;
        }
    }

    /// Casts the rays of some octets, of which these are the bounds, and takes the answers of those that come to
    /// their end. Returns a bit for each of the others, which are to go on with what is on the stack.
    #[inline(always)]
    pub fn cast<S: Simd>(
        &mut self,
        simd: S,
        cast: &mut Cast,
        prefetcher: Prefetcher,
        bounds: PacketBounds,
        part: Range<usize>,
    ) -> Mask {
        simd.outlined(PacketJob { packet: self, cast, prefetcher, bounds, part })
    }

    /// Those of some rays that meet the box in a lane of a node, within their limits.
    #[inline(always)]
    fn meeting<S: Simd>(
        &self,
        simd: S,
        (node, lane): (&Node, usize),
        octant: u32,
        mask: Mask,
        part: &Range<usize>,
    ) -> Mask {
        let mut sides = [[simd.splat(0.0); 2]; 3];
        for axis in 0..3 {
            let side = (octant >> axis & 1) as usize;
            sides[axis] = [
                simd.splat(node.sides[axis][side][lane]),
                simd.splat(node.sides[axis][1 - side][lane]),
            ];
        }
        let mut met = 0;
        for octet in part.clone() {
            let lanes = lanes_of(mask, octet);
            if lanes == 0 {
                continue;
            }
            let fields = &self.octets[octet].fields;
            let mut near = simd.splat(0.0);
            let mut far = simd.load(&self.hits.limits[octet]);
            for axis in 0..3 {
                let [near_side, far_side] = sides[axis];
                let inverse = fields.load(simd, axis);
                let enter =
                    simd.mul_add(near_side, inverse, fields.load(simd, RayFields::NEAR + axis));
                let leave =
                    simd.mul_add(far_side, inverse, fields.load(simd, RayFields::FAR + axis));
                near = simd.max(enter, near);
                far = simd.min(leave, far);
            }
            met |= bits_of(!simd.lt(far, near) & lanes, octet);
        }
        met
    }
}

/// The walk of a packet, in a function of its own.
struct PacketJob<'a, 'b, Q> {
    packet: &'a mut RayPacket<Q>,
    cast: &'a mut Cast<'b>,
    prefetcher: Prefetcher,
    bounds: PacketBounds,
    part: Range<usize>,
}

impl<Q: Query> Job for PacketJob<'_, '_, Q> {
    type Output = Mask;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Mask {
        let PacketJob { packet, cast, prefetcher, bounds, part } = self;
        let tree = cast.target.tree;
        packet.hits.restart(simd, &packet.octets, &part);
        packet.stack.clear();
        packet.limit = packet.hits.limit(simd, &part);
        let mut alive = rays_of(&part);
        let (mut index, mut mask) = (tree.root.index(), alive);
        let (mut steps, mut taken) = (0, 0);
        let max_steps = tree.max_steps().try_into().unwrap_or(u32::MAX);
        'steps: loop {
            // At a node push the children that some ray may meet.
            cast.work.add_nodes(1);
            let node = &tree.nodes[index];
            let children = bounds.meet_children(simd, node, packet.limit);
            packet.stack.push(simd, (node, index), bounds.octant, &children, mask);
            for depth in 0..2 {
                if let Some(place) = packet.stack.below_top(depth) {
                    prefetcher.prefetch(simd, NodeRef(place));
                }
            }
            loop {
                if packet.stack.is_empty() || alive == 0 {
                    break 'steps;
                }
                // Give up what too few rays have in common.
                if steps >= FEW_STEPS && taken < FEW_RAYS * steps {
                    break 'steps;
                }

                // Pop what is nearest, and find the rays that meet it.
                let Some(Popped { place, lane, is_met_by_all, parent, mask: came }) =
                    packet.stack.pop(alive, packet.limit)
                else {
                    continue;
                };
                mask = came;
                if !is_met_by_all {
                    let parent = &tree.nodes[parent];
                    mask = packet.meeting(simd, (parent, lane), bounds.octant, mask, &part);
                }
                if mask == 0 {
                    continue;
                }
                steps += 1;
                if steps > max_steps {
                    panic_corrupt_tree();
                }
                taken += mask.count_ones();
                let place = NodeRef(place);
                if place.is_node() {
                    index = place.index();
                    continue 'steps;
                }
                alive &= !packet.visit_leaf(simd, cast, &bounds, &part, place.index(), mask);
            }
        }
        alive &= !packet.decide_open(simd, cast);
        if packet.stack.is_empty() {
            alive = 0;
        }
        packet.finish(simd, cast, rays_of(&part) & !alive);
        alive
    }
}
