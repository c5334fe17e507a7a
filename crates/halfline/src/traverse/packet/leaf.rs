//! What a packet does in a leaf: its rays against the triangles, what is decided of that, and the answers.

use std::ops::Range;

use super::super::cast::Cast;
use super::super::leaf::{Candidates, NearestSoFar, Pairs, RayCursor};
use super::super::query::{Query, QueryKind};
use super::hits::PacketHits;
use super::{Mask, OCTETS, PacketBounds, RAYS, RayPacket, bits_of, lanes_of};
use crate::geometry::NO_FACE;
use crate::intersect::filter_f32::{test_leaf_by_lane, test_octet};
use crate::rays::RayOctet;
use crate::simd::{Job, LANES, Simd};
use crate::tree::LeafBlock;

/// Pairs of rays and triangles for which no others of later leaves are waited for.
const ENOUGH_PAIRS: usize = 4;

impl<Q: Query> RayPacket<Q> {
    /// Holds rays against the triangles of a leaf. Returns a bit for each to which nothing more can
    /// matter.
    #[inline(always)]
    pub(super) fn visit_leaf<S: Simd>(
        &mut self,
        simd: S,
        cast: &Cast,
        bounds: &PacketBounds,
        part: &Range<usize>,
        index: usize,
        mask: Mask,
    ) -> Mask {
        cast.work.add_leaves(1);
        let block = &cast.target.tree.leaves.blocks[index];
        let mut triangles = bounds.frustum.candidates(simd, bounds.axes, &block.corners);
        triangles &= !simd.eq_u32(&block.faces, NO_FACE);
        if triangles == 0 {
            return 0;
        }
        let mut octets = 0;
        for octet in part.clone() {
            octets += u32::from(lanes_of(mask, octet) != 0);
        }
        // A ray by itself costs as much as a triangle against two octets, or one where any hit will do: there
        // a ray is often done with at once.
        let weight = if Q::KIND == QueryKind::Any { 1 } else { 2 };
        let mut done = if weight * mask.count_ones() < octets * triangles.count_ones() {
            self.visit_by_rays(simd, cast, bounds.axes, (block, index), mask)
        } else {
            let rays = (part, mask);
            self.visit_by_triangles(simd, cast, bounds.axes, rays, (block, index), triangles)
        };
        if self.open_pairs.len() >= ENOUGH_PAIRS {
            done |= self.decide_open(simd, cast);
        }
        if Q::KIND == QueryKind::Closest {
            self.limit = self.hits.limit(simd, part);
        }
        done
    }

    /// Each ray against all triangles.
    #[inline(always)]
    fn visit_by_rays<S: Simd>(
        &mut self,
        simd: S,
        cast: &Cast,
        axes: [usize; 3],
        (block, index): (&LeafBlock, usize),
        mask: Mask,
    ) -> Mask {
        let (mut rest, mut done, mut candidates) = (mask, 0, Candidates::default());
        let triangles = !simd.eq_u32(&block.faces, NO_FACE);
        while rest != 0 {
            let ray = rest.trailing_zeros() as usize % RAYS;
            rest &= rest - 1;
            let (octet, lane) = (ray / LANES, ray % LANES);
            let limit = self.hits.limits[octet][lane];
            let fields = (&self.octets[octet].fields, lane);
            let verdict = if Q::EXACT {
                test_leaf_by_lane::<S, true>(simd, fields, limit, axes, &block.corners)
            } else {
                test_leaf_by_lane::<S, false>(simd, fields, limit, axes, &block.corners)
            };
            candidates.set(simd, verdict, triangles);
            if candidates.open != 0 {
                done |= self.decide_for_ray(simd, cast, ray, &candidates, index);
            }
        }
        done
    }

