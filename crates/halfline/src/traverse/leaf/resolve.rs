//! Rays and a triangle for each, eight at a time: looks in double precision, and where known hits are.

use super::super::answers::Answers;
use super::super::cast::Cast;
use super::super::query::{CertainCrossing, Query, QueryKind, Slot};
use super::{ExactState, NearestSoFar, RayState};
use crate::geometry::{Hit, HitF32, NO_FACE, Vec3};
use crate::intersect::filter_f64::{Refined, refine};
use crate::intersect::hit_f64::{HitLanes, hit_f64x8};
use crate::intersect::t_f32::t_f32x8;
use crate::numeric::PreparedRay;
use crate::simd::{F64x8, Job, LANES, Simd, SimdF64};

/// For rays and the triangles that they are known to hit, t.
pub struct ParameterJob<'a, 'b> {
    /// The batch.
    pub cast: &'a Cast<'b>,
    /// The rays, and a triangle for each.
    pub pairs: &'a Pairs,
}

impl Job for ParameterJob<'_, '_> {
    /// t, and a bit for each that is known.
    type Output = ([f64; LANES], u32);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> ([f64; LANES], u32) {
        let [a, b, c] = self.cast.corner_lanes(simd, self.pairs);
        let rays = self.cast.source.gather8(simd, &self.pairs.numbers);
        let HitLanes { t, known, .. } = hit_f64x8(simd, &[rays.origin, rays.direction, a, b, c]);
        (t, known)
    }
}

/// Up to eight rays and a triangle for each, by lane.
pub struct Pairs {
    /// The number of each ray.
    pub numbers: [usize; LANES],
    /// The face of each triangle.
    pub faces: [u32; LANES],
    /// The index of the block that each triangle is in.
    pub blocks: [u32; LANES],
    /// The lane of each triangle in its block.
    pub triangles: [u32; LANES],
    /// A bit for each lane that is in use.
    pub lanes: u32,
}

impl Pairs {
    /// None yet.
    pub fn none() -> Pairs {
        Pairs {
            numbers: [0; LANES],
            faces: [NO_FACE; LANES],
            blocks: [0; LANES],
            triangles: [0; LANES],
            lanes: 0,
        }
    }

    /// Takes one more. Returns true if there is no room for another one.
    #[inline(always)]
    pub fn push(&mut self, number: usize, face: u32, (block, triangle): Slot) -> bool {
        let lane = self.lanes.count_ones() as usize % LANES;
        (self.numbers[lane], self.faces[lane]) = (number, face);
        (self.blocks[lane], self.triangles[lane]) = (block, triangle);
        self.lanes |= 1 << lane;
        lane == LANES - 1
    }
}

/// [`Cast::finish_pairs`] in a function of its own: all questions and kinds of answers call the same.
struct FinishPairs<'a, 'b> {
    cast: &'a mut Cast<'b>,
    pairs: &'a Pairs,
}

impl Job for FinishPairs<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.cast.find_and_put(simd, self.pairs);
    }
}

