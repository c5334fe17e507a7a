//! The engine's walk: nodes of up to eight children, leaves of up to eight triangles.

use crate::geometry::{Aabb, Hit, NO_FACE, Ray, vec3};
use crate::scene::Scene;
use crate::simd::LANES;
use crate::textbook::Visits;
use crate::tree::{Bounds, KdTree, WideNode, Word};

/// A node or leaf that a ray came to.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineStep {
    /// Its number among the nodes, or among the leaves.
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
        /// Its faces.
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
        let tree = scene.tree();
        let (hit, visits) = scene.watch(ray);
        let mut places = vec![Place { word: tree.wide.root, depth: 0, bounds: tree.root.bounds }];
        let mut steps = Vec::with_capacity(visits.len());
        let mut counts = Visits::default();
        for visit in visits {
            // A walk comes only to children of nodes that it came to before.
            let place = places.iter().rposition(|place| place.word == visit.word);
            let Some(Place { word, depth, bounds }) = place.map(|at| places.swap_remove(at)) else {
                continue;
            };
            counts.nodes += 1;
            let content = if word.is_leaf() {
                let faces = &tree.leaves.blocks[word.index()].faces;
                let faces: Vec<u32> =
                    faces.iter().copied().filter(|&face| face != NO_FACE).collect();
                counts.leaves += 1;
                counts.triangles += faces.len() as u64;
                EngineContent::Leaf { faces }
            } else {
                let node = &tree.wide.nodes[word.index()];
                let before = places.len();
                places.extend(children(node, depth + 1));
                EngineContent::Node { children: places.len() - before }
            };
            let (index, bounds) = (word.index(), user_box(tree, &bounds));
            steps.push(EngineStep { index, depth, bounds, content, t_limit: visit.t_limit });
        }
        EngineWalk { steps, hit, visits: counts }
    }
}

/// Something that the walk may come to.
struct Place {
    word: Word,
    depth: usize,
    bounds: Bounds,
}

fn children(node: &WideNode, depth: usize) -> impl Iterator<Item = Place> {
    node.children().take(LANES).enumerate().map(move |(lane, word)| {
        let side = |side: usize| std::array::from_fn(|axis| node.planes[axis][side][lane]);
        Place { word, depth, bounds: Bounds { min: side(0), max: side(1) } }
    })
}

fn user_box(tree: &KdTree, bounds: &Bounds) -> Aabb {
    let corner = |[x, y, z]: [f32; 3]| {
        let frame = &tree.frame;
        vec3(frame.to_user(x, 0), frame.to_user(y, 1), frame.to_user(z, 2))
    };
    Aabb { min: corner(bounds.min), max: corner(bounds.max) }
}
