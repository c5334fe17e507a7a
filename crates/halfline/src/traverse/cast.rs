//! Rays that are cast, and the decision whether and where each of them hits a triangle.
//!
//! Single precision is certain of nearly every hit and miss (`leaf_kernel.rs`). What it leaves open is
//! decided exactly: triangles whose edges the ray nearly touches, that begin or end its range, or that
//! are as near as the nearest one so far.

use std::cell::Cell;
use std::ops::Range;

use super::hit_lanes::{HitLanes, hits};
use super::leaf_kernel::{Verdict, test};
use super::plane_lanes::single_parameters;
use super::query::{Query, Shortcut};
use super::ray_group::RayLanes;
use super::second_look::{SecondLook, second_look};
use super::wide_ray::{Parameter, WideRay};
use crate::geometry::{Hit, NO_FACE, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::PreparedRay;
use crate::simd::{Doubles, Job, LANES, Numbers, Simd};
use crate::tree::{KdTree, LeafBlock};

/// What is asked about rays whose nearest hits are known, but for where they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// No nearest hits are asked for.
    None,
    /// t in single precision.
    Single,
    /// t and the weights.
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

    /// Eight rays of any numbers.
    fn gather<S: Simd>(&self, simd: S, numbers: &[usize; LANES]) -> RayLanes<S>;

    /// How answers are found for hits that are known, but for where.
    const ENDING: Ending;

    /// Takes the answer of [`Ending::Single`].
    fn finish_single(&mut self, _number: usize, _t: f32, _face: u32) {}

    /// Takes the answer of [`Ending::Double`].
    fn finish_double(&mut self, _number: usize, _hit: Hit) {}

    /// Takes the answer of [`Shortcut::Any`]: there is a hit.
    fn finish_found(&mut self, _number: usize) {}

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
    /// What casting it cost so far.
    pub work: Work,
}

impl<'a, B> Cast<'a, B> {
    /// A batch that is to be cast.
    pub fn new(tree: &'a KdTree, mesh: &'a Mesh, batch: B) -> Cast<'a, B> {
        Cast { tree, mesh, batch, work: Work::default() }
    }
}

/// Counts that change while a batch is only looked at.
#[derive(Default)]
pub struct Work {
    nodes: Cell<u64>,
    leaves: Cell<u64>,
    exact: Cell<u64>,
}

impl Work {
    /// So many nodes were fetched,
    #[inline(always)]
    pub fn add_nodes(&self, nodes: u32) {
        self.nodes.set(self.nodes.get() + u64::from(nodes));
    }

    /// and so many leaves.
    #[inline(always)]
    pub fn add_leaves(&self, leaves: u32) {
        self.leaves.set(self.leaves.get() + u64::from(leaves));
    }

    /// Nodes, leaves, and exact decisions.
    pub fn counts(&self) -> [u64; 3] {
        [self.nodes.get(), self.leaves.get(), self.exact.get()]
    }
}

/// The nearest hit so far.
#[derive(Clone, Copy)]
pub struct Found {
    /// Its face, or [`NO_FACE`].
    pub face: u32,
    /// Where it is at least; at most it is at the ray's limit.
    pub low: f32,
    /// In which block and lane it was found.
    pub place: (u32, u32),
}

impl Found {
    /// Nothing yet.
    pub const NOTHING: Found = Found { face: NO_FACE, low: f32::INFINITY, place: (0, 0) };
}

/// A ray on its way, and what it found.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct RayState {
    /// What boxes and leaves need of it.
    pub wide: WideRay,
    /// What it found.
    pub found: Found,
    /// Its number in the batch.
    pub number: usize,
    /// From t to the parameter of boxes and leaves.
    pub parameter: Parameter,
}

impl RayState {
    /// Before the first ray.
    pub fn none() -> RayState {
        let wide = WideRay::none();
        RayState { wide, found: Found::NOTHING, number: 0, parameter: Parameter::NONE }
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
        self.found = Found::NOTHING;
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
        self.set(simd, test(simd, &ray.wide, &block.corners));
    }

    /// Takes what is known.
    #[inline(always)]
    pub fn set<S: Simd>(&mut self, simd: S, verdict: Verdict<S::Floats>) {
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
    pub is_told: bool,
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
    /// True if anything was decided.
    #[inline(always)]
    pub fn is_prepared(&self) -> bool {
        self.is_prepared
    }

    /// Takes it that there is a hit, where no more is asked.
    #[inline(always)]
    fn settle_any(&mut self) {
        self.is_prepared = true;
        self.query.settle(NO_FACE, [Vec3::ZERO; 3]);
    }

    /// True if nothing more can matter.
    #[inline(always)]
    pub fn is_done(&self) -> bool {
        self.query.is_done()
    }

    /// Forgets the last ray.
    #[inline(always)]
    pub fn restart(&mut self) {
        if self.is_prepared {
            self.query.restart();
            (self.is_prepared, self.is_told) = (false, false);
        }
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
            Shortcut::None => *open,
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
        let (t, known) = simd.apart(Parameters { cast: self, pairs: &pairs });
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
        if B::Query::SHORTCUT == Shortcut::None {
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
        let look = simd.apart(LookAgain { cast: self, pairs: &pairs });
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

    fn prepare(&self, number: usize, decision: &mut Decision<B::Query>) {
        if !decision.is_prepared {
            decision.prepared.set(&self.batch.ray(number));
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
        ended: &mut Pairs,
    ) {
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

    /// Takes the answer of a ray that was decided, if it was.
    #[inline(always)]
    pub fn finish_decided(&mut self, number: usize, decision: &mut Decision<B::Query>) {
        if decision.is_prepared {
            self.batch.finish(number, &decision.prepared, &mut decision.query);
            decision.restart();
        }
    }

    #[inline(always)]
    fn corners_at(&self, (index, lane): (u32, u32)) -> [Vec3; 3] {
        let block = &self.tree.leaves.blocks[index as usize];
        self.tree.leaves.corners(self.mesh, &self.tree.frame, block, lane as usize)
    }

    /// The corners of eight triangles, in the user's coordinates.
    #[inline(always)]
    fn corner_lanes<S: Simd>(&self, simd: S, pairs: &Pairs) -> [[Numbers<S>; 3]; 3] {
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
                    let scaled = wide.times(number, wide.splat(frame.unit()));
                    corners[corner][axis] = wide.plus(scaled, wide.splat(frame.offset()[axis]));
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
        decision.query.settle(face, corners);
        self.batch.finish(number, &decision.prepared, &mut decision.query);
    }
}

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
    /// Numbers of rays, in each lane that of one.
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
