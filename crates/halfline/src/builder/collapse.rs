//! From the binary tree to nodes of eight children.
//!
//! I. Wald, C. Benthin, S. Boulos, "Getting Rid of Packets", RT 2008, merge nodes greedily; here a
//! dynamic programme finds the best cut (H. Ylitalo, T. Karras, S. Laine, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.2). With A the area of a
//! node's box, entering a node or testing a block costs A, and
//!
//! ```text
//! dist(j) = min over k of cost_left[k] + cost_right[j - k]      at most j roots for what lies below
//! cost[1] = dist(8) + A, of a leaf A                            one root: a node of its own
//! cost[i] = min(cost[i - 1], dist(i))
//! ```

use super::node::{BinaryNode, BinaryNodeKind, Children};
use crate::error::Result;
use crate::progress::Observer;
use crate::simd::LANES;
use crate::storage::Buffer;
use crate::tree::{Node, NodeRef};

/// `[i]`: what it costs to hang what lies below a node under at most `i + 1` roots.
type Costs = [f32; LANES - 1];

/// Binary nodes, leaves included, between two looks at the observer.
const CHECKED: usize = 1 << 14;

/// The tree of nodes of eight children.
pub struct Collapsed {
    /// Where a walk begins.
    pub root: NodeRef,
    /// All nodes, depth first.
    pub nodes: Buffer<Node>,
    /// How many references a walk may have on its stack at one time.
    pub max_stack_size: usize,
}

/// The binary tree and what its nodes cost.
struct Collapse<'a> {
    children: &'a [Children],
    /// For both nodes of each pair.
    costs: Vec<[Costs; 2]>,
}

/// Which part of a node of eight children a part of the binary tree became.
#[derive(Clone, Copy)]
enum Part {
    Lane(u32),
    /// Two parts and the axis along which the first comes before the second.
    Split {
        axis: usize,
        parts: [usize; 2],
    },
}

/// A node of eight children in the making.
#[derive(Default)]
struct Lanes {
    lanes: Vec<BinaryNode>,
    parts: Vec<Part>,
}

/// Collapses a binary tree whose pairs of children come after their parents.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn collapse(
    root: BinaryNode,
    children: &[Children],
    observer: &dyn Observer,
) -> Result<Collapsed> {
    if let BinaryNodeKind::Leaf { first, count } = root.kind() {
        let root = if count == 0 { NodeRef::END } else { NodeRef::leaf(first as usize) };
        return Ok(Collapsed { root, nodes: Buffer::default(), max_stack_size: 0 });
    }

    // Find the costs, children first.
    let mut collapse = Collapse { children, costs: vec![[[0.0; LANES - 1]; 2]; children.len()] };
    for pair in (0..children.len()).rev() {
        if pair % CHECKED == 0 {
            observer.check()?;
        }
        collapse.costs[pair] = children[pair].0.map(|node| collapse.costs_of(&node));
    }

    // Cut nodes from the root on, depth first.
    let mut nodes = Vec::with_capacity(children.len() / 5);
    let mut pending = vec![(root, None)];
    while let Some((node, parent)) = pending.pop() {
        if nodes.len() % CHECKED == 0 {
            observer.check()?;
        }
        let number = nodes.len();
        if let Some((parent, lane)) = parent {
            let parent: &mut Node = &mut nodes[parent];
            parent.refs[lane] = NodeRef::node(number).0;
        }
        let (node, inner) = collapse.node_of(&node);
        nodes.push(node);
        pending.extend(inner.into_iter().rev().map(|(lane, node)| (node, Some((number, lane)))));
    }
    let max_stack_size = max_stack_size(&nodes);

    // Now that their number is known, move them to where huge pages can back all of them.
    let mut moved = Vec::with_capacity(nodes.len());
    crate::storage::advise_huge_pages(moved.spare_capacity_mut());
    moved.append(&mut nodes);
    Ok(Collapsed { root: NodeRef::node(0), nodes: moved.into(), max_stack_size })
}

/// A walk that enters a node leaves all children but one on its stack.
fn max_stack_size(nodes: &[Node]) -> usize {
    let mut sizes = vec![0usize; nodes.len()];
    for (number, node) in nodes.iter().enumerate().rev() {
        let below = node.children().filter(|child| child.is_node());
        let below = below.map(|child| sizes[child.index()]).max().unwrap_or(0);
        sizes[number] = node.children().count() - 1 + below;
    }
    sizes[0]
}

