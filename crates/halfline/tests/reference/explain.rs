//! Explanations against what they explain: the textbook's own counts, the engine's own counts, and for
//! misses a minimum that is found by search.

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::engines::textbook_planes;
use crate::common::{Random, grid_cube, meshes, nasty_ray, soup};
use halfline::explain::{
    Case, Cells, Content, Edge, Explanation, Rule, Slice, SlicePlane, Step, Verdict, Visit,
};
use halfline::geometry::vec3;
use halfline::progress::{NoProgress, Observer};
use halfline::textbook::{KdTree, Termination, Visits};
use halfline::{Error, Mesh, Ray, RayF32, Scene, Vec3, brute_force, inspect};

const RAYS_PER_MESH: u64 = 60;

fn single(ray: &Ray) -> RayF32 {
    RayF32 {
        origin: ray.origin.to_array().map(|x| x as f32),
        t_min: ray.t_min as f32,
        direction: ray.direction.to_array().map(|x| x as f32),
        t_max: ray.t_max as f32,
    }
}

/// Shows `look` the explanations of nasty rays, with the tree that they explain.
fn each_explanation(mut look: impl FnMut(&str, &Scene, &KdTree, &Explanation)) {
    for (seed, (name, mesh)) in meshes().into_iter().enumerate() {
        let scene = Scene::new(mesh.clone()).expect("a valid mesh");
        for rule in Rule::ALL {
            let termination = Termination::automatic(mesh.triangle_count());
            let tree = KdTree::init_kd_tree(&mesh, rule.splitting_rule(), &termination);
            let mut planes = Vec::new();
            textbook_planes(tree.root(), &mut planes);
            for i in 0..RAYS_PER_MESH {
                let mut random = Random(0x1234_5678_9abc_def1 ^ (seed as u64) << 32 ^ i);
                let ray = nasty_ray(&mesh, &planes, &mut random);
                // Every other ray is one that single precision holds too.
                let ray = if i % 2 == 0 { ray } else { Ray::from(single(&ray)) };
                if !ray.is_valid() {
                    continue;
                }
                let explanation = scene.explain(&ray, rule, &NoProgress).expect("a valid ray");
                look(&format!("{name}, {rule}: {ray:?}"), &scene, &tree, &explanation);
            }
        }
    }
}

#[test]
fn counts_and_hits_are_those_of_textbook_and_engine() {
    let mut compared_with_engine = 0;
    each_explanation(|name, scene, tree, explanation| {
        let ray = &explanation.ray;
        let mut visits = Visits::default();
        let hit = tree.ray_tree_intersection_counted(ray, &mut visits);
        assert_eq!(explanation.walk.visits, visits, "{name}");
        assert_eq!(explanation.walk.hit, hit, "{name}");
        assert_eq!(explanation.engine.hit, hit, "{name}");
        assert_eq!(
            explanation.hit,
            scene.caster().intersect(ray).unwrap_or(halfline::Hit::MISS),
            "{name}"
        );

        if Ray::from(single(ray)) == *ray {
            let work = inspect::count_work(scene, &[single(ray)], false);
            let Visits { nodes, leaves, .. } = explanation.engine.visits;
            assert_eq!((nodes - leaves, leaves), (work.nodes, work.leaves), "{name}");
            compared_with_engine += usize::from(nodes > 0);
        }
    });
    assert!(compared_with_engine > 500, "{compared_with_engine} walks of the engine were compared");
}

