//! Whether and where a ray hits the triangles that single precision leaves open, by steps that take more and
//! more: double precision for eight at once, t correctly rounded, exact arithmetic.

use super::super::query::{Query, Shortcut};
use super::super::second_look::SecondLook;
use super::super::wide_ray::Parameter;
use super::{Batch, Candidates, Cast, Decision, Found, LookAgain, Pairs, Parameters};
use crate::geometry::NO_FACE;
use crate::simd::{LANES, Simd};

/// What double precision says about a triangle and a ray.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Second {
    /// All that is to be known.
    Certain,
    /// It is hit, but whether before the nearest so far is open.
    Tied,
    /// Nothing for certain.
    Open,
}

/// A ray about which candidates are decided.
pub struct Asked<'a> {
    /// Its number in the batch.
    pub number: usize,
    /// From t to the parameter of boxes and leaves.
    pub parameter: Parameter,
    /// What it found.
    pub found: &'a mut Found,
    /// Where it stops to matter.
    pub limit: &'a mut f32,
}

impl Asked<'_> {
    /// The same ray once more.
    #[inline(always)]
    fn again(&mut self) -> Asked<'_> {
        let Asked { number, parameter, found, limit } = self;
        Asked { number: *number, parameter: *parameter, found, limit }
    }
}

