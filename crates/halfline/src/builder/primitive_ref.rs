//! A triangle, or the part of it that lies in a cell.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::simd_bounds::{PrimitiveBounds, SimdBounds, UPPER};
use crate::geometry::Vec3;
use crate::mesh::Mesh;
use crate::numeric::{Frame, has_edges, is_zero_area};
use crate::simd::{Job, Level, Simd};
use crate::tree::Bounds;

/// The part of a face that lies in a cell, known by its box, as a [`SimdBounds`] has it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(16))]
pub struct PrimitiveRef {
    low: [f32; 3],
    /// The face.
    pub face: u32,
    negated_high: [f32; 3],
    unused: u32,
}

impl PrimitiveRef {
    /// A reference to the part of `face` within `bounds`, which are rounded outwards.
    #[inline(always)]
    pub fn new(face: u32, bounds: Bounds) -> PrimitiveRef {
        let negated_high = [-bounds.max[0], -bounds.max[1], -bounds.max[2]];
        PrimitiveRef { low: bounds.min, face, negated_high, unused: 0 }
    }

    /// The box of the part.
    #[inline(always)]
    pub fn bounds(&self) -> Bounds {
        self.lanes().bounds()
    }

    /// The box of the part, as vector lanes.
    #[inline(always)]
    pub fn lanes(&self) -> SimdBounds {
        let mut lanes: [u32; 8] = bytemuck::cast(*self);
        // A face is no number to compute with: the small ones are denormal.
        lanes[UPPER - 1] = 0;
        SimdBounds(bytemuck::cast(lanes))
    }

    /// From where to where it reaches on an axis.
    #[inline(always)]
    pub fn range(&self, axis: usize) -> (f32, f32) {
        (self.low[axis], -self.negated_high[axis])
    }
}

/// Room for references, each in half a cache line.
pub struct ReferenceBuffer {
    halves: Vec<Half>,
    skipped: usize,
    count: usize,
}

/// Half a reference: memory that needs no more than this alignment comes zeroed from the system, and
/// costs nothing until it is touched.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(16))]
struct Half([u32; 4]);

impl ReferenceBuffer {
    /// Room for `count` references. ReferenceBuffer that stay unused are free.
    pub fn new(count: usize) -> ReferenceBuffer {
        const LINE: usize = 64;
        let mut halves: Vec<Half> =
            bytemuck::allocation::zeroed_vec(2 * count + LINE / size_of::<Half>());
        crate::storage::advise_huge_pages(&mut halves);
        let skipped = halves.as_ptr().align_offset(LINE);
        ReferenceBuffer { halves, skipped, count }
    }

    /// The references, as a slice.
    pub fn as_mut(&mut self) -> &mut [PrimitiveRef] {
        let halves = &mut self.halves[self.skipped..];
        bytemuck::cast_slice_mut(&mut halves[..2 * self.count])
    }
}

/// Where references are.
struct FindExtent<'a>(&'a [PrimitiveRef]);

impl Job for FindExtent<'_> {
    type Output = PrimitiveBounds;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> PrimitiveBounds {
        let mut extent = PrimitiveBounds::EMPTY;
        for reference in self.0 {
            extent.add(&reference.lanes());
        }
        extent
    }
}

/// Where the references are, found by all threads.
pub fn extent_of_all(references: &[PrimitiveRef], level: Level) -> PrimitiveBounds {
    let chunks = references.par_chunks(CHUNK).map(|chunk| level.run(FindExtent(chunk)));
    chunks.reduce(
        || PrimitiveBounds::EMPTY,
        |mut one, other| {
            one.widen(&other);
            one
        },
    )
}

/// Faces that get no reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skipped {
    /// Faces whose three corners lie on one line.
    pub zero_area: usize,
    /// The faces without area whose corners are apart, so that they have edges.
    pub collinear: Vec<u32>,
    /// Faces of which a coordinate is NaN or infinite.
    pub non_finite: usize,
}

impl Skipped {
    /// The corners of a face, or a note of why it gets no reference.
    #[inline]
    pub fn or_corners(&mut self, mesh: &Mesh, face: u32) -> Option<[Vec3; 3]> {
        let corners = mesh.corners(face);
        if !(corners[0].is_finite() && corners[1].is_finite() && corners[2].is_finite()) {
            self.non_finite += 1;
            return None;
        }
        if is_zero_area(corners) {
            self.zero_area += 1;
            if has_edges(corners) {
                self.collinear.push(face);
            }
            return None;
        }
        Some(corners)
    }

    /// How many faces get no reference.
    pub fn count(&self) -> usize {
        self.zero_area + self.non_finite
    }

    /// The faces that get no reference in any of the parts, which are in the order of the faces.
    pub fn all(parts: impl IntoIterator<Item = Skipped>) -> Skipped {
        let mut all = Skipped::default();
        for part in parts {
            all.zero_area += part.zero_area;
            all.non_finite += part.non_finite;
            all.collinear.extend(part.collinear);
        }
        all
    }
}

/// Faces that one task looks at.
pub const CHUNK: usize = 1 << 14;

/// Fills the first slots with a reference for each face that can be hit, in face order. Tells what
/// was left out.
pub fn references_of(mesh: &Mesh, frame: &Frame, slots: &mut [PrimitiveRef]) -> Skipped {
    let slots = &mut slots[..mesh.triangle_count()];
    let fill = |(chunk, target): (usize, &mut [PrimitiveRef])| {
        let mut skipped = Skipped::default();
        let mut kept = 0;
        for i in 0..target.len() {
            let face = (chunk * CHUNK + i) as u32;
            if let Some(corners) = skipped.or_corners(mesh, face) {
                target[kept] = PrimitiveRef::new(face, box_of(frame, corners));
                kept += 1;
            }
        }
        skipped
    };
    let skipped: Vec<Skipped> = slots.par_chunks_mut(CHUNK).enumerate().map(fill).collect();

    // Close the gaps.
    let mut next = 0;
    for (chunk, skipped) in skipped.iter().enumerate() {
        let first = chunk * CHUNK;
        let kept = CHUNK.min(slots.len() - first) - skipped.count();
        if next < first {
            slots.copy_within(first..first + kept, next);
        }
        next += kept;
    }
    Skipped::all(skipped)
}

/// The box of a triangle in the frame, rounded outwards.
#[inline]
pub fn box_of(frame: &Frame, [a, b, c]: [Vec3; 3]) -> Bounds {
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    Bounds {
        min: [frame.lower(min.x, 0), frame.lower(min.y, 1), frame.lower(min.z, 2)],
        max: [frame.upper(max.x, 0), frame.upper(max.y, 1), frame.upper(max.z, 2)],
    }
}
