//! One point through the tree: the plain loop.
//!
//! N. Roussopoulos, S. Kelley, F. Vincent, "Nearest Neighbor Queries", SIGMOD 1995: branch and bound by the distance
//! to boxes, the nearest box first.
//!
//! ```text
//! push the root
//! while there is something on the stack:
//!     pop; pass over what is farther than the nearest face so far
//!     node: push the children, the nearest last
//!     leaf: take the faces that are nearer, or as near and lower
//! ```
//!
//! Different here: what is as near as the nearest is looked at too, since the lowest face counts; and distances to
//! boxes err on the near side.

use crate::geometry::{NO_FACE, Vec3};
use crate::numeric::{NearestPart, UNIT_ROUNDOFF};
use crate::traverse::{CancelCheck, Target};
use crate::tree::{BLOCK_SIZE, Bounds, NodeRef, Tree, panic_corrupt_tree};

/// What points are held against.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// The triangles.
    pub target: Target<'a>,
    /// A tree over the faces without area, if there are any: segments and points.
    pub without_area: Option<&'a Tree>,
}

/// Error of the distance to a box in doubles, in terms of itself: half of a difference twice, a product and two sums.
const BOX_ERROR: f64 = 8.0 * UNIT_ROUNDOFF;

/// Error of the distance to a box, in terms of the largest coordinate of the point in the frame: that of its
/// coordinates, one rounding each.
const POINT_ERROR: f64 = 2.0 * UNIT_ROUNDOFF;

/// Distances in the frame below this are taken for zero: scaling may have lost some of their digits.
const SMALLEST: f64 = 1e-30;

/// Lengths below this have squares that are no normal numbers.
const SMALLEST_LENGTH: f64 = 1e-150;

/// Points farther away than this in the frame are held against every leaf.
const FARTHEST: f64 = 1e100;

/// A point and the nearest face so far.
struct Walk<'a> {
    tree: &'a Tree,
    surface: Surface<'a>,
    point: Vec3,
    max_distance: f64,
    nearest: Option<NearestPart>,
}

/// Walks with single points.
pub struct Seeker<'a> {
    surface: Surface<'a>,
    /// What is to be looked at, and its distance in the frame.
    pending: Vec<(NodeRef, f64)>,
}

impl<'a> Seeker<'a> {
    /// For points that are held against a surface.
    pub fn new(surface: Surface<'a>) -> Seeker<'a> {
        Seeker { surface, pending: Vec::new() }
    }

    /// The nearest part of all faces, if nothing of the walk is known.
    pub fn nearest(
        &mut self,
        point: Vec3,
        max_distance: f64,
        cancel: &mut CancelCheck,
    ) -> Option<NearestPart> {
        let Seeker { surface, pending } = self;
        let tree = surface.target.tree;
        let mut walk = Walk { tree, surface: *surface, point, max_distance, nearest: None };
        walk.go(pending, cancel);
        let nearest = walk.nearest;
        self.nearest_given(point, max_distance, nearest, cancel)
    }

    /// The nearest part of all faces, given that of those that have an area.
    #[inline]
    pub fn nearest_given(
        &mut self,
        point: Vec3,
        max_distance: f64,
        nearest: Option<NearestPart>,
        cancel: &mut CancelCheck,
    ) -> Option<NearestPart> {
        let Seeker { surface, pending } = self;
        let Some(tree) = surface.without_area else { return nearest };
        let mut walk = Walk { tree, surface: *surface, point, max_distance, nearest };
        walk.go(pending, cancel);
        walk.nearest
    }
}

/// The square of the distance of a place in the frame from a box, rounded.
#[inline(always)]
fn square_to_box(place: Vec3, bounds: &Bounds) -> f64 {
    let mut square = 0.0;
    for axis in 0..3 {
        let (low, high) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
        let beyond = (low - place[axis]).max(place[axis] - high).max(0.0);
        square += beyond * beyond;
    }
    square
}

/// No point of the box of three corners is nearer than this; not a number where that is not known.
fn distance_to_corners(p: Vec3, [a, b, c]: [Vec3; 3]) -> f64 {
    let before = a.min(b).min(c) - p;
    let behind = p - a.max(b).max(c);
    let distance = before.max(behind).max(Vec3::ZERO).length();
    // Squares of less may have lost their digits, and count for zero.
    distance * (1.0 - BOX_ERROR) - SMALLEST_LENGTH
}

impl Walk<'_> {
    /// The square of the largest computed distance, of a place that far out in the frame, to a box that may matter.
    fn limit(&self, reach: f64) -> f64 {
        // What is beyond the largest distance by less than a rounding is rounded to it.
        let known = self.nearest.map_or(f64::INFINITY, |part| part.high);
        let limit = known.min(self.max_distance.next_up()) * self.tree.frame.scale();
        let limit = (limit + POINT_ERROR * reach) * (1.0 + BOX_ERROR) + SMALLEST;
        limit * limit
    }

    fn go(&mut self, pending: &mut Vec<(NodeRef, f64)>, cancel: &mut CancelCheck) {
        let tree = self.tree;
        let place = tree.frame.point(self.point);
        let reach = place.abs().max_element();
        // Nor is it if that is not a number.
        let is_near = reach < FARTHEST;
        let square_to = |bounds: &Bounds| if is_near { square_to_box(place, bounds) } else { 0.0 };
        let mut limit = self.limit(reach);
        let mut steps = tree.max_steps();
        pending.clear();
        pending.push((tree.root, square_to(&tree.bounds)));
        while let Some((at, square)) = pending.pop() {
            if square > limit || at == NodeRef::END {
                continue;
            }
            if steps == 0 {
                panic_corrupt_tree();
            }
            steps -= 1;
            if at.is_leaf() {
                for face in tree.faces(at.index()) {
                    self.consider(face);
                }
                limit = self.limit(reach);
                cancel.count(BLOCK_SIZE);
                if cancel.is_cancelled() {
                    return;
                }
                continue;
            }
            let node = &tree.nodes[at.index()];
            let first = pending.len();
            for (lane, child) in node.children().enumerate() {
                let square = square_to(&node.bounds(lane));
                if square <= limit {
                    pending.push((child, square));
                }
            }
            pending[first..].sort_by(|one, other| other.1.total_cmp(&one.1));
        }
    }

    /// Takes a face if it is nearer.
    fn consider(&mut self, face: u32) {
        let corners = self.surface.target.mesh.corners(face);
        // As in a tree that was damaged.
        if face == NO_FACE || !corners.into_iter().all(Vec3::is_finite) {
            return;
        }
        if self
            .nearest
            .is_some_and(|nearest| distance_to_corners(self.point, corners) > nearest.high)
        {
            return;
        }
        let part = NearestPart::of(self.point, face, corners);
        if self
            .nearest
            .is_none_or(|nearest| face != nearest.face && part.is_before(self.point, &nearest))
        {
            self.nearest = Some(part);
        }
    }
}
