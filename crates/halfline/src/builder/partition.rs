//! Moves references to the two sides of a plane, in place.

use super::clip::split_triangle;
use super::primitive_ref::PrimitiveRef;
use super::simd_bounds::PrimitiveBounds;
use crate::geometry::Vec3;
use crate::simd::{Job, Level, Simd};

/// The two sides of a divided cell: references `0..counts[0]` of the slots are on the first, those
/// from `second_start` on, on the second.
#[derive(Clone, Copy, Debug)]
pub struct Sides {
    /// Where the second side's slots begin.
    pub second_start: usize,
    /// Number of references on each side.
    pub counts: [usize; 2],
    /// Where each side is.
    pub extents: [PrimitiveBounds; 2],
}

/// Cuts `slots[..count]` by the plane; the spare slots at the end are shared out between the two
/// sides by their numbers. `corners_of` gives a face's corners in the frame.
///
/// `None`, with nothing changed, if the spare slots cannot hold what the cut adds, or if it leaves
/// a side empty.
pub fn cut(
    slots: &mut [PrimitiveRef],
    count: usize,
    axis: usize,
    plane: f32,
    corners_of: impl Fn(u32) -> [Vec3; 3],
    level: Level,
) -> Option<Sides> {
    // See whether the second references fit.
    let mut all_below = 0;
    let mut all_above = 0;
    for reference in &slots[..count] {
        let (low, high) = reference.range(axis);
        all_below += usize::from(high <= plane);
        all_above += usize::from(high > plane && low >= plane);
    }
    let straddling = count - all_below - all_above;
    if count + straddling > slots.len() || all_above == count || all_below == count {
        return None;
    }

    let SortOut { below, added, extents, .. } = level.run(SortOut {
        slots: &mut *slots,
        count,
        axis,
        plane,
        corners_of,
        below: 0,
        added: count,
        extents: [PrimitiveBounds::EMPTY; 2],
    });

    Some(share_out(slots, below, added, extents))
}

/// The two sides of `slots[..count]`, of which the first `first_count` are on the first: the spare
/// slots are shared out between them by their numbers.
pub fn share_out(
    slots: &mut [PrimitiveRef],
    first_count: usize,
    count: usize,
    extents: [PrimitiveBounds; 2],
) -> Sides {
    let counts = [first_count, count - first_count];
    let spare = slots.len() - count;
    let for_first = (spare as u128 * first_count as u128 / count.max(1) as u128) as usize;
    let second_start = first_count + for_first;
    slots.copy_within(first_count..count, second_start);
    Sides { second_start, counts, extents }
}

/// Brings what is below a plane to the front.
struct SortOut<'a, C> {
    slots: &'a mut [PrimitiveRef],
    count: usize,
    axis: usize,
    plane: f32,
    corners_of: C,
    /// How many are below the plane, and how many there are in all.
    below: usize,
    added: usize,
    extents: [PrimitiveBounds; 2],
}

impl<C: Fn(u32) -> [Vec3; 3]> Job for SortOut<'_, C> {
    type Output = Self;

    #[inline(always)]
    fn run<S: Simd>(mut self, _: S) -> Self {
        let SortOut { axis, plane, count, .. } = self;
        for i in 0..count {
            let mut reference = self.slots[i];
            let (low, high) = reference.range(axis);
            // A box that lies in the plane belongs below.
            let mut is_below = high <= plane;
            if low < plane && plane < high {
                // Of a triangle that straddles the plane the lower part takes its place, and the
                // upper goes behind all others; or takes its place, if there is no lower.
                let face = reference.face;
                let parts =
                    split_triangle((self.corners_of)(face), &reference.bounds(), axis, plane);
                let [below, above] =
                    parts.map(|part| part.map(|part| PrimitiveRef::new(face, part)));
                is_below = below.is_some();
                if let (Some(_), Some(above)) = (below, above) {
                    self.extents[1].add(&above.lanes());
                    self.slots[self.added] = above;
                    self.added += 1;
                }
                // Where nothing is left on either side, its box reached into the cell, and it did
                // not. It stays above, so that the count does.
                reference = below.or(above).unwrap_or_else(|| {
                    let mut bounds = reference.bounds();
                    bounds.min[axis] = plane;
                    PrimitiveRef::new(face, bounds)
                });
            }

            // Which side comes next cannot be foreseen, so nothing depends on it but where the
            // next of those below goes.
            let lanes = reference.lanes();
            self.extents[0].add_if(is_below, &lanes);
            self.extents[1].add_if(!is_below, &lanes);
            self.slots[i] = self.slots[self.below];
            self.slots[self.below] = reference;
            self.below += usize::from(is_below);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vec3;
    use crate::tree::Bounds;

    /// Each face ends on the sides that it reaches into, wherever in the list it comes: also one
    /// whose box straddles the plane but whose part below has left the cell.
    #[test]
    fn faces_go_where_they_reach() {
        let bounds = |low: f32, high: f32| Bounds { min: [low, 0.0, -1.0], max: [high, 0.25, 1.0] };
        let references = [
            PrimitiveRef::new(0, bounds(0.0, 1.0)),
            PrimitiveRef::new(1, bounds(0.0, 0.25)),
            PrimitiveRef::new(2, bounds(0.25, 0.5)),
            PrimitiveRef::new(3, bounds(0.5, 0.75)),
            PrimitiveRef::new(4, bounds(0.75, 1.0)),
            PrimitiveRef::new(5, bounds(0.0, 1.0)),
            PrimitiveRef::new(6, bounds(0.0, 1.0)),
        ];
        let corners_of = |face: u32| match face {
            0 => [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.1, 1.0, 0.1)],
            5 => [vec3(0.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(0.9, 1.0, 0.1)],
            6 => [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.5, 0.25, 1.0)],
            _ => unreachable!("face {face} does not straddle the plane"),
        };
        let orders = (1..7).flat_map(|step| (0..7).map(move |first| (step, first)));
        for ((step, first), level) in
            orders.flat_map(|o| Level::available().into_iter().map(move |l| (o, l)))
        {
            let mut slots = [PrimitiveRef::new(u32::MAX, Bounds::EMPTY); 12];
            for i in 0..7 {
                slots[i] = references[(first + step * i) % 7];
            }
            let sides = cut(&mut slots, 7, 0, 0.5, corners_of, level).expect("there is room");
            let faces = |start: usize, count: usize| {
                let mut faces: Vec<u32> =
                    slots[start..start + count].iter().map(|r| r.face).collect();
                faces.sort_unstable();
                faces
            };
            assert_eq!(faces(0, sides.counts[0]), [1, 2, 5, 6]);
            assert_eq!(faces(sides.second_start, sides.counts[1]), [0, 3, 4, 6]);
            let [below, above] = sides.extents.map(|extent| extent.whole.bounds());
            assert!(below.max[0] <= 0.5 && above.min[0] >= 0.5);
        }
    }
}
