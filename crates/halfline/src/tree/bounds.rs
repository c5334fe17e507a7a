//! A box in single-precision frame coordinates.

use bytemuck::{Pod, Zeroable};

/// The points p with `min <= p <= max`, in the scene frame.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Bounds {
    /// Lowest corner.
    pub min: [f32; 3],
    /// Highest corner.
    pub max: [f32; 3],
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Bounds = Bounds { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// True if no point lies within.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.min[axis] > self.max[axis])
    }

    /// The smallest box around both.
    #[inline(always)]
    pub fn union(&self, other: &Bounds) -> Bounds {
        let mut union = *self;
        for axis in 0..3 {
            // Plain comparisons and not f32::min: no NaN can occur, and these are one instruction.
            if other.min[axis] < union.min[axis] {
                union.min[axis] = other.min[axis];
            }
            if other.max[axis] > union.max[axis] {
                union.max[axis] = other.max[axis];
            }
        }
        union
    }

    /// The points that lie in both.
    pub fn intersection(&self, other: &Bounds) -> Bounds {
        let mut common = *self;
        for axis in 0..3 {
            common.min[axis] = common.min[axis].max(other.min[axis]);
            common.max[axis] = common.max[axis].min(other.max[axis]);
        }
        common
    }

    /// Half the area of the six sides; zero if empty.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| (self.max[axis] - self.min[axis]).max(0.0));
        x * y + y * z + z * x
    }
}