    /// Each of some triangles against eight rays at a time.
    #[inline(always)]
    fn visit_by_triangles<S: Simd>(
        &mut self,
        simd: S,
        cast: &Cast,
        axes: [usize; 3],
        (part, mask): (&Range<usize>, Mask),
        (block, index): (&LeafBlock, usize),
        triangles: u32,
    ) -> Mask {
        let mut done = 0;
        for octet in part.clone() {
            let mut lanes = lanes_of(mask, octet);
            let mut rest = triangles;
            while rest != 0 && lanes != 0 {
                let triangle = rest.trailing_zeros() as usize % LANES;
                rest &= rest - 1;
                let fields = (&self.octets[octet].fields, lanes);
                let limits = &self.hits.limits[octet];
                let corners = (&block.corners, triangle);
                let verdict = if Q::EXACT {
                    test_octet::<S, true>(simd, fields, limits, axes, corners)
                } else {
                    test_octet::<S, false>(simd, fields, limits, axes, corners)
                };
                let Some(verdict) = verdict else { continue };
                let mut open = verdict.candidates & lanes;
                if open == 0 {
                    continue;
                }
                match Q::KIND {
                    QueryKind::Closest => {
                        // Take it where it is the nearest for certain, and pass by where it is not.
                        let face = block.faces[triangle];
                        open &= !simd.eq_u32(&self.hits.faces[octet], face);
                        let lows = simd.load(&self.hits.lows[octet]);
                        let nearer = verdict.certain & open & simd.lt(verdict.high, lows);
                        let limits = simd.load(&self.hits.limits[octet]);
                        simd.store(
                            simd.select(nearer, verdict.low, lows),
                            &mut self.hits.lows[octet],
                        );
                        simd.store(
                            simd.select(nearer, verdict.high, limits),
                            &mut self.hits.limits[octet],
                        );
                        simd.masked_fill_u32(nearer, face, &mut self.hits.faces[octet]);
                        simd.masked_fill_u32(nearer, index as u32, &mut self.hits.blocks[octet]);
                        simd.masked_fill_u32(
                            nearer,
                            triangle as u32,
                            &mut self.hits.triangles[octet],
                        );
                        self.hits.query_has_nearest &= !bits_of(nearer, octet);
                        open &= !nearer;
                        open &= !self.take_in_plane(
                            cast,
                            octet,
                            (index, triangle),
                            face,
                            open & verdict.certain,
                        );
                    }
                    QueryKind::All => {
                        let mut certain = verdict.certain & open;
                        open &= !certain;
                        while certain != 0 {
                            let ray = octet * LANES + certain.trailing_zeros() as usize % LANES;
                            certain &= certain - 1;
                            let slot = (index as u32, triangle as u32);
                            self.states[ray].accept(block.faces[triangle], slot);
                        }
                    }
                    QueryKind::Any => {
                        let certain = verdict.certain & open;
                        done |= bits_of(certain, octet);
                        lanes &= !certain;
                        open &= !certain;
                        simd.store(
                            simd.select(
                                certain,
                                simd.splat(-1.0),
                                simd.load(&self.hits.limits[octet]),
                            ),
                            &mut self.hits.limits[octet],
                        );
                        // Those that were found so need no decision.
                        simd.masked_fill_u32(certain, 0, &mut self.hits.faces[octet]);
                    }
                }
                if open != 0 {
                    if self.open_pairs.is_full() {
                        let more = self.decide_open(simd, cast);
                        done |= more;
                        lanes &= !lanes_of(more, octet);
                    }
                    while open != 0 {
                        let ray = octet * LANES + open.trailing_zeros() as usize % LANES;
                        open &= open - 1;
                        self.open_pairs.push_if(true, ray, index as u32, triangle as u32);
                    }
                }
            }
        }
        done
    }

    /// Takes a triangle for those of some rays of an octet, all of which hit it, whose nearest so far lies in the
    /// same plane. Returns a bit for each of these.
    #[inline(always)]
    fn take_in_plane(
        &mut self,
        cast: &Cast,
        octet: usize,
        (index, triangle): (usize, usize),
        face: u32,
        mut open: u32,
    ) -> u32 {
        let (mut taken, hits) = (0, &mut self.hits);
        // Where the nearest was decided exactly, it is not known in which leaf it lies.
        open &= !lanes_of(hits.query_has_nearest, octet);
        while open != 0 {
            let lane = open.trailing_zeros() as usize % LANES;
            open &= open - 1;
            let nearest = hits.nearest(octet, lane);
            let slot = (index as u32, triangle as u32);
            if nearest.face != NO_FACE && cast.are_in_one_plane(nearest.slot, slot) {
                taken |= 1 << lane;
                if face < nearest.face {
                    hits.faces[octet][lane] = face;
                    (hits.blocks[octet][lane], hits.triangles[octet][lane]) = slot;
                }
            }
        }
        taken
    }

