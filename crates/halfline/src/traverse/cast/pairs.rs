//! Rays and a triangle for each, eight at a time: looks in double precision, and answers.

use super::super::hit_lanes::{HitLanes, hits};
use super::super::plane_lanes::single_parameters;
use super::super::query::{CertainCrossing, Query, Shortcut};
use super::super::second_look::{SecondLook, second_look};
use super::{Batch, Cast, Decision, Ending, Found, RayState};
use crate::geometry::{Hit, NO_FACE, Vec3};
use crate::simd::{F64x8, Job, LANES, Simd, SimdF64};

/// For rays and the triangles that they are known to hit, t.
pub struct Parameters<'a, 'b, B> {
    /// The batch.
    pub cast: &'a Cast<'b, B>,
    /// The rays, and a triangle for each.
    pub pairs: &'a Pairs,
}

impl<B: Batch> Job for Parameters<'_, '_, B> {
    /// t, and a bit for each that is known.
    type Output = ([f64; LANES], u32);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> ([f64; LANES], u32) {
        let [a, b, c] = self.cast.corner_lanes(simd, self.pairs);
        let rays = self.cast.batch.gather(simd, &self.pairs.numbers);
        let HitLanes { t, known, .. } = hits(simd, &[rays.origin, rays.direction, a, b, c]);
        (t, known)
    }
}

/// A look at rays and triangles once more, in double precision.
pub struct LookAgain<'a, 'b, B> {
    /// The batch.
    pub cast: &'a Cast<'b, B>,
    /// The rays, and a triangle for each.
    pub pairs: &'a Pairs,
}

impl<B: Batch> Job for LookAgain<'_, '_, B> {
    type Output = SecondLook;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> SecondLook {
        let corners = self.cast.corner_lanes(simd, self.pairs);
        second_look(simd, &self.cast.batch.gather(simd, &self.pairs.numbers), &corners)
    }
}

/// Up to eight rays and a triangle for each, by lane.
pub struct Pairs {
    /// F64x8 of rays, in each lane that of one.
    pub numbers: [usize; LANES],
    /// Faces,
    pub faces: [u32; LANES],
    /// the blocks that they are in,
    pub blocks: [u32; LANES],
    /// and where in them.
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
    pub fn push(&mut self, number: usize, face: u32, (block, triangle): (u32, u32)) -> bool {
        let lane = self.lanes.count_ones() as usize % LANES;
        (self.numbers[lane], self.faces[lane]) = (number, face);
        (self.blocks[lane], self.triangles[lane]) = (block, triangle);
        self.lanes |= 1 << lane;
        lane == LANES - 1
    }
}