impl Cast<'_> {
    /// Takes the answer of a ray whose walk is over.
    #[inline(always)]
    pub fn finish<S: Simd, Q: Query>(
        &mut self,
        simd: S,
        ray: &RayState,
        state: &mut ExactState<Q>,
        ended: &mut Pairs,
    ) {
        let NearestSoFar { face, low, slot } = ray.nearest;
        if Q::KIND == QueryKind::All {
            self.finish_all(simd, ray.number, state, ended);
        } else if Q::KIND == QueryKind::Closest && face != NO_FACE && !state.query_has_nearest {
            if !Q::EXACT {
                self.put_plain(ray.number, face, ray.parameter.t(low));
            } else if ended.push(ray.number, face, slot) {
                self.finish_pairs(simd, ended);
                ended.lanes = 0;
            }
            state.restart();
        } else {
            self.finish_decided(ray.number, state);
        }
    }

    /// Takes all hits of a ray whose walk is over.
    #[inline(always)]
    pub fn finish_all<S: Simd, Q: Query>(
        &mut self,
        simd: S,
        number: usize,
        state: &mut ExactState<Q>,
        ended: &mut Pairs,
    ) {
        let Some(contacts) = state.query.contacts() else { return };
        if contacts.is_empty() {
            return state.restart();
        }
        if self.answers.are_crossings() {
            self.put_crossing_sum(number, contacts);
            state.is_prepared = true;
            return state.restart();
        }
        if !contacts.touches.is_empty() {
            // Which of them count depends on t of all crossings.
            self.make_exact(number, state);
        } else if self.answers.are_counts() {
            self.answers.put_crossings(number, contacts);
            state.is_prepared = true;
            return state.restart();
        } else {
            for i in 0..contacts.certain.len() {
                let CertainCrossing { face, slot } = contacts.certain[i];
                if ended.push(number, face, slot) {
                    self.finish_pairs(simd, ended);
                    ended.lanes = 0;
                }
            }
            contacts.certain.clear();
        }
        self.finish_decided(number, state);
    }

    /// Finds t and the weights of the crossings that are merely certain.
    #[cold]
    #[inline(never)]
    fn make_exact<Q: Query>(&self, number: usize, state: &mut ExactState<Q>) {
        self.prepare(number, state);
        let ExactState { prepared, query, .. } = state;
        let Some(contacts) = query.contacts() else { return };
        for CertainCrossing { face, slot } in contacts.certain.drain(..) {
            contacts.hits.push(prepared.hit(face, self.corners_at(slot)));
        }
    }

    /// Takes the answer of a ray about which something was decided exactly, if that is so.
    #[inline(always)]
    pub fn finish_decided<Q: Query>(&mut self, number: usize, state: &mut ExactState<Q>) {
        if state.is_prepared {
            state.query.answer(number, &state.prepared, self.target, &mut self.answers);
            state.restart();
        }
    }

    /// Puts a closest hit whose t was taken as it came.
    pub(in super::super) fn put_plain(&mut self, number: usize, face: u32, t: f64) {
        if self.answers.are_f32() {
            self.answers.put_hit_f32(number, HitF32 { t: t as f32, face });
        } else {
            self.answers.put_hit(number, Hit { t, face, u: 0.0, v: 0.0 });
        }
    }

    #[inline(always)]
    pub(in super::super) fn corners_at(&self, (block, lane): Slot) -> [Vec3; 3] {
        let tree = self.target.tree;
        let block = &tree.leaves.blocks[block as usize];
        tree.leaves.corners(self.target.mesh, &tree.frame, block, lane as usize)
    }

    /// The corners of eight triangles, in the user's coordinates.
    #[inline(always)]
    fn corner_lanes<S: Simd>(&self, simd: S, pairs: &Pairs) -> [[F64x8<S>; 3]; 3] {
        let tree = self.target.tree;
        let (wide, leaves, frame) = (simd.doubles(), &tree.leaves, &tree.frame);
        let mut corners = [[wide.splat(0.0); 3]; 3];
        // The other lanes may say nothing of where their faces lie.
        let first = pairs.lanes.trailing_zeros() as usize % LANES;
        let is_one = !simd.eq_u32(&pairs.faces, pairs.faces[first]) & pairs.lanes == 0;
        if is_one & leaves.are_exact {
            // Neighbours in a picture mostly hit the same face.
            let block = &leaves.blocks[pairs.blocks[first] as usize].corners;
            let triangle = pairs.triangles[first] as usize % LANES;
            for corner in 0..3 {
                for axis in 0..3 {
                    let number = frame.to_user(block[corner][axis][triangle], axis);
                    corners[corner][axis] = wide.splat(number);
                }
            }
        } else if leaves.are_exact {
            let mut blocks = [&leaves.blocks[pairs.blocks[0] as usize].corners; LANES];
            let mut triangles = [0; LANES];
            for lane in 0..LANES {
                blocks[lane] = &leaves.blocks[pairs.blocks[lane] as usize].corners;
                triangles[lane] = pairs.triangles[lane] as usize % LANES;
            }
            for corner in 0..3 {
                for axis in 0..3 {
                    let mut lanes = [0.0; LANES];
                    for lane in 0..LANES {
                        lanes[lane] = blocks[lane][corner][axis][triangles[lane]];
                    }
                    let number = simd.widen(simd.set(lanes));
                    let scaled = wide.mul(number, wide.splat(frame.unit()));
                    corners[corner][axis] = wide.add(scaled, wide.splat(frame.offset()[axis]));
                }
            }
        } else {
            let mut triangles = [[Vec3::ZERO; 3]; LANES];
            let mut rest = pairs.lanes;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % LANES;
                rest &= rest - 1;
                triangles[lane] = self.target.mesh.corners(pairs.faces[lane]);
            }
            for corner in 0..3 {
                for axis in 0..3 {
                    let mut lanes = [0.0; LANES];
                    for lane in 0..LANES {
                        lanes[lane] = triangles[lane][corner][axis];
                    }
                    corners[corner][axis] = wide.set(lanes);
                }
            }
        }
        corners
    }

    /// Takes the answers of rays whose nearest hits are these, or of which these are some of all hits.
    #[inline(always)]
    pub fn finish_pairs<S: Simd>(&mut self, simd: S, pairs: &Pairs) {
        if pairs.lanes != 0 {
            simd.outlined(FinishPairs { cast: self, pairs });
        }
    }

    /// Looks at rays and triangles in double precision.
    #[inline(always)]
    pub fn refine<S: Simd>(&self, simd: S, pairs: &Pairs) -> Refined {
        let corners = self.corner_lanes(simd, pairs);
        refine(simd, &self.source.gather8(simd, &pairs.numbers), &corners, pairs.lanes)
    }

    /// The body of [`Cast::finish_pairs`].
    #[inline(always)]
    pub fn find_and_put<S: Simd>(&mut self, simd: S, pairs: &Pairs) {
        let [a, b, c] = self.corner_lanes(simd, pairs);
        let rays = self.source.gather8(simd, &pairs.numbers);
        let lanes = [rays.origin, rays.direction, a, b, c];
        let mut open = pairs.lanes;
        if let Answers::HitsF32(places) = &mut self.answers {
            let (t, certain) = t_f32x8(simd, &lanes);
            let mut rest = open & certain;
            open &= !certain;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % LANES;
                rest &= rest - 1;
                places[pairs.numbers[lane]] = HitF32 { t: t[lane], face: pairs.faces[lane] };
            }
        } else {
            let HitLanes { t, u, v, known, weights_known } = hit_f64x8(simd, &lanes);
            // Where only t lies too near to the middle of two doubles, the weights are good.
            let mut rest = open & !known & weights_known;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % LANES;
                rest &= rest - 1;
                self.finish_t(pairs, lane, [u[lane], v[lane]]);
            }
            let mut rest = open & known;
            open &= !weights_known;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % LANES;
                rest &= rest - 1;
                let hit = Hit { t: t[lane], face: pairs.faces[lane], u: u[lane], v: v[lane] };
                self.answers.put_hit(pairs.numbers[lane], hit);
            }
        }
        while open != 0 {
            let lane = open.trailing_zeros() as usize % LANES;
            open &= open - 1;
            self.finish_exactly(pairs, lane);
        }
    }

    /// The ray of a pair, ready for exact decisions, and the corners of its triangle.
    fn prepared_pair(&self, pairs: &Pairs, lane: usize) -> (PreparedRay, [Vec3; 3]) {
        let mut prepared = PreparedRay::default();
        prepared.set(&self.source.ray(pairs.numbers[lane]));
        (prepared, self.corners_at((pairs.blocks[lane], pairs.triangles[lane])))
    }

    /// Finds t of a known hit whose weights are known.
    #[inline(never)]
    fn finish_t(&mut self, pairs: &Pairs, lane: usize, [u, v]: [f64; 2]) {
        let (prepared, corners) = self.prepared_pair(pairs, lane);
        let hit = Hit { t: prepared.parameter(&corners), face: pairs.faces[lane], u, v };
        self.answers.put_hit(pairs.numbers[lane], hit);
    }

    /// Finds where a known hit is, whatever it takes.
    #[cold]
    #[inline(never)]
    fn finish_exactly(&mut self, pairs: &Pairs, lane: usize) {
        let (number, face) = (pairs.numbers[lane], pairs.faces[lane]);
        let (prepared, corners) = self.prepared_pair(pairs, lane);
        if self.answers.are_f32() {
            // A zero below one half of the smallest denormal would keep its sign.
            let t = prepared.parameter(&corners) as f32 + 0.0;
            self.answers.put_hit_f32(number, HitF32 { t, face });
        } else {
            self.answers.put_hit(number, prepared.hit(face, corners));
        }
    }
}
