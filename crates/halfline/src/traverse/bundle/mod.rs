//! Many rays as one, where they are alike.
//!
//! A. Reshetov, A. Soupikov, J. Hurley, "Multi-Level Ray Tracing Algorithm", SIGGRAPH 2005, and
//! I. Wald, "Realtime Ray Tracing and Interactive Global Illumination", 2004: rays from one eye, or to
//! one light, pass through the same nodes. So the children of a node are first held against bounds of
//! all rays, by interval arithmetic, at the cost of two single rays. What is left, and not met by all of
//! them for certain, is held against the rays themselves when its turn comes, eight at a time. In a leaf
//! a beam around the rays passes over most triangles; each of the others is held against eight rays at a
//! time, or each ray against all of them, whatever is less work.
//!
//! Different here: the interval arithmetic is relative to a point near the starts, since inverse
//! directions and starts vary together, and each by itself would give far wider bounds. And a bundle
//! that falls apart goes on as single rays from where it is.

mod leaf;

use std::ops::Range;

use super::cast::{Batch, Cast, Decision, Found, RayState};
use super::leaf_kernel::Beam;
use super::query::{Query, Shortcut};
use super::queue::Memory;
use super::ray_group::{Columns, RayGroup};
use super::wide_ray::World;
use crate::geometry::NO_FACE;
use crate::numeric::projection_axes;
use crate::simd::{LANES, Simd};
use crate::tree::{WideNode, Word, give_up};

/// Groups of eight rays that are looked at together: the rays of a tile of 8 by 8 pixels.
pub const GROUPS: usize = 8;

/// Rays that are looked at together.
pub const RAYS: usize = GROUPS * LANES;

/// A bit for each ray.
pub type Mask = u64;

/// How far rays of a bundle may be apart somewhere in the scene, in terms of its size.
const WIDEST: f32 = 0.1;

/// Steps after which a bundle is looked at, and how many rays must have taken part in each.
const FEW_STEPS: u32 = 12;
const FEW_RAYS: u32 = 4;

/// Single-precision roundings of a position that the interval arithmetic adds to those of a ray.
const INTERVAL_ERROR: f32 = 8.0 * f32::EPSILON;

/// Room for the roundings of a beam, in terms of the coordinates that it is found from.
const BEAM_ERROR: f32 = 8.0 * f32::EPSILON;

/// Beside the number of a lane: all rays that met its node meet its box.
const BY_ALL: u32 = 8;

/// Rays, and what waits for them.
pub struct Bundle<Q> {
    /// The number of the first.
    pub first: usize,
    /// As they were prepared.
    pub groups: [RayGroup; GROUPS],
    /// What they found, by lane: where each of them stops to matter,
    limits: [[f32; LANES]; GROUPS],
    /// where the nearest hit is at least,
    lows: [[f32; LANES]; GROUPS],
    /// which face it is on,
    faces: [[u32; LANES]; GROUPS],
    /// and in which block and lane.
    blocks: [[u32; LANES]; GROUPS],
    triangles: [[u32; LANES]; GROUPS],
    /// What they may need to decide, and which have.
    pub decisions: Vec<Decision<Q>>,
    decided: Mask,
    /// A bit for each whose decision knows its nearest hit.
    told: Mask,
    bounds: [Interval; 3],
    beam: Beam,
    axes: [usize; 3],
    octant: u32,
    /// Beyond this no ray matters.
    limit: f32,
    nears: Vec<f32>,
    words: Vec<u32>,
    /// In which lane of which node the boxes are, and which rays came to that.
    lanes: Vec<u32>,
    nodes: Vec<u32>,
    masks: Vec<Mask>,
    waiting: usize,
}

/// Bounds of the rays along an axis, for `(plane - center) * inverse + base`.
#[derive(Clone, Copy, Default)]
struct Interval {
    center: f32,
    inverse: [f32; 2],
    /// The least and the largest of near sides, and of far ones.
    near: [f32; 2],
    far: [f32; 2],
}

/// The lanes of a group in a mask.
#[inline(always)]
fn lanes_of(mask: Mask, group: usize) -> u32 {
    (mask >> (group * LANES)) as u32 & ALL
}

