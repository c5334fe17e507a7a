use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use super::*;
use halfline::mesh::Positions;
use halfline::progress::{NoProgress, Stage};

const NUMBERS: [usize; 5] = [1, 2, 10, 1000, 123_456];

fn made(kind: Kind, triangles: usize, seed: u64) -> Mesh {
    generate(kind, triangles, seed, &NoProgress).unwrap()
}

fn singles(mesh: &Mesh) -> &[[f32; 3]] {
    match mesh.positions() {
        Positions::F32(positions) => positions,
        Positions::F64(_) => panic!("generated meshes are single precision"),
    }
}

/// FNV-1a over all that a mesh file would hold.
fn fingerprint(mesh: &Mesh) -> u64 {
    let positions = singles(mesh).iter().flatten().map(|c| c.to_bits());
    let indices = mesh.triangles().iter().flatten().copied();
    let materials = mesh.triangle_materials.iter().flatten().copied();
    positions
        .chain(indices)
        .chain(materials)
        .flat_map(u32::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
}

/// The triangles that belong to closed surfaces: all but those with one of `open` materials.
fn closed_part(kind: Kind, mesh: &Mesh) -> Vec<[u32; 3]> {
    let keep = |material: u32| match kind {
        Kind::Scan | Kind::Sphere | Kind::Tetra => true,
        // Floors, walls and fields come first.
        Kind::Balls | Kind::Gears | Kind::Rings | Kind::Tree => material > 0,
        // The glass balls; the fossils.
        Kind::Mount | Kind::Hall => material == 0,
        Kind::Soup | Kind::Layers | Kind::Sticks | Kind::Terrain | Kind::Teapot => false,
    };
    let material = |t: usize| mesh.triangle_materials.as_ref().map_or(0, |m| m[t]);
    let triangles = mesh.triangles().iter().enumerate();
    triangles.filter(|&(t, _)| keep(material(t))).map(|(_, &t)| t).collect()
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let expected: [(Kind, u64); 14] = [
        (Kind::Scan, 0xb5af_e5e4_009b_bd53),
        (Kind::Sphere, 0xb1de_fbe5_b0dd_c6c6),
        (Kind::Soup, 0xd2c2_783e_bc89_08dc),
        (Kind::Layers, 0xbc32_8427_64e4_8253),
        (Kind::Sticks, 0x803f_b488_37e9_1a4d),
        (Kind::Terrain, 0xb761_69d5_a22b_b09d),
        (Kind::Hall, 0x79eb_3d14_ccb9_58df),
        (Kind::Balls, 0xa67d_3c42_5482_f017),
        (Kind::Gears, 0x83e9_72ac_a6be_b1c7),
        (Kind::Mount, 0x89e3_237a_a01a_621f),
        (Kind::Rings, 0xa176_47a4_21eb_554a),
        (Kind::Teapot, 0x11d4_b767_4e02_3a73),
        (Kind::Tetra, 0x352b_d995_ea79_9f85),
        (Kind::Tree, 0x3e87_047d_5376_520a),
    ];
    for threads in [1, 4] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        // More vertices than one piece of work has.
        let got =
            pool.install(|| Kind::ALL.map(|kind| (kind, fingerprint(&made(kind, 40_000, 7)))));
        assert_eq!(got, expected, "{threads} threads: {got:#x?}");
    }
}

#[test]
fn another_seed_gives_another_mesh_where_that_is_said() {
    for kind in Kind::ALL {
        let differ = fingerprint(&made(kind, 5000, 1)) != fingerprint(&made(kind, 5000, 2));
        assert_eq!(differ, kind.is_random(), "{kind}");
    }
}

#[test]
fn numbers_of_triangles_are_as_near_as_documented() {
    for kind in Kind::ALL {
        for wanted in NUMBERS.into_iter().chain([300, 2345, 99_999, 300_000]) {
            let got = made(kind, wanted, 3).triangle_count();
            let n = wanted as f64;
            // The smallest mesh, and the allowed difference above it.
            let (smallest, difference) = match kind {
                Kind::Scan | Kind::Sphere => (12, (wanted % 2) as f64),
                Kind::Soup | Kind::Layers | Kind::Sticks => (1, 0.0),
                Kind::Terrain if wanted < 1000 => (2, n.sqrt()),
                Kind::Terrain => (2, 0.02 * n),
                Kind::Hall if wanted < 300 => (10, n),
                Kind::Hall => (10, 1.0),
                Kind::Balls => (116, if wanted < 600 { n } else { 0.10 * n }),
                Kind::Gears => (574, n),
                Kind::Mount => (26, if wanted < 1000 { n } else { 0.03 * n }),
                Kind::Rings => (422, if wanted < 1000 { n } else { 0.10 * n }),
                Kind::Teapot => (248, n.sqrt() * 9.0),
                Kind::Tetra => (4, n),
                Kind::Tree => (58, if wanted < 600 { n } else { 0.12 * n }),
            };
            if wanted <= smallest {
                assert_eq!(got, smallest, "{kind} {wanted}");
            } else {
                let off = got.abs_diff(wanted) as f64;
                assert!(off <= difference, "{kind}: {got} instead of {wanted}");
            }
        }
    }
}

