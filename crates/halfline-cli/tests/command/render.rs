//! `halfline render` and `halfline generate`.

use crate::{Bench, CUBE};

fn bytes(bench: &Bench, name: &str) -> Vec<u8> {
    std::fs::read(bench.path(name)).unwrap()
}

#[test]
fn a_picture_of_the_asked_size_and_its_figures() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    let figures = bench.figures("render cube.ply -o cube.png --resolution 80,60 --samples 2");
    assert_eq!((&figures["width"], &figures["height"]), (&80.into(), &60.into()));
    assert_eq!((&figures["triangles"], &figures["shading"]), (&12.into(), &"clay".into()));
    // One more than the samples for the layers of depth, normal and face.
    let primary = figures["rays_by_kind"]["primary"].as_u64().unwrap();
    assert_eq!(primary, 80 * 60 * 3);
    assert!(figures["rays"].as_u64().unwrap() > primary);
    let coverage = figures["coverage"].as_f64().unwrap();
    assert!(0.1 < coverage && coverage < 0.95, "{coverage}");
    for name in ["load_seconds", "build_seconds", "trace_seconds", "write_seconds"] {
        assert!(figures[name].as_f64().is_some_and(|seconds| seconds > 0.0), "{name}");
    }
    let png = bytes(&bench, "cube.png");
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    assert_eq!(png[16..24], [0, 0, 0, 80, 0, 0, 0, 60]);
    assert_eq!(bench.names(), ["cube.ply", "cube.png"]);
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let bench = Bench::new();
    bench.run("generate scan -n 2000 -o scan.ply").succeeded();
    for options in ["--shading clay", "--shading whitted --material glass --ground=checker"] {
        for kind in ["png", "exr"] {
            let mut expected = None;
            for threads in [1, 4] {
                let line = format!(
                    "render scan.ply -o out.{kind} --resolution 64,48 --samples 4 {options} \
                     --seed 3 --threads {threads}"
                );
                bench.run(&line).succeeded();
                let picture = bytes(&bench, &format!("out.{kind}"));
                assert!(expected.get_or_insert(picture.clone()) == &picture, "{line} differs");
            }
        }
    }
}

#[test]
fn options_reach_the_picture() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    let mut pictures = std::collections::HashMap::new();
    for options in [
        "",
        "--seed 1",
        "--samples 5",
        "--up +Z",
        "--up -Y",
        "--camera-position -3,4,5",
        "--camera-focal-point -0.5,0,0",
        "--camera-view-up 1,1,0",
        "--camera-view-angle 60",
        "--camera-azimuth-angle -40",
        "--camera-elevation-angle -40",
        "--camera-orthographic",
        "--camera-orthographic=9",
        "--background-color 1,0,0",
        "--background-color #00ff00",
        "--no-background",
        "--ground",
        "--ground=checker",
        "--ground=#402010",
        "--ground --ground-height -2",
        "--color #c08040",
        "--ground --occlusion-reach 0.05",
        "--occlusion-rays 1",
        "--shading whitted",
        "--shading whitted --material mirror",
        "--shading whitted --material glass",
        "--shading whitted --material glass --base-ior 2",
        "--shading whitted --material glass --max-depth 1",
        "--shading whitted --ground --ground-reflectivity 0.5",
        "--shading whitted --light point:position=3,4,5:intensity=40",
        "--shading whitted --light directional:direction=-1,-2,-3",
        "--shading whitted --light area:corner=2,4,2:edge-u=1,0,0:edge-v=0,0,1:radiance=20",
        "--shading normal",
        "--shading depth",
        "--shading face",
        "--shading steps",
    ] {
        let line = format!("render cube.ply -o out.png --resolution 48,36 --samples 4 {options}");
        let line = match options.contains("--samples") {
            true => line.replace("--samples 4 ", ""),
            false => line,
        };
        bench.run(&line).succeeded();
        if let Some(other) = pictures.insert(bytes(&bench, "out.png"), options) {
            panic!("`{options}` gives the same picture as `{other}`");
        }
    }
}

#[test]
fn people_get_a_summary_unless_quiet() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    let line = "render cube.ply -o cube.png --resolution 40,30 --samples 1";
    let outcome = bench.run(line);
    let text = &outcome.succeeded().stdout;
    for expected in ["cube.png\n", "load", "build", "trace", "rays/s", "40 x 30 pixels"] {
        assert!(text.contains(expected), "no {expected:?} in {text}");
    }
    assert_eq!(bench.run(&format!("{line} --quiet")).succeeded().stdout, "");
}

#[test]
fn the_same_seed_generates_the_same_file() {
    let bench = Bench::new();
    let figures = bench.figures("generate soup --triangles 0.3k --seed 5 -o a.ply");
    assert_eq!((&figures["triangles"], &figures["seed"]), (&300.into(), &5.into()));
    assert_eq!(figures["file_bytes"], bytes(&bench, "a.ply").len());
    bench.run("generate soup -n 300 --seed 5 -o b.ply --threads 3").succeeded();
    bench.run("generate soup -n 300 --seed 6 -o c.ply").succeeded();
    assert!(bytes(&bench, "a.ply") == bytes(&bench, "b.ply"));
    assert!(bytes(&bench, "a.ply") != bytes(&bench, "c.ply"));
    assert_eq!(bench.figures("info a.ply")["triangles"], 300);
}

#[test]
fn every_kind_is_generated_and_its_hint_renders() {
    let bench = Bench::new();
    for kind in halfline_io::models::Kind::ALL {
        let name = kind.name();
        let outcome = bench.run(&format!("generate {name} -n 2000 -o {name}.ply"));
        let hint = outcome.succeeded().stdout.lines().last().unwrap().trim();
        let line = hint.strip_prefix("halfline ").unwrap_or_else(|| panic!("{name}: {hint}"));
        let figures = bench.figures(&format!("{line} --resolution 32,24 --samples 1"));
        assert!(figures["coverage"].as_f64().unwrap() > 0.05, "{name}: {figures}");
    }
}

#[test]
fn triangles_that_cannot_be_seen_are_told() {
    let bench = Bench::new();
    let flat = CUBE.replace("element face 6", "element face 8") + "3 0 1 1\n3 2 2 2\n";
    bench.write("flat.ply", flat);
    let line = "render flat.ply -o flat.png --resolution 8,6 --samples 1";
    assert_eq!(bench.figures(line)["skipped"], 2);
    let outcome = bench.run(line);
    let said = &outcome.succeeded().stdout;
    assert!(said.contains("2 without area, 0 not finite"), "{said}");
    bench.write("points.off", "OFF 2 0 0\n0 0 0\n1 1 1\n");
    let outcome = bench.run(&line.replace("flat.ply", "points.off"));
    let said = &outcome.succeeded().stdout;
    assert!(said.contains("no triangles: there is nothing to see"), "{said}");
}

#[test]
fn a_camera_looks_straight_down_but_not_at_itself() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    let line = "render cube.ply -o top.png --resolution 8,6 --samples 1 --camera-focal-point 0,0,0";
    let figures = bench.figures(&format!("{line} --camera-position 0,9,0"));
    assert!(figures["coverage"].as_f64().unwrap() > 0.05);
    let outcome = bench.run(&format!("{line} --camera-position 0,0,0"));
    outcome.refused("--camera-position and --camera-focal-point are the same point");
}
