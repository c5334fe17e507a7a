//! A point as single precision sees it: in the frame of the tree, with bounds of all that was rounded.

use crate::geometry::Vec3;
use crate::numeric::{F32_ROUNDOFF, FRAME_ERROR, UNIT_ROUNDOFF, round_down, round_up};
use crate::tree::Tree;

/// Points farther away than this in the frame are not looked at in single precision: it would leave too many triangles
/// open.
const FARTHEST: f64 = 512.0;

/// Larger than all distances of points in the frame that are no farther away.
const UNBOUNDED: f32 = 2048.0;

/// Error of a frame coordinate in doubles, in terms of itself: a difference. Twice that is taken.
const COORDINATE_ERROR: f64 = 2.0 * UNIT_ROUNDOFF;

/// Error of a frame coordinate that is cut into two single-precision numbers, in terms of itself: that of the double,
/// and the rounding of the second part. Eight times that is taken, which also covers what it adds to the rounding of
/// the first difference with a corner.
const PARTS_ERROR: f64 = 8.0 * F32_ROUNDOFF * F32_ROUNDOFF;

/// Frame coordinates and distances below this count for zero, lest digits are lost in squares.
pub const SMALLEST: f32 = 1e-18;

/// What is the same for all points that are held against a tree.
#[derive(Clone, Copy)]
pub struct CornerErrors(f32);

impl CornerErrors {
    /// How far corners of leaves may be from where they are in the frame.
    pub fn of(tree: &Tree) -> CornerErrors {
        let frame = &tree.frame;
        // Where blocks give the user's corners, they do so by one rounding of these.
        let offset = frame.offset().abs().max_element() * frame.scale();
        let doubles = FRAME_ERROR + 2.0 * UNIT_ROUNDOFF * offset;
        let singles = if tree.leaves.are_exact {
            0.0
        } else {
            F32_ROUNDOFF * f64::from(tree.reach) * (1.0 + f64::from(f32::EPSILON))
        };
        CornerErrors(round_up(doubles + singles))
    }
}

/// A point in the frame.
#[derive(Clone, Copy, Default)]
pub struct PointInFrame {
    /// The largest single-precision coordinates not above.
    pub low: [f32; 3],
    /// The smallest not below.
    pub high: [f32; 3],
    /// The nearest.
    pub near: [f32; 3],
    /// What they leave.
    pub rest: [f32; 3],
    /// Bound on what a distance from a triangle is off by, beside its rounding.
    pub slack: f32,
}

impl PointInFrame {
    /// The point in the frame of a tree; `None` if it is too far away.
    pub fn new(tree: &Tree, errors: CornerErrors, point: Vec3) -> Option<PointInFrame> {
        let place = tree.frame.point(point);
        let reach = place.abs().max_element();
        // What is not a number is not looked at neither.
        (reach < FARTHEST).then_some(())?;
        let mut inside = PointInFrame::default();
        for axis in 0..3 {
            let x = place[axis];
            let error = COORDINATE_ERROR * x.abs() + f64::from(f32::MIN_POSITIVE);
            inside.low[axis] = round_down(x - error);
            inside.high[axis] = round_up(x + error);
            inside.near[axis] = x as f32;
            inside.rest[axis] = (x - f64::from(inside.near[axis])) as f32;
        }
        // A vector is no longer than twice its largest component.
        let off = f64::from(errors.0) + PARTS_ERROR * reach;
        inside.slack = round_up(2.0 * off) + SMALLEST;
        Some(inside)
    }
}

/// A bound of distances in the frame, from a distance of the user's that counts: what is beyond that by less than a
/// rounding is rounded to it.
pub fn bound_in_frame(tree: &Tree, max_distance: f64) -> f32 {
    let bound = max_distance.next_up() * tree.frame.scale() * (1.0 + COORDINATE_ERROR);
    round_up(bound.min(f64::from(UNBOUNDED))) + SMALLEST
}
