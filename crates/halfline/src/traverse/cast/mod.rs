//! Rays that are cast, and the decision whether and where each of them hits a triangle.
//!
//! Single precision is certain of nearly every hit and miss (`leaf_kernel.rs`). What it leaves open is
//! decided exactly: triangles whose edges the ray nearly touches, that begin or end its range, or that
//! are as near as the nearest one so far.

mod decide;
mod pairs;

use std::cell::Cell;
use std::ops::Range;

use super::leaf_kernel::{Verdict, test};
use super::query::{AllContacts, CertainCrossing, Query};
use super::ray_group::RayLanes;
use super::wide_ray::{Parameter, WideRay};
use crate::geometry::{Hit, NO_FACE, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::PreparedRay;
use crate::simd::{LANES, Simd};
use crate::tree::{KdTree, LeafBlock, Word};

pub use decide::{Asked, Second};
pub use pairs::{LookAgain, Pairs, Parameters};

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

    /// How answers are found for hits that are known, but for where. Where all hits are asked for,
    /// [`Ending::None`] means that only their number is.
    const ENDING: Ending;

    /// Takes the answer of [`Ending::Single`].
    fn finish_single(&mut self, _number: usize, _t: f32, _face: u32) {}

    /// Takes the answer of [`Ending::Double`].
    fn finish_double(&mut self, _number: usize, _hit: Hit) {}

    /// Takes the answer of [`Shortcut::Any`]: there is a hit.
    fn finish_found(&mut self, _number: usize) {}

    /// Takes how many faces a ray crosses, where no more is asked of those that touch none.
    fn finish_count(&mut self, _number: usize, _contacts: &mut AllContacts) {}

    /// True if the batch wants to hear of every step.
    const IS_WATCHED: bool = false;

    /// Hears that a ray comes to a node or leaf, and where it stops to matter.
    fn watch(&self, _word: Word, _ray: &RayState) {}

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
    pub fn set<S: Simd>(&mut self, simd: S, verdict: Verdict<S::F32x8>) {
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

    /// Takes it that a face is crossed, where all that are crossed are asked for.
    #[inline(always)]
    fn settle_each(&mut self, face: u32, place: (u32, u32)) {
        if let Some(contacts) = self.query.contacts()
            && face != NO_FACE
        {
            contacts.certain.push(CertainCrossing { face, place });
        }
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
