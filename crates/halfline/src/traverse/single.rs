//! One ray through the tree: the plain loop, to be read before `stream.rs` and `packet/`.
//!
//! ```text
//! push the root
//! while there is something on the stack:
//!     pop; pass over what is entered beyond the nearest hit
//!     node: push the children that are met, the nearest last
//!     leaf: hold its triangles against the ray; the query keeps what it needs
//! ```
//!
//! Eight boxes and eight triangles are met at once. The order of a node's children depends on the octant of the
//! direction alone, and is stored with the node, so nothing is sorted. What single precision leaves of a leaf is
//! decided exactly, without the steps in between that batches take (`leaf/decide.rs`); the answers are the same.

use super::cast::Target;
use super::crossing_sum::SignedCrossing;
use super::query::{AllContacts, AnyHit, ClosestHit, Query};
use crate::geometry::{Hit, NO_FACE, Ray};
use crate::intersect::filter_f32::test_leaf;
use crate::numeric::PreparedRay;
use crate::rays::{Parameter, RootFrame, TraversalRay};
use crate::simd::{Job, LANES, Simd};
use crate::tree::{NodeRef, panic_corrupt_tree};

/// What casting rays took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounters {
    /// Nodes of up to eight children that rays came to.
    pub nodes: u32,
    /// Leaves that rays came to.
    pub leaves: u32,
    /// Triangles in those leaves.
    pub triangles: u32,
}

/// What lies on the stack of a walk: references, and lower bounds of where the ray enters them. It needs no
/// clearing between walks, so it is made once for many rays.
struct Stack {
    refs: Vec<u32>,
    entries: Vec<f32>,
}

/// One ray's walk.
struct Walk<'a, Q> {
    target: Target<'a>,
    traversal: TraversalRay,
    parameter: Parameter,
    prepared: &'a PreparedRay,
    query: &'a mut Q,
    stack: &'a mut Stack,
    counters: &'a mut RayCounters,
}

impl<Q: Query> Job for Walk<'_, Q> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Walk { target, mut traversal, parameter, prepared, query, stack, counters } = self;
        let Target { tree, mesh, .. } = target;
        let t_max = prepared.t_max;
        (stack.refs[0], stack.entries[0]) = (tree.root.0, f32::NEG_INFINITY);
        let (mut size, mut steps) = (1, tree.max_steps());
        while size > 0 {
            // Pop what is nearest, unless it lies beyond what matters.
            size -= 1;
            let place = NodeRef(stack.refs[size]);
            if stack.entries[size] > traversal.limit || place == NodeRef::END {
                continue;
            }
            if steps == 0 {
                panic_corrupt_tree();
            }
            steps -= 1;

            // At a node push the children that the ray meets.
            if place.is_node() {
                counters.nodes += 1;
                let entries = stack.entries[size..].first_chunk_mut::<LANES>();
                let refs = stack.refs[size..].first_chunk_mut::<LANES>();
                let (Some(entries), Some(refs)) = (entries, refs) else { panic_corrupt_tree() };
                let node = &tree.nodes[place.index()];
                size += traversal.intersect_children(simd, node, entries, refs);
                continue;
            }

            // At a leaf show the query the triangles that the ray's line meets.
            counters.leaves += 1;
            counters.triangles += tree.faces(place.index()).count() as u32;
            let block = &tree.leaves.blocks[place.index()];
            let mut candidates = test_leaf::<S, true>(simd, &traversal, &block.corners).candidates;
            while candidates != 0 {
                let lane = candidates.trailing_zeros() as usize % LANES;
                candidates &= candidates - 1;
                if block.faces[lane] != NO_FACE {
                    let corners = tree.leaves.corners(mesh, &tree.frame, block, lane);
                    prepared.intersect_line_then(corners, block.faces[lane], query);
                }
            }
            if query.is_done() {
                return;
            }
            traversal.limit = parameter.limit(query.t_max(t_max));
        }
    }
}

/// Casts one ray after another at a scene: [`Scene::caster`](crate::Scene::caster) gives one.
///
/// It holds what a walk through the tree needs besides the tree, so casting allocates and clears
/// nothing; each thread needs one of its own.
pub struct Caster<'scene> {
    target: Target<'scene>,
    stack: Stack,
    all: AllContacts,
}

impl<'scene> Caster<'scene> {
    pub(crate) fn new(target: Target<'scene>) -> Caster<'scene> {
        let room = target.tree.max_stack_size + 1 + LANES;
        let stack = Stack { refs: vec![NodeRef::END.0; room], entries: vec![0.0; room] };
        Caster { target, stack, all: AllContacts::default() }
    }

    /// The hit with the smallest t, of equal ones that with the lowest face index; `None` for a miss.
    pub fn intersect(&mut self, ray: &Ray) -> Option<Hit> {
        self.intersect_counted(ray, &mut RayCounters::default())
    }

    /// [`Caster::intersect`], adding what it took to `counters`.
    pub fn intersect_counted(&mut self, ray: &Ray, counters: &mut RayCounters) -> Option<Hit> {
        let prepared = PreparedRay::new(ray)?;
        let mut query = ClosestHit::<true>::default();
        walk(self.target, ray, &prepared, &mut query, &mut self.stack, counters);
        Some(query.finish(&prepared)).filter(Hit::is_hit)
    }

    /// True if the ray hits anything.
    pub fn occluded(&mut self, ray: &Ray) -> bool {
        let Some(prepared) = PreparedRay::new(ray) else { return false };
        let mut query = AnyHit::<true>::default();
        let counters = &mut RayCounters::default();
        walk(self.target, ray, &prepared, &mut query, &mut self.stack, counters);
        query.found
    }

    /// The crossings of a ray, sorted by face, and whether it starts on the surface.
    pub(crate) fn signed_crossings(&mut self, ray: &Ray) -> (Vec<SignedCrossing>, bool) {
        let mut crossings = Vec::new();
        let Some(prepared) = PreparedRay::new(ray) else { return (crossings, false) };
        let Caster { target, stack, all } = self;
        all.restart();
        walk(*target, ray, &prepared, all, stack, &mut RayCounters::default());
        let corners = |face| target.mesh.corners(face);
        let is_on_surface =
            all.signed_crossings(ray, |certain| corners(certain.face), corners, &mut crossings);
        (crossings, is_on_surface)
    }

    /// Appends all hits to `hits`, sorted by t and then by face; see [`numeric`](crate::numeric).
    pub fn intersect_all(&mut self, ray: &Ray, hits: &mut Vec<Hit>) {
        let Some(prepared) = PreparedRay::new(ray) else { return };
        let Caster { target, stack, all } = self;
        all.restart();
        walk(*target, ray, &prepared, all, stack, &mut RayCounters::default());
        hits.extend_from_slice(all.finish(&prepared, *target));
    }
}

/// Shows `query` the contacts of a ray, which was also `prepared`, until nothing more can matter.
fn walk<Q: Query>(
    target: Target,
    ray: &Ray,
    prepared: &PreparedRay,
    query: &mut Q,
    stack: &mut Stack,
    counters: &mut RayCounters,
) {
    if let Some((traversal, parameter)) = TraversalRay::new(ray, &RootFrame::of(target.tree)) {
        let walk = Walk { target, traversal, parameter, prepared, query, stack, counters };
        target.level.run(walk);
    }
}
