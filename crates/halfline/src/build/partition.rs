//! Moves references to the two sides of a plane, in place.

use super::clip::split_triangle;
use super::reference::Reference;
use crate::geometry::Vec3;
use crate::tree::Bounds;

/// The two sides after a cut: references `0..counts[0]` of the slots lie below the plane, those
/// from `second_start` on above it.
#[derive(Clone, Copy, Debug)]
pub struct Sides {
    /// Where the second side's slots begin.
    pub second_start: usize,
    /// Number of references on each side.
    pub counts: [usize; 2],
    /// The tight box of each side.
    pub bounds: [Bounds; 2],
}

/// Cuts `slots[..count]` by the plane; the spare slots at the end are shared out between the two
/// sides by their numbers. `corners_of` gives a face's corners in the frame.
///
/// `None`, with nothing changed, if the spare slots cannot hold what the cut adds, or if it leaves
/// a side empty.
pub fn cut(
    slots: &mut [Reference],
    count: usize,
    axis: usize,
    plane: f32,
    corners_of: impl Fn(u32) -> [Vec3; 3],
) -> Option<Sides> {
    // See whether the second references fit.
    let straddles = |b: &Bounds| b.min[axis] < plane && plane < b.max[axis];
    let straddling = slots[..count].iter().filter(|r| straddles(&r.bounds)).count();
    if count + straddling > slots.len() {
        return None;
    }
    let whole_below = slots[..count].iter().filter(|r| r.bounds.max[axis] <= plane).count();
    let whole_above = count - straddling - whole_below;
    if whole_below + straddling == 0 || whole_above + straddling == 0 {
        return None;
    }

    // Sort out: below the plane to the front, above it to the back. Of a triangle that straddles
    // the plane the lower part takes its place, and the upper goes behind all others. A box that
    // lies in the plane belongs below.
    let mut bounds = [Bounds::EMPTY; 2];
    let (mut next, mut end, mut added) = (0, count, count);
    while next < end {
        let reference = slots[next];
        if reference.bounds.max[axis] <= plane {
            bounds[0] = bounds[0].union(&reference.bounds);
            next += 1;
            continue;
        }
        if straddles(&reference.bounds) {
            let face = reference.face;
            let [below, above] = split_triangle(corners_of(face), &reference.bounds, axis, plane);
            if let Some(above) = above {
                bounds[1] = bounds[1].union(&above);
                slots[added] = Reference::new(face, above);
                added += 1;
            }
            if let Some(below) = below {
                bounds[0] = bounds[0].union(&below);
                slots[next] = Reference::new(face, below);
                next += 1;
            } else {
                // Nothing of it is left here: close the gap with the last that is not sorted yet,
                // and that gap with the last of all.
                end -= 1;
                slots[next] = slots[end];
                added -= 1;
                slots[end] = slots[added];
            }
            continue;
        }
        bounds[1] = bounds[1].union(&reference.bounds);
        end -= 1;
        slots.swap(next, end);
    }

    // Share out the spare slots and move the upper side behind those of the lower.
    let counts = [next, added - next];
    let spare = slots.len() - added;
    let for_below = (spare as u128 * counts[0] as u128 / added.max(1) as u128) as usize;
    let second_start = counts[0] + for_below;
    slots.copy_within(next..added, second_start);
    Some(Sides { second_start, counts, bounds })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vec3;

    /// Each face ends on the sides that it reaches into, wherever in the list it comes: also one
    /// whose box straddles the plane but whose part below has left the cell.
    #[test]
    fn faces_go_where_they_reach() {
        let bounds = |low: f32, high: f32| Bounds { min: [low, 0.0, -1.0], max: [high, 0.25, 1.0] };
        let references = [
            Reference::new(0, bounds(0.0, 1.0)),
            Reference::new(1, bounds(0.0, 0.25)),
            Reference::new(2, bounds(0.25, 0.5)),
            Reference::new(3, bounds(0.5, 0.75)),
            Reference::new(4, bounds(0.75, 1.0)),
            Reference::new(5, bounds(0.0, 1.0)),
            Reference::new(6, bounds(0.0, 1.0)),
        ];
        let corners_of = |face: u32| match face {
            0 => [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.1, 1.0, 0.1)],
            5 => [vec3(0.0, 0.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(0.9, 1.0, 0.1)],
            6 => [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.5, 0.25, 1.0)],
            _ => unreachable!("face {face} does not straddle the plane"),
        };
        for (step, first) in (1..7).flat_map(|step| (0..7).map(move |first| (step, first))) {
            let mut slots = [Reference::new(u32::MAX, Bounds::EMPTY); 12];
            for i in 0..7 {
                slots[i] = references[(first + step * i) % 7];
            }
            let sides = cut(&mut slots, 7, 0, 0.5, corners_of).expect("there is room");
            let faces = |start: usize, count: usize| {
                let mut faces: Vec<u32> =
                    slots[start..start + count].iter().map(|r| r.face).collect();
                faces.sort_unstable();
                faces
            };
            assert_eq!(faces(0, sides.counts[0]), [1, 2, 5, 6]);
            assert_eq!(faces(sides.second_start, sides.counts[1]), [0, 3, 4, 6]);
            assert!(sides.bounds[0].max[0] <= 0.5 && sides.bounds[1].min[0] >= 0.5);
        }
    }
}