    /// Decides the pairs that wait. Returns a bit for each ray to which nothing more can matter.
    #[inline(always)]
    pub(super) fn decide_open<S: Simd>(&mut self, simd: S, cast: &Cast) -> Mask {
        if self.open_pairs.len() == 0 {
            return 0;
        }
        simd.outlined(DecideOpen { packet: self, cast })
    }

    /// Decides candidates of a leaf for a ray.
    #[inline(always)]
    fn decide_for_ray<S: Simd>(
        &mut self,
        simd: S,
        cast: &Cast,
        ray: usize,
        candidates: &Candidates,
        index: usize,
    ) -> Mask {
        let (octet, lane) = (ray / LANES, ray % LANES);
        let (mut nearest, mut limit) =
            (self.hits.nearest(octet, lane), self.hits.limits[octet][lane]);
        let mut cursor = self.cursor(ray, &mut nearest, &mut limit);
        let state = &mut self.states[ray];
        state.query_has_nearest = self.hits.query_has_nearest >> ray & 1 == 1;
        let open = cast.decide(&mut cursor, state, candidates, index);
        let is_done = state.is_done();
        self.take(ray, nearest, limit, is_done);
        let mut done = Mask::from(is_done) << ray;
        if open != 0 {
            if self.open_pairs.is_full() {
                done |= self.decide_open(simd, cast);
            }
            self.open_pairs.push_all(ray, index as u32, open);
        }
        done
    }

    /// Takes the answers of rays that are at their end.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(&mut self, simd: S, cast: &mut Cast, mask: Mask) {
        let mut rest = mask;
        if Q::KIND == QueryKind::All {
            let mut ended = Pairs::none();
            while rest != 0 {
                let ray = rest.trailing_zeros() as usize % RAYS;
                rest &= rest - 1;
                let number = self.number(ray);
                cast.finish_all(simd, number, &mut self.states[ray], &mut ended);
            }
            cast.finish_pairs(simd, &ended);
            return;
        }
        if Q::KIND == QueryKind::Closest {
            if Q::EXACT {
                simd.outlined(FinishPacket { hits: &self.hits, octets: &self.octets, cast, mask });
            } else {
                self.finish_plain(cast, mask);
            }
            rest &= self.hits.decided;
            while rest != 0 {
                let ray = rest.trailing_zeros() as usize % RAYS;
                rest &= rest - 1;
                if self.hits.query_has_nearest >> ray & 1 == 1 {
                    cast.finish_decided(self.number(ray), &mut self.states[ray]);
                } else {
                    self.states[ray].restart();
                }
            }
            return;
        }
        while rest != 0 {
            let ray = rest.trailing_zeros() as usize % RAYS;
            rest &= rest - 1;
            let is_decided = self.hits.decided >> ray & 1 == 1;
            if self.hits.faces[ray / LANES][ray % LANES] != NO_FACE {
                cast.answers.put_occluded(self.number(ray));
                if is_decided {
                    self.states[ray].restart();
                }
            } else if is_decided {
                cast.finish_decided(self.number(ray), &mut self.states[ray]);
            }
        }
    }

    /// Takes the hits of some rays whose t was taken as it came.
    fn finish_plain(&self, cast: &mut Cast, mut mask: Mask) {
        while mask != 0 {
            let ray = mask.trailing_zeros() as usize % RAYS;
            mask &= mask - 1;
            let (octet, lane) = (ray / LANES, ray % LANES);
            let face = self.hits.faces[octet][lane];
            if face != NO_FACE {
                let t = self.octets[octet].parameter(lane).t(self.hits.lows[octet][lane]);
                cast.put_plain(self.number(ray), face, t);
            }
        }
    }

    /// A ray, to decide about it.
    #[inline(always)]
    fn cursor<'a>(
        &self,
        ray: usize,
        nearest: &'a mut NearestSoFar,
        limit: &'a mut f32,
    ) -> RayCursor<'a> {
        let parameter = self.octets[ray / LANES].parameter(ray % LANES);
        RayCursor { number: self.number(ray), parameter, nearest, limit }
    }

    /// Takes what was decided for a ray.
    #[inline(always)]
    fn take(&mut self, ray: usize, nearest: NearestSoFar, limit: f32, is_done: bool) {
        let (octet, lane) = (ray / LANES, ray % LANES);
        let hits = &mut self.hits;
        hits.limits[octet][lane] = if is_done { -1.0 } else { limit };
        hits.lows[octet][lane] = nearest.low;
        hits.faces[octet][lane] = nearest.face;
        (hits.blocks[octet][lane], hits.triangles[octet][lane]) = nearest.slot;
        let state = &self.states[ray];
        hits.decided |= Mask::from(state.is_prepared()) << ray;
        hits.query_has_nearest =
            hits.query_has_nearest & !(1 << ray) | Mask::from(state.query_has_nearest) << ray;
    }
}

