//! Textbook tree and engine against brute force, which shares no code with them but the triangle
//! test; the triangle test has a judge of its own in `exact/triangle.rs`.

use crate::common::contact::Answers;
use crate::common::engines::{
    build_variants, by_batch, by_brute_force, by_engine, by_textbook, engine_planes,
    textbook_planes,
};
use crate::common::proof::{Share, report};
use crate::common::{Random, meshes, nasty_ray};
use halfline::progress::NoProgress;
use halfline::textbook::{
    KdTree, Middle, Node, ObjectMedian, SplittingRule, SurfaceArea, Termination,
};
use halfline::{Mesh, Ray, Scene, Vec3};
use rayon::prelude::*;

/// Casts `rays` nasty rays and compares; `planes` are those to aim at.
fn compare(
    name: &str,
    mesh: &Mesh,
    planes: &[(usize, f64)],
    rays: usize,
    seed: u64,
    answers: impl FnOnce(&[Ray]) -> Vec<Answers>,
) {
    let ray =
        |i| nasty_ray(mesh, planes, &mut Random(seed.wrapping_mul(0x1234_5678_9abc_def1) ^ i));
    let rays: Vec<Ray> = (0..rays as u64).map(ray).collect();
    let answers = answers(&rays);
    rays.par_iter().zip(answers).enumerate().for_each(|(i, (ray, answers))| {
        assert_eq!(answers, by_brute_force(mesh, ray), "{name}, ray {i}: {ray:?}");
    });
}

/// The answers to rays that are asked one by one.
fn one_by_one(rays: &[Ray], answer: impl Fn(&Ray) -> Answers + Send + Sync) -> Vec<Answers> {
    rays.par_iter().map(answer).collect()
}

fn textbook_agrees(rule: &dyn SplittingRule, rule_name: &str) {
    let meshes = meshes();
    let terminations = |triangles: usize| {
        [
            Termination::automatic(triangles),
            Termination { maximum_depth: 12, few_triangles: 1 },
            Termination { maximum_depth: 3, few_triangles: 10 },
        ]
    };
    let rays = (Share::ORACLE.rays() / 6).div_ceil(meshes.len() * terminations(0).len());
    let mut sent = 0;
    for (seed, (name, mesh)) in meshes.iter().enumerate() {
        for termination in terminations(mesh.triangle_count()) {
            let tree = KdTree::init_kd_tree(mesh, rule, &termination);
            let mut planes = Vec::new();
            textbook_planes(tree.root(), &mut planes);
            let name = format!("{name}, {rule_name}, {termination:?}");
            compare(&name, mesh, &planes, rays, seed as u64, |rays| {
                one_by_one(rays, |ray| by_textbook(&tree, ray))
            });
            sent += rays;
        }
    }
    report(&format!("textbook, {rule_name}, against brute force"), sent);
}

#[test]
fn textbook_with_middle_splits_agrees_with_brute_force() {
    textbook_agrees(&Middle, "middle");
}

#[test]
fn textbook_with_median_splits_agrees_with_brute_force() {
    textbook_agrees(&ObjectMedian, "median");
}

#[test]
fn textbook_with_surface_area_splits_agrees_with_brute_force() {
    textbook_agrees(&SurfaceArea { traversal_cost: 1.0 }, "surface area");
}

#[test]
fn engine_agrees_with_brute_force() {
    let (meshes, variants) = (meshes(), build_variants());
    let rays = (Share::ORACLE.rays() / 2).div_ceil(meshes.len() * variants.len());
    let mut sent = 0;
    for (seed, (name, mesh)) in meshes.iter().enumerate() {
        for parameters in &variants {
            let mut scene = Scene::builder(mesh.clone())
                .parameters(*parameters)
                .observer(&NoProgress)
                .build()
                .expect("builds");
            let planes = engine_planes(&scene);
            let name = format!("{name}, {parameters:?}");
            compare(&name, mesh, &planes, rays, seed as u64, |rays| {
                let answers = by_batch(&mut scene, rays);
                assert_eq!(answers, one_by_one(rays, |ray| by_engine(&scene, ray)), "{name}");
                answers
            });
            sent += rays;
        }
    }
    report("engine against brute force", sent);
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

/// Whatever the size of a batch, the number of threads, and the order of the rays.
#[test]
fn batches_agree_with_single_rays() {
    let pools = [1, 3].map(|threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool")
    });
    for (name, mesh) in meshes() {
        let mut scene = Scene::new(mesh).expect("builds");
        let planes = engine_planes(&scene);
        let mut random = Random(3);
        let rays: Vec<Ray> =
            (0..3000).map(|_| nasty_ray(scene.mesh(), &planes, &mut random)).collect();
        let single: Vec<Answers> = rays.iter().map(|ray| by_engine(&scene, ray)).collect();
        for size in [1, 7, 1024, 1025, 3000] {
            // Small batches cost a task each; the first few rays will do.
            let few = if size < 100 { 15 } else { rays.len() };
            for pool in &pools {
                let batches = rays[..few].chunks(size);
                let answers = pool.install(|| {
                    batches.flat_map(|batch| by_batch(&mut scene, batch)).collect::<Vec<_>>()
                });
                assert!(answers == single[..few], "{name}, batches of {size}");
            }
        }
        let mut order: Vec<usize> = (0..rays.len()).collect();
        order.sort_by_cached_key(|_| random.below(1 << 30));
        let shuffled: Vec<Ray> = order.iter().map(|&i| rays[i]).collect();
        let answers = by_batch(&mut scene, &shuffled);
        assert!(order.iter().zip(answers).all(|(&i, answer)| answer == single[i]), "{name}");
    }
    assert!(by_batch(&mut Scene::new(meshes().remove(0).1).expect("builds"), &[]).is_empty());
}
