//! Rays that are cast, and the decision whether and where each of them hits a triangle.
//!
//! Single precision is certain of nearly every hit and miss (`leaf_kernel.rs`). What it leaves open is
//! decided exactly: triangles whose edges the ray nearly touches, that begin or end its range, or that
//! are as near as the nearest one so far.

use std::ops::Range;

use super::hit_lanes::{HitLanes, hits};
use super::leaf_kernel::test;
use super::plane_lanes::{LineLanes, single_parameters};
use super::query::{Query, Search, Shortcut};
use super::ray_group::RayLanes;
use super::wide_ray::{Parameter, WideRay};
use crate::geometry::{Hit, NO_FACE, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::PreparedRay;
use crate::simd::{LANES, Simd};
use crate::tree::{KdTree, LeafBlock};

/// How the answer of a ray is found whose nearest hit is known, but for where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// By itself.
    Alone,
    /// With others: t in single precision.
    Single,
    /// With others: t and the weights.
    Double,
}

/// A batch: rays by number, and what is asked about each.
pub trait Batch {
    /// What is asked.
    type Query: Query + Default;

    /// How many rays there are.
    fn count(&self) -> usize;

    /// A ray; those of one number are always the same.
    fn ray(&self, number: usize) -> Ray;

    /// Up to eight rays.
    fn lanes<S: Simd>(&self, simd: S, numbers: Range<usize>) -> RayLanes<S>;

    /// How answers are found for hits that are known, but for where.
    const ENDING: Ending;

    /// Takes the answer of [`Ending::Single`].
    fn finish_single(&mut self, _number: usize, _t: f32, _face: u32) {}

    /// Takes the answer of [`Ending::Double`].
    fn finish_double(&mut self, _number: usize, _hit: Hit) {}

    /// Takes the answer of a walk that met some triangle's line.
    fn finish(&mut self, number: usize, ray: &PreparedRay, query: &mut Self::Query);
}

/// A batch that is cast.
pub struct Cast<'a, B> {
    /// The scene's tree.
    pub tree: &'a KdTree,
    /// The scene's mesh.
    pub mesh: &'a Mesh,
    /// The batch.
    pub batch: B,
}

/// A ray on its way, and what it found.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct RayState {
    /// What boxes and leaves need of it.
    pub wide: WideRay,
    /// The nearest hit so far, where it is at least, and in which block and lane it was found. It is
    /// at most at the limit.
    nearest: u32,
    nearest_low: f32,
    place: (u32, u32),
    /// Its number in the batch.
    pub number: usize,
    /// From t to the parameter of boxes and leaves.
    pub parameter: Parameter,
}

impl RayState {
    /// Before the first ray.
    pub fn none() -> RayState {
        RayState {
            wide: WideRay::none(),
            nearest: NO_FACE,
            nearest_low: f32::INFINITY,
            place: (0, 0),
            number: 0,
            parameter: Parameter::NONE,
        }
    }

    /// Begins with another ray.
    #[inline(always)]
    pub fn restart<S: Simd>(
        &mut self,
        simd: S,
        number: usize,
        wide: &WideRay,
        parameter: Parameter,
    ) {
        self.wide.copy_from(simd, wide);
        (self.number, self.parameter) = (number, parameter);
        (self.nearest, self.nearest_low) = (NO_FACE, f32::INFINITY);
    }
}

/// What is known about the triangles of a leaf.
#[derive(Clone, Copy, Default)]
#[repr(C, align(32))]
pub struct Candidates {
    /// Where the ray hits them, at least and at most.
    low: [f32; LANES],
    high: [f32; LANES],
    /// A bit for each triangle that the ray may hit.
    pub open: u32,
    /// A bit for each of those that it hits for certain.
    certain: u32,
    /// A bit for each whose place is known.
    placed: u32,
}