#[test]
fn gears_and_tetra_have_the_nearest_size_factor() {
    assert_eq!(made(Kind::Gears, 36_610, 0).triangle_count(), 4 * 4 * 4 * 572 + 2);
    assert_eq!(made(Kind::Gears, 30_000, 0).triangle_count(), 4 * 4 * 4 * 572 + 2);
    assert_eq!(made(Kind::Gears, 20_000, 0).triangle_count(), 3 * 3 * 3 * 572 + 2);
    assert_eq!(made(Kind::Tetra, 4096, 0).triangle_count(), 4096);
    assert_eq!(made(Kind::Tetra, 2049, 0).triangle_count(), 4096);
    assert_eq!(made(Kind::Tetra, 2048, 0).triangle_count(), 1024);
}

#[test]
fn every_triangle_has_finite_corners_and_an_area() {
    for kind in Kind::ALL {
        for wanted in NUMBERS {
            let mesh = made(kind, wanted, 5);
            let mut used = vec![false; mesh.positions().len()];
            for t in 0..mesh.triangle_count() as u32 {
                let [a, b, c] = mesh.corners(t);
                let area = (b - a).cross(c - a).length();
                assert!(
                    area > 0.0 && area.is_finite(),
                    "{kind} {wanted}: {t} at {a:?} {b:?} {c:?}"
                );
                mesh.triangles()[t as usize].iter().for_each(|&v| used[v as usize] = true);
            }
            assert!(used.iter().all(|&u| u), "{kind} {wanted}: a vertex is not used");
            if let Some(materials) = &mesh.triangle_materials {
                assert_eq!(materials.len(), mesh.triangle_count());
                assert!(materials.iter().all(|&m| (m as usize) < mesh.materials.len()));
            }
        }
    }
}

#[test]
fn closed_surfaces_are_closed() {
    for kind in Kind::ALL {
        for wanted in NUMBERS {
            let mesh = made(kind, wanted, 11);
            let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
            for [a, b, c] in closed_part(kind, &mesh) {
                for edge in [(a, b), (b, c), (c, a)] {
                    *edges.entry(edge).or_default() += 1;
                }
            }
            for (&(a, b), &times) in &edges {
                assert_eq!(times, 1, "{kind} {wanted}: edge {a} {b} runs twice the same way");
                assert_eq!(edges.get(&(b, a)), Some(&1), "{kind} {wanted}: edge {a} {b} is open");
            }
        }
    }
}

#[test]
fn closed_surfaces_have_their_front_outside() {
    for kind in Kind::ALL {
        let mesh = made(kind, 30_000, 11);
        let triangles = closed_part(kind, &mesh);
        // The volume of each connected piece, as seen from one of its own vertices.
        let mut parent: Vec<u32> = (0..mesh.positions().len() as u32).collect();
        fn root(parent: &mut [u32], mut v: u32) -> u32 {
            while parent[v as usize] != v {
                parent[v as usize] = parent[parent[v as usize] as usize];
                v = parent[v as usize];
            }
            v
        }
        for t in &triangles {
            let first = root(&mut parent, t[0]);
            for &v in &t[1..] {
                let other = root(&mut parent, v);
                parent[other as usize] = first;
            }
        }
        let mut volumes: HashMap<u32, f64> = HashMap::new();
        for t in &triangles {
            let piece = root(&mut parent, t[0]);
            let from = mesh.positions().get(piece as usize);
            let [a, b, c] = t.map(|v| mesh.positions().get(v as usize) - from);
            *volumes.entry(piece).or_default() += a.dot(b.cross(c)) / 6.0;
        }
        let pieces = match kind {
            Kind::Scan | Kind::Sphere => 1,
            Kind::Soup | Kind::Layers | Kind::Sticks | Kind::Terrain | Kind::Teapot => 0,
            Kind::Tetra => triangles.len() / 4,
            Kind::Gears => triangles.len() / 572,
            Kind::Balls => 1 + 9 + 81,
            Kind::Mount => 4,
            Kind::Hall => 10,
            Kind::Rings => 60 * (1 + 4),
            Kind::Tree => 2 * ((1 << 8) - 1),
        };
        assert_eq!(volumes.len(), pieces, "{kind}");
        assert!(volumes.values().all(|&v| v > 0.0), "{kind}");
    }
}

