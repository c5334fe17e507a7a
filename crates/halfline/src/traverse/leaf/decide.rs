//! Whether a ray hits the triangles that single precision leaves open, by steps that take more and more: double
//! precision for eight at once, t correctly rounded, exact arithmetic.

use super::super::cast::Cast;
use super::super::query::{Query, QueryKind, Slot};
use super::{Candidates, ExactState, NearestSoFar, Pairs, ParameterJob};
use crate::geometry::NO_FACE;
use crate::intersect::filter_f64::Refined;
use crate::rays::Parameter;
use crate::simd::{LANES, Simd};

/// What double precision says about a triangle and a ray.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Refinement {
    /// All that is to be known.
    Certain,
    /// It is hit, but whether before the nearest so far is open.
    Tied,
    /// Nothing for certain.
    Open,
}

/// A ray about which candidates are decided.
pub struct RayCursor<'a> {
    /// Its number in the batch.
    pub number: usize,
    /// From t to the parameter of boxes and leaves.
    pub parameter: Parameter,
    /// The nearest hit so far.
    pub nearest: &'a mut NearestSoFar,
    /// Where it stops to matter.
    pub limit: &'a mut f32,
}

impl Cast<'_> {
    /// Takes what single precision is certain of about the candidates of the leaf whose block has this
    /// index. Returns a bit for each of the others.
    #[inline(always)]
    pub fn decide<Q: Query>(
        &self,
        ray: &mut RayCursor,
        state: &mut ExactState<Q>,
        candidates: &Candidates,
        index: usize,
    ) -> u32 {
        let block = &self.target.tree.leaves.blocks[index];
        let Candidates { low, high, open, certain, has_interval } = candidates;
        match Q::KIND {
            QueryKind::All => {
                let mut rest = *certain;
                while rest != 0 {
                    let lane = rest.trailing_zeros() as usize % LANES;
                    rest &= rest - 1;
                    state.accept(block.faces[lane], (index as u32, lane as u32));
                }
                *open & !*certain
            }
            QueryKind::Any => {
                if *certain == 0 {
                    return *open;
                }
                state.accept(NO_FACE, (index as u32, 0));
                0
            }
            QueryKind::Closest => {
                let (mut rest, mut open) = (*open, 0);
                while rest != 0 {
                    let lane = rest.trailing_zeros() as usize % LANES;
                    rest &= rest - 1;
                    let (face, low, high) = (block.faces[lane], low[lane], high[lane]);
                    let is_beyond = has_interval >> lane & 1 == 1 && low > *ray.limit;
                    if face == ray.nearest.face || is_beyond {
                        continue;
                    }
                    let is_certain = certain >> lane & 1 == 1;
                    let slot = (index as u32, lane as u32);
                    if is_certain && high < ray.nearest.low {
                        *ray.nearest = NearestSoFar { face, low, slot };
                        *ray.limit = high;
                        state.query_has_nearest = false;
                    } else if is_certain
                        && ray.nearest.face != NO_FACE
                        && !state.query_has_nearest
                        && self.are_in_one_plane(ray.nearest.slot, slot)
                    {
                        self.take_lower(ray, state, face, slot);
                    } else {
                        open |= 1 << lane;
                    }
                }
                open
            }
        }
    }

    /// True if two triangles lie in one plane across an axis, as the boards of a floor do: rays that cross both
    /// cross them at the same t exactly. Other planes are not looked into.
    #[inline(always)]
    pub fn are_in_one_plane(&self, (block, lane): Slot, (other, other_lane): Slot) -> bool {
        let leaves = &self.target.tree.leaves;
        let a = &leaves.blocks[block as usize].corners;
        let b = &leaves.blocks[other as usize].corners;
        let (i, j) = (lane as usize % LANES, other_lane as usize % LANES);
        let mut is_one = false;
        for axis in 0..3 {
            let height = a[0][axis][i];
            is_one |= (a[1][axis][i] == height)
                & (a[2][axis][i] == height)
                & (b[0][axis][j] == height)
                & (b[1][axis][j] == height)
                & (b[2][axis][j] == height);
        }
        // Rounded coordinates may be equal where the user's are not.
        is_one & leaves.are_exact
    }

    /// Takes a triangle in the plane of the nearest so far: of equal t the lower face counts.
    #[inline(always)]
    fn take_lower<Q: Query>(
        &self,
        ray: &mut RayCursor,
        state: &mut ExactState<Q>,
        face: u32,
        slot: Slot,
    ) {
        if face < ray.nearest.face {
            // Where it is lies between the same bounds.
            (ray.nearest.face, ray.nearest.slot) = (face, slot);
            state.query_has_nearest = false;
        }
    }

    /// Decides a pair of a ray and the triangle in a lane of the leaf whose block has this index, at which double
    /// precision had a look.
    #[inline(always)]
    pub fn take_look<S: Simd, Q: Query>(
        &self,
        simd: S,
        mut ray: RayCursor,
        state: &mut ExactState<Q>,
        look: (&Refined, usize),
        place: (usize, usize),
    ) {
        let refinement = self.take_refined(&mut ray, state, look, place);
        if refinement != Refinement::Certain {
            self.decide_rest(simd, ray, state, refinement, place);
        }
    }

    /// Takes what double precision is certain of about the triangle in a lane of the leaf whose block has
    /// this index.
    #[inline(always)]
    fn take_refined<Q: Query>(
        &self,
        ray: &mut RayCursor,
        state: &mut ExactState<Q>,
        (look, pair): (&Refined, usize),
        (index, lane): (usize, usize),
    ) -> Refinement {
        if look.missed >> pair & 1 == 1 {
            return Refinement::Certain;
        }
        if look.hit >> pair & 1 == 0 {
            return Refinement::Open;
        }
        let face = self.target.tree.leaves.blocks[index].faces[lane];
        if Q::KIND != QueryKind::Closest {
            state.accept(face, (index as u32, lane as u32));
            return Refinement::Certain;
        }
        let low = ray.parameter.lower(look.low[pair]);
        let high = ray.parameter.limit(look.high[pair]);
        if face == ray.nearest.face || low > *ray.limit {
            return Refinement::Certain;
        }
        if high < ray.nearest.low {
            *ray.nearest = NearestSoFar { face, low, slot: (index as u32, lane as u32) };
            *ray.limit = high;
            state.query_has_nearest = false;
            return Refinement::Certain;
        }
        Refinement::Tied
    }

    /// Finds out which of two triangles a ray hits first, the nearest so far or one that it hits as well.
    /// Returns false if that is still open.
    #[inline(always)]
    fn break_tie<S: Simd, Q: Query>(
        &self,
        simd: S,
        ray: &mut RayCursor,
        state: &mut ExactState<Q>,
        (index, lane): (usize, usize),
    ) -> bool {
        let face = self.target.tree.leaves.blocks[index].faces[lane];
        let mut pairs = Pairs::none();
        pairs.push(ray.number, ray.nearest.face, ray.nearest.slot);
        pairs.push(ray.number, face, (index as u32, lane as u32));
        let (t, known) = simd.outlined(ParameterJob { cast: self, pairs: &pairs });
        if known & 3 != 3 {
            return false;
        }
        // Both are what exact arithmetic gives, rounded; of equal ones the lower face comes first.
        if t[1] < t[0] || (t[1] == t[0] && face < ray.nearest.face) {
            let (low, high) = (ray.parameter.lower(t[1]), ray.parameter.limit(t[1]));
            *ray.nearest = NearestSoFar { face, low, slot: (index as u32, lane as u32) };
            *ray.limit = high;
            state.query_has_nearest = false;
        }
        true
    }

    /// Decides a triangle about which double precision said so much.
    #[inline(always)]
    fn decide_rest<S: Simd, Q: Query>(
        &self,
        simd: S,
        mut ray: RayCursor,
        state: &mut ExactState<Q>,
        refinement: Refinement,
        (index, lane): (usize, usize),
    ) {
        let query_has_nearest = state.query_has_nearest && ray.nearest.face != NO_FACE;
        let place = (index as u32, lane as u32);
        let is_decided = match refinement {
            Refinement::Certain => true,
            Refinement::Tied
                if ray.nearest.face != NO_FACE
                    && !query_has_nearest
                    && self.are_in_one_plane(ray.nearest.slot, place) =>
            {
                let face = self.target.tree.leaves.blocks[index].faces[lane];
                self.take_lower(&mut ray, state, face, place);
                true
            }
            Refinement::Tied if !query_has_nearest => {
                self.break_tie(simd, &mut ray, state, (index, lane))
            }
            Refinement::Tied | Refinement::Open => false,
        };
        if !is_decided && !state.is_done() {
            self.decide_exactly(ray, state, index, 1 << lane);
        }
    }

    /// Decides triangles of a leaf, whatever it takes.
    #[inline(never)]
    pub fn decide_exactly<Q: Query>(
        &self,
        ray: RayCursor,
        state: &mut ExactState<Q>,
        index: usize,
        mut open: u32,
    ) {
        let tree = self.target.tree;
        let RayCursor { number, parameter, nearest, limit } = ray;
        self.work.add_exact();
        self.prepare(number, state);
        let ExactState { prepared, query, query_has_nearest, .. } = state;
        if nearest.face != NO_FACE && !*query_has_nearest {
            query.restart();
            prepared.intersect_line_then(self.corners_at(nearest.slot), nearest.face, query);
        }
        *query_has_nearest = true;
        let block = &tree.leaves.blocks[index];
        while open != 0 {
            let lane = open.trailing_zeros() as usize;
            open &= open - 1;
            if block.faces[lane] == NO_FACE {
                continue;
            }
            let corners = tree.leaves.corners(self.target.mesh, &tree.frame, block, lane);
            prepared.intersect_line_then(corners, block.faces[lane], query);
        }
        if Q::KIND == QueryKind::Closest {
            let (face, bounds) = query.nearest();
            if face != NO_FACE {
                (nearest.face, nearest.low) = (face, parameter.lower(bounds.low));
                *limit = parameter.limit(bounds.high);
            }
        }
    }

    /// Prepares a ray for exact decisions, if that was not done yet.
    pub(super) fn prepare<Q: Query>(&self, number: usize, state: &mut ExactState<Q>) {
        if !state.is_prepared {
            state.prepared.set(&self.source.ray(number));
            state.is_prepared = true;
        }
    }
}
