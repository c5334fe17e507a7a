//! `halfline query`.

use npyz::Order;

use crate::files::{Array, Arrays, read_npz, write_rays};
use crate::{Bench, CUBE};

/// Eight rays: at the cube from -z and from +x, away from it, four that hit nothing by
/// definition, and one out of its middle.
const RAYS: [[f64; 8]; 8] = {
    const INF: f64 = f64::INFINITY;
    const NAN: f64 = f64::NAN;
    [
        [0.25, 0.5, -3.0, 0.0, 0.0, 1.0, 0.0, INF],
        [3.0, 0.25, 0.5, -0.5, 0.0, 0.0, 0.0, INF],
        [0.25, 0.5, -3.0, 0.0, 0.0, -1.0, 0.0, INF],
        [0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, INF],
        [NAN, 0.0, -3.0, 0.0, 0.0, 1.0, 0.0, INF],
        [0.25, 0.5, -3.0, 0.0, 0.0, 1.0, NAN, INF],
        [0.25, 0.5, -3.0, 0.0, 0.0, 1.0, 5.0, 1.0],
        [0.125, 0.25, 0.0, 0.0, 2.0, 0.0, 0.0, INF],
    ]
};

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    write_rays(&bench.path("rays.npy"), RAYS.as_flattened(), 8, "<f8", Order::C);
    bench
}

fn column<'a>(arrays: &'a Arrays, name: &str) -> &'a Array {
    &arrays.get(name).unwrap_or_else(|| panic!("no {name} in {arrays:?}")).1
}

#[test]
fn hits_have_the_documented_names_shapes_and_values() {
    let bench = bench();
    let figures = bench.figures("query cube.ply rays.npy -o hits.npz");
    assert_eq!(figures["rays"], 8);
    assert_eq!(figures["invalid_rays"], 4);
    assert_eq!(figures["hits"], 3);
    assert_eq!(figures["engine"], "fast");
    assert!(figures["rays_per_second"].as_f64().unwrap() > 0.0);

    let hits = read_npz(&bench.path("hits.npz"));
    let shapes: Vec<_> =
        hits.iter().map(|(name, (shape, _))| (name.as_str(), shape.as_slice())).collect();
    let expected: [(&str, &[u64]); 4] =
        [("face", &[8]), ("source_face", &[8]), ("t", &[8]), ("uv", &[8, 2])];
    assert_eq!(shapes, expected);
    let inf = f64::INFINITY;
    assert_eq!(column(&hits, "t").floats(), [2.0, 4.0, inf, inf, inf, inf, inf, 0.375]);
    assert_eq!(column(&hits, "source_face").ints(), [0, 4, -1, -1, -1, -1, -1, 3]);
    let faces = column(&hits, "face").ints();
    // Each square of the cube was cut into two triangles, in order.
    let squares: Vec<i64> = faces.iter().map(|&face| face.div_euclid(2)).collect();
    assert_eq!(squares, [0, 4, -1, -1, -1, -1, -1, 3]);
    let uv = column(&hits, "uv").floats();
    for (ray, face) in faces.iter().enumerate() {
        let (u, v) = (uv[2 * ray], uv[2 * ray + 1]);
        assert!(*face < 0 || (u >= 0.0 && v >= 0.0 && u + v <= 1.0), "ray {ray}: {u} {v}");
    }
    assert_eq!(bench.names(), ["cube.ply", "hits.npz", "rays.npy"]);
}

#[test]
fn any_tells_only_whether() {
    let bench = bench();
    let figures = bench.figures("query cube.ply rays.npy -o hits.npz --any");
    assert_eq!((&figures["hits"], &figures["question"]), (&3.into(), &"any".into()));
    let hits = read_npz(&bench.path("hits.npz"));
    let expected = [true, true, false, false, false, false, false, true];
    assert_eq!(column(&hits, "occluded").bools(), expected);
    assert_eq!(hits.len(), 1);
}

#[test]
fn all_tells_every_crossing_in_order() {
    let bench = bench();
    let figures = bench.figures("query cube.ply rays.npy -o hits.npz --all");
    assert_eq!((&figures["hits"], &figures["hit_rays"]), (&5.into(), &3.into()));
    let hits = read_npz(&bench.path("hits.npz"));
    assert_eq!(column(&hits, "splits").ints(), [0, 2, 4, 4, 4, 4, 4, 4, 5]);
    assert_eq!(column(&hits, "t").floats(), [2.0, 4.0, 4.0, 8.0, 0.375]);
    assert_eq!(column(&hits, "source_face").ints(), [0, 1, 4, 5, 3]);
    assert_eq!(hits["uv"].0, [5, 2]);
}

#[test]
fn every_way_to_store_the_rays_gives_the_same_hits() {
    let bench = bench();
    // All numbers of the rays are exact in single precision.
    let mut expected = None;
    for dtype in ["<f8", ">f8", "<f4", ">f4"] {
        for order in [Order::C, Order::Fortran] {
            write_rays(&bench.path("rays.npy"), RAYS.as_flattened(), 8, dtype, order);
            bench.run("query cube.ply rays.npy -o hits.npz").succeeded();
            let bytes = std::fs::read(bench.path("hits.npz")).unwrap();
            assert_eq!(expected.get_or_insert(bytes.clone()), &bytes, "{dtype} {order:?}");
        }
    }
    // Six columns are the same as eight with a range from zero to infinity.
    let six: Vec<f64> = RAYS
        .iter()
        .filter(|ray| ray[6..] == [0.0, f64::INFINITY])
        .flat_map(|r| r[..6].to_vec())
        .collect();
    write_rays(&bench.path("rays.npy"), &six, 6, "<f8", Order::Fortran);
    bench.run("query cube.ply rays.npy -o hits.npz").succeeded();
    let hits = read_npz(&bench.path("hits.npz"));
    let inf = f64::INFINITY;
    assert_eq!(column(&hits, "t").floats(), [2.0, 4.0, inf, inf, inf, 0.375]);
}

