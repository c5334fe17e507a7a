//! Many points under way at once, each on a walk of its own.
//!
//! The walk is that of `single.rs`, and the loop that of the rays (`traverse/stream.rs`): a walk stands still for
//! memory at nearly every step, so 32 points are under way, and each step ends by asking for what the next one needs.
//!
//! ```text
//! NODE  find the distances of eight boxes; push those within the bound, the nearest last; pop; prefetch
//! LEAF  find bounds of the distances of eight triangles; lower the bound, and drop what is beyond it; note those
//!       that may be the nearest; pop; prefetch
//! END   decide among those that are left, exactly; give the slot to the next point
//! ```
//!
//! All bounds of single precision err on the far side, so what is decided in the end holds the nearest face, and all
//! that are as near.

use super::boxes::{push_children, square_of_limit};
use super::candidates::Candidates;
use super::eight_answers::{Found, Waiting};
use super::leaf::distance_bounds;
use super::point_in_frame::{CornerErrors, PointInFrame, bound_in_frame};
use super::questions::{Answers, PointSource};
use super::single::{Seeker, Surface};
use crate::geometry::{ClosestPoint, NO_FACE, Vec3};
use crate::numeric::{NearestPart, round_up};
use crate::rays::ALL;
use crate::simd::{Job, LANES, Simd};
use crate::traverse::{CancelCheck, PrefetchChoice, Prefetcher, SLOTS, Stacks, next_slot};
use crate::tree::{BLOCK_SIZE, NodeRef, Tree, panic_corrupt_tree};

/// Faces that are decided exactly take the time of so many leaves' faces, as counts to the next look at the observer.
const EXACT_FACES: usize = 16;

/// Answers about all points of a chunk.
pub fn answer_all(
    surface: Surface,
    source: PointSource,
    answers: Answers,
    cancel: &mut CancelCheck,
) {
    surface.target.level.run(Stream { surface, source, answers, cancel, visits: None });
}

/// The closest point of one point, found as in a batch, and every node and leaf that its walk comes to, in order: none
/// for a point too far away for single precision, with which the plain loop walks, and none of what has no area.
pub fn record_visits(
    surface: Surface,
    point: Vec3,
    cancel: &mut CancelCheck,
) -> (ClosestPoint, Vec<PointVisit>) {
    let (mut closest, mut visits) = ([ClosestPoint::NONE], Vec::new());
    let points = [point];
    let source = PointSource::rows(&points, f64::INFINITY);
    let (answers, recorded) = (Answers::Rows(&mut closest), Some(&mut visits));
    surface.target.level.run(Stream { surface, source, answers, cancel, visits: recorded });
    (closest[0], visits)
}

/// A node or leaf that a point's walk comes to.
#[derive(Clone, Copy, Debug)]
pub struct PointVisit {
    /// Which node or leaf.
    pub place: NodeRef,
    /// About the distance, in the mesh's units, beyond which nothing matters any more; infinite until a face was met.
    pub limit: f64,
}

/// Records where the points of some slots are.
#[cold]
fn record(
    visits: &mut Vec<PointVisit>,
    tree: &Tree,
    mut slots: u32,
    (places, queries): (&[u32; SLOTS], &[Query; SLOTS]),
) {
    while let Some(slot) = next_slot(&mut slots) {
        let bound = queries[slot].bound;
        let limit = match bound < bound_in_frame(tree, f64::INFINITY) {
            true => f64::from(bound) * tree.frame.unit(),
            false => f64::INFINITY,
        };
        visits.push(PointVisit { place: NodeRef(places[slot]), limit });
    }
}

/// A chunk of points.
struct Stream<'a, 'b, 'c> {
    surface: Surface<'a>,
    source: PointSource<'a>,
    answers: Answers<'a>,
    cancel: &'b mut CancelCheck<'c>,
    /// The steps of a single point, if somebody wants to know them.
    visits: Option<&'b mut Vec<PointVisit>>,
}

/// A point under way.
#[derive(Clone, Copy)]
struct Query {
    inside: PointInFrame,
    /// What is farther away in the frame is not the nearest.
    bound: f32,
    /// The square of that, for boxes.
    limit: f32,
    /// Steps that the walk may still take.
    steps: usize,
    number: usize,
    point: Vec3,
    max_distance: f64,
    /// The nearest of those that were decided on the way.
    nearest: Option<NearestPart>,
}

/// The number of a slot that has no point.
const NOBODY: usize = usize::MAX;

