//! What happens in a leaf: whether and where a ray hits its triangles.
//!
//! Single precision is certain of nearly every hit and miss (`intersect/filter_f32.rs`). What it leaves open,
//! triangles whose edges the ray nearly touches, that begin or end its range, or that are as near as the nearest
//! one so far, climbs the ladder of [`intersect`](crate::intersect): `decide.rs` says how far. `resolve.rs` finds
//! t of the hits that are known, eight at a time.

mod decide;
mod open_pairs;
mod resolve;

use super::query::{Query, QueryKind, Slot};
use crate::geometry::NO_FACE;
use crate::intersect::filter_f32::{F32Verdict, test_leaf};
use crate::numeric::PreparedRay;
use crate::rays::{Parameter, TraversalRay};
use crate::simd::{LANES, Simd};
use crate::tree::LeafBlock;

pub use decide::RayCursor;
pub use open_pairs::OpenPairs;
pub use resolve::Pairs;
use resolve::ParameterJob;

/// The nearest hit so far.
#[derive(Clone, Copy)]
pub struct NearestSoFar {
    /// Its face, or [`NO_FACE`].
    pub face: u32,
    /// Where it is at least; at most it is at the ray's limit.
    pub low: f32,
    /// Where it was found, unless the query knows it: what is decided exactly is not looked up again.
    pub slot: Slot,
}

impl NearestSoFar {
    /// Nothing yet.
    pub const NOTHING: NearestSoFar =
        NearestSoFar { face: NO_FACE, low: f32::INFINITY, slot: (0, 0) };
}

/// A ray on its way, and what it found.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct RayState {
    /// What boxes and leaves need of it.
    pub traversal: TraversalRay,
    /// What it found.
    pub nearest: NearestSoFar,
    /// Its number in the batch.
    pub number: usize,
    /// From t to the parameter of boxes and leaves.
    pub parameter: Parameter,
}

impl RayState {
    /// Before the first ray.
    pub fn none() -> RayState {
        let traversal = TraversalRay::none();
        RayState {
            traversal,
            nearest: NearestSoFar::NOTHING,
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
        traversal: &TraversalRay,
        parameter: Parameter,
    ) {
        self.traversal.copy_from(simd, traversal);
        (self.number, self.parameter) = (number, parameter);
        self.nearest = NearestSoFar::NOTHING;
    }
}

/// What is known about the triangles of a leaf.
#[derive(Clone, Copy, Default)]
#[repr(C, align(32))]
pub struct Candidates {
    /// Lower bounds of where the ray hits them.
    low: [f32; LANES],
    /// Upper bounds.
    high: [f32; LANES],
    /// A bit for each triangle that the ray may hit.
    pub open: u32,
    /// A bit for each of those that it hits for certain.
    pub certain: u32,
    /// A bit for each whose bounds are known.
    has_interval: u32,
}

impl Candidates {
    /// True if there is one, and it is not certain.
    #[inline(always)]
    pub fn is_single_and_open(&self) -> bool {
        // Without a branch.
        (self.certain == 0) & (self.open != 0) & (self.open & self.open.wrapping_sub(1) == 0)
    }

    /// Holds a ray against the triangles of a leaf.
    #[inline(always)]
    pub fn find<S: Simd, Q: Query>(&mut self, simd: S, ray: &RayState, block: &LeafBlock) {
        let verdict = if Q::EXACT {
            test_leaf::<S, true>(simd, &ray.traversal, &block.corners)
        } else {
            test_leaf::<S, false>(simd, &ray.traversal, &block.corners)
        };
        self.set(simd, verdict, !simd.eq_u32(&block.faces, NO_FACE));
    }

    /// Takes what the filter found about the lanes that hold a triangle.
    #[inline(always)]
    pub fn set<S: Simd>(&mut self, simd: S, verdict: F32Verdict<S::F32x8>, triangles: u32) {
        simd.store(verdict.low, &mut self.low);
        simd.store(verdict.high, &mut self.high);
        (self.open, self.certain) = (verdict.candidates & triangles, verdict.certain & triangles);
        self.has_interval = verdict.has_interval;
    }
}

/// What only rays need of which something is decided exactly.
pub struct ExactState<Q> {
    is_prepared: bool,
    /// True if the query knows the nearest hit so far.
    pub query_has_nearest: bool,
    prepared: PreparedRay,
    query: Q,
}

impl<Q: Query> ExactState<Q> {
    /// Before the first ray.
    pub fn new() -> ExactState<Q> {
        let (prepared, query) = (PreparedRay::default(), Q::default());
        ExactState { is_prepared: false, query_has_nearest: false, prepared, query }
    }
}

impl<Q: Query> ExactState<Q> {
    /// True if anything was decided.
    #[inline(always)]
    pub fn is_prepared(&self) -> bool {
        self.is_prepared
    }

    /// Takes a face that is hit for certain, where no t is needed.
    #[inline(always)]
    pub fn accept(&mut self, face: u32, slot: Slot) {
        // A ray of which any hit is asked is at its end, and has an answer.
        self.is_prepared |= Q::KIND == QueryKind::Any;
        self.query.accept(face, slot);
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
            (self.is_prepared, self.query_has_nearest) = (false, false);
        }
    }
}