#[test]
fn steps_tell_the_whole_walk() {
    let mut seen = std::collections::HashSet::new();
    each_explanation(|name, _, _, explanation| {
        let (mut counts, mut waiting) = (Visits::default(), Vec::<Visit>::new());
        let mut next = match &explanation.walk.steps[0] {
            Step::Clip { within } => within.map(|[t_near, t_far]| Visit { cell: 0, t_near, t_far }),
            other => panic!("{name}: begins with {other:?}"),
        };
        for step in &explanation.walk.steps[1..] {
            match step {
                Step::Clip { .. } => panic!("{name}: cut twice"),
                Step::Inner { at, case, enter, push, near, far, plane_touched, .. } => {
                    assert_eq!(next, Some(*at), "{name}");
                    counts.nodes += 1;
                    seen.insert((*case, *plane_touched));
                    assert_eq!(push.is_some(), matches!(case, Case::Both | Case::InPlane));
                    let children = explanation.cells[at.cell].content.clone();
                    let Content::Inner { children, .. } = children else { panic!("{name}") };
                    assert!(children.contains(near) && children.contains(far) && near != far);
                    waiting.extend(*push);
                    next = Some(*enter);
                }
                Step::Leaf { at, tests, closest } => {
                    assert_eq!(next, Some(*at), "{name}");
                    counts.nodes += 1;
                    counts.leaves += 1;
                    counts.triangles += tests.len() as u64;
                    let nearest = tests.iter().filter_map(|test| test.hit());
                    let nearest = nearest.map(|hit| hit.t).fold(f64::INFINITY, f64::min);
                    assert_eq!(closest.map_or(f64::INFINITY, |hit| hit.t), nearest, "{name}");
                    next = None;
                }
                Step::Pop { at, is_entered, .. } => {
                    assert_eq!((next, waiting.pop()), (None, Some(*at)), "{name}");
                    next = is_entered.then_some(*at);
                }
                Step::End { hit } => {
                    assert_eq!((next, waiting.len()), (None, 0), "{name}");
                    assert_eq!(hit.is_some(), explanation.hit.is_hit(), "{name}");
                }
            }
        }
        assert!(matches!(explanation.walk.steps.last(), Some(Step::End { .. })), "{name}");
        assert_eq!(counts, explanation.walk.visits, "{name}");
    });
    for case in Case::ALL {
        assert!(seen.contains(&(case, false)), "no ray showed the case {}", case.name());
    }
    assert!(seen.contains(&(Case::Both, true)), "no ray touched a plane at an end");
}

#[test]
fn verdicts_are_those_of_brute_force() {
    let mut seen = std::collections::HashSet::new();
    each_explanation(|name, scene, _, explanation| {
        let ray = &explanation.ray;
        let whole = Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..*ray };
        let tests = explanation.walk.steps.iter().filter_map(|step| match step {
            Step::Leaf { tests, .. } => Some(tests),
            _ => None,
        });
        for test in tests.flatten() {
            let alone = soup([scene.mesh().corners(test.face)]);
            let hit = brute_force::closest(&alone, ray);
            let on_line = brute_force::closest(&alone, &whole);
            seen.insert(std::mem::discriminant(&test.verdict));
            match test.verdict {
                Verdict::Hit(found) => assert_eq!((found.t, found.u), (hit.t, hit.u), "{name}"),
                Verdict::Beyond { t } => {
                    assert!(!hit.is_hit() && (t == on_line.t || !t.is_finite()), "{name}");
                    assert!(t > ray.t_max || !t.is_finite(), "{name}");
                }
                Verdict::Behind { t } => {
                    assert!(!hit.is_hit() && t == on_line.t && t < ray.t_min, "{name}");
                }
                Verdict::Outside { .. } | Verdict::EdgeOn | Verdict::NoArea => {
                    assert!(!on_line.is_hit(), "{name}: {test:?}");
                }
            }
        }
    });
    assert_eq!(seen.len(), 6, "every verdict was seen");
}

/// The least of a convex function between two numbers, by ternary search.
fn least(mut low: f64, mut high: f64, function: &dyn Fn(f64) -> f64) -> f64 {
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        let (a, b) = (low + third, high - third);
        if function(a) < function(b) {
            high = b;
        } else {
            low = a;
        }
    }
    function((low + high) / 2.0)
}

/// The distance between a triangle and a ray's part with t from 0 to 4, by search.
fn distance_by_search(ray: &Ray, [a, b, c]: [Vec3; 3]) -> f64 {
    least(0.0, 4.0, &|t| {
        let point = ray.at(t);
        least(0.0, 1.0, &|u| {
            least(0.0, 1.0 - u, &|v| (a + (b - a) * u + (c - a) * v - point).length())
        })
    })
}

