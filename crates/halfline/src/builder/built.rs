//! Finished parts of the tree, and how they are put together.

use super::node::{BinaryNode, Children, Split};
use crate::tree::{Bounds, LeafFaces};

/// A finished part of the tree, with indices of its own.
pub enum Built {
    /// What one thread has built.
    Subtree(BinaryNode, Subtree),
    /// Two parts, which were built by themselves.
    Divided { bounds: Bounds, split: Split, parts: Box<[Built; 2]> },
}

/// What lies below a node, with indices of its own.
pub struct Subtree {
    /// Pairs of nodes, depth first.
    pub children: Vec<Children>,
    /// The leaves, depth first.
    pub leaves: Vec<LeafFaces>,
    /// References in all of them.
    pub references: usize,
}

/// How much of each a part of the tree has.
pub struct Counts {
    /// Pairs of siblings.
    pub pairs: usize,
    /// Leaves.
    pub leaves: usize,
    /// References to triangles.
    pub references: usize,
}

impl Built {
    /// How much of each it has.
    pub fn counts(&self) -> Counts {
        match self {
            Built::Subtree(_, Subtree { children, leaves, references }) => {
                Counts { pairs: children.len(), leaves: leaves.len(), references: *references }
            }
            Built::Divided { parts, .. } => {
                let [first, second] = [parts[0].counts(), parts[1].counts()];
                Counts {
                    pairs: 1 + first.pairs + second.pairs,
                    leaves: first.leaves + second.leaves,
                    references: first.references + second.references,
                }
            }
        }
    }

    /// Puts this part into its places in the whole, depth first, and gives its root. Before them
    /// there are so many pairs and leaves.
    pub fn place(
        self,
        all_children: &mut [Children],
        all_leaves: &mut [LeafFaces],
        pairs_before: usize,
        leaves_before: usize,
    ) -> BinaryNode {
        match self {
            Built::Subtree(root, Subtree { children, leaves, .. }) => {
                let moved =
                    |node: BinaryNode| node.moved(pairs_before as u32, leaves_before as u32);
                for (place, Children([first, second])) in all_children.iter_mut().zip(children) {
                    *place = Children([moved(first), moved(second)]);
                }
                all_leaves.copy_from_slice(&leaves);
                moved(root)
            }
            Built::Divided { bounds, split, parts } => {
                let [first, second] = *parts;
                let counts = first.counts();
                let (pair, rest) = all_children.split_at_mut(1);
                let children = rest.split_at_mut(counts.pairs);
                let leaves = all_leaves.split_at_mut(counts.leaves);
                let pairs_before_first = pairs_before + 1;
                let (first, second) = rayon::join(
                    || first.place(children.0, leaves.0, pairs_before_first, leaves_before),
                    || {
                        let pairs_before = pairs_before_first + counts.pairs;
                        second.place(
                            children.1,
                            leaves.1,
                            pairs_before,
                            leaves_before + counts.leaves,
                        )
                    },
                );
                pair[0] = Children([first, second]);
                BinaryNode::inner(bounds, pairs_before as u32, split)
            }
        }
    }
}
