//! The same with any numbers at all: answers may differ where products of coordinates leave the
//! range of doubles, but nothing may panic or hang.

#![no_main]

use halfline::progress::NoProgress;
use halfline::textbook::{KdTree, Middle, Termination};
use halfline::{BuildParameters, Scene, brute_force};
use halfline_fuzz::be_single_threaded;
use halfline_fuzz::query_input::{QueryInput, Range};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    be_single_threaded();
    let Ok(QueryInput { mesh, rays, choice }) = QueryInput::new(bytes, Range::Whole) else {
        return;
    };
    brute_force::intersect(&mesh, &rays);
    let termination = Termination { maximum_depth: 7, few_triangles: 2 };
    let tree = KdTree::init_kd_tree(&mesh, &Middle, &termination);
    for ray in &rays {
        tree.ray_tree_intersection(ray);
        tree.all(ray, &mut Vec::new());
    }
    let parameters = BuildParameters::default()
        .with_spatial_split_min_triangles(1 + usize::from(choice >> 4))
        .with_duplication_budget(f64::from(choice & 15))
        .with_coarse_grid(choice & 15 == 0);
    let scene =
        Scene::builder(mesh).parameters(parameters).observer(&NoProgress).build().expect("builds");
    scene.intersect(&rays);
    scene.occluded(&rays);
    scene.intersect_all(&rays);
});