#[test]
fn meshes_are_where_they_are_said_to_be() {
    for wanted in [1000, 50_000] {
        let bounds = |kind| made(kind, wanted, 2).bounds();
        let within = |kind: Kind, low: [f64; 3], high: [f64; 3], slack: f64| {
            let b = bounds(kind);
            let slack = Vec3::splat(slack);
            let (low, high) = (Vec3::from(low), Vec3::from(high));
            assert!((b.min - low).abs().max_element() <= slack.x, "{kind}: {b:?}");
            assert!((b.max - high).abs().max_element() <= slack.x, "{kind}: {b:?}");
        };
        within(Kind::Sphere, [-1.0; 3], [1.0; 3], 0.02);
        within(Kind::Scan, [-1.1, -1.1, -0.5], [1.1, 1.1, 0.7], 0.2);
        within(Kind::Soup, [0.0; 3], [1.0; 3], 0.1);
        within(Kind::Layers, [0.0; 3], [1.0; 3], 0.02);
        within(Kind::Sticks, [0.0; 3], [1.0; 3], 0.01);
        within(Kind::Terrain, [-1.0, -1.0, 0.0], [1.0, 1.0, 0.5], 0.35);
        within(Kind::Hall, [-22.5, -10.0, 0.0], [22.5, 10.0, 15.0], 4.0);
        within(Kind::Balls, [-12.0, -12.0, -0.5], [12.0, 12.0, 0.75], 0.05);
        within(Kind::Gears, [-2.0, -2.0, 0.0], [2.0, 2.0, 1.0], 1e-6);
        within(Kind::Mount, [-1.0, -1.0, -0.5], [1.0, 1.0, 1.38], 0.8);
        within(Kind::Teapot, [-4.0, -4.0, 0.0], [4.0, 4.0, 3.15], 1e-3);
        within(Kind::Tetra, [-1.0; 3], [1.0; 3], 1e-6);
        within(Kind::Tree, [-50.0, -50.0, 0.0], [50.0, 50.0, 2.75], 0.4);
    }
}

#[test]
fn the_sphere_is_round_and_evenly_cut() {
    let mesh = made(Kind::Sphere, 50_000, 0);
    for &p in singles(&mesh) {
        assert!((Vec3::from(p).length() - 1.0).abs() < 1e-6);
    }
    let (low, high) = percentiles(&edge_lengths(&mesh));
    assert!(high / low < 1.6, "{low} {high}");
}

#[test]
fn the_scan_has_triangles_of_even_size() {
    let (low, high) = percentiles(&edge_lengths(&made(Kind::Scan, 200_000, 0)));
    assert!(high / low < 2.5, "{low} {high}");
}

/// The lengths of the square root of each triangle's area, in effect its size.
fn edge_lengths(mesh: &Mesh) -> Vec<f64> {
    (0..mesh.triangle_count() as u32)
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(c - a).length().sqrt()
        })
        .collect()
}

/// The values that a twentieth of all are below and above.
fn percentiles(values: &[f64]) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    (sorted[sorted.len() / 20], sorted[sorted.len() * 19 / 20])
}

#[test]
fn the_balls_touch_and_rest_on_the_floor() {
    let mesh = made(Kind::Balls, 40_000, 0);
    let lowest = singles(&mesh).iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
    assert_eq!(lowest, -0.5);
    // The largest child lies a third of its parent's radius further out, to one side of the pole.
    let highest = singles(&mesh).iter().map(|p| p[2]).fold(0.0, f32::max);
    assert!((0.7..1.0).contains(&highest), "{highest}");
}

#[test]
fn sizes_in_the_hall_differ_by_a_hundred_thousand() {
    let mesh = made(Kind::Hall, 2_000_000, 0);
    let areas: Vec<f64> = edge_lengths(&mesh).iter().map(|edge| edge * edge / 2.0).collect();
    let largest = areas.iter().copied().fold(0.0, f64::max);
    let small = areas.iter().filter(|&&area| area * 1e5 < largest).count();
    assert!(small > 1_000_000, "{small}");
}