#[test]
fn no_rays_give_no_hits() {
    let bench = bench();
    write_rays(&bench.path("rays.npy"), &[], 6, "<f4", Order::C);
    for (flag, name, shape) in
        [("", "uv", vec![0, 2]), ("--any", "occluded", vec![0]), ("--all", "splits", vec![1])]
    {
        bench.run(&format!("query cube.ply rays.npy -o hits.npz {flag}")).succeeded();
        assert_eq!(read_npz(&bench.path("hits.npz"))[name].0, shape);
    }
}

/// Rays between pseudo-random points of a box around the unit sphere, some with short ranges.
fn many_rays(count: usize) -> Vec<f64> {
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .flat_map(|_| {
            let mut ray = [0.0; 8].map(|_: f64| random() * 3.0 - 1.5);
            ray[6] = 0.0;
            ray[7] = if random() < 0.2 { 0.5 } else { f64::INFINITY };
            ray
        })
        .collect()
}

#[test]
fn engines_and_threads_agree_to_the_bit() {
    let bench = Bench::new();
    bench.run("generate sphere -n 2000 -o sphere.ply").succeeded();
    write_rays(&bench.path("rays.npy"), &many_rays(5000), 8, "<f8", Order::C);
    for question in ["", "--any", "--all"] {
        let mut expected = None;
        for how in ["fast --threads 1", "fast --threads 4", "textbook", "brute"] {
            let line = format!("query sphere.ply rays.npy -o hits.npz {question} --engine {how}");
            let figures = bench.figures(&line);
            assert!(figures["hits"].as_u64().unwrap() > 1000, "{line}: {figures}");
            let bytes = std::fs::read(bench.path("hits.npz")).unwrap();
            assert!(expected.get_or_insert(bytes.clone()) == &bytes, "{line} differs");
        }
    }
}

#[test]
fn more_rays_than_a_batch_keep_their_order() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    // Ray i starts i / 2^20 before the square at z = -1; every seventh looks away.
    let count = 600_000;
    let rays: Vec<f64> = (0..count)
        .flat_map(|i| {
            let away = if i % 7 == 0 { -1.0 } else { 1.0 };
            [0.25, 0.5, -1.0 - f64::from(i) / 1048576.0, 0.0, 0.0, away]
        })
        .collect();
    let expected: Vec<f64> = (0..count)
        .map(|i| if i % 7 == 0 && i > 0 { f64::INFINITY } else { f64::from(i) / 1048576.0 })
        .collect();
    for order in [Order::C, Order::Fortran] {
        write_rays(&bench.path("rays.npy"), &rays, 6, "<f8", order);
        bench.run("query cube.ply rays.npy -o hits.npz").succeeded();
        let hits = read_npz(&bench.path("hits.npz"));
        assert!(column(&hits, "t").floats() == expected, "{order:?}");
    }
    bench.run("query cube.ply rays.npy -o hits.npz --all").succeeded();
    let hits = read_npz(&bench.path("hits.npz"));
    let (splits, t) = (column(&hits, "splits").ints(), column(&hits, "t").floats());
    assert_eq!(splits.len(), count as usize + 1);
    for i in [1, 262_143, 262_144, 262_145, 524_289, 599_998] {
        let firsts = &t[splits[i] as usize..splits[i + 1] as usize];
        let first = if expected[i].is_finite() { Some(&expected[i]) } else { None };
        assert_eq!(firsts.first(), first, "ray {i}");
        assert_eq!(firsts.len(), if first.is_some() { 2 } else { 0 }, "ray {i}");
    }
}

#[test]
#[cfg(unix)]
fn rays_may_come_on_standard_input() {
    let bench = bench();
    bench.run("query cube.ply rays.npy -o file.npz").succeeded();
    let rays = std::fs::File::open(bench.path("rays.npy")).unwrap();
    let mut cat = std::process::Command::new("cat")
        .stdin(rays)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut command = bench.command("query cube.ply - -o pipe.npz");
    let output = command.stdin(cat.stdout.take().unwrap()).output().unwrap();
    cat.wait().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    let bytes = |name: &str| std::fs::read(bench.path(name)).unwrap();
    assert_eq!(bytes("pipe.npz"), bytes("file.npz"));
}

#[test]
fn people_get_a_summary_unless_quiet() {
    let bench = bench();
    let outcome = bench.run("query cube.ply rays.npy -o hits.npz");
    let text = &outcome.succeeded().stdout;
    for expected in ["hits.npz\n", "12 triangles", "8 rays", "3 rays hit", "invalid"] {
        assert!(text.contains(expected), "no {expected:?} in {text}");
    }
    let outcome = bench.run("query cube.ply rays.npy -o hits.npz --quiet");
    assert_eq!(outcome.succeeded().stdout, "");
}

#[test]
fn triangles_that_nothing_can_hit_are_counted_by_the_engine_that_looks() {
    let bench = Bench::new();
    let flat = CUBE.replace("element face 6", "element face 7") + "3 0 1 1\n";
    bench.write("flat.ply", flat);
    let rays = [5.0, 0.1, 0.2, -1.0, 0.0, 0.0];
    write_rays(&bench.path("rays.npy"), &rays, 6, "<f8", Order::C);
    let line = "query flat.ply rays.npy -o hits.npz";
    assert_eq!(bench.figures(line)["skipped"], 1);
    assert!(bench.figures(&format!("{line} --engine brute"))["skipped"].is_null());
    assert!(bench.run(line).stdout.contains("1 without area, 0 not finite"));
}
