//! Nothing makes the builder hang or explode. One test only: it measures the memory of its process.

mod common;

use common::{Random, check_structure, soup};
use halfline::progress::NoProgress;
use halfline::{BuildParameters, Preset, Ray, Scene, Vec3, brute_force};
use halfline_io::models::{Kind, generate};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// A million triangles of the worst kinds. Each build has to end, within twice the memory of that
/// of as many triangles of a scan, with right answers.
#[test]
fn a_million_degenerate_triangles_neither_hang_nor_explode() {
    const MILLION: usize = 1_000_000;
    let ordinary = {
        let mesh = generate(Kind::Scan, MILLION, 1, &NoProgress).expect("generates");
        let before = MEMORY.current_usage();
        MEMORY.reset_peak_usage();
        let scene = Scene::new(mesh).expect("builds");
        assert!(scene.tree().references >= MILLION);
        MEMORY.peak_usage() - before
    };

    let mut random = Random(5);
    let [a, b, c] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]].map(Vec3::from);
    let worst = [
        ("copies of one triangle", (0..MILLION).map(|_| [a, b, c]).collect::<Vec<_>>()),
        (
            "triangles through one point",
            (0..MILLION).map(|_| [Vec3::ZERO, random.point(), random.point()]).collect(),
        ),
        (
            "triangles in one plane",
            (0..MILLION)
                .map(|_| {
                    let corner =
                        |random: &mut Random| Vec3::from([random.signed(), random.signed(), 0.25]);
                    [corner(&mut random), corner(&mut random), corner(&mut random)]
                })
                .collect(),
        ),
        (
            "triangles that all cross one line",
            (0..MILLION)
                .map(|_| {
                    let tip = |z: f64, random: &mut Random| {
                        Vec3::from([random.signed() * 1e-3, random.signed() * 1e-3, z])
                    };
                    [tip(-1.0, &mut random), tip(1.0, &mut random), tip(0.0, &mut random)]
                })
                .collect(),
        ),
    ];
    let worst = worst.map(|(name, triangles)| (name, soup(triangles)));
    for ((name, mesh), preset) in worst.iter().flat_map(|one| Preset::ALL.map(|p| (one, p))) {
        let name = format!("{name}, {}", preset.name());
        let mesh = mesh.clone();
        let before = MEMORY.current_usage();
        MEMORY.reset_peak_usage();
        let parameters = BuildParameters::preset(preset);
        let scene = Scene::builder(mesh)
            .parameters(parameters)
            .observer(&NoProgress)
            .build()
            .expect("builds");
        let peak = MEMORY.peak_usage() - before;
        assert!(peak <= 2 * ordinary, "{name}: {peak} bytes, a scan takes {ordinary}");
        check_structure(&name, scene.tree(), scene.mesh());
        for i in 0..3 {
            let origin = random.point() * 2.0;
            let aim = if i == 0 { Vec3::from([0.25, 0.25, 0.125]) } else { random.point() * 0.3 };
            let ray = Ray::new(origin, aim - origin);
            let (engine, judge) = (
                scene.caster().intersect(&ray).unwrap_or(halfline::Hit::MISS),
                brute_force::closest(scene.mesh(), &ray),
            );
            assert_eq!(engine, judge, "{name}: {ray:?}");
        }
    }
}