impl<B: Batch> Cast<'_, B> {
    /// Takes what single precision is certain of about the candidates of the leaf whose block has this
    /// index. Returns a bit for each of the others.
    #[inline(always)]
    pub fn decide(
        &self,
        ray: &mut Asked,
        decision: &mut Decision<B::Query>,
        candidates: &Candidates,
        index: usize,
    ) -> u32 {
        let block = &self.tree.leaves.blocks[index];
        let Candidates { low, high, open, certain, placed } = candidates;
        match B::Query::SHORTCUT {
            Shortcut::Each => {
                let mut rest = *certain;
                while rest != 0 {
                    let lane = rest.trailing_zeros() as usize % LANES;
                    rest &= rest - 1;
                    let place = (index as u32, lane as u32);
                    decision.settle_each(block.faces[lane], place);
                }
                *open & !*certain
            }
            Shortcut::Any => {
                if *certain == 0 {
                    return *open;
                }
                decision.settle_any();
                0
            }
            Shortcut::Nearest => {
                let (mut rest, mut open) = (*open, 0);
                while rest != 0 {
                    let lane = rest.trailing_zeros() as usize % LANES;
                    rest &= rest - 1;
                    let (face, low, high) = (block.faces[lane], low[lane], high[lane]);
                    let is_beyond = placed >> lane & 1 == 1 && low > *ray.limit;
                    if face == ray.found.face || face == NO_FACE || is_beyond {
                        continue;
                    }
                    if certain >> lane & 1 == 1 && high < ray.found.low {
                        *ray.found = Found { face, low, place: (index as u32, lane as u32) };
                        *ray.limit = high;
                        decision.is_told = false;
                    } else {
                        open |= 1 << lane;
                    }
                }
                open
            }
        }
    }

    /// Takes what double precision is certain of about the triangle in a lane of the leaf whose block has
    /// this index.
    #[inline(always)]
    pub fn decide_again(
        &self,
        ray: &mut Asked,
        decision: &mut Decision<B::Query>,
        (look, pair): (&SecondLook, usize),
        (index, lane): (usize, usize),
    ) -> Second {
        if look.missed >> pair & 1 == 1 {
            return Second::Certain;
        }
        if look.hit >> pair & 1 == 0 {
            return Second::Open;
        }
        if B::Query::SHORTCUT == Shortcut::Any {
            decision.settle_any();
            return Second::Certain;
        }
        let face = self.tree.leaves.blocks[index].faces[lane];
        let low = ray.parameter.lower(look.low[pair]);
        let high = ray.parameter.limit(look.high[pair]);
        if face == ray.found.face || low > *ray.limit {
            return Second::Certain;
        }
        if high < ray.found.low {
            *ray.found = Found { face, low, place: (index as u32, lane as u32) };
            *ray.limit = high;
            decision.is_told = false;
            return Second::Certain;
        }
        Second::Tied
    }

    /// Finds out which of two triangles a ray hits first, the nearest so far or one that it hits as well.
    /// Returns false if that is still open.
    #[inline(always)]
    fn break_tie<S: Simd>(
        &self,
        simd: S,
        ray: &mut Asked,
        decision: &mut Decision<B::Query>,
        (index, lane): (usize, usize),
    ) -> bool {
        let face = self.tree.leaves.blocks[index].faces[lane];
        let mut pairs = Pairs::none();
        pairs.push(ray.number, ray.found.face, ray.found.place);
        pairs.push(ray.number, face, (index as u32, lane as u32));
        let (t, known) = simd.outlined(Parameters { cast: self, pairs: &pairs });
        if known & 3 != 3 {
            return false;
        }
        // Both are what exact arithmetic gives, rounded; of equal ones the lower face comes first.
        if t[1] < t[0] || (t[1] == t[0] && face < ray.found.face) {
            let (low, high) = (ray.parameter.lower(t[1]), ray.parameter.limit(t[1]));
            *ray.found = Found { face, low, place: (index as u32, lane as u32) };
            *ray.limit = high;
            decision.is_told = false;
        }
        true
    }

    /// Decides a triangle about which double precision said so much.
    #[inline(always)]
    pub fn decide_rest<S: Simd>(
        &self,
        simd: S,
        mut ray: Asked,
        decision: &mut Decision<B::Query>,
        second: Second,
        (index, lane): (usize, usize),
    ) {
        let is_told = decision.is_told && ray.found.face != NO_FACE;
        let is_decided = match second {
            Second::Certain => true,
            Second::Tied if !is_told => self.break_tie(simd, &mut ray, decision, (index, lane)),
            Second::Tied | Second::Open => false,
        };
        if !is_decided && !decision.is_done() {
            self.decide_exactly(ray, decision, index, 1 << lane);
        }
    }

    /// Decides triangles of a leaf of which single precision is not certain, for one ray. Returns true if
    /// nothing more can matter to it.
    #[inline(always)]
    pub fn decide_open<S: Simd>(
        &self,
        simd: S,
        mut ray: Asked,
        decision: &mut Decision<B::Query>,
        index: usize,
        open: u32,
    ) -> bool {
        if B::Query::SHORTCUT == Shortcut::Each {
            self.decide_exactly(ray, decision, index, open);
            return decision.is_done();
        }
        let faces = &self.tree.leaves.blocks[index].faces;
        let (mut pairs, mut rest) = (Pairs::none(), open);
        while rest != 0 {
            let lane = rest.trailing_zeros();
            rest &= rest - 1;
            let face = faces[lane as usize % LANES];
            if face != NO_FACE {
                pairs.push(ray.number, face, (index as u32, lane));
            }
        }
        let look = simd.outlined(LookAgain { cast: self, pairs: &pairs });
        for pair in 0..pairs.lanes.count_ones() as usize {
            let lane = pairs.triangles[pair % LANES] as usize % LANES;
            let second = self.decide_again(&mut ray, decision, (&look, pair), (index, lane));
            if second != Second::Certain {
                self.decide_rest(simd, ray.again(), decision, second, (index, lane));
            }
        }
        decision.is_done()
    }

    /// Decides triangles of a leaf, whatever it takes.
    #[inline(never)]
    pub fn decide_exactly(
        &self,
        ray: Asked,
        decision: &mut Decision<B::Query>,
        index: usize,
        mut open: u32,
    ) {
        let tree = self.tree;
        let Asked { number, parameter, found, limit } = ray;
        self.work.exact.set(self.work.exact.get() + 1);
        self.prepare(number, decision);
        let Decision { prepared, query, is_told, .. } = decision;
        if found.face != NO_FACE && !*is_told {
            query.restart();
            prepared.meet_line_then(self.corners_at(found.place), found.face, query);
        }
        *is_told = true;
        let block = &tree.leaves.blocks[index];
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
                (found.face, found.low) = (face, parameter.lower(bounds.low));
                *limit = parameter.limit(bounds.high);
            }
        }
    }

    pub(super) fn prepare(&self, number: usize, decision: &mut Decision<B::Query>) {
        if !decision.is_prepared {
            decision.prepared.set(&self.batch.ray(number));
            decision.is_prepared = true;
        }
    }
}
