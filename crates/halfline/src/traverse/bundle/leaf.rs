//! What a bundle does in a leaf: its rays against the triangles, what is decided of that, and the answers.

use std::ops::Range;

use super::super::cast::{Asked, Batch, Candidates, Cast, Found, LookAgain, Pairs, Second};
use super::super::leaf_kernel::{test_group, test_lane};
use super::super::query::{Query, Shortcut};
use super::{Bundle, GROUPS, Mask, RAYS, bits_of, lanes_of};
use crate::geometry::NO_FACE;
use crate::simd::{LANES, Simd};
use crate::tree::LeafBlock;

impl<B: Batch> Cast<'_, B> {
    /// Holds rays against the triangles of a leaf. Returns a bit for each to which nothing more can
    /// matter.
    #[inline(always)]
    pub(super) fn visit_leaf<S: Simd>(
        &self,
        simd: S,
        bundle: &mut Bundle<B::Query>,
        part: &Range<usize>,
        index: usize,
        mask: Mask,
    ) -> Mask {
        self.work.add_leaves(1);
        let block = &self.tree.leaves.blocks[index];
        let mut triangles = bundle.beam.candidates(simd, bundle.axes, &block.corners);
        triangles &= !simd.eq_u32(&block.faces, NO_FACE);
        if triangles == 0 {
            return 0;
        }
        let mut groups = 0;
        for group in part.clone() {
            groups += u32::from(lanes_of(mask, group) != 0);
        }
        // A ray by itself costs as much as a triangle against two groups, or one where any hit will do: there
        // a ray is often done with at once.
        let weight = if B::Query::SHORTCUT == Shortcut::Any { 1 } else { 2 };
        let done = if weight * mask.count_ones() < groups * triangles.count_ones() {
            self.visit_by_rays(simd, bundle, block, index, mask)
        } else {
            self.visit_by_triangles(simd, bundle, part, (block, index), triangles, mask)
        };
        if B::Query::SHORTCUT == Shortcut::Nearest {
            bundle.set_limit(simd, part);
        }
        done
    }

    /// Each ray against all triangles.
    #[inline(always)]
    fn visit_by_rays<S: Simd>(
        &self,
        simd: S,
        bundle: &mut Bundle<B::Query>,
        block: &LeafBlock,
        index: usize,
        mask: Mask,
    ) -> Mask {
        let (mut rest, mut done, mut candidates) = (mask, 0, Candidates::default());
        while rest != 0 {
            let ray = rest.trailing_zeros() as usize % RAYS;
            rest &= rest - 1;
            let (group, lane) = (ray / LANES, ray % LANES);
            let limit = bundle.limits[group][lane];
            let columns = (&bundle.groups[group].columns, lane);
            let verdict = test_lane(simd, columns, limit, bundle.axes, &block.corners);
            candidates.set(simd, verdict);
            if candidates.open != 0 {
                let is_done = self.decide_in_bundle(simd, bundle, ray, &candidates, index);
                done |= Mask::from(is_done) << ray;
            }
        }
        done
    }

    /// Each of some triangles against eight rays at a time.
    #[inline(always)]
    fn visit_by_triangles<S: Simd>(
        &self,
        simd: S,
        bundle: &mut Bundle<B::Query>,
        part: &Range<usize>,
        (block, index): (&LeafBlock, usize),
        triangles: u32,
        mask: Mask,
    ) -> Mask {
        let mut done = 0;
        for group in part.clone() {
            let mut lanes = lanes_of(mask, group);
            let mut rest = triangles;
            while rest != 0 && lanes != 0 {
                let triangle = rest.trailing_zeros() as usize % LANES;
                rest &= rest - 1;
                let verdict = test_group(
                    simd,
                    (&bundle.groups[group].columns, lanes),
                    &bundle.limits[group],
                    bundle.axes,
                    (&block.corners, triangle),
                );
                let Some(verdict) = verdict else { continue };
                let mut open = verdict.candidates & lanes;
                if open == 0 {
                    continue;
                }
                match B::Query::SHORTCUT {
                    Shortcut::Nearest => {
                        // Take it where it is the nearest for certain, and pass by where it is not.
                        let face = block.faces[triangle];
                        open &= !simd.eq_u32(&bundle.faces[group], face);
                        let lows = simd.load(&bundle.lows[group]);
                        let nearer = verdict.certain & open & simd.lt(verdict.high, lows);
                        let limits = simd.load(&bundle.limits[group]);
                        simd.store(simd.select(nearer, verdict.low, lows), &mut bundle.lows[group]);
                        simd.store(
                            simd.select(nearer, verdict.high, limits),
                            &mut bundle.limits[group],
                        );
                        simd.masked_fill_u32(nearer, face, &mut bundle.faces[group]);
                        simd.masked_fill_u32(nearer, index as u32, &mut bundle.blocks[group]);
                        simd.masked_fill_u32(nearer, triangle as u32, &mut bundle.triangles[group]);
                        bundle.told &= !bits_of(nearer, group);
                        open &= !nearer;
                    }
                    Shortcut::Any | Shortcut::Each => {
                        let certain = verdict.certain & open;
                        done |= bits_of(certain, group);
                        lanes &= !certain;
                        open &= !certain;
                        simd.store(
                            simd.select(
                                certain,
                                simd.splat(-1.0),
                                simd.load(&bundle.limits[group]),
                            ),
                            &mut bundle.limits[group],
                        );
                        // Those that were found so need no decision.
                        simd.masked_fill_u32(certain, 0, &mut bundle.faces[group]);
                    }
                }
                if open != 0 {
                    let more = self.look_at_group(simd, bundle, group, (index, triangle), open);
                    done |= bits_of(more, group);
                    lanes &= !more;
                }
            }
        }
        done
    }

    /// Decides a triangle of a leaf, of which single precision is not certain, for rays of a group. Returns
    /// a bit for each to which nothing more can matter.
    #[inline(always)]
    fn look_at_group<S: Simd>(
        &self,
        simd: S,
        bundle: &mut Bundle<B::Query>,
        group: usize,
        (index, triangle): (usize, usize),
        open: u32,
    ) -> u32 {
        let face = self.tree.leaves.blocks[index].faces[triangle];
        let pairs = Pairs {
            numbers: numbers_from(bundle.first + group * LANES),
            faces: [face; LANES],
            blocks: [index as u32; LANES],
            triangles: [triangle as u32; LANES],
            lanes: open,
        };
        let look = simd.outlined(LookAgain { cast: self, pairs: &pairs });
        let (mut rest, mut done) = (open, 0);
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % LANES;
            rest &= rest - 1;
            let ray = group * LANES + lane;
            let (mut found, mut limit) = (bundle.found(group, lane), bundle.limits[group][lane]);
            let mut asked = bundle.asked(ray, &mut found, &mut limit);
            let decision = &mut bundle.decisions[ray];
            decision.is_told = bundle.told >> ray & 1 == 1;
            let place = (index, triangle);
            let second = self.decide_again(&mut asked, decision, (&look, lane), place);
            if second != Second::Certain {
                self.decide_rest(simd, asked, decision, second, place);
            }
            let is_done = decision.is_done();
            bundle.take(ray, found, limit, is_done);
            done |= u32::from(is_done) << lane;
        }
        done
    }

    /// Decides candidates of a leaf for a ray.
    #[inline(always)]
    fn decide_in_bundle<S: Simd>(
        &self,
        simd: S,
        bundle: &mut Bundle<B::Query>,
        ray: usize,
        candidates: &Candidates,
        index: usize,
    ) -> bool {
        let (group, lane) = (ray / LANES, ray % LANES);
        let (mut found, mut limit) = (bundle.found(group, lane), bundle.limits[group][lane]);
        let mut asked = bundle.asked(ray, &mut found, &mut limit);
        let decision = &mut bundle.decisions[ray];
        decision.is_told = bundle.told >> ray & 1 == 1;
        let open = self.decide(&mut asked, decision, candidates, index);
        if open != 0 {
            self.decide_open(simd, asked, decision, index, open);
        }
        let is_done = decision.is_done();
        bundle.take(ray, found, limit, is_done);
        is_done
    }

    /// Takes the answers of rays that are at their end.
    #[inline(always)]
    pub(super) fn finish_bundle<S: Simd>(
        &mut self,
        simd: S,
        bundle: &mut Bundle<B::Query>,
        mask: Mask,
    ) {
        let mut rest = mask;
        if B::Query::SHORTCUT == Shortcut::Nearest {
            for group in 0..GROUPS {
                let lanes = lanes_of(mask & !bundle.told, group);
                let lanes = lanes & !simd.eq_u32(&bundle.faces[group], NO_FACE);
                if lanes == 0 {
                    continue;
                }
                let pairs = Pairs {
                    numbers: numbers_from(bundle.first + group * LANES),
                    faces: bundle.faces[group],
                    blocks: bundle.blocks[group],
                    triangles: bundle.triangles[group],
                    lanes,
                };
                self.finish_pairs(simd, &pairs);
            }
            rest &= bundle.decided;
            while rest != 0 {
                let ray = rest.trailing_zeros() as usize % RAYS;
                rest &= rest - 1;
                if bundle.told >> ray & 1 == 1 {
                    self.finish_decided(bundle.first + ray, &mut bundle.decisions[ray]);
                } else {
                    bundle.decisions[ray].restart();
                }
            }
            return;
        }
        while rest != 0 {
            let ray = rest.trailing_zeros() as usize % RAYS;
            rest &= rest - 1;
            let is_decided = bundle.decided >> ray & 1 == 1;
            if bundle.faces[ray / LANES][ray % LANES] != NO_FACE {
                self.batch.finish_found(bundle.first + ray);
                if is_decided {
                    bundle.decisions[ray].restart();
                }
            } else if is_decided {
                self.finish_decided(bundle.first + ray, &mut bundle.decisions[ray]);
            }
        }
    }
}

impl<Q: Query> Bundle<Q> {
    /// A ray, to decide about it.
    #[inline(always)]
    fn asked<'a>(&self, ray: usize, found: &'a mut Found, limit: &'a mut f32) -> Asked<'a> {
        let parameter = self.groups[ray / LANES].parameter(ray % LANES);
        Asked { number: self.first + ray, parameter, found, limit }
    }

    /// Takes what was decided for a ray.
    #[inline(always)]
    fn take(&mut self, ray: usize, found: Found, limit: f32, is_done: bool) {
        let (group, lane) = (ray / LANES, ray % LANES);
        self.limits[group][lane] = if is_done { -1.0 } else { limit };
        self.lows[group][lane] = found.low;
        self.faces[group][lane] = found.face;
        (self.blocks[group][lane], self.triangles[group][lane]) = found.place;
        let decision = &self.decisions[ray];
        self.decided |= Mask::from(decision.is_prepared()) << ray;
        self.told = self.told & !(1 << ray) | Mask::from(decision.is_told) << ray;
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