#[test]
fn the_nearest_miss_is_the_least_distance() {
    let mut random = Random(5);
    for round in 0..40 {
        let triangles: Vec<[Vec3; 3]> = (0..5)
            .map(|_| {
                let p = random.point();
                [p, p + random.point() * 0.3, p + random.point() * 0.3]
            })
            .collect();
        let (from, to) = (random.point() * 1.5, random.point() * 1.5);
        let ray = Ray::with_range(from, to - from, 0.0, 4.0);
        let scene = Scene::new(soup(triangles.clone())).expect("a valid mesh");
        let explanation = scene.explain(&ray, Rule::Middle, &NoProgress).expect("a valid ray");
        let Some(miss) = explanation.nearest_miss else {
            assert!(explanation.hit.is_hit(), "round {round}");
            continue;
        };
        let distances = triangles.iter().map(|corners| distance_by_search(&ray, *corners));
        let expected = distances.fold(f64::INFINITY, f64::min);
        assert!((miss.distance - expected).abs() < 1e-6, "round {round}: {miss:?}, {expected}");
        // The points tell the same, and lie where they should.
        let apart = (miss.point_on_face - miss.point_on_ray).length();
        assert!((apart - miss.distance).abs() < 1e-12, "round {round}: {miss:?}");
        assert!((ray.at(miss.t) - miss.point_on_ray).length() < 1e-12, "round {round}: {miss:?}");
        let corners = triangles[miss.test.face as usize];
        let off = distance_by_search(&Ray::new(miss.point_on_face, Vec3::ZERO), corners);
        assert!(off < 1e-6, "round {round}: {miss:?}");
    }
}

fn triangle() -> Mesh {
    soup([[vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)]])
}

fn miss_of(mesh: Mesh, ray: Ray) -> (Verdict, f64) {
    let scene = Scene::new(mesh).expect("a valid mesh");
    let explanation = scene.explain(&ray, Rule::default(), &NoProgress).expect("a valid ray");
    let miss = explanation.nearest_miss.expect("a miss");
    (miss.test.verdict, miss.distance)
}

#[test]
fn a_miss_says_why() {
    let down = vec3(0.0, 0.0, -2.0);
    let from = |x: f64, y: f64, z: f64| Ray::new(vec3(x, y, z), down);
    let (verdict, distance) = miss_of(triangle(), from(0.25, -0.5, 4.0));
    assert_eq!((verdict, distance), (Verdict::Outside { edge: Edge::AB, distance: 0.5 }, 0.5));
    let (verdict, distance) = miss_of(triangle(), from(-0.125, 0.5, 4.0));
    assert_eq!((verdict, distance), (Verdict::Outside { edge: Edge::CA, distance: 0.125 }, 0.125));
    let (verdict, distance) = miss_of(triangle(), from(1.0, 1.0, 4.0));
    let Verdict::Outside { edge: Edge::BC, .. } = verdict else { panic!("{verdict:?}") };
    assert!((distance - 0.5f64.sqrt()).abs() < 1e-15, "{distance}");

    assert_eq!(miss_of(triangle(), from(0.25, 0.25, -1.0)), (Verdict::Behind { t: -0.5 }, 1.0));
    let short = Ray { t_max: 1.5, ..from(0.25, 0.25, 4.0) };
    assert_eq!(miss_of(triangle(), short), (Verdict::Beyond { t: 2.0 }, 1.0));
    let within = Ray::new(vec3(-1.0, 0.25, 0.0), vec3(1.0, 0.0, 0.0));
    assert_eq!(miss_of(triangle(), within), (Verdict::EdgeOn, 0.0));
    let sliver = soup([[vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.5, 0.0, 0.0)]]);
    assert_eq!(miss_of(sliver, from(0.25, 0.0, 4.0)), (Verdict::NoArea, 0.0));
}

#[test]
fn misses_are_measured_at_any_size_and_place() {
    for (offset, size) in [(5_400_000.0, 2.0), (0.0, 1e-30), (0.0, 1e30), (1e30, 1e30)] {
        let offset = Vec3::splat(offset);
        let place = |x: f64, y: f64, z: f64| offset + vec3(x, y, z) * size;
        let mesh = soup([[place(0.0, 0.0, 0.0), place(1.0, 0.0, 0.0), place(0.0, 1.0, 0.0)]]);
        // From a hundred sizes away, a quarter of the size beside the edge a-b.
        let ray = Ray::new(place(0.25, -0.25, 100.0), vec3(0.0, 0.0, -1.0) * size);
        let (verdict, distance) = miss_of(mesh, ray);
        assert!((distance / size - 0.25).abs() < 1e-9, "{offset:?}, {size}: {distance}");
        let Verdict::Outside { edge: Edge::AB, .. } = verdict else { panic!("{verdict:?}") };
    }
}

