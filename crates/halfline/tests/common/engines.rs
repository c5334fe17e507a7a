//! Every engine under trial, and what they answer.

use halfline::mesh::Positions;
use halfline::progress::NoProgress;
use halfline::textbook::{
    KdTree, Middle, Node, ObjectMedian, SplittingRule, SurfaceArea, Termination,
};
use halfline::{BuildParameters, Hit, Level, Mesh, Preset, Ray, RayF32, Scene, brute_force};

use super::contact::{Answers, Case};

/// How trees are built in the tests: with many planes, with none, and as each preset has it.
pub fn build_variants() -> Vec<BuildParameters> {
    let balanced = BuildParameters::default();
    let many = balanced.with_spatial_split_min_triangles(1).with_duplication_budget(16.0);
    let none = balanced.with_spatial_split_min_triangles(8).with_duplication_budget(0.0);
    [many, none].into_iter().chain(Preset::ALL.map(BuildParameters::preset)).collect()
}

pub fn by_brute_force(mesh: &Mesh, ray: &Ray) -> Answers {
    let mut all = Vec::new();
    brute_force::all(mesh, ray, &mut all);
    Answers { closest: brute_force::closest(mesh, ray), any: brute_force::any(mesh, ray), all }
}

pub fn by_textbook(tree: &KdTree, ray: &Ray) -> Answers {
    let mut all = Vec::new();
    tree.all(ray, &mut all);
    Answers { closest: tree.ray_tree_intersection(ray), any: tree.any(ray), all }
}

pub fn by_engine(scene: &Scene, ray: &Ray) -> Answers {
    let mut all = Vec::new();
    scene.caster().intersect_all(ray, &mut all);
    Answers {
        closest: scene.caster().intersect(ray).unwrap_or(Hit::MISS),
        any: scene.caster().occluded(ray),
        all,
    }
}

/// The answers to a batch, ray by ray, which are the same bits by every instruction set.
pub fn by_batch(scene: &mut Scene, rays: &[Ray]) -> Vec<Answers> {
    let chosen = scene.simd_level();
    let mut by_level = Vec::new();
    for level in Level::available() {
        scene.set_simd_level(level);
        let (closest, any) = (scene.intersect(rays), scene.occluded(rays));
        let all = scene.intersect_all(rays);
        assert_eq!(all.splits.len(), rays.len() + 1, "one end for each ray");
        let counts: Vec<usize> = all.splits.windows(2).map(|ends| ends[1] - ends[0]).collect();
        assert_eq!(scene.count_intersections(rays), counts, "{}", level.name());
        check_single_precision(scene, rays, &closest, &any);
        let answers: Vec<Answers> = (0..rays.len())
            .map(|i| Answers {
                closest: closest[i],
                any: any[i],
                all: all.hits[all.splits[i]..all.splits[i + 1]].to_vec(),
            })
            .collect();
        by_level.push((level, answers));
    }
    scene.set_simd_level(chosen);
    let (first, answers) = by_level.swap_remove(0);
    for (level, others) in by_level {
        for ((ray, one), other) in rays.iter().zip(&answers).zip(&others) {
            let (first, level) = (first.name(), level.name());
            assert_eq!(bits(one), bits(other), "{first} and {level}: {ray:?}");
        }
    }
    answers
}

/// Every number of some answers, with the sign of its zero.
pub fn bits(answers: &Answers) -> (bool, Vec<[u64; 4]>) {
    let hits = std::iter::once(&answers.closest).chain(&answers.all);
    let numbers =
        |hit: &Hit| [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), u64::from(hit.face)];
    (answers.any, hits.map(numbers).collect())
}

