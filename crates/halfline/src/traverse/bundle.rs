//! Sixteen rays as one, where they are alike.
//!
//! A. Reshetov, A. Soupikov, J. Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005, and
//! I. Wald, "Realtime Ray Tracing and Interactive Global Illumination", 2004: rays from one eye, or to
//! one light, pass through the same nodes. So the children of a node are first held against bounds of
//! all sixteen rays, by interval arithmetic, at the cost of two single rays. What is left is, when its
//! turn comes, held against the sixteen themselves; leaves are tested for each ray that meets their box.
//!
//! Different here: the interval arithmetic is relative to a point near the starts, since inverse
//! directions and starts vary together, and each by itself would give far wider bounds. And a bundle
//! that falls apart goes on as single rays from where it is.

use std::ops::Range;

use super::cast::{Batch, Candidates, Cast, Decision, Ended, RayState};
use super::query::{Query, Shortcut};
use super::queue::Memory;
use super::ray_group::{Columns, RayGroup};
use super::wide_ray::World;
use crate::simd::{LANES, Simd};
use crate::tree::{WideNode, Word};

/// Rays in a bundle.
pub const RAYS: usize = 2 * LANES;

/// How far rays of a bundle may be apart somewhere in the scene, in terms of its size.
const WIDEST: f32 = 0.1;

/// Steps after which a bundle is looked at, and how many rays must have taken part in each.
const FEW_STEPS: u32 = 12;
const FEW_RAYS: u32 = 4;

/// Single-precision roundings of a position that the interval arithmetic adds to those of a ray.
const INTERVAL_ERROR: f32 = 8.0 * f32::EPSILON;

/// Each lane.
const NUMBERS: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Sixteen rays, and what waits for them.
pub struct Bundle<Q> {
    /// The number of the first.
    pub first: usize,
    /// As they were prepared.
    pub groups: [RayGroup; 2],
    /// The same by what is needed of them.
    columns: [Columns; 2],
    /// Where each of them stops to matter, or below zero if nothing more can.
    limits: [[f32; LANES]; 2],
    /// On their way.
    pub rays: Vec<RayState>,
    /// And what they may need to decide.
    pub decisions: Vec<Decision<Q>>,
    bounds: [Interval; 3],
    octant: usize,
    nears: Vec<f32>,
    words: Vec<u32>,
    /// In which lane of which node the boxes are.
    lanes: Vec<u32>,
    nodes: Vec<u32>,
    waiting: usize,
}

/// Bounds of sixteen rays along an axis, for `(plane - center) * inverse + base`.
#[derive(Clone, Copy, Default)]
struct Interval {
    center: f32,
    inverse: [f32; 2],
    /// The least of near sides, and the largest of far ones.
    base: [f32; 2],
}

impl<Q: Query + Default> Bundle<Q> {
    /// Room for rays in a tree where so much may wait.
    pub fn new(most_waiting: usize) -> Bundle<Q> {
        let room = most_waiting + 1 + LANES;
        Bundle {
            first: 0,
            groups: [RayGroup::none(), RayGroup::none()],
            columns: [Columns::none(), Columns::none()],
            limits: [[0.0; LANES]; 2],
            rays: vec![RayState::none(); RAYS],
            decisions: (0..RAYS).map(|_| Decision::new()).collect(),
            bounds: [Interval::default(); 3],
            octant: 0,
            nears: vec![0.0; room],
            words: vec![0; room],
            lanes: vec![0; room],
            nodes: vec![0; room],
            waiting: 0,
        }
    }

    /// Copies what waits, the last last, and returns how much.
    pub fn copy_waiting(&self, words: &mut [u32], nears: &mut [f32]) -> usize {
        words[..self.waiting].copy_from_slice(&self.words[..self.waiting]);
        nears[..self.waiting].copy_from_slice(&self.nears[..self.waiting]);
        self.waiting
    }

