//! Boxes in the form in which the union of two of them is a few instructions.

use crate::tree::Bounds;

/// The lower sides of a box, then its upper sides negated, each followed by infinity: a union takes
/// the least of each.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct LaneBox(pub [f32; 8]);

/// Where upper sides begin.
pub const UPPER: usize = 4;

impl LaneBox {
    /// The box that holds nothing.
    pub const EMPTY: LaneBox = LaneBox([f32::INFINITY; 8]);

    /// The same box.
    #[inline(always)]
    pub fn of(bounds: &Bounds) -> LaneBox {
        let Bounds { min: [a, b, c], max: [x, y, z] } = *bounds;
        LaneBox([a, b, c, f32::INFINITY, -x, -y, -z, f32::INFINITY])
    }

    /// Makes it hold another box as well.
    #[inline(always)]
    pub fn widen(&mut self, other: &LaneBox) {
        for lane in 0..8 {
            let (a, b) = (self.0[lane], other.0[lane]);
            // A plain comparison and not f32::min: no NaN can occur, and it is one instruction.
            self.0[lane] = if b < a { b } else { a };
        }
    }

    /// The same box.
    #[inline(always)]
    pub fn bounds(&self) -> Bounds {
        let [a, b, c, _, x, y, z, _] = self.0;
        Bounds { min: [a, b, c], max: [-x, -y, -z] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_union_holds_both_boxes() {
        let one = Bounds { min: [0.0, -2.0, 5.0], max: [1.0, 3.0, 5.0] };
        let other = Bounds { min: [-1.0, -1.0, 4.0], max: [0.5, 4.0, 6.0] };
        let mut both = LaneBox::of(&one);
        both.widen(&LaneBox::of(&other));
        assert_eq!(both.bounds(), one.union(&other));
        both.widen(&LaneBox::EMPTY);
        assert_eq!(both.bounds(), one.union(&other));
        assert!(LaneBox::EMPTY.bounds().is_empty());
    }
}
