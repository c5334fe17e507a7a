//! The engine's walk: nodes of up to eight children, leaves of up to eight triangles.

use crate::geometry::{Aabb, Hit, Ray, vec3};
use crate::scene::{Scene, inspect};
use crate::textbook::Visits;
use crate::tree::{Bounds, Node, NodeRef, Tree};

/// A node or leaf that a ray came to.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineStep {
    /// The number of the node among the nodes, or of the leaf among the leaves.
    pub index: usize,
    /// Levels below the root.
    pub depth: usize,
    /// The box of what it holds, as the engine knows it: somewhat too large.
    pub bounds: Aabb,
    /// What is there.
    pub content: EngineContent,
    /// About the t beyond which nothing mattered any more when the ray came.
    pub t_limit: f64,
}

/// What a ray comes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EngineContent {
    /// A node.
    Node {
        /// How many children it has.
        children: usize,
    },
    /// A leaf.
    Leaf {
        /// The faces of the leaf.
        faces: Vec<u32>,
    },
}

/// The walk of a ray through the engine's tree.
#[derive(Clone, Debug)]
pub struct EngineWalk {
    /// Where it came to, in order. None if the ray does not meet the root's box.
    pub steps: Vec<EngineStep>,
    /// The closest hit.
    pub hit: Hit,
    /// What it took; `nodes` includes the leaves, as for the textbook.
    pub visits: Visits,
}

impl EngineWalk {
    /// Casts a ray at a scene.
    pub fn through(scene: &Scene, ray: &Ray) -> EngineWalk {
        let (hit, visits) = inspect::record_visits(scene, ray);
        let places = visits.iter().map(|visit| (visit.place, visit.t_limit));
        let (steps, visits) = follow(scene.tree(), places);
        EngineWalk { steps, hit, visits }
    }
}

/// The steps of a walk that came to these places, in order, each with its limit; and how much that was.
pub(super) fn follow(
    tree: &Tree,
    visits: impl ExactSizeIterator<Item = (NodeRef, f64)>,
) -> (Vec<EngineStep>, Visits) {
    let mut places = vec![Place { at: tree.root, depth: 0, bounds: tree.bounds }];
    let mut steps = Vec::with_capacity(visits.len());
    let mut counts = Visits::default();
    for (place, t_limit) in visits {
        // A walk comes only to children of nodes that it came to before.
        let place = places.iter().rposition(|known| known.at == place);
        let Some(Place { at, depth, bounds }) = place.map(|number| places.swap_remove(number))
        else {
            continue;
        };
        counts.nodes += 1;
        let content = if at.is_leaf() {
            let faces: Vec<u32> = tree.faces(at.index()).collect();
            counts.leaves += 1;
            counts.triangles += faces.len() as u64;
            EngineContent::Leaf { faces }
        } else {
            let node = &tree.nodes[at.index()];
            let before = places.len();
            places.extend(children(node, depth + 1));
            EngineContent::Node { children: places.len() - before }
        };
        let (index, bounds) = (at.index(), user_box(tree, &bounds));
        steps.push(EngineStep { index, depth, bounds, content, t_limit });
    }
    (steps, counts)
}

/// Something that the walk may come to.
struct Place {
    at: NodeRef,
    depth: usize,
    bounds: Bounds,
}

fn children(node: &Node, depth: usize) -> impl Iterator<Item = Place> {
    let place = move |(lane, at)| Place { at, depth, bounds: node.bounds(lane) };
    node.children().enumerate().map(place)
}

fn user_box(tree: &Tree, bounds: &Bounds) -> Aabb {
    let corner = |[x, y, z]: [f32; 3]| {
        let frame = &tree.frame;
        vec3(frame.to_user(x, 0), frame.to_user(y, 1), frame.to_user(z, 2))
    };
    Aabb { min: corner(bounds.min), max: corner(bounds.max) }
}
