//! A batch of rays on its way: what all parts of the traversal share.

use std::cell::{Cell, RefCell};

use super::answers::Answers;
use super::leaf::RayState;
use super::prefetch::PrefetchTuner;
use super::query::ClosestHit;
use super::stream::cast;
use crate::geometry::{Hit, Ray};
use crate::mesh::Mesh;
use crate::rays::{RayOrder, RaySource};
use crate::simd::Level;
use crate::tree::{NodeRef, Tree};

/// What rays are cast at, and by which instruction set.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// The tree.
    pub tree: &'a Tree,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The instruction set.
    pub level: Level,
    /// What finds out whether asking memory ahead is worth it, if it is to be found out.
    pub tuner: Option<&'a PrefetchTuner>,
}

/// A batch that is cast: where rays come from, where answers go, and what it took so far.
pub struct Cast<'a> {
    /// What rays are cast at.
    pub target: Target<'a>,
    /// The rays.
    pub source: RaySource<'a>,
    /// In which order they are cast.
    pub order: RayOrder,
    /// The places for their answers.
    pub answers: Answers<'a>,
    /// What casting them took so far.
    pub work: Work,
    /// The steps of single rays, if somebody wants to know them.
    visits: Option<RefCell<Vec<Visit>>>,
}

impl<'a> Cast<'a> {
    /// A batch that is to be cast.
    pub fn new(target: Target<'a>, source: RaySource<'a>, answers: Answers<'a>) -> Cast<'a> {
        // All hits of a ray are put where they are found, so none may be cast twice.
        let is_once = matches!(answers, Answers::AllHits(_));
        let width = if is_once { 0 } else { source.image_width() };
        let order = RayOrder::new(width, source.len());
        Cast { target, source, order, answers, work: Work::default(), visits: None }
    }

    /// True if every step is recorded.
    #[inline(always)]
    pub(super) fn is_recorded(&self) -> bool {
        self.visits.is_some()
    }

    /// Records that a ray comes to a node or leaf.
    #[cold]
    pub(super) fn record(&self, place: NodeRef, ray: &RayState) {
        if let Some(visits) = &self.visits {
            let t_limit = ray.parameter.t(ray.traversal.limit);
            visits.borrow_mut().push(Visit { place, t_limit });
        }
    }
}

/// What casting took. The counts change while a batch is only looked at.
#[derive(Default)]
pub struct Work {
    nodes: Cell<u64>,
    leaves: Cell<u64>,
    exact: Cell<u64>,
}

impl Work {
    /// Counts nodes that were fetched.
    #[inline(always)]
    pub fn add_nodes(&self, nodes: u32) {
        self.nodes.set(self.nodes.get() + u64::from(nodes));
    }

    /// Counts leaves that were fetched.
    #[inline(always)]
    pub fn add_leaves(&self, leaves: u32) {
        self.leaves.set(self.leaves.get() + u64::from(leaves));
    }

    /// Counts an exact decision.
    pub fn add_exact(&self) {
        self.exact.set(self.exact.get() + 1);
    }

    /// The counts of nodes, of leaves, and of exact decisions.
    pub fn counts(&self) -> [u64; 3] {
        [self.nodes.get(), self.leaves.get(), self.exact.get()]
    }
}

/// A node or leaf that a ray comes to.
#[derive(Clone, Copy, Debug)]
pub struct Visit {
    /// Which node or leaf.
    pub place: NodeRef,
    /// About the t beyond which nothing matters any more.
    pub t_limit: f64,
}

/// The closest hit of a ray, found as in a batch, and every node and leaf that the ray came to on its way
/// there, in order.
pub fn record_visits(target: Target, ray: &Ray) -> (Hit, Vec<Visit>) {
    let mut hits = [Hit::MISS];
    let rays = [*ray];
    let mut batch = Cast::new(target, RaySource::Rows(&rays), Answers::Hits(&mut hits));
    batch.visits = Some(RefCell::default());
    let batch = cast::<ClosestHit>(batch);
    let visits = batch.visits.map(RefCell::into_inner).unwrap_or_default();
    (hits[0], visits)
}
