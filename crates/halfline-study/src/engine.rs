//! Who answers the rays.

use std::sync::Arc;

use halfline::error::Result;
use halfline::explain::Rule;
use halfline::geometry::{Hit, Ray};
use halfline::progress::Observer;
use halfline::textbook::{KdTree, Node, Visits};
use halfline::{Mesh, Scene, brute_force, inspect};

/// A way to find closest hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Engine {
    /// Every triangle for every ray.
    BruteForce,
    /// The lecture's kd-tree, split by one of its rules.
    Textbook(Rule),
    /// The engine of halfline.
    Fast,
}

impl Engine {
    /// Every engine, the slowest first.
    pub const ALL: [Engine; 5] = [
        Engine::BruteForce,
        Engine::Textbook(Rule::Middle),
        Engine::Textbook(Rule::Median),
        Engine::Textbook(Rule::SurfaceArea),
        Engine::Fast,
    ];

    /// The name of the engine in figures.
    pub const fn name(self) -> &'static str {
        match self {
            Engine::BruteForce => "brute",
            Engine::Textbook(rule) => rule.name(),
            Engine::Fast => "fast",
        }
    }

    /// The name of the engine in sentences.
    pub const fn title(self) -> &'static str {
        match self {
            Engine::BruteForce => "brute force",
            Engine::Textbook(Rule::Middle) => "textbook middle",
            Engine::Textbook(Rule::Median) => "textbook median",
            Engine::Textbook(Rule::SurfaceArea) => "textbook SAH",
            Engine::Fast => "halfline",
        }
    }
}

/// An engine with a mesh, ready for rays.
pub enum Ready<'mesh> {
    /// Nothing was to be built.
    BruteForce(&'mesh Mesh),
    /// One of the textbook's trees.
    Textbook(KdTree<'mesh>),
    /// A scene of halfline.
    Fast(Box<Scene>),
}

/// Rays that a reference engine casts between two looks at the observer, of which each may take it 50
/// milliseconds.
const BRUTE_CHUNK: usize = 1;
const TEXTBOOK_CHUNK: usize = 64;

impl Ready<'_> {
    /// The closest hit of each ray; what it took is added to `visits`, but by halfline, whose batches
    /// count only if asked to: see [`Ready::count`].
    ///
    /// # Errors
    /// [`Error::Interrupted`](halfline::Error::Interrupted).
    pub fn cast(
        &self,
        rays: &[Ray],
        visits: &mut Visits,
        observer: &dyn Observer,
    ) -> Result<Vec<Hit>> {
        match self {
            Ready::BruteForce(mesh) => {
                visits.triangles += (rays.len() * mesh.triangle_count()) as u64;
                one_by_one(rays, BRUTE_CHUNK, observer, |ray| brute_force::closest(mesh, ray))
            }
            Ready::Textbook(tree) => one_by_one(rays, TEXTBOOK_CHUNK, observer, |ray| {
                tree.ray_tree_intersection_counted(ray, visits)
            }),
            Ready::Fast(scene) => scene.observed(observer).intersect(rays),
        }
    }

    /// What the rays cost, counted apart from any casting; nothing for those that count as they cast.
    /// `nodes` are those of eight children that are fetched, and the leaves, blocks of up to eight
    /// triangles, which are tested together. Batches do not count the triangles in these: `triangles` is the
    /// number of leaves times the mean number in the leaves that some of the rays come to one by one.
    pub fn count(&self, rays: &[Ray]) -> Option<Visits> {
        let Ready::Fast(scene) = self else { return None };
        let work = inspect::count_work(scene, rays, false);
        let (mut leaves, mut triangles) = (0, 0);
        for ray in rays.iter().take(FILL_RAYS) {
            let (_, visits) = inspect::record_visits(scene, ray);
            for visit in visits.iter().filter(|visit| visit.place.is_leaf()) {
                leaves += 1;
                triangles += scene.tree().faces(visit.place.index()).count();
            }
        }
        let fill = triangles as f64 / f64::from(leaves.max(1));
        let triangles = (work.leaves as f64 * fill).round() as u64;
        Some(Visits { nodes: work.nodes + work.leaves, leaves: work.leaves, triangles })
    }

    /// Bytes that were built, without the mesh.
    pub fn bytes(&self) -> usize {
        match self {
            Ready::BruteForce(_) => 0,
            Ready::Textbook(tree) => size_of::<Node>() + bytes_below(tree.root()),
            Ready::Fast(scene) => scene.tree().bytes(),
        }
    }

    /// Bytes in which rays find what they need: the tree; and the mesh, unless the tree has the
    /// triangles inside.
    pub fn bytes_walked(&self, mesh: &Mesh) -> usize {
        match self {
            Ready::Fast(_) => self.bytes(),
            _ => self.bytes() + mesh_bytes(mesh),
        }
    }
}

/// Rays by which the leaves' fill is found.
const FILL_RAYS: usize = 4096;

fn one_by_one(
    rays: &[Ray],
    chunk: usize,
    observer: &dyn Observer,
    mut cast: impl FnMut(&Ray) -> Hit,
) -> Result<Vec<Hit>> {
    let mut hits = Vec::with_capacity(rays.len());
    for rays in rays.chunks(chunk) {
        observer.check()?;
        hits.extend(rays.iter().map(&mut cast));
    }
    Ok(hits)
}

/// Builds the tree of halfline over the mesh.
///
/// # Errors
/// Those of [`SceneBuilder::build`](halfline::SceneBuilder::build).
pub fn build_fast(mesh: &Arc<Mesh>, observer: &dyn Observer) -> Result<Ready<'static>> {
    let parameters = halfline::BuildParameters::default();
    Ok(Ready::Fast(Box::new(
        Scene::builder(Arc::clone(mesh)).parameters(parameters).observer(observer).build()?,
    )))
}

/// Bytes of vertices and faces.
pub fn mesh_bytes(mesh: &Mesh) -> usize {
    let vertex = match mesh.positions() {
        halfline::mesh::Positions::F32(_) => size_of::<[f32; 3]>(),
        halfline::mesh::Positions::F64(_) => size_of::<[f64; 3]>(),
    };
    mesh.positions().len() * vertex + size_of_val(mesh.triangles())
}

fn bytes_below(node: &Node) -> usize {
    match node {
        Node::Leaf { triangles } => triangles.capacity() * size_of::<u32>(),
        Node::Inner { children, .. } => {
            size_of::<[Node; 2]>() + children.iter().map(bytes_below).sum::<usize>()
        }
    }
}
