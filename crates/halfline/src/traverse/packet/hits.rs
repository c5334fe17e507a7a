//! What the rays of a packet have found so far, by octet and lane.

use std::ops::Range;

use super::super::leaf::NearestSoFar;
use super::{Mask, OCTETS};
use crate::geometry::NO_FACE;
use crate::rays::{RayFields, RayOctet};
use crate::simd::{LANES, Simd};

/// The nearest hits so far, and where rays stop to matter.
pub struct PacketHits {
    /// Where each ray stops to matter; below zero for one to which nothing matters any more.
    pub limits: [[f32; LANES]; OCTETS],
    /// Where the nearest hit of each ray is at least.
    pub lows: [[f32; LANES]; OCTETS],
    /// The face of the nearest hit of each ray, or [`NO_FACE`].
    pub faces: [[u32; LANES]; OCTETS],
    /// The index of the block that the face was found in.
    pub blocks: [[u32; LANES]; OCTETS],
    /// The lane of the face in its block.
    pub triangles: [[u32; LANES]; OCTETS],
    /// A bit for each ray about which something was decided exactly.
    pub decided: Mask,
    /// A bit for each ray whose query knows its nearest hit.
    pub query_has_nearest: Mask,
}

impl PacketHits {
    /// Room for the hits of a packet.
    pub fn new() -> PacketHits {
        PacketHits {
            limits: [[0.0; LANES]; OCTETS],
            lows: [[0.0; LANES]; OCTETS],
            faces: [[NO_FACE; LANES]; OCTETS],
            blocks: [[0; LANES]; OCTETS],
            triangles: [[0; LANES]; OCTETS],
            decided: 0,
            query_has_nearest: 0,
        }
    }

    /// Begins with the rays of some octets.
    #[inline(always)]
    pub fn restart<S: Simd>(&mut self, simd: S, octets: &[RayOctet], part: &Range<usize>) {
        for octet in part.clone() {
            let limits = octets[octet].fields.load(simd, RayFields::LIMIT);
            simd.store(limits, &mut self.limits[octet]);
            self.lows[octet] = [f32::INFINITY; LANES];
            self.faces[octet] = [NO_FACE; LANES];
        }
        (self.query_has_nearest, self.decided) = (0, 0);
    }

    /// The nearest hit so far of one ray.
    #[inline(always)]
    pub fn nearest(&self, octet: usize, lane: usize) -> NearestSoFar {
        NearestSoFar {
            face: self.faces[octet][lane],
            low: self.lows[octet][lane],
            slot: (self.blocks[octet][lane], self.triangles[octet][lane]),
        }
    }

    /// Beyond this no ray of some octets matters.
    #[inline(always)]
    pub fn limit<S: Simd>(&self, simd: S, part: &Range<usize>) -> f32 {
        let mut largest = simd.splat(0.0);
        for octet in part.clone() {
            largest = simd.max(simd.load(&self.limits[octet]), largest);
        }
        let mut lanes = [0.0; LANES];
        simd.store(largest, &mut lanes);
        let mut limit = lanes[0];
        for lane in 1..LANES {
            limit = if lanes[lane] > limit { lanes[lane] } else { limit };
        }
        limit
    }
}
