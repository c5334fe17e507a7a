//! Textbook tree and engine against brute force, which shares no code with them but the triangle
//! test; the triangle test has a judge of its own in `exact_judge.rs`.

mod common;

use common::{Random, meshes, nasty_ray, ray_budget};
use halfline::build::BuildParameters;
use halfline::progress::Silent;
use halfline::textbook::{
    KdTree, Middle, Node, ObjectMedian, SplittingRule, SurfaceArea, Termination,
};
use halfline::tree::{NodeKind, Split};
use halfline::{Hit, Mesh, Ray, Scene, Vec3, brute_force};
use rayon::prelude::*;

/// The splitting planes of a textbook tree.
fn textbook_planes(node: &Node, planes: &mut Vec<(usize, f64)>) {
    if let Node::Inner { splitting_axis, splitting_coordinate, children } = node {
        planes.push((*splitting_axis, *splitting_coordinate));
        children.iter().for_each(|child| textbook_planes(child, planes));
    }
}

/// The splitting planes and box sides of the engine's tree, in user coordinates.
fn engine_planes(scene: &Scene) -> Vec<(usize, f64)> {
    let tree = scene.tree();
    let mut planes = Vec::new();
    for node in tree.children.iter().flat_map(|pair| pair.0) {
        if let NodeKind::Inner { split: Split::Plane { axis, position }, .. } = node.kind() {
            planes.push((axis, tree.frame.to_user(position, axis)));
        }
        for axis in 0..3 {
            planes.push((axis, tree.frame.to_user(node.bounds.min[axis], axis)));
            planes.push((axis, tree.frame.to_user(node.bounds.max[axis], axis)));
        }
    }
    planes.retain(|(_, position)| position.is_finite());
    planes
}

/// Everything that an engine answers about a ray.
#[derive(Debug, PartialEq)]
struct Answers {
    closest: Hit,
    any: bool,
    all: Vec<Hit>,
}

fn by_brute_force(mesh: &Mesh, ray: &Ray) -> Answers {
    let mut all = Vec::new();
    brute_force::all(mesh, ray, &mut all);
    Answers { closest: brute_force::closest(mesh, ray), any: brute_force::any(mesh, ray), all }
}

fn by_textbook(tree: &KdTree, ray: &Ray) -> Answers {
    let mut all = Vec::new();
    tree.all(ray, &mut all);
    Answers { closest: tree.ray_tree_intersection(ray), any: tree.any(ray), all }
}

fn by_engine(scene: &Scene, ray: &Ray) -> Answers {
    let mut all = Vec::new();
    scene.all(ray, &mut all);
    Answers { closest: scene.closest(ray), any: scene.any(ray), all }
}

/// Casts `rays` nasty rays and compares; `planes` are those to aim at.
fn compare(
    name: &str,
    mesh: &Mesh,
    planes: &[(usize, f64)],
    rays: usize,
    seed: u64,
    answer: impl Fn(&Ray) -> Answers + Sync,
) {
    (0..rays as u64).into_par_iter().for_each(|i| {
        let ray =
            nasty_ray(mesh, planes, &mut Random(seed.wrapping_mul(0x1234_5678_9abc_def1) ^ i));
        assert_eq!(answer(&ray), by_brute_force(mesh, &ray), "{name}, ray {i}: {ray:?}");
    });
}

fn textbook_agrees(rule: &dyn SplittingRule, rule_name: &str, share: usize) {
    let meshes = meshes();
    let rays = ray_budget() / share / meshes.len();
    for (seed, (name, mesh)) in meshes.iter().enumerate() {
        let terminations = [
            Termination::automatic(mesh.triangle_count()),
            Termination { maximum_depth: 12, few_triangles: 1 },
            Termination { maximum_depth: 3, few_triangles: 10 },
        ];
        for termination in &terminations {
            let tree = KdTree::init_kd_tree(mesh, rule, termination);
            let mut planes = Vec::new();
            textbook_planes(tree.root(), &mut planes);
            let name = format!("{name}, {rule_name}, {termination:?}");
            compare(&name, mesh, &planes, rays / 3, seed as u64, |ray| by_textbook(&tree, ray));
        }
    }
}

#[test]
fn textbook_with_middle_splits_agrees_with_brute_force() {
    textbook_agrees(&Middle, "middle", 6);
}

