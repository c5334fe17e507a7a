//! A triangle, or the part of it that lies in a cell.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::lane_box::LaneBox;
use crate::geometry::Vec3;
use crate::mesh::Mesh;
use crate::numeric::{Frame, has_edges, is_zero_area};
use crate::tree::Bounds;

/// The part of a face that lies in a cell, known by its box.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Reference {
    /// Box of the part, rounded outwards.
    pub bounds: Bounds,
    /// The face.
    pub face: u32,
    unused: u32,
}

impl Reference {
    /// A reference to the part of `face` within `bounds`.
    pub fn new(face: u32, bounds: Bounds) -> Reference {
        Reference { bounds, face, unused: 0 }
    }
}

/// The box around the references.
pub fn bounds_of(references: &[Reference]) -> Bounds {
    let mut all = LaneBox::EMPTY;
    references.iter().for_each(|reference| all.widen(&LaneBox::of(&reference.bounds)));
    all.bounds()
}

/// Faces that get no reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skipped {
    /// The three corners lie on one line.
    pub zero_area: usize,
    /// Those of them whose corners are apart, so that they have edges.
    pub on_line: Vec<u32>,
    /// A coordinate is NaN or infinite.
    pub non_finite: usize,
}

/// Faces that one task looks at.
const CHUNK: usize = 1 << 14;

enum Verdict {
    Keep([Vec3; 3]),
    ZeroArea([Vec3; 3]),
    NonFinite,
}

fn judge(mesh: &Mesh, face: usize) -> Verdict {
    let corners = mesh.corners(face as u32);
    if !corners.into_iter().all(Vec3::is_finite) {
        Verdict::NonFinite
    } else if is_zero_area(corners) {
        Verdict::ZeroArea(corners)
    } else {
        Verdict::Keep(corners)
    }
}

/// A reference for each face that can be hit, in face order, at the start of an array of
/// `slots(kept faces)`; the number of those; and what was left out.
pub fn references_of(
    mesh: &Mesh,
    frame: &Frame,
    slots: impl FnOnce(usize) -> usize,
) -> (Vec<Reference>, usize, Skipped) {
    // Count what each chunk keeps, so that each knows where to write.
    let faces = mesh.triangle_count();
    let chunks = faces.div_ceil(CHUNK);
    let range = |chunk: usize| chunk * CHUNK..((chunk + 1) * CHUNK).min(faces);
    let counts: Vec<Skipped> = (0..chunks)
        .into_par_iter()
        .map(|chunk| {
            let mut skipped = Skipped::default();
            for face in range(chunk) {
                match judge(mesh, face) {
                    Verdict::Keep(_) => {}
                    Verdict::ZeroArea(corners) => {
                        skipped.zero_area += 1;
                        if has_edges(corners) {
                            skipped.on_line.push(face as u32);
                        }
                    }
                    Verdict::NonFinite => skipped.non_finite += 1,
                }
            }
            skipped
        })
        .collect();
    let mut skipped = Skipped::default();
    for chunk in &counts {
        skipped.zero_area += chunk.zero_area;
        skipped.non_finite += chunk.non_finite;
        skipped.on_line.extend_from_slice(&chunk.on_line);
    }
    let kept = faces - skipped.zero_area - skipped.non_finite;

    // Zeroed memory costs nothing until it is touched, so slots that stay unused are free.
    let mut references: Vec<Reference> = bytemuck::allocation::zeroed_vec(slots(kept).max(kept));
    crate::io::advise_huge_pages(&mut references);
    let mut rest = &mut references[..kept];
    let mut targets = Vec::with_capacity(chunks);
    for (chunk, skipped) in counts.iter().enumerate() {
        let keeps = range(chunk).len() - skipped.zero_area - skipped.non_finite;
        let (target, tail) = rest.split_at_mut(keeps);
        targets.push(target);
        rest = tail;
    }
    targets.into_par_iter().enumerate().for_each(|(chunk, target)| {
        let kept = range(chunk).filter_map(|face| match judge(mesh, face) {
            Verdict::Keep(corners) => Some(Reference::new(face as u32, box_of(frame, corners))),
            Verdict::ZeroArea(_) | Verdict::NonFinite => None,
        });
        for (slot, reference) in target.iter_mut().zip(kept) {
            *slot = reference;
        }
    });
    (references, kept, skipped)
}

/// The box of a triangle in the frame, rounded outwards.
fn box_of(frame: &Frame, [a, b, c]: [Vec3; 3]) -> Bounds {
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    Bounds {
        min: [0, 1, 2].map(|axis| frame.lower(min[axis], axis)),
        max: [0, 1, 2].map(|axis| frame.upper(max[axis], axis)),
    }
}
