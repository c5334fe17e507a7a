//! The figures of a tree.

use super::{Bounds, NodeRef, Tree};

/// What `halfline info` tells about a tree.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TreeStatistics {
    /// Levels of nodes and leaves below the root.
    pub depth: usize,
    /// Nodes of up to eight children, without the leaves.
    pub nodes: usize,
    /// How often the builder cut space by a plane.
    pub spatial_splits: usize,
    /// How often the builder divided triangles without cutting them.
    pub object_splits: usize,
    /// How many leaves there are.
    pub leaves: usize,
    /// Children of a node, on the average.
    pub children_per_node: f64,
    /// How many leaves hold i triangles, for each i.
    pub leaves_by_size: Vec<usize>,
    /// References to triangles, all leaves together.
    pub references: usize,
    /// References for each triangle that has any.
    pub references_per_triangle: f64,
    /// Expected cost of a line that meets the root's box, by the surface-area heuristic: one for
    /// each node entered, one for each leaf.
    pub sah_cost: f64,
    /// Bytes of the tree, without the mesh.
    pub bytes: usize,
    /// Bytes of the tree for each triangle that has references.
    pub bytes_per_triangle: f64,
}

impl Tree {
    /// Counts through the whole tree. `triangles` is the number of faces of the mesh.
    pub fn statistics(&self, triangles: usize) -> TreeStatistics {
        let mut statistics = TreeStatistics {
            nodes: self.nodes.len(),
            spatial_splits: self.spatial_splits,
            object_splits: self.object_splits,
            references: self.references,
            bytes: self.bytes(),
            ..TreeStatistics::default()
        };
        let root_area = half_area(&self.bounds);
        let (mut steps, mut children) = (0, 0);
        let mut pending = vec![(self.root, self.bounds, 0)];
        while let Some((place, bounds, depth)) = pending.pop() {
            if place == NodeRef::END {
                continue;
            }
            steps += 1;
            if steps > self.max_steps() {
                super::panic_corrupt_tree();
            }
            statistics.depth = statistics.depth.max(depth);
            statistics.sah_cost +=
                if root_area > 0.0 { half_area(&bounds) / root_area } else { 1.0 };
            if place.is_leaf() {
                let count = self.faces(place.index()).count();
                statistics.leaves += 1;
                if statistics.leaves_by_size.len() <= count {
                    statistics.leaves_by_size.resize(count + 1, 0);
                }
                statistics.leaves_by_size[count] += 1;
                continue;
            }
            let node = &self.nodes[place.index()];
            for (lane, child) in node.children().enumerate() {
                children += 1;
                pending.push((child, node.bounds(lane), depth + 1));
            }
        }
        statistics.children_per_node = children as f64 / statistics.nodes.max(1) as f64;
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
