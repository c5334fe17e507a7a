//! From the binary tree to nodes of eight children.
//!
//! I. Wald, C. Benthin, S. Boulos, "Getting Rid of Packets", RT 2008, merge nodes greedily; here a
//! dynamic programme finds the best cut (H. Ylitalo, T. Karras, S. Laine, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.2). With A the area of a
//! node's box, entering a node or testing a block costs A, and
//!
//! ```text
//! dist(j) = min over k of cost_left[k] + cost_right[j - k]      at most j roots for what lies below
//! cost[1] = dist(8) + A, of a leaf A                            one root: a wide node of its own
//! cost[i] = min(cost[i - 1], dist(i))
//! ```

use crate::error::Result;
use crate::map::Buffer;
use crate::progress::Observer;
use crate::simd::LANES;
use crate::tree::{Children, Node, NodeKind, WideNode, WideTree, Word};

/// `[i]`: what it costs to hang what lies below a node under at most `i + 1` roots.
type Costs = [f32; LANES - 1];

/// Binary nodes, leaves included, between two looks at the observer.
const CHECKED: usize = 1 << 14;

/// The binary tree and what its nodes cost.
struct Collapse<'a> {
    children: &'a [Children],
    /// For both nodes of each pair.
    costs: Vec<[Costs; 2]>,
}

/// Which part of a wide node a part of the binary tree became.
#[derive(Clone, Copy)]
enum Part {
    Lane(u32),
    /// Two parts and the axis along which the first comes before the second.
    Split {
        axis: usize,
        parts: [usize; 2],
    },
}

/// A wide node in the making.
#[derive(Default)]
struct Lanes {
    lanes: Vec<Node>,
    parts: Vec<Part>,
}

/// Collapses a binary tree whose pairs of children come after their parents.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn collapse(root: Node, children: &[Children], observer: &dyn Observer) -> Result<WideTree> {
    let NodeKind::Inner { .. } = root.kind() else {
        let NodeKind::Leaf { first, count } = root.kind() else { unreachable!("two kinds") };
        let root = if count == 0 { Word::END } else { Word::leaf(first) };
        return Ok(WideTree { root, nodes: Buffer::default(), most_waiting: 0 });
    };

    // Find the costs, children first.
    let mut collapse = Collapse { children, costs: vec![[[0.0; LANES - 1]; 2]; children.len()] };
    for pair in (0..children.len()).rev() {
        if pair % CHECKED == 0 {
            observer.check()?;
        }
        collapse.costs[pair] = children[pair].0.map(|node| collapse.costs_of(&node));
    }

    // Cut wide nodes from the root on, depth first.
    let mut nodes = Vec::with_capacity(children.len() / 5);
    let mut pending = vec![(root, None)];
    while let Some((node, parent)) = pending.pop() {
        if nodes.len() % CHECKED == 0 {
            observer.check()?;
        }
        let number = nodes.len();
        if let Some((parent, lane)) = parent {
            let parent: &mut WideNode = &mut nodes[parent];
            parent.words[lane] = Word::inner(number).0;
        }
        let (wide, inner) = collapse.wide_node(&node);
        nodes.push(wide);
        pending.extend(inner.into_iter().rev().map(|(lane, node)| (node, Some((number, lane)))));
    }
    let most_waiting = most_waiting(&nodes);

    // Now that their number is known, move them to where huge pages can back all of them.
    let mut moved = Vec::with_capacity(nodes.len());
    crate::map::advise_huge_pages(moved.spare_capacity_mut());
    moved.append(&mut nodes);
    Ok(WideTree { root: Word::inner(0), nodes: moved.into(), most_waiting })
}

/// A walk that enters a node leaves all children but one waiting.
fn most_waiting(nodes: &[WideNode]) -> usize {
    let mut waiting = vec![0usize; nodes.len()];
    for (number, node) in nodes.iter().enumerate().rev() {
        let below = node.children().filter(|word| word.is_inner());
        let below = below.map(|word| waiting[word.index()]).max().unwrap_or(0);
        waiting[number] = node.children().count() - 1 + below;
    }
    waiting[0]
}

impl Collapse<'_> {
    fn costs_at(&self, children: u32) -> &[Costs; 2] {
        &self.costs[children as usize]
    }

    fn costs_of(&self, node: &Node) -> Costs {
        let area = node.bounds.half_area();
        let NodeKind::Inner { children, .. } = node.kind() else { return [area; LANES - 1] };
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

    /// The wide node for an inner node, and its inner children with their lanes; their words are
    /// to be set.
    fn wide_node(&self, node: &Node) -> (WideNode, Vec<(usize, Node)>) {
        let NodeKind::Inner { children, split } = node.kind() else { unreachable!("not a leaf") };
        let mut lanes = Lanes::default();
        let top = self.divide(children, split.axis(), LANES, &mut lanes);
        let mut wide = WideNode::EMPTY;
        let mut inner = Vec::new();
        for (lane, node) in lanes.lanes.iter().enumerate() {
            let word = match node.kind() {
                NodeKind::Leaf { first, .. } => Word::leaf(first),
                NodeKind::Inner { .. } => {
                    inner.push((lane, *node));
                    Word::END
                }
            };
            wide.set(lane, word, &node.bounds);
        }
        for octant in 0..8 {
            wide.orders[octant] = lanes.order(top, octant);
        }
        (wide, inner)
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
    fn cut(&self, node: &Node, place: (u32, usize), roots: usize, lanes: &mut Lanes) -> usize {
        // Take the fewest roots that cost no more.
        let costs = &self.costs_at(place.0)[place.1];
        let roots = (1..=roots).find(|r| costs[r - 1] == costs[roots - 1]).unwrap_or(roots);
        match node.kind() {
            NodeKind::Inner { children, split } if roots > 1 => {
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