/// The bits of a group's lanes.
#[inline(always)]
fn bits_of(lanes: u32, group: usize) -> Mask {
    Mask::from(lanes) << (group * LANES)
}

/// The rays of some groups.
#[inline(always)]
fn rays_of(groups: &Range<usize>) -> Mask {
    (Mask::MAX >> (RAYS - groups.len() * LANES)) << (groups.start * LANES)
}

impl<Q: Query + Default> Bundle<Q> {
    /// Room for rays in a tree where so much may wait.
    pub fn new(most_waiting: usize) -> Bundle<Q> {
        let room = most_waiting + 1 + LANES;
        Bundle {
            first: 0,
            groups: std::array::from_fn(|_| RayGroup::none()),
            limits: [[0.0; LANES]; GROUPS],
            lows: [[0.0; LANES]; GROUPS],
            faces: [[NO_FACE; LANES]; GROUPS],
            blocks: [[0; LANES]; GROUPS],
            triangles: [[0; LANES]; GROUPS],
            decisions: (0..RAYS).map(|_| Decision::new()).collect(),
            decided: 0,
            told: 0,
            bounds: [Interval::default(); 3],
            beam: Beam::default(),
            axes: [0, 1, 2],
            octant: 0,
            limit: 0.0,
            nears: vec![0.0; room],
            words: vec![0; room],
            lanes: vec![0; room],
            nodes: vec![0; room],
            masks: vec![0; room],
            waiting: 0,
        }
    }

    /// Hands a ray over to a walk of its own, with what it may need to decide.
    #[inline(always)]
    pub fn hand_over<S: Simd>(
        &mut self,
        simd: S,
        ray: usize,
        state: &mut RayState,
        decision: &mut Decision<Q>,
    ) {
        let (group, lane) = (ray / LANES, ray % LANES);
        self.groups[group].write_rays(simd);
        let (wide, parameter) = self.groups[group].lane(lane);
        state.restart(simd, self.first + ray, wide, parameter);
        state.wide.limit = self.limits[group][lane];
        state.found = self.found(group, lane);
        if self.decided >> ray & 1 == 1 {
            std::mem::swap(decision, &mut self.decisions[ray]);
            decision.is_told = self.told >> ray & 1 == 1;
        }
    }

    #[inline(always)]
    fn found(&self, group: usize, lane: usize) -> Found {
        Found {
            face: self.faces[group][lane],
            low: self.lows[group][lane],
            place: (self.blocks[group][lane], self.triangles[group][lane]),
        }
    }

    /// Copies what waits, the last last, and returns how much.
    pub fn copy_waiting(&self, words: &mut [u32], nears: &mut [f32]) -> usize {
        words[..self.waiting].copy_from_slice(&self.words[..self.waiting]);
        nears[..self.waiting].copy_from_slice(&self.nears[..self.waiting]);
        self.waiting
    }