/// Rays that are the same in single precision have the same answers, with t rounded.
fn check_single_precision(scene: &Scene, rays: &[Ray], closest: &[Hit], any: &[bool]) {
    let single = |ray: &Ray| RayF32 {
        origin: ray.origin.to_array().map(|x| x as f32),
        t_min: ray.t_min as f32,
        direction: ray.direction.to_array().map(|x| x as f32),
        t_max: ray.t_max as f32,
    };
    let is_same = |i: &usize| Ray::from(single(&rays[*i])) == rays[*i];
    let numbers: Vec<usize> = (0..rays.len()).filter(is_same).collect();
    let singles: Vec<RayF32> = numbers.iter().map(|&i| single(&rays[i])).collect();
    let (hits, flags) = (scene.intersect_f32(&singles), scene.occluded(&singles));
    for ((i, hit), flag) in numbers.into_iter().zip(hits).zip(flags) {
        let found = (hit.face, hit.t.to_bits(), flag);
        let expected = (closest[i].face, (closest[i].t as f32).to_bits(), any[i]);
        assert_eq!(found, expected, "in single precision: {:?}", rays[i]);
    }
}

/// The mesh, and the same in single precision if that is the same.
pub fn in_both_precisions(mesh: &Mesh) -> Vec<Mesh> {
    let Positions::F64(positions) = mesh.positions() else { return vec![mesh.clone()] };
    match Positions::without_loss(positions.to_vec()) {
        Positions::F64(_) => vec![mesh.clone()],
        single => vec![
            mesh.clone(),
            Mesh::new(single, mesh.triangles().to_vec()).expect("as valid as the mesh"),
        ],
    }
}

/// What the engines answer wrongly, if anything: brute force, a textbook tree, and the engine with
/// every variant of the tree. Precisions, the textbook's rules, and single rays and batches take
/// turns, and have all met each other after twelve; batches are cast by every instruction set.
pub fn check_engines(mesh: &Mesh, cases: &[Case], turn: usize) -> Result<(), String> {
    let rays: Vec<Ray> = cases.iter().map(|case| case.ray).collect();
    let meshes = in_both_precisions(mesh);
    let check = |name: &str, answers: Vec<Answers>| {
        let wrong = cases.iter().zip(answers).find(|(case, a)| !a.are_right(&case.contacts));
        wrong.map_or(Ok(()), |(case, answers)| {
            Err(format!("{name}: {answers:#?}\nfor {case:#?}\nin {mesh:?}"))
        })
    };

    let mesh = &meshes[turn % meshes.len()];
    check("brute force", rays.iter().map(|ray| by_brute_force(mesh, ray)).collect())?;

    let rules: [&dyn SplittingRule; 3] =
        [&Middle, &ObjectMedian, &SurfaceArea { traversal_cost: 1.0 }];
    // Deep enough for planes in all places of a coarse grid; each level may double the tree.
    let termination = Termination { maximum_depth: 5, few_triangles: 1 };
    let tree = KdTree::init_kd_tree(mesh, rules[turn % 3], &termination);
    check("textbook", rays.iter().map(|ray| by_textbook(&tree, ray)).collect())?;

    for (i, parameters) in build_variants().iter().enumerate() {
        let mesh = meshes[(turn + i) % meshes.len()].clone();
        let mut scene = Scene::builder(mesh)
            .parameters(*parameters)
            .observer(&NoProgress)
            .build()
            .expect("builds");
        let name = format!("engine, {parameters:?}, turn {turn}");
        check(&format!("{name}, batch"), by_batch(&mut scene, &rays))?;
        if (turn / 2 + i).is_multiple_of(2) {
            check(&name, rays.iter().map(|ray| by_engine(&scene, ray)).collect())?;
        }
    }
    Ok(())
}

/// The splitting planes of a textbook tree.
pub fn textbook_planes(node: &Node, planes: &mut Vec<(usize, f64)>) {
    if let Node::Inner { splitting_axis, splitting_coordinate, children } = node {
        planes.push((*splitting_axis, *splitting_coordinate));
        children.iter().for_each(|child| textbook_planes(child, planes));
    }
}

/// The box sides of the engine's tree, in user coordinates.
pub fn engine_planes(scene: &Scene) -> Vec<(usize, f64)> {
    let tree = scene.tree();
    let mut planes = Vec::new();
    for node in &tree.nodes {
        for (lane, _) in node.children().enumerate() {
            let bounds = node.bounds(lane);
            for axis in 0..3 {
                planes.push((axis, tree.frame.to_user(bounds.min[axis], axis)));
                planes.push((axis, tree.frame.to_user(bounds.max[axis], axis)));
            }
        }
    }
    planes.retain(|(_, position)| position.is_finite());
    planes
}
