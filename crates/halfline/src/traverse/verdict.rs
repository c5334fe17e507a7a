//! What single precision knows about a ray and a leaf, for explanations and tests.

use crate::geometry::Ray;
use crate::intersect::filter_f32::test_leaf;
use crate::numeric::UNIT_ROUNDOFF;
use crate::rays::{RayOctet, RayOrder, RaySource, RootFrame, prepare_octets};
use crate::simd::{Job, LANES, Simd};
use crate::tree::{LeafBlock, Tree};

use super::cast::Target;

/// What single precision knows about a ray and the triangles of a leaf.
#[derive(Clone, Copy, Debug)]
pub struct LeafVerdict {
    /// A bit for each triangle that the ray may hit; it hits no other.
    pub candidates: u32,
    /// A bit for each of those that it hits for certain, neither on an edge nor at a corner.
    pub certain: u32,
    /// For each triangle two numbers between which t is if the ray's line meets it.
    pub bounds: [[f64; 2]; LANES],
}

/// Holds a ray against a leaf of a tree, as a batch does. `None` if the ray does not meet the box of all that
/// can be hit.
pub fn leaf_verdict(target: Target, ray: &Ray, block: &LeafBlock) -> Option<LeafVerdict> {
    target.level.run(Judged { tree: target.tree, ray, block })
}

struct Judged<'a> {
    tree: &'a Tree,
    ray: &'a Ray,
    block: &'a LeafBlock,
}

impl Job for Judged<'_> {
    type Output = Option<LeafVerdict>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<LeafVerdict> {
        let mut octets = [RayOctet::none()];
        let rays = [*self.ray];
        let root = RootFrame::of(self.tree);
        let rays = (&RaySource::Rows(&rays), &RayOrder::new(0, 1));
        prepare_octets(simd, &mut octets, rays, 0..1, &root);
        let [mut octet] = octets;
        if octet.met & 1 == 0 {
            return None;
        }
        octet.write_rays(simd);
        let (traversal, parameter) = octet.lane(0);
        let verdict = test_leaf::<S, true>(simd, traversal, &self.block.corners);
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        simd.store(verdict.low, &mut low);
        simd.store(verdict.high, &mut high);
        let mut bounds = [[0.0; 2]; LANES];
        for lane in 0..LANES {
            let [a, b] = [parameter.t(low[lane]), parameter.t(high[lane])];
            let room = 8.0 * UNIT_ROUNDOFF * (a.abs() + b.abs() + parameter.t(0.0).abs());
            let is_known = verdict.has_interval >> lane & 1 == 1 && !(a.is_nan() || b.is_nan());
            let unknown = [f64::NEG_INFINITY, f64::INFINITY];
            bounds[lane] = if is_known { [a - room, b + room] } else { unknown };
        }
        Some(LeafVerdict { candidates: verdict.candidates, certain: verdict.certain, bounds })
    }
}