    /// True if the rays of some groups have the same octant and axis, and are near to each other all the
    /// way. Then their bounds are known.
    #[inline(always)]
    pub fn is_coherent<S: Simd>(&mut self, simd: S, world: &World, part: &Range<usize>) -> bool {
        // No ray misses the scene or was looked at by itself, and none differs in kind.
        let groups = &self.groups[part.clone()];
        let Some(first) = groups.first() else { return false };
        let (octant, last) =
            (first.columns.at(Columns::OCTANT, 0), first.columns.at(Columns::LAST, 0));
        let mut different = 0;
        for group in groups {
            let octants = group.columns.load(simd, Columns::OCTANT);
            let lasts = group.columns.load(simd, Columns::LAST);
            different |= !group.met & ALL | group.single;
            different |= differing(simd, octants, octant) | differing(simd, lasts, last);
        }
        if different != 0 {
            return false;
        }

        // How far do they spread at the ends of the scene?
        let zero = simd.splat(0.0);
        let infinite = simd.splat(f32::INFINITY);
        let reach = simd.splat(world.reach);
        let mut least = [infinite; LANES];
        for group in groups {
            for axis in 0..2 {
                let slope = group.columns.load(simd, Columns::SLOPE + axis);
                let center = group.columns.load(simd, Columns::CENTER + axis);
                let before = simd.neg_mul_add(slope, reach, center);
                let behind = simd.mul_add(slope, reach, center);
                least[4 * axis] = simd.min(before, least[4 * axis]);
                least[4 * axis + 1] = simd.min(simd.sub(zero, before), least[4 * axis + 1]);
                least[4 * axis + 2] = simd.min(behind, least[4 * axis + 2]);
                least[4 * axis + 3] = simd.min(simd.sub(zero, behind), least[4 * axis + 3]);
            }
        }
        let ends = least_of_each(simd, least);
        let mut beam = Beam::default();
        for axis in 0..2 {
            let [low, high] = [ends[4 * axis], -ends[4 * axis + 1]];
            let [low_behind, high_behind] = [ends[4 * axis + 2], -ends[4 * axis + 3]];
            let spreads = [high - low, high_behind - low_behind];
            let widest = WIDEST * world.reach;
            // A spread that is NaN is not below anything.
            let is_narrow = (spreads[0] <= widest) & (spreads[1] <= widest);
            if !is_narrow {
                return false;
            }
            let spread = spreads[0].max(spreads[1]);
            let (before, behind) = ((low + high) * 0.5, (low_behind + high_behind) * 0.5);
            beam.slope[axis] = (behind - before) * 0.5 / world.reach;
            beam.center[axis] = (behind + before) * 0.5;
            let size = world.reach + before.abs() + behind.abs();
            beam.margin[axis] = spread * 0.5 + BEAM_ERROR * size;
        }

        // Bound what meets boxes.
        let mut centers = [0.0; 3];
        for axis in 0..3 {
            let columns = &first.columns;
            centers[axis] = -columns.at(Columns::NEAR + axis, 0) / columns.at(axis, 0);
        }
        let mut sides = [infinite; LANES];
        let mut others = [infinite; LANES];
        let mut inverses = [infinite; LANES];
        for group in groups {
            for axis in 0..3 {
                let center = simd.splat(centers[axis]);
                let inverse = group.columns.load(simd, axis);
                let near = group.columns.load(simd, Columns::NEAR + axis);
                let far = group.columns.load(simd, Columns::FAR + axis);
                let near = simd.mul_add(center, inverse, near);
                let far = simd.mul_add(center, inverse, far);
                sides[axis] = simd.min(near, sides[axis]);
                sides[3 + axis] = simd.min(simd.sub(zero, far), sides[3 + axis]);
                others[axis] = simd.min(simd.sub(zero, near), others[axis]);
                others[3 + axis] = simd.min(far, others[3 + axis]);
                inverses[axis] = simd.min(inverse, inverses[axis]);
                inverses[3 + axis] = simd.min(simd.sub(zero, inverse), inverses[3 + axis]);
            }
            let error = group.columns.load(simd, Columns::ERROR);
            inverses[6] = simd.min(simd.sub(zero, error), inverses[6]);
        }
        let (sides, others) = (least_of_each(simd, sides), least_of_each(simd, others));
        let inverses = least_of_each(simd, inverses);
        for axis in 0..3 {
            let (center, inverse) = (centers[axis], [inverses[axis], -inverses[3 + axis]]);
            let steepest = inverse[0].abs().max(inverse[1].abs());
            let room = INTERVAL_ERROR * (world.reach + center.abs()) * steepest;
            let near = [sides[axis] - room, room - others[axis]];
            let far = [others[3 + axis] - room, room - sides[3 + axis]];
            if !(near[0].is_finite() && far[1].is_finite()) {
                return false;
            }
            self.bounds[axis] = Interval { center, inverse, near, far };
        }
        // The error of an edge function for each unit of distance is no less than that of a corner.
        beam.margin = [beam.margin[0] - inverses[6], beam.margin[1] - inverses[6]];
        self.beam = beam;
        self.axes = projection_axes(first.columns.last(0));
        self.octant = octant.to_bits() & 7;
        true
    }