#[test]
fn meshes_without_triangles_are_explained() {
    let empty = soup([]);
    let not_finite = soup([[vec3(f64::NAN, 0.0, 0.0), Vec3::ZERO, vec3(1.0, 1.0, 1.0)]]);
    for mesh in [empty, not_finite] {
        let scene = Scene::new(mesh).expect("a valid mesh");
        let ray = Ray::new(Vec3::ZERO, vec3(1.0, 0.0, 0.0));
        for rule in Rule::ALL {
            let explanation = scene.explain(&ray, rule, &NoProgress).expect("a valid ray");
            assert!(!explanation.hit.is_hit() && explanation.nearest_miss.is_none());
            assert_eq!(explanation.walk.steps[0], Step::Clip { within: None });
        }
    }
}

#[test]
fn a_ray_that_is_none_is_refused() {
    let scene = Scene::new(triangle()).expect("a valid mesh");
    let x = vec3(1.0, 0.0, 0.0);
    let rays = [
        (Ray::new(vec3(f64::NAN, 0.0, 0.0), x), "its origin NaN, 0, 0 is not finite"),
        (Ray::new(x, vec3(0.0, f64::INFINITY, 0.0)), "its direction 0, inf, 0 is not finite"),
        (Ray::new(x, Vec3::ZERO), "its direction is zero"),
        (Ray::with_range(x, x, 2.0, 1.0), "its range from 2 to 1 is empty"),
    ];
    for (ray, reason) in rays {
        let error =
            scene.explain(&ray, Rule::default(), &NoProgress).expect_err(reason).to_string();
        assert_eq!(error, format!("ray: {reason}: it hits nothing"));
    }
}

/// Wants the end once it was asked so many times, and counts how often it is.
struct Patience {
    questions: AtomicUsize,
    enough: usize,
}

impl Patience {
    fn new(enough: usize) -> Patience {
        Patience { questions: AtomicUsize::new(0), enough }
    }

    fn questions(&self) -> usize {
        self.questions.load(Ordering::Relaxed)
    }
}

impl Observer for Patience {
    fn cancelled(&self) -> bool {
        self.questions.fetch_add(1, Ordering::Relaxed) >= self.enough
    }
}

#[test]
fn the_observer_is_asked_before_a_cell_is_split() {
    let mesh = grid_cube(4);
    let termination = Termination::automatic(mesh.triangle_count());
    for rule in Rule::ALL {
        let all = Patience::new(usize::MAX);
        let mut cells = Cells::new(&mesh, rule, termination, &all).expect("not interrupted");
        let mut number = 0;
        while let Content::Inner { children, .. } =
            cells.visit(number).expect("not interrupted").content
        {
            // Once for the mesh, and once for each cell that was split.
            assert!(all.questions() > cells.get(number).depth + 1, "{rule}");
            number = children[0];
        }
        assert!(cells.get(number).depth > 2, "{rule}");

        // Each of these questions can be the last.
        let first = Patience::new(0);
        assert!(matches!(Cells::new(&mesh, rule, termination, &first), Err(Error::Interrupted)));
        let second = Patience::new(1);
        let mut cells = Cells::new(&mesh, rule, termination, &second).expect("not interrupted");
        assert!(matches!(cells.visit(0), Err(Error::Interrupted)), "{rule}: split all the same");
        assert_eq!(cells.into_cells().len(), 1, "{rule}: split all the same");
    }
}

#[test]
fn an_explanation_ends_whenever_the_observer_says() {
    let scene = Scene::new(grid_cube(4)).expect("a valid mesh");
    let ray = Ray::new(vec3(-9.0, 0.3, 0.2), vec3(1.0, 0.0, 0.0));
    let all = Patience::new(usize::MAX);
    let explanation = scene.explain(&ray, Rule::default(), &all).expect("not interrupted");
    let split = |cell: &&halfline::explain::Cell| matches!(cell.content, Content::Inner { .. });
    assert!(all.questions() > explanation.cells.iter().filter(split).count());
    for enough in 0..all.questions() {
        let outcome = scene.explain(&ray, Rule::default(), &Patience::new(enough));
        assert!(matches!(outcome, Err(Error::Interrupted)), "after {enough} questions");
    }
}