/// Decides the pairs that wait, in a function of its own.
struct DecideOpen<'a, 'b, Q> {
    packet: &'a mut RayPacket<Q>,
    cast: &'a Cast<'b>,
}

impl<Q: Query> Job for DecideOpen<'_, '_, Q> {
    type Output = Mask;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Mask {
        let DecideOpen { packet, cast } = self;
        let mut done = 0;
        while packet.open_pairs.len() != 0 {
            let blocks = &cast.target.tree.leaves.blocks;
            let pairs = packet.open_pairs.first(blocks, |ray| packet.number(ray % RAYS));
            let look = cast.refine(simd, &pairs);
            for pair in 0..pairs.lanes.count_ones() as usize % (LANES + 1) {
                let ray = packet.open_pairs.owner(pair) % RAYS;
                let (octet, lane) = (ray / LANES, ray % LANES);
                let (mut nearest, mut limit) =
                    (packet.hits.nearest(octet, lane), packet.hits.limits[octet][lane]);
                if limit < 0.0 {
                    continue;
                }
                let cursor = packet.cursor(ray, &mut nearest, &mut limit);
                let state = &mut packet.states[ray];
                state.query_has_nearest = packet.hits.query_has_nearest >> ray & 1 == 1;
                let place = (pairs.blocks[pair] as usize, pairs.triangles[pair] as usize % LANES);
                cast.take_look(simd, cursor, state, (&look, pair), place);
                let is_done = state.is_done();
                packet.take(ray, nearest, limit, is_done);
                done |= Mask::from(is_done) << ray;
            }
            packet.open_pairs.drop_first();
        }
        done
    }
}

/// Finds where the nearest hits of some rays of a packet are, where their queries do not know, in a function of its
/// own: all kinds of answers call the same.
struct FinishPacket<'a, 'b> {
    hits: &'a PacketHits,
    octets: &'a [RayOctet; OCTETS],
    cast: &'a mut Cast<'b>,
    mask: Mask,
}

impl Job for FinishPacket<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let FinishPacket { hits, octets, cast, mask } = self;
        for octet in 0..OCTETS {
            let lanes = lanes_of(mask & !hits.query_has_nearest, octet);
            let lanes = lanes & !simd.eq_u32(&hits.faces[octet], NO_FACE);
            if lanes != 0 {
                let pairs = Pairs {
                    numbers: numbers_from(octets[octet].first),
                    faces: hits.faces[octet],
                    blocks: hits.blocks[octet],
                    triangles: hits.triangles[octet],
                    lanes,
                };
                cast.find_and_put(simd, &pairs);
            }
        }
    }
}

/// Eight numbers in a row.
#[inline(always)]
fn numbers_from(first: usize) -> [usize; LANES] {
    let mut numbers = [first; LANES];
    for lane in 0..LANES {
        numbers[lane] += lane;
    }
    numbers
}
