//! The scene frame: where single precision is good enough to find, though not to decide.
//!
//! Boxes and planes of the tree are single precision, in coordinates moved to the scene and scaled
//! by a power of two so that they are near 1: a scene far from the origin, or of any size, loses
//! nothing. Bounds are rounded outwards; what they hold is never lost.

use super::double_double::{UNIT_ROUNDOFF, two_difference};
use crate::geometry::{Aabb, Vec3, vec3};

/// Maps the user's coordinates to the frame: `(x - offset) * scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    offset: Vec3,
    /// A power of two.
    scale: f64,
    /// The inverse of `scale`.
    unit: f64,
}

/// Frame coordinates of the scene are at most this in magnitude.
pub const FRAME_LIMIT: f64 = 4.0;

/// Bound on the error of a frame coordinate that is not rounded outwards: one subtraction.
pub const FRAME_ERROR: f64 = FRAME_LIMIT * UNIT_ROUNDOFF;

impl Frame {
    /// The frame for a scene within `bounds`.
    pub fn around(bounds: &Aabb) -> Frame {
        if bounds.is_empty() {
            return Frame { offset: Vec3::ZERO, scale: 1.0, unit: 1.0 };
        }
        // Half extents cannot overflow.
        let half = bounds.max * 0.5 - bounds.min * 0.5;
        let unit = power_of_two_at_least(half.max_element());

        // Leave coordinates that are near zero as they are, so that they stay exact. Else move by
        // whole units: the difference then needs no more bits than the coordinate had.
        let center = bounds.center();
        let offset = |c: f64| if c.abs() <= unit { 0.0 } else { (c / unit).round() * unit };
        let offset = vec3(offset(center.x), offset(center.y), offset(center.z));
        Frame { offset, scale: 1.0 / unit, unit }
    }

    /// The frame of an offset and a unit, which is a power of two.
    pub fn from_parts(offset: Vec3, unit: f64) -> Frame {
        Frame { offset, scale: 1.0 / unit, unit }
    }

    /// Lengths in the frame are this times those of the user.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The inverse of the scale.
    #[inline(always)]
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// The user's coordinates of the frame's origin.
    #[inline(always)]
    pub fn offset(&self) -> Vec3 {
        self.offset
    }

    /// A point in the frame, each coordinate with a relative error of at most one rounding.
    #[inline]
    pub fn point(&self, p: Vec3) -> Vec3 {
        (p - self.offset) * self.scale
    }

    /// The largest single-precision number not above the frame coordinate of `x`.
    #[inline]
    pub fn lower(&self, x: f64, axis: usize) -> f32 {
        let (difference, error) = two_difference(x, self.offset[axis]);
        let scaled = difference * self.scale;
        let rounded = round_down(scaled);
        if f64::from(rounded) == scaled && error < 0.0 { rounded.next_down() } else { rounded }
    }

    /// The smallest single-precision number not below the frame coordinate of `x`.
    #[inline]
    pub fn upper(&self, x: f64, axis: usize) -> f32 {
        let (difference, error) = two_difference(x, self.offset[axis]);
        let scaled = difference * self.scale;
        let rounded = round_up(scaled);
        if f64::from(rounded) == scaled && error > 0.0 { rounded.next_up() } else { rounded }
    }

    /// The user's coordinate of a plane of the frame, with one rounding.
    #[inline(always)]
    pub fn to_user(&self, coordinate: f32, axis: usize) -> f64 {
        f64::from(coordinate) * self.unit + self.offset[axis]
    }
}

/// The largest single-precision number not above `x`.
#[inline]
pub fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The smallest single-precision number not below `x`.
#[inline]
pub fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// The smallest power of two that is no smaller than `x`; 1 for zero.
fn power_of_two_at_least(x: f64) -> f64 {
    if x == 0.0 {
        return 1.0;
    }
    // Keep well inside of the range in which the power and its inverse are normal numbers.
    let x = x.clamp(f64::MIN_POSITIVE * 4.0, f64::MAX / 8.0);
    let floor = f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000);
    if floor == x { floor } else { floor * 2.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames() -> Vec<(Frame, Aabb)> {
        let boxes = [
            ([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
            ([500_000.0, 5_400_000.0, 12.0], [500_002.0, 5_400_002.0, 14.0]),
            ([1e-30, -2e-30, 0.0], [3e-30, 2e-30, 1e-30]),
            ([-1e30, 1e29, 0.0], [1e30, 2e30, 0.0]),
            ([7.0, 7.0, 7.0], [7.0, 7.0, 7.0]),
            // Less 1, the lower corners round to single precision numbers, from either side.
            ([2f64.powi(-7) + 2f64.powi(-59); 3], [2.0 + 2f64.powi(-7); 3]),
            ([2f64.powi(-7) - 2f64.powi(-59); 3], [2.0 + 2f64.powi(-7); 3]),
        ];
        boxes
            .into_iter()
            .map(|(min, max)| Aabb { min: min.into(), max: max.into() })
            .map(|bounds| (Frame::around(&bounds), bounds))
            .collect()
    }

    #[test]
    fn frame_coordinates_are_near_one() {
        for (frame, bounds) in frames() {
            for corner in [bounds.min, bounds.max] {
                assert!(frame.point(corner).abs().max_element() <= FRAME_LIMIT, "{frame:?}");
            }
        }
    }

    #[test]
    fn bounds_are_rounded_outwards_and_tight() {
        for (frame, bounds) in frames() {
            for (step, axis) in (0..=1000).flat_map(|step| (0..3).map(move |axis| (step, axis))) {
                let share = f64::from(step) / 1000.0;
                let x = bounds.min[axis] * (1.0 - share) + bounds.max[axis] * share;
                let (low, high) = (frame.lower(x, axis), frame.upper(x, axis));
                let (difference, error) = two_difference(x, frame.offset[axis]);
                // The sign of a bound minus the exact coordinate.
                let beyond = |bound: f32| {
                    let d = f64::from(bound) - difference * frame.scale;
                    if d == 0.0 { -error } else { d }
                };
                assert!(beyond(low) <= 0.0 && beyond(high) >= 0.0, "{x} in {frame:?}");
                assert!(high == low || high == low.next_up(), "{x} in {frame:?}: {low} {high}");
            }
        }
    }
}