impl Job for Stream<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Stream { surface, source, mut answers, cancel, mut visits } = self;
        let tree = surface.target.tree;
        let errors = CornerErrors::of(tree);
        let mut stacks = Stacks::new(tree.max_stack_size);
        let mut candidates = Candidates::new();
        let nobody = Query {
            inside: PointInFrame::default(),
            bound: 0.0,
            limit: 0.0,
            steps: 0,
            number: NOBODY,
            point: Vec3::ZERO,
            max_distance: 0.0,
            nearest: None,
        };
        let mut queries = [nobody; SLOTS];
        let mut places = [NodeRef::END.0; SLOTS];
        let mut seeker = Seeker::new(surface);
        let [(_, is_on), _] = PrefetchChoice::of(tree, None).parts(0);
        let prefetcher = Prefetcher::of(tree, is_on);
        let mut waiting = Waiting::default();
        let (mut next, count) = (0, answers.len());
        loop {
            // Divide the slots by what is next.
            let nodes = simd.lt_u32(&places, NodeRef::FIRST_LEAF);
            let leaves = simd.lt_u32(&places, NodeRef::END.0) & !nodes;
            let done = simd.lt_u32(&places, NodeRef::IDLE.0) & !(nodes | leaves);
            if (nodes | leaves | done == 0) | cancel.is_cancelled() {
                break;
            }
            cancel.count(leaves.count_ones() as usize * BLOCK_SIZE);
            if let Some(visits) = &mut visits {
                record(visits, tree, nodes | leaves, (&places, &queries));
            }

            // Let every point at a node take a step.
            let mut rest = nodes;
            while let Some(slot) = next_slot(&mut rest) {
                let node = &tree.nodes[NodeRef(places[slot]).index()];
                let (squares, refs) = stacks.free(slot);
                let Query { inside, limit, steps, .. } = &mut queries[slot];
                if *steps == 0 {
                    panic_corrupt_tree();
                }
                *steps -= 1;
                let pushed = push_children(simd, inside, *limit, node, squares, refs);
                places[slot] = stacks.pop_after(slot, pushed);
                prefetcher.prefetch(simd, NodeRef(places[slot]));
            }

            // Let every point at a leaf meet its triangles.
            let mut rest = leaves;
            while let Some(slot) = next_slot(&mut rest) {
                let number = NodeRef(places[slot]).index();
                let block = &tree.leaves.blocks[number];
                let query = &mut queries[slot];
                if query.steps == 0 {
                    panic_corrupt_tree();
                }
                query.steps -= 1;
                let [low, high] = distance_bounds(simd, &query.inside, block);
                let empty = simd.eq_u32(&block.faces, NO_FACE);
                // Most leaves hold nothing that is near enough. What is not a number is.
                if !simd.lt(simd.splat(query.bound), low) & !empty & ALL != 0 {
                    let mut highs = [0.0; LANES];
                    simd.store(high, &mut highs);
                    // Empty lanes repeat a triangle.
                    let mut bound = query.bound;
                    for high in highs {
                        bound = if high < bound { high } else { bound };
                    }
                    if bound < query.bound {
                        (query.bound, query.limit) = (bound, square_of_limit(bound));
                        stacks.drop_beyond(simd, slot, query.limit);
                        candidates.drop_beyond(simd, slot, bound);
                    }
                    let low = simd.select(empty, simd.splat(f32::INFINITY), low);
                    candidates.take(simd, slot, number, low, bound);
                    if candidates.are_many(slot) {
                        decide(&surface, query, (&mut candidates, slot), cancel);
                        stacks.drop_beyond(simd, slot, query.limit);
                    }
                }
                places[slot] = stacks.pop_after(slot, 0);
                prefetcher.prefetch(simd, NodeRef(places[slot]));
            }

            // Answer those that came to an end, and let others begin.
            let mut rest = done;
            while let Some(slot) = next_slot(&mut rest) {
                let query = &mut queries[slot];
                if query.number != NOBODY {
                    candidates.drop_beyond(simd, slot, query.bound);
                    decide(&surface, query, (&mut candidates, slot), cancel);
                    let Query { point, max_distance, nearest, .. } = *query;
                    let nearest = seeker.nearest_given(point, max_distance, nearest, cancel);
                    match nearest {
                        Some(part) => {
                            let found = Found { number: query.number, point, max_distance, part };
                            waiting.push(simd, found, &mut answers);
                        }
                        None => answers.put(query.number, &ClosestPoint::NONE),
                    }
                    query.number = NOBODY;
                }
                places[slot] = NodeRef::IDLE.0;
                while next < count {
                    let number = next;
                    next += 1;
                    let Some((point, max_distance)) = source.at(number) else {
                        answers.put(number, &ClosestPoint::NONE);
                        continue;
                    };
                    let Some(inside) = PointInFrame::new(tree, errors, point) else {
                        match seeker.nearest(point, max_distance, cancel) {
                            Some(part) => {
                                let found = Found { number, point, max_distance, part };
                                waiting.push(simd, found, &mut answers);
                            }
                            None => answers.put(number, &ClosestPoint::NONE),
                        }
                        continue;
                    };
                    let bound = bound_in_frame(tree, max_distance);
                    let (limit, steps) = (square_of_limit(bound), tree.max_steps());
                    *query = Query {
                        inside,
                        bound,
                        limit,
                        steps,
                        number,
                        point,
                        max_distance,
                        nearest: None,
                    };
                    candidates.clear(slot);
                    stacks.restart(slot, 0);
                    places[slot] = tree.root.0;
                    break;
                }
            }
        }
        waiting.flush(&mut answers);
    }
}

/// Finds the nearest among the candidates of a slot, which become none.
#[inline(never)]
fn decide(
    surface: &Surface,
    query: &mut Query,
    (candidates, slot): (&mut Candidates, usize),
    cancel: &mut CancelCheck,
) {
    let (tree, mesh) = (surface.target.tree, surface.target.mesh);
    let count = candidates.count(slot);
    cancel.count(count * EXACT_FACES);
    for number in 0..count {
        let (block, lane, _) = candidates.at(slot, number);
        let block = &tree.leaves.blocks[block];
        let corners = tree.leaves.corners(mesh, &tree.frame, block, lane);
        let face = block.faces[lane];
        if face == NO_FACE || !corners.iter().all(|corner| corner.is_finite()) {
            continue;
        }
        let part = NearestPart::of(query.point, face, corners);
        let is_nearer =
            |nearest: NearestPart| face != nearest.face && part.is_before(query.point, &nearest);
        if query.nearest.is_none_or(is_nearer) {
            query.nearest = Some(part);
            let high = part.high * tree.frame.scale() * (1.0 + f64::EPSILON);
            let bound = round_up(high.min(f64::from(f32::MAX))) + f32::MIN_POSITIVE;
            if bound < query.bound {
                (query.bound, query.limit) = (bound, square_of_limit(bound));
            }
        }
    }
    candidates.clear(slot);
}