impl Candidates {
    /// Holds a ray against the triangles of a leaf.
    #[inline(always)]
    pub fn find<S: Simd>(&mut self, simd: S, ray: &RayState, block: &LeafBlock) {
        let verdict = test(simd, &ray.wide, &block.corners);
        simd.store(verdict.low, &mut self.low);
        simd.store(verdict.high, &mut self.high);
        (self.open, self.certain) = (verdict.candidates, verdict.certain);
        self.placed = verdict.placed;
    }
}

/// What only rays need that may hit.
pub struct Decision<Q> {
    is_prepared: bool,
    /// True if the query knows the walk's nearest hit.
    is_told: bool,
    prepared: PreparedRay,
    query: Q,
}

impl<Q: Query + Default> Decision<Q> {
    /// Before the first ray.
    pub fn new() -> Decision<Q> {
        let (prepared, query) = (PreparedRay::default(), Q::default());
        Decision { is_prepared: false, is_told: false, prepared, query }
    }
}

impl<Q: Query> Decision<Q> {
    /// Forgets the last ray.
    #[inline(always)]
    fn restart(&mut self) {
        if self.is_prepared {
            self.query.restart();
            (self.is_prepared, self.is_told) = (false, false);
        }
    }
}

impl<B: Batch> Cast<'_, B> {
    /// Decides the candidates of the leaf whose block has this index. Returns true if nothing more
    /// can matter to the ray.
    #[inline(always)]
    pub fn decide(
        &self,
        ray: &mut RayState,
        decision: &mut Decision<B::Query>,
        candidates: &Candidates,
        index: usize,
    ) -> bool {
        let block = &self.tree.leaves.blocks[index];
        let Candidates { low, high, open, certain, placed } = candidates;
        let mut open = *open;
        match B::Query::SHORTCUT {
            Shortcut::None => {}
            Shortcut::Any => {
                if *certain != 0 {
                    decision.is_prepared = true;
                    decision.query.settle(NO_FACE, [Vec3::ZERO; 3]);
                    return true;
                }
            }
            Shortcut::Nearest => {
                let mut rest = std::mem::take(&mut open);
                while rest != 0 {
                    let lane = rest.trailing_zeros() as usize % LANES;
                    rest &= rest - 1;
                    let (face, low, high) = (block.faces[lane], low[lane], high[lane]);
                    let is_beyond = placed >> lane & 1 == 1 && low > ray.wide.limit;
                    if face == ray.nearest || face == NO_FACE || is_beyond {
                        continue;
                    }
                    if certain >> lane & 1 == 1 && high < ray.nearest_low {
                        (ray.nearest, ray.nearest_low, ray.wide.limit) = (face, low, high);
                        ray.place = (index as u32, lane as u32);
                        decision.is_told = false;
                    } else {
                        open |= 1 << lane;
                    }
                }
            }
        }
        if open == 0 {
            return false;
        }
        self.decide_exactly(ray, decision, block, open);
        decision.query.is_done()
    }

    /// Decides triangles of a block of which single precision is not certain.
    #[inline(never)]
    fn decide_exactly(
        &self,
        ray: &mut RayState,
        decision: &mut Decision<B::Query>,
        block: &LeafBlock,
        mut open: u32,
    ) {
        let tree = self.tree;
        self.prepare(ray, decision);
        let Decision { prepared, query, is_told, .. } = decision;
        if ray.nearest != NO_FACE && !*is_told {
            query.restart();
            let (block, lane) = (&tree.leaves.blocks[ray.place.0 as usize], ray.place.1 as usize);
            let corners = tree.leaves.corners(self.mesh, &tree.frame, block, lane);
            prepared.meet_line_then(corners, ray.nearest, query);
        }
        *is_told = true;
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
                (ray.nearest, ray.nearest_low) = (face, ray.parameter.lower(bounds.low));
                ray.wide.limit = ray.parameter.limit(bounds.high);
            }
        }
    }

    #[inline(always)]
    pub fn prepare(&self, ray: &RayState, decision: &mut Decision<B::Query>) {
        if !decision.is_prepared {
            decision.prepared.set(&self.batch.ray(ray.number));
            decision.is_prepared = true;
        }
    }

    /// Takes the answer of a ray whose walk is over.
    #[inline(always)]
    pub fn finish<S: Simd>(
        &mut self,
        simd: S,
        ray: &RayState,
        decision: &mut Decision<B::Query>,
        ended: &mut Ended,
    ) {
        let is_known =
            B::Query::SHORTCUT == Shortcut::Nearest && ray.nearest != NO_FACE && !decision.is_told;
        if is_known {
            if B::ENDING != Ending::Alone {
                ended.hits[ended.count % LANES] = (ray.number, ray.nearest, ray.place);
                ended.count += 1;
                if ended.count == LANES {
                    self.finish_ended(simd, ended);
                }
                decision.restart();
                return;
            }
            self.prepare(ray, decision);
            decision.query.settle(ray.nearest, self.corners_at(ray.place));
        }
        if decision.is_prepared {
            self.batch.finish(ray.number, &decision.prepared, &mut decision.query);
            decision.restart();
        }
    }

    #[inline(always)]
    fn corners_at(&self, (index, lane): (u32, u32)) -> [Vec3; 3] {
        let block = &self.tree.leaves.blocks[index as usize];
        self.tree.leaves.corners(self.mesh, &self.tree.frame, block, lane as usize)
    }

    /// Takes the answers of rays that wait for the end of others.
    #[inline(always)]
    pub fn finish_ended<S: Simd>(&mut self, simd: S, ended: &mut Ended) {
        let count = ended.count.min(LANES);
        for lane in 0..count {
            let (number, _, place) = ended.hits[lane];
            let ray = self.batch.ray(number);
            let [a, b, c] = self.corners_at(place);
            for axis in 0..3 {
                ended.lanes[0][axis][lane] = ray.origin[axis];
                ended.lanes[1][axis][lane] = ray.direction[axis];
                ended.lanes[2][axis][lane] = a[axis];
                ended.lanes[3][axis][lane] = b[axis];
                ended.lanes[4][axis][lane] = c[axis];
            }
        }
        if B::ENDING == Ending::Single {
            let (t, certain) = single_parameters(simd, &ended.lanes);
            for lane in 0..count {
                let (number, face, place) = ended.hits[lane];
                if certain >> lane & 1 == 1 {
                    self.batch.finish_single(number, t[lane], face);
                } else {
                    self.finish_closely(number, face, place);
                }
            }
        } else {
            let HitLanes { t, u, v, known } = hits(simd, &ended.lanes);
            for lane in 0..count {
                let (number, face, place) = ended.hits[lane];
                if known >> lane & 1 == 1 {
                    let hit = Hit { t: t[lane], face, u: u[lane], v: v[lane] };
                    self.batch.finish_double(number, hit);
                } else {
                    self.finish_closely(number, face, place);
                }
            }
        }
        ended.count = 0;
    }

    #[cold]
    #[inline(never)]
    fn finish_closely(&mut self, number: usize, face: u32, place: (u32, u32)) {
        let mut decision = Decision::<B::Query>::new();
        decision.prepared.set(&self.batch.ray(number));
        decision.query.settle(face, self.corners_at(place));
        self.batch.finish(number, &decision.prepared, &mut decision.query);
    }
}

/// Rays that came to an end with hits that are known, but for t.
pub struct Ended {
    /// Number, face and place.
    hits: [(usize, u32, (u32, u32)); LANES],
    count: usize,
    lanes: LineLanes,
}

impl Ended {
    /// None yet.
    pub fn none() -> Ended {
        Ended { hits: [(0, NO_FACE, (0, 0)); LANES], count: 0, lanes: [[[0.0; LANES]; 3]; 5] }
    }
}