/// In the planes of the floor, of the long walls and of the aisles' roofs.
#[test]
fn planks_in_the_hall_share_planes() {
    let mesh = made(Kind::Hall, 100_000, 0);
    let in_plane = |axis: usize, value: f32| {
        let is_there = |&v: &u32| singles(&mesh)[v as usize][axis] == value;
        mesh.triangles().iter().filter(|corners| corners.iter().all(is_there)).count()
    };
    assert!(in_plane(2, 0.0) > 1600, "{}", in_plane(2, 0.0));
    assert!(in_plane(1, -10.0) > 600 && in_plane(1, 10.0) > 600);
    assert!(in_plane(2, 11.6) > 40, "{}", in_plane(2, 11.6));
}

#[test]
fn the_furnished_hall_is_the_same_everywhere() {
    let got = fingerprint(&made(Kind::Hall, 550_000, 7));
    assert_eq!(got, 0xee4a_af5e_b6b7_bde0, "{got:#x}");
}

#[test]
fn views_see_the_mesh() {
    for kind in Kind::ALL {
        let Some(view) = suggested_view(kind) else { continue };
        let mesh = made(kind, 20_000, 1);
        let forward = (view.at - view.from).normalized();
        let across = forward.cross(view.up).length();
        assert!(across > 0.1, "{kind}: looks along up");
        let seen = singles(&mesh)
            .iter()
            .filter(|&&p| {
                let to = Vec3::from(p) - view.from;
                let ahead = to.dot(forward);
                let aside = (to - forward * ahead).length();
                ahead > 0.0 && aside < ahead * libm::tan(view.angle_degrees.to_radians() / 2.0)
            })
            .count();
        assert!(seen * 2 > singles(&mesh).len(), "{kind}: sees {seen}");
    }
}

#[test]
fn names_are_read_as_they_are_written() {
    for kind in Kind::ALL {
        assert_eq!(kind.to_string().parse::<Kind>().unwrap(), kind);
        assert!(!kind.description().contains('\n') && kind.description().len() < 80);
    }
    let error = "dragon".parse::<Kind>().unwrap_err().to_string();
    assert!(error.contains("\"dragon\"") && error.contains("teapot"), "{error}");
}

#[test]
fn impossible_numbers_are_refused() {
    for kind in Kind::ALL {
        for wanted in [0, MAX_TRIANGLES + 1, usize::MAX] {
            let error = generate(kind, wanted, 0, &NoProgress).unwrap_err();
            assert!(matches!(error, Error::Invalid { .. }), "{kind} {wanted}: {error}");
        }
    }
}

/// Asks for the end after a number of looks.
struct Impatient {
    patience: AtomicU64,
}

impl Observer for Impatient {
    fn cancelled(&self) -> bool {
        self.patience
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |p| p.checked_sub(1))
            .is_err()
    }
}

#[test]
fn every_kind_can_be_interrupted_on_the_way() {
    for kind in Kind::ALL {
        let observer = Impatient { patience: AtomicU64::new(3) };
        let result = generate(kind, 300_000, 0, &observer);
        assert!(matches!(result, Err(Error::Interrupted)), "{kind}");
    }
}

/// Remembers what it was told.
#[derive(Default)]
struct Diary {
    reports: std::sync::Mutex<Vec<(Stage, u64, u64)>>,
}

impl Observer for Diary {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        self.reports.lock().unwrap().push((stage, done, total));
    }
}

#[test]
fn progress_rises_to_the_end() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for kind in Kind::ALL {
        let diary = Diary::default();
        pool.install(|| generate(kind, 200_001, 0, &diary)).unwrap();
        let reports = diary.reports.into_inner().unwrap();
        assert!(reports.iter().all(|&(stage, _, total)| stage == Stage::Load && total == 200_001));
        assert!(reports.is_sorted_by_key(|&(_, done, _)| done), "{kind}: {reports:?}");
        assert_eq!(reports.last().unwrap().1, 200_001, "{kind}");
        if matches!(kind, Kind::Scan | Kind::Sphere | Kind::Soup | Kind::Terrain | Kind::Hall) {
            assert!(reports.len() > 5, "{kind}: {reports:?}");
            // The hall's structure is one step; else steps are of one size.
            let longest = if kind == Kind::Hall { 0.5 } else { 0.15 };
            for pair in reports.windows(2) {
                let step = (pair[1].1 - pair[0].1) as f64;
                assert!(step <= longest * 200_001.0, "{kind}: {reports:?}");
            }
        }
    }
}