    /// True if the rays have the same octant and axis, and are near to each other all the way. Then
    /// their bounds are known.
    #[inline(always)]
    pub fn is_coherent<S: Simd>(&mut self, simd: S, world: &World) -> bool {
        // No ray was looked at by itself, and none differs in kind.
        let [a, b] = &self.columns;
        let kind = a.kind(0);
        let mut is_alike = self.groups[0].single | self.groups[1].single == 0;
        for lane in 0..LANES {
            is_alike &= (a.kind(lane) == kind) & (b.kind(lane) == kind);
        }
        if !is_alike {
            return false;
        }

        // How far do they spread at the ends of the scene?
        for axis in 0..2 {
            let [low, high] = bounds(
                simd,
                a.load(simd, Columns::SLOPE + axis),
                b.load(simd, Columns::SLOPE + axis),
            );
            let [left, right] = bounds(
                simd,
                a.load(simd, Columns::CENTER + axis),
                b.load(simd, Columns::CENTER + axis),
            );
            if (high - low) * world.reach + (right - left) > WIDEST * world.reach {
                return false;
            }
        }

        for axis in 0..3 {
            let inverse = [a.load(simd, axis), b.load(simd, axis)];
            let near = [a.load(simd, Columns::NEAR + axis), b.load(simd, Columns::NEAR + axis)];
            let far = [a.load(simd, Columns::FAR + axis), b.load(simd, Columns::FAR + axis)];
            let center = -a.at(Columns::NEAR + axis, 0) / a.at(axis, 0);
            let splat = simd.splat(center);
            let near = bounds(
                simd,
                simd.multiply_add(splat, inverse[0], near[0]),
                simd.multiply_add(splat, inverse[1], near[1]),
            );
            let far = bounds(
                simd,
                simd.multiply_add(splat, inverse[0], far[0]),
                simd.multiply_add(splat, inverse[1], far[1]),
            );
            let inverse = bounds(simd, inverse[0], inverse[1]);
            let steepest = inverse[0].abs().max(inverse[1].abs());
            let room = INTERVAL_ERROR * (world.reach + center.abs()) * steepest;
            let base = [near[0] - room, far[1] + room];
            if !(base[0].is_finite() && base[1].is_finite()) {
                return false;
            }
            self.bounds[axis] = Interval { center, inverse, base };
        }
        self.octant = (a.octant(0) & 7) as usize;
        true
    }

    /// Puts the children of a node that some ray may meet on the stack.
    #[inline(always)]
    fn push_children<S: Simd>(&mut self, simd: S, nodes: &[WideNode], index: usize, limit: f32) {
        let node = &nodes[index];
        let mut near = simd.splat(0.0);
        let mut far = simd.splat(limit);
        for axis in 0..3 {
            let Interval { center, inverse, base } = &self.bounds[axis];
            let side = self.octant >> axis & 1;
            let center = simd.splat(*center);
            let inverse = [simd.splat(inverse[0]), simd.splat(inverse[1])];
            let near_sides = simd.minus(simd.load(&node.planes[axis][side]), center);
            let far_sides = simd.minus(simd.load(&node.planes[axis][1 - side]), center);
            let (low, high) = (simd.splat(base[0]), simd.splat(base[1]));
            let enter = simd.least(
                simd.multiply_add(near_sides, inverse[0], low),
                simd.multiply_add(near_sides, inverse[1], low),
            );
            let leave = simd.largest(
                simd.multiply_add(far_sides, inverse[0], high),
                simd.multiply_add(far_sides, inverse[1], high),
            );
            near = simd.largest(enter, near);
            far = simd.least(leave, far);
        }
        let first = self.waiting;
        let order = node.orders[self.octant];
        let (nears, words) =
            (self.nears[first..].first_chunk_mut(), self.words[first..].first_chunk_mut());
        let (lanes, numbers) =
            (self.lanes[first..].first_chunk_mut(), self.nodes[first..].first_chunk_mut::<LANES>());
        let (Some(nears), Some(words), Some(lanes), Some(numbers)) = (nears, words, lanes, numbers)
        else {
            unreachable!("the builder bounds what waits")
        };
        simd.push(near, far, &NUMBERS, order, nears, lanes);
        self.waiting += simd.push(near, far, &node.words, order, nears, words);
        *numbers = [index as u32; LANES];
    }

    /// A bit for each ray that meets the box in a lane of a node, within its limit.
    #[inline(always)]
    fn meeting<S: Simd>(&self, simd: S, node: &WideNode, lane: usize) -> u32 {
        let mut met = 0;
        for half in 0..2 {
            let columns = &self.columns[half];
            let mut near = simd.splat(0.0);
            let mut far = simd.load(&self.limits[half]);
            for axis in 0..3 {
                let side = self.octant >> axis & 1;
                let inverse = columns.load(simd, axis);
                let near_side = simd.splat(node.planes[axis][side][lane]);
                let far_side = simd.splat(node.planes[axis][1 - side][lane]);
                let enter =
                    simd.multiply_add(near_side, inverse, columns.load(simd, Columns::NEAR + axis));
                let leave =
                    simd.multiply_add(far_side, inverse, columns.load(simd, Columns::FAR + axis));
                near = simd.largest(enter, near);
                far = simd.least(leave, far);
            }
            met |= (!simd.are_below(far, near) & ALL) << (half * LANES);
        }
        met
    }
}

const ALL: u32 = (1 << LANES) - 1;