impl Collapse<'_> {
    fn costs_at(&self, children: u32) -> &[Costs; 2] {
        &self.costs[children as usize]
    }

    fn costs_of(&self, node: &BinaryNode) -> Costs {
        let area = node.bounds.half_area();
        let BinaryNodeKind::Inner { children, .. } = node.kind() else { return [area; LANES - 1] };
        let mut costs = [0.0; LANES - 1];
        costs[0] = self.best_division(children, LANES).1 + area;
        for roots in 2..LANES {
            costs[roots - 1] = costs[roots - 2].min(self.best_division(children, roots).1);
        }
        costs
    }

    /// How many of `roots` roots the first of two children should get, and what that costs.
    fn best_division(&self, children: u32, roots: usize) -> (usize, f32) {
        let [first, second] = self.costs_at(children);
        (1..roots)
            .map(|k| (k, first[k - 1] + second[roots - k - 1]))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .expect("there are at least two roots")
    }

    /// The node that a binary node and what is below it become, and its inner children with their lanes, whose
    /// references are still to be set.
    fn node_of(&self, node: &BinaryNode) -> (Node, Vec<(usize, BinaryNode)>) {
        let BinaryNodeKind::Inner { children, split } = node.kind() else {
            unreachable!("not a leaf")
        };
        let mut lanes = Lanes::default();
        let top = self.divide(children, split.axis(), LANES, &mut lanes);
        let mut merged = Node::EMPTY;
        let mut inner = Vec::new();
        for (lane, node) in lanes.lanes.iter().enumerate() {
            let child = match node.kind() {
                BinaryNodeKind::Leaf { first, .. } => NodeRef::leaf(first as usize),
                BinaryNodeKind::Inner { .. } => {
                    inner.push((lane, *node));
                    NodeRef::END
                }
            };
            merged.set(lane, child, &node.bounds);
        }
        for octant in 0..8 {
            merged.orders[octant] = lanes.order(top, octant);
        }
        (merged, inner)
    }

    /// Hangs a pair of children under `roots` lanes, and returns their part.
    fn divide(&self, children: u32, axis: usize, roots: usize, lanes: &mut Lanes) -> usize {
        let (k, _) = self.best_division(children, roots);
        let pair = self.children[children as usize].0;
        let first = self.cut(&pair[0], (children, 0), k, lanes);
        let second = self.cut(&pair[1], (children, 1), roots - k, lanes);
        lanes.parts.push(Part::Split { axis, parts: [first, second] });
        lanes.parts.len() - 1
    }

    /// Hangs a node under at most `roots` lanes, and returns their part.
    fn cut(
        &self,
        node: &BinaryNode,
        place: (u32, usize),
        roots: usize,
        lanes: &mut Lanes,
    ) -> usize {
        // Take the fewest roots that cost no more.
        let costs = &self.costs_at(place.0)[place.1];
        let roots = (1..=roots).find(|r| costs[r - 1] == costs[roots - 1]).unwrap_or(roots);
        match node.kind() {
            BinaryNodeKind::Inner { children, split } if roots > 1 => {
                self.divide(children, split.axis(), roots, lanes)
            }
            _ => {
                lanes.parts.push(Part::Lane(lanes.lanes.len() as u32));
                lanes.lanes.push(*node);
                lanes.parts.len() - 1
            }
        }
    }
}

impl Lanes {
    /// The lanes of a part from the last to the first along rays of an octant, three bits each. What
    /// is beyond them names empty lanes.
    fn order(&self, top: usize, octant: usize) -> u32 {
        let mut order = 0;
        let mut step = 0;
        let mut pending = vec![top];
        while let Some(part) = pending.pop() {
            match self.parts[part] {
                Part::Lane(lane) => {
                    order |= lane << (3 * step);
                    step += 1;
                }
                Part::Split { axis, parts: [first, second] } => {
                    let is_negative = octant >> axis & 1 == 1;
                    let (near, far) = if is_negative { (second, first) } else { (first, second) };
                    // The far one is taken up next, since the order is from the last.
                    pending.extend([near, far]);
                }
            }
        }
        for lane in step..LANES as u32 {
            order |= lane << (3 * lane);
        }
        order
    }
}