    /// Puts the children of a node that some ray may meet on the stack.
    #[inline(always)]
    fn push_children<S: Simd>(&mut self, simd: S, nodes: &[WideNode], index: usize, mask: Mask) {
        let node = &nodes[index];
        let mut near = simd.splat(0.0);
        let mut far = simd.splat(self.limit);
        let (mut latest, mut soonest) = (simd.splat(0.0), simd.splat(f32::INFINITY));
        for axis in 0..3 {
            let bounds = &self.bounds[axis];
            let side = (self.octant >> axis & 1) as usize;
            let center = simd.splat(bounds.center);
            let inverse = [simd.splat(bounds.inverse[0]), simd.splat(bounds.inverse[1])];
            let near_sides = simd.sub(simd.load(&node.planes[axis][side]), center);
            let far_sides = simd.sub(simd.load(&node.planes[axis][1 - side]), center);
            let enter = [simd.mul(near_sides, inverse[0]), simd.mul(near_sides, inverse[1])];
            let leave = [simd.mul(far_sides, inverse[0]), simd.mul(far_sides, inverse[1])];
            let enter_first = simd.add(simd.min(enter[0], enter[1]), simd.splat(bounds.near[0]));
            let enter_last = simd.add(simd.max(enter[0], enter[1]), simd.splat(bounds.near[1]));
            let leave_first = simd.add(simd.min(leave[0], leave[1]), simd.splat(bounds.far[0]));
            let leave_last = simd.add(simd.max(leave[0], leave[1]), simd.splat(bounds.far[1]));
            near = simd.max(enter_first, near);
            far = simd.min(leave_last, far);
            latest = simd.max(enter_last, latest);
            soonest = simd.min(leave_first, soonest);
        }
        let by_all = simd.lt(latest, soonest);
        let mut numbers = [0; LANES];
        for lane in 0..LANES {
            numbers[lane] = lane as u32 + (by_all >> lane & 1) * BY_ALL;
        }
        let first = self.waiting;
        let order = node.orders[self.octant as usize];
        let (nears, words) =
            (self.nears[first..].first_chunk_mut(), self.words[first..].first_chunk_mut());
        let (lanes, parents) =
            (self.lanes[first..].first_chunk_mut(), self.nodes[first..].first_chunk_mut::<LANES>());
        let masks = self.masks[first..].first_chunk_mut::<LANES>();
        let (Some(nears), Some(words), Some(lanes), Some(parents), Some(masks)) =
            (nears, words, lanes, parents, masks)
        else {
            unreachable!("the builder bounds what waits")
        };
        simd.compress(near, far, &numbers, order, nears, lanes);
        self.waiting += simd.compress(near, far, &node.words, order, nears, words);
        *parents = [index as u32; LANES];
        *masks = [mask; LANES];
    }

    /// Those of some rays that meet the box in a lane of a node, within their limits.
    #[inline(always)]
    fn meeting<S: Simd>(
        &self,
        simd: S,
        node: &WideNode,
        lane: usize,
        mask: Mask,
        part: &Range<usize>,
    ) -> Mask {
        let mut sides = [[simd.splat(0.0); 2]; 3];
        for axis in 0..3 {
            let side = (self.octant >> axis & 1) as usize;
            sides[axis] = [
                simd.splat(node.planes[axis][side][lane]),
                simd.splat(node.planes[axis][1 - side][lane]),
            ];
        }
        let mut met = 0;
        for group in part.clone() {
            let lanes = lanes_of(mask, group);
            if lanes == 0 {
                continue;
            }
            let columns = &self.groups[group].columns;
            let mut near = simd.splat(0.0);
            let mut far = simd.load(&self.limits[group]);
            for axis in 0..3 {
                let [near_side, far_side] = sides[axis];
                let inverse = columns.load(simd, axis);
                let enter =
                    simd.mul_add(near_side, inverse, columns.load(simd, Columns::NEAR + axis));
                let leave =
                    simd.mul_add(far_side, inverse, columns.load(simd, Columns::FAR + axis));
                near = simd.max(enter, near);
                far = simd.min(leave, far);
            }
            met |= bits_of(!simd.lt(far, near) & lanes, group);
        }
        met
    }

    /// Sets the limit beyond which no ray matters.
    #[inline(always)]
    fn set_limit<S: Simd>(&mut self, simd: S, part: &Range<usize>) {
        let mut largest = simd.splat(0.0);
        for group in part.clone() {
            largest = simd.max(simd.load(&self.limits[group]), largest);
        }
        let mut lanes = [0.0; LANES];
        simd.store(largest, &mut lanes);
        self.limit = lanes[0];
        for lane in 1..LANES {
            self.limit = if lanes[lane] > self.limit { lanes[lane] } else { self.limit };
        }
    }
}

