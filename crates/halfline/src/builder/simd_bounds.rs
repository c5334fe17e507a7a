//! Boxes in the form in which the union of two of them is a few instructions.

use crate::tree::Bounds;

/// The lower sides of a box, a lane that means nothing, its upper sides negated, and another such
/// lane: a union takes the least of each.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct SimdBounds(pub [f32; 8]);

/// Where upper sides begin.
pub const UPPER: usize = 4;

impl SimdBounds {
    /// The box that holds nothing.
    pub const EMPTY: SimdBounds = SimdBounds([f32::INFINITY; 8]);

    /// The box that holds everything.
    pub const ALL: SimdBounds = SimdBounds([f32::NEG_INFINITY; 8]);

    /// Makes it hold another box as well.
    #[inline(always)]
    pub fn widen(&mut self, other: &SimdBounds) {
        for lane in 0..8 {
            let (a, b) = (self.0[lane], other.0[lane]);
            // A plain comparison and not f32::min: no NaN can occur, and it is one instruction.
            self.0[lane] = if b < a { b } else { a };
        }
    }

    /// What both boxes hold.
    #[inline(always)]
    pub fn intersection(&self, other: &SimdBounds) -> SimdBounds {
        let mut common = *self;
        for lane in 0..8 {
            let (a, b) = (self.0[lane], other.0[lane]);
            common.0[lane] = if b > a { b } else { a };
        }
        common
    }

    /// The point that is twice the centre of the box, as a box.
    #[inline(always)]
    pub fn doubled_center(&self) -> SimdBounds {
        let mut point = *self;
        for lane in 0..UPPER {
            let center = self.0[lane] - self.0[UPPER + lane];
            point.0[lane] = center;
            point.0[UPPER + lane] = -center;
        }
        point
    }

    /// The box as its lowest and its highest corner.
    #[inline(always)]
    pub fn bounds(&self) -> Bounds {
        let [a, b, c, _, x, y, z, _] = self.0;
        Bounds { min: [a, b, c], max: [-x, -y, -z] }
    }

    /// Half the area of the six sides of a box that is not empty; zero for [`SimdBounds::EMPTY`].
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let side = |axis: usize| {
            let side = -(self.0[axis] + self.0[UPPER + axis]);
            // Written so that the sides of the empty box, which are -inf, count as zero.
            if side > 0.0 { side } else { 0.0 }
        };
        let (x, y, z) = (side(0), side(1), side(2));
        x * y + y * z + z * x
    }
}

/// Where some parts of triangles are.
#[derive(Clone, Copy, Debug)]
pub struct PrimitiveBounds {
    /// The box around their boxes.
    pub whole: SimdBounds,
    /// The box around twice the centres of their boxes.
    pub centers: SimdBounds,
}

impl PrimitiveBounds {
    /// Where no triangles are.
    pub const EMPTY: PrimitiveBounds =
        PrimitiveBounds { whole: SimdBounds::EMPTY, centers: SimdBounds::EMPTY };

    /// Adds a box.
    #[inline(always)]
    pub fn add(&mut self, part: &SimdBounds) {
        self.whole.widen(part);
        self.centers.widen(&part.doubled_center());
    }

    /// Adds a box if `condition` holds: without a branch, for conditions that cannot be foreseen.
    #[inline(always)]
    pub fn add_if(&mut self, condition: bool, part: &SimdBounds) {
        let beyond = if condition { 0.0 } else { f32::INFINITY };
        let (mut part, mut center) = (*part, part.doubled_center());
        for lane in 0..8 {
            part.0[lane] += beyond;
            center.0[lane] += beyond;
        }
        self.whole.widen(&part);
        self.centers.widen(&center);
    }

    /// Adds all that another holds.
    #[inline(always)]
    pub fn widen(&mut self, other: &PrimitiveBounds) {
        self.whole.widen(&other.whole);
        self.centers.widen(&other.centers);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: Bounds = Bounds { min: [0.0, -2.0, 5.0], max: [1.0, 3.0, 5.0] };
    const OTHER: Bounds = Bounds { min: [-1.0, -1.0, 4.0], max: [0.5, 4.0, 6.0] };

    fn lanes(Bounds { min: [a, b, c], max: [x, y, z] }: &Bounds) -> SimdBounds {
        SimdBounds([*a, *b, *c, 0.0, -x, -y, -z, 0.0])
    }

    #[test]
    fn a_union_holds_both_boxes_and_an_intersection_what_is_in_both() {
        let mut both = lanes(&ONE);
        both.widen(&lanes(&OTHER));
        assert_eq!(both.bounds(), ONE.union(&OTHER));
        both.widen(&SimdBounds::EMPTY);
        assert_eq!(both.bounds(), ONE.union(&OTHER));
        let common = lanes(&ONE).intersection(&lanes(&OTHER));
        assert_eq!(common.bounds(), ONE.intersection(&OTHER));
        assert_eq!(common.intersection(&SimdBounds::ALL).bounds(), ONE.intersection(&OTHER));
        assert!(SimdBounds::EMPTY.bounds().is_empty());
        for bounds in [ONE, OTHER, Bounds::EMPTY] {
            assert_eq!(lanes(&bounds).half_area(), bounds.half_area());
        }
    }

    #[test]
    fn an_extent_holds_what_was_added_and_nothing_else() {
        let mut extent = PrimitiveBounds::EMPTY;
        extent.add_if(false, &lanes(&ONE));
        assert!(extent.whole.bounds().is_empty() && extent.centers.bounds().is_empty());
        extent.add_if(true, &lanes(&ONE));
        let center = [1.0, 1.0, 10.0];
        assert_eq!(extent.centers.bounds(), Bounds { min: center, max: center });
        extent.add(&lanes(&OTHER));
        assert_eq!(extent.whole.bounds(), ONE.union(&OTHER));
        let centers = Bounds { min: [-0.5, 1.0, 10.0], max: [1.0, 3.0, 10.0] };
        assert_eq!(extent.centers.bounds(), centers);
    }
}