impl<B: Batch> Cast<'_, B> {
    /// Whether bundles are of any use here.
    #[inline(always)]
    pub fn can_bundle(&self) -> bool {
        B::Query::SHORTCUT != Shortcut::None && self.tree.wide.root.is_inner()
    }

    /// Prepares up to eight rays. Returns a bit for each that meets the root's box.
    #[inline(always)]
    pub fn prepare_rays<S: Simd>(
        &self,
        simd: S,
        world: &World,
        bundle: &mut Bundle<B::Query>,
        half: usize,
        numbers: Range<usize>,
    ) -> u32 {
        let group = &mut bundle.groups[half];
        let lanes = self.batch.lanes(simd, numbers.clone());
        group.set(simd, &lanes, world, &mut bundle.columns[half]);
        let in_use = (1 << numbers.len()) - 1;
        let mut met = group.met & in_use;
        let mut single = group.single & in_use;
        while single != 0 {
            let lane = single.trailing_zeros() as usize;
            single &= single - 1;
            if !group.set_single(lane, &self.batch.ray(numbers.start + lane), world) {
                met &= !(1 << lane);
            }
        }
        met
    }

    /// Casts sixteen rays that are coherent. Returns a bit for each that is not at its end: those are
    /// to go on with what waits.
    #[inline(always)]
    pub fn cast_bundle<S: Simd>(
        &mut self,
        simd: S,
        memory: Memory,
        bundle: &mut Bundle<B::Query>,
        ended: &mut Ended,
    ) -> u32 {
        let tree = self.tree;
        for lane in 0..RAYS {
            let (wide, parameter) = bundle.groups[lane / LANES].lane(lane % LANES);
            bundle.rays[lane].restart(simd, bundle.first + lane, wide, parameter);
            bundle.limits[lane / LANES][lane % LANES] = wide.limit;
        }
        bundle.waiting = 0;
        let mut alive = (1 << RAYS) - 1;
        let mut node = tree.wide.root.index();
        let (mut steps, mut taken) = (0, 0);
        'steps: loop {
            let limits = [simd.load(&bundle.limits[0]), simd.load(&bundle.limits[1])];
            let limit = bounds(simd, limits[0], limits[1])[1];
            bundle.push_children(simd, &tree.wide.nodes, node, limit);
            if bundle.waiting > 0 {
                memory.prefetch(simd, Word(bundle.words[bundle.waiting - 1]));
            }
            if bundle.waiting > 1 {
                memory.prefetch(simd, Word(bundle.words[bundle.waiting - 2]));
            }
            loop {
                if bundle.waiting == 0 || alive == 0 {
                    break 'steps;
                }
                // Give up what too few rays have in common.
                if steps >= FEW_STEPS && taken < FEW_RAYS * steps {
                    break 'steps;
                }
                let top = bundle.waiting - 1;
                bundle.waiting = top;
                let parent = &tree.wide.nodes[bundle.nodes[top] as usize];
                let met = bundle.meeting(simd, parent, bundle.lanes[top] as usize & 7);
                let word = Word(bundle.words[top]);
                if met == 0 {
                    continue;
                }
                steps += 1;
                taken += met.count_ones();
                if word.is_inner() {
                    node = word.index();
                    continue 'steps;
                }
                let block = &tree.leaves.blocks[word.index()];
                let (mut rest, mut candidates) = (met, Candidates::default());
                while rest != 0 {
                    let lane = rest.trailing_zeros() as usize & (RAYS - 1);
                    rest &= rest - 1;
                    let ray = &mut bundle.rays[lane];
                    candidates.find(simd, ray, block);
                    if candidates.open == 0 {
                        continue;
                    }
                    let is_done =
                        self.decide(ray, &mut bundle.decisions[lane], &candidates, word.index());
                    let limit = if is_done { -1.0 } else { ray.wide.limit };
                    bundle.limits[lane / LANES][lane % LANES] = limit;
                    alive &= !(u32::from(is_done) << lane);
                }
            }
        }
        if bundle.waiting == 0 {
            alive = 0;
        }
        for lane in 0..RAYS {
            if alive >> lane & 1 == 0 {
                self.finish(simd, &bundle.rays[lane], &mut bundle.decisions[lane], ended);
            }
        }
        alive
    }
}

/// The least and the largest of sixteen numbers that are not NaN.
#[inline(always)]
fn bounds<S: Simd>(simd: S, a: S::Floats, b: S::Floats) -> [f32; 2] {
    let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
    simd.store(simd.least(a, b), &mut low);
    simd.store(simd.largest(a, b), &mut high);
    let (mut least, mut largest) = (low[0], high[0]);
    for lane in 1..LANES {
        least = if low[lane] < least { low[lane] } else { least };
        largest = if high[lane] > largest { high[lane] } else { largest };
    }
    [least, largest]
}
