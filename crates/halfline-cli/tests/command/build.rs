//! `halfline build`, and trees where meshes may stand.

use std::fs;

use npyz::Order;

use crate::files::write_rays;
use crate::{Bench, CUBE};

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    bench.run("build cube.ply -o cube.hlt").succeeded();
    bench
}

#[test]
fn figures_and_table_tell_what_was_built() {
    let bench = bench();
    let figures = bench.figures("build cube.ply -o again.hlt --preset best");
    let bytes = fs::metadata(bench.path("again.hlt")).unwrap().len();
    assert_eq!(figures["triangles"], 12);
    assert_eq!(figures["preset"], "best");
    assert_eq!(figures["bytes"], bytes);
    assert_eq!(figures["bytes_per_triangle"], bytes as f64 / 12.0);
    let hash = figures["content_hash"].as_str().unwrap();
    assert!(hash.len() == 32 && hash.bytes().all(|b| b.is_ascii_hexdigit()), "{hash}");
    for name in ["load_seconds", "build_seconds", "write_seconds"] {
        assert!(figures[name].as_f64().is_some_and(|seconds| seconds > 0.0), "{name}");
    }
    let table = bench.run("build cube.ply -o again.hlt --preset best");
    for word in ["12 triangles", "best", "bytes per triangle", hash] {
        assert!(table.succeeded().stdout.contains(word), "{word}: {}", table.stdout);
    }
    assert_eq!(bench.run("build cube.ply -o again.hlt --quiet").succeeded().stdout, "");
}

/// The tree's content does not depend on when or where it was built.
#[test]
fn info_and_doctor_name_the_content() {
    let bench = bench();
    let hash = bench.figures("build cube.ply -o again.hlt")["content_hash"].clone();
    for command in ["info", "doctor"] {
        let figures = bench.figures(&format!("{command} cube.hlt"));
        assert_eq!(figures["content_hash"], hash, "{command}");
        assert_eq!(figures["preset"], "balanced");
        assert_eq!(figures["build_seconds"], 0.0);
        let table = bench.run(&format!("{command} cube.hlt"));
        assert!(table.succeeded().stdout.contains(hash.as_str().unwrap()), "{}", table.stdout);
        let of_mesh = bench.figures(&format!("{command} cube.ply"));
        assert!(of_mesh["content_hash"].is_null());
    }
}

#[test]
fn a_tree_takes_the_place_of_its_mesh() {
    let bench = bench();
    let rays: Vec<f64> =
        (0..60).flat_map(|i| [0.1, 0.2, -3.0, f64::from(i) / 99.0, 0.0, 1.0]).collect();
    write_rays(&bench.path("rays.npy"), &rays, 6, "<f8", Order::C);
    for question in ["", "--any", "--all"] {
        for engine in ["fast", "textbook", "brute"] {
            let [mesh, tree] = ["cube.ply", "cube.hlt"].map(|from| {
                bench
                    .run(&format!("query {from} rays.npy -o h.npz {question} --engine {engine}"))
                    .succeeded();
                fs::read(bench.path("h.npz")).unwrap()
            });
            assert!(mesh == tree, "{question} --engine {engine}");
        }
    }
    let [mesh, tree] = ["cube.ply", "cube.hlt"].map(|from| {
        bench.run(&format!("render {from} -o p.png --resolution 40,30")).succeeded();
        fs::read(bench.path("p.png")).unwrap()
    });
    assert!(mesh == tree, "the picture");
    let verdicts = ["cube.ply", "cube.hlt"]
        .map(|from| bench.figures(&format!("doctor {from}"))["verdict"].clone());
    assert_eq!(verdicts[0], verdicts[1]);
    // A tree of a tree is the same tree.
    let [first, second] = ["cube.ply", "cube.hlt"]
        .map(|from| bench.figures(&format!("build {from} -o copy.hlt"))["content_hash"].clone());
    assert_eq!(first, second);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let bench = bench();
    let before = bench.names();
    for line in [
        "info cube.hlt --preset balanced",
        "doctor cube.hlt --preset fast",
        "render cube.hlt -o x.png --preset best",
        "build cube.hlt -o x.hlt --preset best",
    ] {
        bench.run(line).refused("--preset cannot be used with cube.hlt: it is a tree");
    }
    bench.run("build cube.ply -o x.ply").refused("must end in .hlt");
    bench.run("build cube.hlt -o cube.hlt").refused("would overwrite the input");
    bench.run("build missing.ply -o x.hlt").failed("missing.ply", "No such file");
    bench.run("info missing.hlt").failed("missing.hlt", "No such file");
    let whole = fs::read(bench.path("cube.hlt")).unwrap();
    bench.write("cut.hlt", &whole[..whole.len() / 2]);
    bench.run("info cut.hlt").failed("cut.hlt", "");
    bench.write("ply.hlt", CUBE);
    bench.run("info ply.hlt").failed("ply.hlt", "");
    fs::remove_file(bench.path("cut.hlt")).unwrap();
    fs::remove_file(bench.path("ply.hlt")).unwrap();
    assert_eq!(bench.names(), before);
}
