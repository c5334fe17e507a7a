//! One ray's walk through the tree, front to back.
//!
//! V. Havran, "Heuristic Ray Shooting Algorithms", 2000, appendix C (the recursive algorithm with a
//! stack of its own). Different here: nodes know the tight box of what they hold, so both children
//! are clipped by their boxes and not by the plane alone; the plane's axis and the direction's
//! sign still say which child comes first. A hit that lies beyond its cell needs no special case:
//! it lowers t_max, and what is entered beyond that is dropped when it is popped.

use super::leaf_test::LeafTest;
use super::query::Search;
use super::slab::SlabRay;
use crate::geometry::Ray;
use crate::mesh::Mesh;
use crate::numeric::PreparedRay;
use crate::tree::{KdTree, MAX_DEPTH, NodeKind, give_up};

/// What casting rays cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounters {
    /// Tree nodes entered, leaves included.
    pub nodes: u32,
    /// Leaves entered.
    pub leaves: u32,
    /// Triangles tested.
    pub triangles: u32,
}

/// The far children that wait: where they are entered, which pair they are of, and which of it. A
/// walk holds at most one for each level, and the builder bounds the levels. It needs no clearing
/// between walks, so it is made once for many rays.
pub struct Stack([(f64, u32, u8); MAX_DEPTH]);

impl Default for Stack {
    fn default() -> Stack {
        Stack([(0.0, 0, 0); MAX_DEPTH])
    }
}

/// Shows `query` the contacts of a ray, which was also `prepared`, until nothing more can matter.
#[inline]
pub fn walk<T: LeafTest<Q>, Q: Search>(
    tree: &KdTree,
    mesh: &Mesh,
    ray: &Ray,
    prepared: &PreparedRay,
    query: &mut Q,
    stack: &mut Stack,
    counters: &mut RayCounters,
) {
    let slab_ray = SlabRay::new(ray, &tree.frame);
    let mut limit = slab_ray.scale.limit(ray.t_max);
    if slab_ray.entry(&tree.root.bounds, limit) == f64::INFINITY {
        return;
    }

    let test = T::new(ray, tree);
    let stack = &mut stack.0;
    let mut waiting = 0;
    let mut node = &tree.root;
    let mut steps = tree.most_steps();
    loop {
        counters.nodes += 1;
        if steps == 0 {
            give_up();
        }
        steps -= 1;
        match node.kind() {
            NodeKind::Inner { children, split } => {
                // Clip both children; go to the nearer one that is met, and let the other wait.
                let pair = &tree.children[children as usize].0;
                let near = usize::from(slab_ray.is_negative[split.axis()]);
                let near_entry = slab_ray.entry(&pair[near].bounds, limit);
                let far_entry = slab_ray.entry(&pair[1 - near].bounds, limit);
                if near_entry < f64::INFINITY {
                    if far_entry < f64::INFINITY {
                        stack[waiting] = (far_entry, children, 1 - near as u8);
                        waiting += 1;
                    }
                    node = &pair[near];
                    continue;
                }
                if far_entry < f64::INFINITY {
                    node = &pair[1 - near];
                    continue;
                }
            }
            NodeKind::Leaf { first, count } => {
                counters.leaves += 1;
                counters.triangles += count;
                let block = &tree.leaves.blocks[first as usize];
                test.test(tree, mesh, prepared, block, count, query);
                if query.is_done() {
                    return;
                }
                limit = slab_ray.scale.limit(query.t_max(ray.t_max));
            }
        }

        // Take up the nearest child that waits and is still worth a visit.
        loop {
            if waiting == 0 {
                return;
            }
            waiting -= 1;
            let (entry, children, side) = stack[waiting];
            if entry <= limit {
                node = &tree.children[children as usize].0[usize::from(side)];
                break;
            }
        }
    }
}
