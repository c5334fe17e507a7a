//! The figures of a tree.

use super::{BLOCK_SIZE, Bounds, Children, KdTree, Node, NodeKind, Split};

/// What `halfline info` tells about a tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TreeStatistics {
    /// Levels below the root.
    pub depth: usize,
    /// Nodes, leaves included.
    pub nodes: usize,
    /// Inner nodes that cut space by a plane.
    pub plane_nodes: usize,
    /// Inner nodes that divide triangles into groups.
    pub group_nodes: usize,
    /// Leaves.
    pub leaves: usize,
    /// Leaves without a triangle.
    pub empty_leaves: usize,
    /// How many leaves hold i triangles, for each i.
    pub leaves_by_size: Vec<usize>,
    /// References to triangles, all leaves together.
    pub references: usize,
    /// References for each triangle that has any.
    pub references_per_triangle: f64,
    /// Expected cost of a line that meets the root's box, by the surface-area heuristic: one for
    /// each inner node entered, one for each block of triangles tested.
    pub sah_cost: f64,
    /// Bytes of the tree, without the mesh.
    pub bytes: usize,
    /// The same for each triangle that has references.
    pub bytes_per_triangle: f64,
}

impl KdTree {
    /// Counts through the whole tree. `triangles` is the number of faces of the mesh.
    pub fn statistics(&self, triangles: usize) -> TreeStatistics {
        let mut statistics = TreeStatistics {
            references: self.references,
            bytes: self.bytes(),
            ..TreeStatistics::default()
        };
        let root_area = half_area(&self.root.bounds);
        let mut pending: Vec<(Node, usize)> = vec![(self.root, 0)];
        while let Some((node, depth)) = pending.pop() {
            statistics.nodes += 1;
            if statistics.nodes > self.most_steps() {
                super::give_up();
            }
            statistics.depth = statistics.depth.max(depth);
            let probability =
                if root_area > 0.0 { half_area(&node.bounds) / root_area } else { 1.0 };
            match node.kind() {
                NodeKind::Leaf { count, .. } => {
                    // More would be damage.
                    let count = (count as usize).min(BLOCK_SIZE);
                    statistics.leaves += 1;
                    statistics.empty_leaves += usize::from(count == 0);
                    if statistics.leaves_by_size.len() <= count {
                        statistics.leaves_by_size.resize(count + 1, 0);
                    }
                    statistics.leaves_by_size[count] += 1;
                    statistics.sah_cost += probability * count.div_ceil(BLOCK_SIZE) as f64;
                }
                NodeKind::Inner { children, split } => {
                    match split {
                        Split::Plane { .. } => statistics.plane_nodes += 1,
                        Split::Groups { .. } => statistics.group_nodes += 1,
                    }
                    statistics.sah_cost += probability;
                    let Children([first, second]) = self.children[children as usize];
                    pending.push((second, depth + 1));
                    pending.push((first, depth + 1));
                }
            }
        }
        let kept = triangles.saturating_sub(self.skipped_zero_area + self.skipped_non_finite);
        if kept > 0 {
            statistics.references_per_triangle = statistics.references as f64 / kept as f64;
            statistics.bytes_per_triangle = statistics.bytes as f64 / kept as f64;
        }
        statistics
    }
}

/// Half the surface of a box, in double precision: sums over millions of nodes stay exact enough.
fn half_area(bounds: &Bounds) -> f64 {
    let [x, y, z] =
        [0, 1, 2].map(|axis| (f64::from(bounds.max[axis]) - f64::from(bounds.min[axis])).max(0.0));
    x * y + y * z + z * x
}