#[test]
fn textbook_with_median_splits_agrees_with_brute_force() {
    textbook_agrees(&ObjectMedian, "median", 6);
}

#[test]
fn textbook_with_surface_area_splits_agrees_with_brute_force() {
    textbook_agrees(&SurfaceArea { traversal_cost: 1.0 }, "surface area", 6);
}

#[test]
fn engine_agrees_with_brute_force() {
    let meshes = meshes();
    // Trees with many planes, with the default, and with none.
    let parameters = [
        BuildParameters { last_cell_triangles: 8, spare_references: 8.0 },
        BuildParameters::default(),
        BuildParameters { last_cell_triangles: 8, spare_references: 0.0 },
    ];
    let rays = ray_budget() / 2 / meshes.len();
    for (seed, (name, mesh)) in meshes.iter().enumerate() {
        for parameters in &parameters {
            let scene = Scene::build_with(mesh.clone(), parameters, &Silent).expect("builds");
            let planes = engine_planes(&scene);
            let name = format!("{name}, {parameters:?}");
            compare(&name, mesh, &planes, rays / 3, seed as u64, |ray| by_engine(&scene, ray));
        }
    }
}

/// The faces in the leaves of a textbook tree.
fn textbook_faces(node: &Node, faces: &mut Vec<u32>) {
    match node {
        Node::Leaf { triangles } => faces.extend(triangles),
        Node::Inner { children, .. } => {
            children.iter().for_each(|child| textbook_faces(child, faces));
        }
    }
}

#[test]
fn textbook_trees_hold_each_finite_face_and_no_other() {
    for (name, mesh) in meshes() {
        let tree =
            KdTree::init_kd_tree(&mesh, &Middle, &Termination::automatic(mesh.triangle_count()));
        let mut faces = Vec::new();
        textbook_faces(tree.root(), &mut faces);
        faces.sort_unstable();
        faces.dedup();
        let finite = |&face: &u32| mesh.corners(face).into_iter().all(Vec3::is_finite);
        let expected: Vec<u32> = (0..mesh.triangle_count() as u32).filter(finite).collect();
        assert_eq!(faces, expected, "{name}");
    }
}

#[test]
fn batches_agree_with_single_rays() {
    for (name, mesh) in meshes() {
        let scene = Scene::new(mesh).expect("builds");
        let planes = engine_planes(&scene);
        let mut random = Random(3);
        let rays: Vec<Ray> =
            (0..3000).map(|_| nasty_ray(scene.mesh(), &planes, &mut random)).collect();
        let closest: Vec<Hit> = rays.iter().map(|ray| scene.closest(ray)).collect();
        let any: Vec<bool> = rays.iter().map(|ray| scene.any(ray)).collect();
        for threads in [1, 3] {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| {
                assert_eq!(scene.intersect(&rays), closest, "{name}");
                assert_eq!(scene.occluded(&rays), any, "{name}");
                let all = scene.intersect_all(&rays);
                assert_eq!(all.splits.len(), rays.len() + 1);
                for (i, ray) in rays.iter().enumerate() {
                    let mut hits = Vec::new();
                    scene.all(ray, &mut hits);
                    assert_eq!(all.hits[all.splits[i]..all.splits[i + 1]], hits, "{name}");
                }
            });
        }
    }
}

/// From inside of a closed surface the number of crossings is odd, even along rays through its
/// vertices and edges.
#[test]
fn parity_is_right_from_inside() {
    for (name, mesh) in
        meshes().into_iter().filter(|(name, _)| name.contains("sphere") || *name == "grid cube")
    {
        let scene = Scene::new(mesh).expect("builds");
        let center = scene.mesh().bounds().center();
        let mut odd = 0;
        for face in 0..scene.mesh().triangle_count() as u32 {
            let [a, b, _] = scene.mesh().corners(face);
            for target in [a, a * 0.5 + b * 0.5] {
                let ray = Ray::new(center, target - center);
                assert!(scene.closest(&ray).is_hit(), "{name}: {ray:?} leaks");
                let mut hits = Vec::new();
                scene.all(&ray, &mut hits);
                assert_eq!(hits.len() % 2, 1, "{name}: {ray:?} crosses {hits:?}");
                odd += 1;
            }
        }
        assert!(odd > 100, "{name}");
    }
}
