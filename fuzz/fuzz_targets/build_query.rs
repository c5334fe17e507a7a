//! Small nasty meshes and rays: the engine, with trees of many kinds, against brute force, and so
//! the textbook's trees.

#![no_main]

use std::fmt::Debug;

use halfline::progress::NoProgress;
use halfline::textbook::{KdTree, Middle, ObjectMedian, SplittingRule, SurfaceArea, Termination};
use halfline::{BuildParameters, Hit, Mesh, Preset, Ray, Scene, brute_force};
use halfline_fuzz::be_single_threaded;
use halfline_fuzz::query_input::{QueryInput, Range};
use libfuzzer_sys::fuzz_target;

/// Trees of planes down to single triangles, of few planes, and of none; and those of the presets.
const PARAMETERS: [BuildParameters; 6] = [
    with(1, 16.0),
    with(4, 1.0),
    with(8, 0.0),
    BuildParameters::preset(Preset::Fast),
    BuildParameters::preset(Preset::Balanced),
    BuildParameters::preset(Preset::Best),
];

const fn with(spatial_split_min_triangles: usize, duplication_budget: f64) -> BuildParameters {
    let balanced = BuildParameters::preset(Preset::Balanced);
    balanced
        .with_spatial_split_min_triangles(spatial_split_min_triangles)
        .with_duplication_budget(duplication_budget)
}

/// Everything that can be asked about a ray, in bits, so that zeros of either sign differ.
#[derive(Debug, PartialEq)]
struct Answers {
    closest: HitBits,
    any: bool,
    all: Vec<HitBits>,
}

type HitBits = (u32, [u64; 3]);

fn bits(hit: &Hit) -> HitBits {
    (hit.face, [hit.t, hit.u, hit.v].map(f64::to_bits))
}

impl Answers {
    fn new(closest: Hit, any: bool, all: &[Hit]) -> Answers {
        Answers { closest: bits(&closest), any, all: all.iter().map(bits).collect() }
    }

    fn by_brute_force(mesh: &Mesh, ray: &Ray) -> Answers {
        let mut all = Vec::new();
        brute_force::all(mesh, ray, &mut all);
        Answers::new(brute_force::closest(mesh, ray), brute_force::any(mesh, ray), &all)
    }

    fn by_textbook(tree: &KdTree, ray: &Ray) -> Answers {
        let mut all = Vec::new();
        tree.all(ray, &mut all);
        Answers::new(tree.ray_tree_intersection(ray), tree.any(ray), &all)
    }

    fn by_engine(scene: &Scene, ray: &Ray) -> Answers {
        let mut all = Vec::new();
        scene.caster().intersect_all(ray, &mut all);
        Answers::new(
            scene.caster().intersect(ray).unwrap_or(Hit::MISS),
            scene.caster().occluded(ray),
            &all,
        )
    }

    /// The engine's answers to all rays at once.
    fn by_batch(scene: &Scene, rays: &[Ray]) -> Vec<Answers> {
        let (closest, any) = (scene.intersect(rays), scene.occluded(rays));
        let all = scene.intersect_all(rays);
        let of = |i: usize| {
            Answers::new(closest[i], any[i], &all.hits[all.splits[i]..all.splits[i + 1]])
        };
        (0..rays.len()).map(of).collect()
    }
}

/// Fails unless `answers` are those of brute force.
fn compare(input: &QueryInput, who: &dyn Debug, judge: &[Answers], answers: &[Answers]) {
    assert_eq!(answers.len(), judge.len(), "{who:?}: number of answers");
    for (i, (answer, expected)) in answers.iter().zip(judge).enumerate() {
        assert_eq!(answer, expected, "{who:?}\n{}", input.as_snippet(i));
    }
}

fuzz_target!(|bytes: &[u8]| {
    be_single_threaded();
    let Ok(input) = QueryInput::new(bytes, Range::Promised) else { return };
    let QueryInput { mesh, rays, choice } = &input;
    let judge: Vec<Answers> = rays.iter().map(|ray| Answers::by_brute_force(mesh, ray)).collect();

    let rules: [&dyn SplittingRule; 3] =
        [&Middle, &ObjectMedian, &SurfaceArea { traversal_cost: 1.0 }];
    let rule = usize::from(choice % 3);
    // Triangles that all reach into all cells would fill deeper trees for seconds.
    let termination = Termination { maximum_depth: 7, few_triangles: 2 };
    let tree = KdTree::init_kd_tree(mesh, rules[rule], &termination);
    let answers: Vec<_> = rays.iter().map(|ray| Answers::by_textbook(&tree, ray)).collect();
    compare(&input, &("textbook", rule), &judge, &answers);

    let first = usize::from(choice / 3) % PARAMETERS.len();
    for parameters in [PARAMETERS[first], PARAMETERS[(first + 1) % PARAMETERS.len()]] {
        let scene = Scene::builder(mesh.clone())
            .parameters(parameters)
            .observer(&NoProgress)
            .build()
            .expect("builds");
        let answers: Vec<_> = rays.iter().map(|ray| Answers::by_engine(&scene, ray)).collect();
        compare(&input, &parameters, &judge, &answers);
        compare(&input, &("batch", parameters), &judge, &Answers::by_batch(&scene, rays));
    }
});