#[test]
fn a_textbook_build_that_is_stopped_leaves_cells_whole() {
    let mesh = grid_cube(4);
    let termination = Termination::automatic(mesh.triangle_count());
    for rule in Rule::ALL {
        let planes_until = |stop: &dyn Fn(usize) -> bool| {
            let rule = rule.splitting_rule();
            let tree = KdTree::init_kd_tree_until(&mesh, rule, &termination, stop);
            let mut planes = Vec::new();
            textbook_planes(tree.root(), &mut planes);
            planes
        };
        let all = planes_until(&|_| false);
        // It is told how many triangles the cell has, the root's first.
        let root = mesh.triangle_count();
        assert_eq!(planes_until(&|triangles| triangles == root), [], "{rule}");
        let asked = Cell::new(0);
        let after_four = planes_until(&|_| asked.replace(asked.get() + 1) >= 4);
        assert_eq!(after_four, all[..4], "{rule}: the build goes depth first");
        assert!(all.len() > 4, "{rule}");
    }
}

#[test]
fn a_slice_shows_the_cells_that_points_lie_in() {
    for (name, mesh) in meshes() {
        let bounds = mesh.bounds();
        if bounds.is_empty() {
            continue;
        }
        for (rule, axis) in Rule::ALL.into_iter().flat_map(|rule| (0..3).map(move |a| (rule, a))) {
            let coordinate = bounds.min[axis] * 0.4 + bounds.max[axis] * 0.6;
            let plane = SlicePlane { axis, coordinate };
            let termination = Termination::automatic(mesh.triangle_count());
            let mut cells =
                Cells::new(&mesh, rule, termination, &NoProgress).expect("not interrupted");
            let slice = Slice::through(&mut cells, plane, 0.0, usize::MAX).expect("it is met");

            // The cells fill the picture, and each is the leaf that its middle lies in.
            let area = |[low, high]: [[f64; 2]; 2]| (high[0] - low[0]) * (high[1] - low[1]);
            let sum: f64 = slice.cells.iter().map(|cell| area(cell.rectangle)).sum();
            let whole = area(slice.rectangle);
            assert!((sum - whole).abs() <= 1e-9 * whole, "{name}, {rule}: {sum}, {whole}");
            for cell in &slice.cells {
                assert!(cell.is_leaf, "{name}, {rule}");
                let [low, high] = cell.rectangle;
                let middle = [0, 1].map(|i| low[i] * 0.5 + high[i] * 0.5);
                if !(0..2).all(|i| low[i] < middle[i] && middle[i] < high[i]) {
                    // Flat cells, as medians make them, hold no point for themselves.
                    continue;
                }
                let mut point = Vec3::ZERO;
                point[axis] = coordinate;
                for (i, at) in plane.axes().into_iter().enumerate() {
                    point[at] = middle[i];
                }
                assert_eq!(leaf_of(&cells, point), cell.cell, "{name}, {rule}: {cell:?}");
            }

            // Each segment lies in the plane and on the mesh's box.
            let [low, high] = slice.rectangle;
            for [p, q] in &slice.segments {
                for i in 0..2 {
                    assert!(low[i] <= p[i].min(q[i]) && p[i].max(q[i]) <= high[i], "{name}");
                }
            }
        }
    }
}

/// The leaf at a point, by planes alone.
fn leaf_of(cells: &Cells, point: Vec3) -> usize {
    let mut number = 0;
    while let Content::Inner { axis, plane, children } = &cells.get(number).content {
        number = children[usize::from(point[*axis] >= *plane)];
    }
    number
}

#[test]
fn a_slice_that_misses_is_refused() {
    let mesh = grid_cube(2);
    let termination = Termination::automatic(mesh.triangle_count());
    let mut cells =
        Cells::new(&mesh, Rule::Middle, termination, &NoProgress).expect("a valid mesh");
    for coordinate in [2.5, f64::NAN] {
        let plane = SlicePlane { axis: 1, coordinate };
        let error = Slice::through(&mut cells, plane, 0.0, 9).expect_err("outside").to_string();
        let expected = format!("slice: {coordinate} is outside of the mesh: y is from -2 to 2");
        assert_eq!(error, expected);
    }
    let slice = SlicePlane { axis: 1, coordinate: 0.5 };
    let slice = Slice::through(&mut cells, slice, 0.0, 9).expect("it is met");
    // The surface of the cube, in unit squares cut in two: each square of a side gives two segments.
    assert_eq!(slice.segments.len(), 4 * 4 * 2);
}