impl<B: Batch> Cast<'_, B> {
    /// Takes the answer of a ray whose walk is over.
    #[inline(always)]
    pub fn finish<S: Simd>(
        &mut self,
        simd: S,
        ray: &RayState,
        decision: &mut Decision<B::Query>,
        ended: &mut Pairs,
    ) {
        if B::Query::SHORTCUT == Shortcut::Each {
            return self.finish_each(simd, ray.number, decision, ended);
        }
        let Found { face, place, .. } = ray.found;
        if B::Query::SHORTCUT == Shortcut::Nearest && face != NO_FACE && !decision.is_told {
            if ended.push(ray.number, face, place) {
                self.finish_pairs(simd, ended);
                ended.lanes = 0;
            }
            decision.restart();
        } else {
            self.finish_decided(ray.number, decision);
        }
    }

    /// Takes all hits of a ray whose walk is over.
    #[inline(always)]
    fn finish_each<S: Simd>(
        &mut self,
        simd: S,
        number: usize,
        decision: &mut Decision<B::Query>,
        ended: &mut Pairs,
    ) {
        let Some(contacts) = decision.query.contacts() else { return };
        if contacts.is_empty() {
            return decision.restart();
        }
        if !contacts.touches.is_empty() {
            // Which of them count depends on t of all crossings.
            self.make_exact(number, decision);
        } else if B::ENDING == Ending::None {
            self.batch.finish_count(number, contacts);
            decision.is_prepared = true;
            return decision.restart();
        } else {
            for i in 0..contacts.certain.len() {
                let CertainCrossing { face, place } = contacts.certain[i];
                if ended.push(number, face, place) {
                    self.finish_pairs(simd, ended);
                    ended.lanes = 0;
                }
            }
            contacts.certain.clear();
        }
        self.finish_decided(number, decision);
    }

    /// Finds t and the weights of the crossings that are merely certain.
    #[cold]
    #[inline(never)]
    fn make_exact(&self, number: usize, decision: &mut Decision<B::Query>) {
        self.prepare(number, decision);
        let Decision { prepared, query, .. } = decision;
        let Some(contacts) = query.contacts() else { return };
        for CertainCrossing { face, place } in contacts.certain.drain(..) {
            contacts.hits.push(prepared.hit(face, self.corners_at(place)));
        }
    }

    /// Takes the answer of a ray that was decided, if it was.
    #[inline(always)]
    pub fn finish_decided(&mut self, number: usize, decision: &mut Decision<B::Query>) {
        if decision.is_prepared {
            self.batch.finish(number, &decision.prepared, &mut decision.query);
            decision.restart();
        }
    }

    #[inline(always)]
    pub(super) fn corners_at(&self, (index, lane): (u32, u32)) -> [Vec3; 3] {
        let block = &self.tree.leaves.blocks[index as usize];
        self.tree.leaves.corners(self.mesh, &self.tree.frame, block, lane as usize)
    }

    /// The corners of eight triangles, in the user's coordinates.
    #[inline(always)]
    fn corner_lanes<S: Simd>(&self, simd: S, pairs: &Pairs) -> [[F64x8<S>; 3]; 3] {
        let (wide, leaves, frame) = (simd.doubles(), &self.tree.leaves, &self.tree.frame);
        let mut corners = [[wide.splat(0.0); 3]; 3];
        if leaves.are_exact {
            let mut lanes = [[[0.0; LANES]; 3]; 3];
            for lane in 0..LANES {
                let block = &leaves.blocks[pairs.blocks[lane] as usize].corners;
                let triangle = pairs.triangles[lane] as usize % LANES;
                for corner in 0..3 {
                    for axis in 0..3 {
                        lanes[corner][axis][lane] = block[corner][axis][triangle];
                    }
                }
            }
            for corner in 0..3 {
                for axis in 0..3 {
                    let number = simd.widen(simd.load(&lanes[corner][axis]));
                    let scaled = wide.mul(number, wide.splat(frame.unit()));
                    corners[corner][axis] = wide.add(scaled, wide.splat(frame.offset()[axis]));
                }
            }
        } else {
            let mut lanes = [[[0.0; LANES]; 3]; 3];
            let mut rest = pairs.lanes;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % LANES;
                rest &= rest - 1;
                let triangle = self.mesh.corners(pairs.faces[lane]);
                for corner in 0..3 {
                    for axis in 0..3 {
                        lanes[corner][axis][lane] = triangle[corner][axis];
                    }
                }
            }
            for corner in 0..3 {
                for axis in 0..3 {
                    corners[corner][axis] = wide.load(&lanes[corner][axis]);
                }
            }
        }
        corners
    }

    /// Takes the answers of rays whose nearest hits are these.
    #[inline(always)]
    pub fn finish_pairs<S: Simd>(&mut self, simd: S, pairs: &Pairs) {
        let mut rest = pairs.lanes;
        if rest == 0 {
            return;
        }
        let [a, b, c] = self.corner_lanes(simd, pairs);
        let rays = self.batch.gather(simd, &pairs.numbers);
        let lanes = [rays.origin, rays.direction, a, b, c];
        if B::ENDING == Ending::Single {
            let (t, certain) = single_parameters(simd, &lanes);
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % LANES;
                rest &= rest - 1;
                if certain >> lane & 1 == 1 {
                    self.batch.finish_single(pairs.numbers[lane], t[lane], pairs.faces[lane]);
                } else {
                    self.finish_closely(pairs, lane);
                }
            }
        } else {
            let HitLanes { t, u, v, known } = hits(simd, &lanes);
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % LANES;
                rest &= rest - 1;
                if known >> lane & 1 == 1 {
                    let hit = Hit { t: t[lane], face: pairs.faces[lane], u: u[lane], v: v[lane] };
                    self.batch.finish_double(pairs.numbers[lane], hit);
                } else {
                    self.finish_closely(pairs, lane);
                }
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn finish_closely(&mut self, pairs: &Pairs, lane: usize) {
        let (number, face) = (pairs.numbers[lane], pairs.faces[lane]);
        let corners = self.corners_at((pairs.blocks[lane], pairs.triangles[lane]));
        let mut decision = Decision::<B::Query>::new();
        decision.prepared.set(&self.batch.ray(number));
        if B::Query::SHORTCUT == Shortcut::Each {
            return self.batch.finish_double(number, decision.prepared.hit(face, corners));
        }
        decision.query.settle(face, corners);
        self.batch.finish(number, &decision.prepared, &mut decision.query);
    }
}