const ALL: u32 = (1 << LANES) - 1;

impl<B: Batch> Cast<'_, B> {
    /// Whether bundles are of any use here.
    #[inline(always)]
    pub fn can_bundle(&self) -> bool {
        B::Query::SHORTCUT != Shortcut::Each && self.tree.wide.root.is_inner()
    }

    /// Prepares up to eight rays. Returns a bit for each that meets the root's box.
    #[inline(always)]
    pub fn prepare_rays<S: Simd>(
        &self,
        simd: S,
        world: &World,
        group: &mut RayGroup,
        numbers: Range<usize>,
    ) -> u32 {
        group.set(simd, &self.batch.lanes(simd, numbers.clone()), world);
        let in_use = (1 << numbers.len()) - 1;
        group.met &= in_use;
        group.single &= in_use;
        let mut single = group.single;
        if single != 0 {
            group.write_rays(simd);
        }
        while single != 0 {
            let lane = single.trailing_zeros() as usize;
            single &= single - 1;
            if !group.set_single(lane, &self.batch.ray(numbers.start + lane), world) {
                group.met &= !(1 << lane);
            }
        }
        group.met
    }

    /// Casts the rays of some groups, which are coherent. Returns a bit for each that is not at its end:
    /// those are to go on with what waits.
    #[inline(always)]
    pub fn cast_bundle<S: Simd>(
        &mut self,
        simd: S,
        memory: Memory,
        bundle: &mut Bundle<B::Query>,
        part: &Range<usize>,
    ) -> Mask {
        let tree = self.tree;
        for group in part.clone() {
            simd.store(
                bundle.groups[group].columns.load(simd, Columns::LIMIT),
                &mut bundle.limits[group],
            );
            bundle.lows[group] = [f32::INFINITY; LANES];
            bundle.faces[group] = [NO_FACE; LANES];
        }
        (bundle.waiting, bundle.told, bundle.decided) = (0, 0, 0);
        bundle.set_limit(simd, part);
        let mut alive = rays_of(part);
        let (mut node, mut mask) = (tree.wide.root.index(), alive);
        let (mut steps, mut taken) = (0, 0);
        let most_steps = tree.most_wide_steps().try_into().unwrap_or(u32::MAX);
        'steps: loop {
            self.work.add_nodes(1);
            bundle.push_children(simd, &tree.wide.nodes, node, mask);
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
                mask = bundle.masks[top] & alive;
                if mask == 0 || bundle.nears[top] > bundle.limit {
                    continue;
                }
                let lane = bundle.lanes[top];
                if lane & BY_ALL == 0 {
                    let parent = &tree.wide.nodes[bundle.nodes[top] as usize];
                    mask = bundle.meeting(simd, parent, lane as usize & 7, mask, part);
                }
                if mask == 0 {
                    continue;
                }
                steps += 1;
                if steps > most_steps {
                    give_up();
                }
                taken += mask.count_ones();
                let word = Word(bundle.words[top]);
                if word.is_inner() {
                    node = word.index();
                    continue 'steps;
                }
                alive &= !self.visit_leaf(simd, bundle, part, word.index(), mask);
            }
        }
        if bundle.waiting == 0 {
            alive = 0;
        }
        self.finish_bundle(simd, bundle, rays_of(part) & !alive);
        alive
    }
}

/// A bit for each number that is not this one.
#[inline(always)]
fn differing<S: Simd>(simd: S, a: S::F32x8, b: f32) -> u32 {
    let b = simd.splat(b);
    simd.lt(a, b) | simd.lt(b, a)
}

/// The least number of each of eight vectors, none of which is NaN.
#[inline(always)]
fn least_of_each<S: Simd>(simd: S, a: [S::F32x8; LANES]) -> [f32; LANES] {
    let columns = simd.transpose(a);
    let mut least = columns[0];
    for column in 1..LANES {
        least = simd.min(columns[column], least);
    }
    let mut lanes = [0.0; LANES];
    simd.store(least, &mut lanes);
    lanes
}
