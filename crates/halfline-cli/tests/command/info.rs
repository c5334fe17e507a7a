//! `halfline info`.

use serde_json::{Value, json};

use crate::{Bench, CUBE};

#[test]
fn figures_of_a_cube() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    let figures = bench.figures("info cube.ply");
    assert_eq!(figures["triangles"], 12);
    assert_eq!(figures["vertices"], 8);
    assert_eq!(figures["precision"], "float32");
    assert_eq!(figures["bounds"], json!([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]));
    assert_eq!(figures["skipped"], 0);
    let tree = &figures["tree"];
    let whole = |name: &str| tree[name].as_u64().unwrap_or_else(|| panic!("{name} in {tree}"));
    let by_size: Vec<u64> = tree["leaves_by_size"]
        .as_array()
        .unwrap()
        .iter()
        .map(|count| count.as_u64().unwrap())
        .collect();
    assert_eq!(by_size.iter().sum::<u64>(), whole("leaves"));
    let references: u64 = by_size.iter().zip(0..).map(|(count, size)| count * size).sum();
    assert_eq!(references, whole("references"));
    assert!(references >= 12);
    assert_eq!(tree["references_per_triangle"].as_f64(), Some(references as f64 / 12.0));
    assert_eq!(whole("leaves"), whole("spatial_splits") + whole("object_splits") + 1);
    assert!(tree["sah_cost"].as_f64().unwrap() >= 1.0);
    assert!(tree["bytes_per_triangle"].as_f64().unwrap() > 0.0);
    for name in ["load_seconds", "build_seconds"] {
        assert!(figures[name].as_f64().is_some_and(|seconds| seconds > 0.0), "{name}");
    }
}

/// No triangle is cut for `fast`.
#[test]
fn presets_are_named_and_build_different_trees() {
    let bench = Bench::new();
    bench.run("generate hall -n 20000 -o hall.ply").succeeded();
    assert_eq!(bench.figures("info hall.ply")["preset"], "balanced");
    let mut references = Vec::new();
    for preset in ["fast", "balanced", "best"] {
        let figures = bench.figures(&format!("info hall.ply --preset {preset}"));
        assert_eq!(figures["preset"], preset);
        references.push(figures["tree"]["references_per_triangle"].as_f64().unwrap());
        let table = bench.run(&format!("info hall.ply --preset {preset}"));
        assert!(table.succeeded().stdout.contains(preset), "{}", table.stdout);
    }
    let [fast, balanced, best] = references[..] else { unreachable!("three presets") };
    assert!(fast == 1.0 && balanced > 1.0 && best > 1.0, "{references:?}");
}

#[test]
fn an_empty_mesh_has_no_bounds() {
    let bench = Bench::new();
    let header: String =
        CUBE.lines().take_while(|line| *line != "-1 -1 -1").map(|l| format!("{l}\n")).collect();
    bench.write("none.ply", header.replace("vertex 8", "vertex 0").replace("face 6", "face 0"));
    let figures = bench.figures("info none.ply");
    assert_eq!((&figures["triangles"], &figures["bounds"]), (&json!(0), &Value::Null));
    bench.run("info none.ply").succeeded();
}

#[test]
fn faces_that_nothing_can_hit_are_counted_by_reason() {
    let bench = Bench::new();
    let mesh = CUBE
        .replace("element vertex 8", "element vertex 9")
        .replace("4 3 2 1 0\n", "nan 0 0\n4 3 2 1 0\n")
        .replace("face 6", "face 9")
        + "3 0 0 1\n3 2 2 2\n3 0 1 8\n";
    bench.write("mesh.ply", mesh);
    let figures = bench.figures("info mesh.ply");
    assert_eq!(figures["triangles"], 15);
    assert_eq!(figures["skipped"], 3);
    assert_eq!(figures["skipped_degenerate"], 2);
    assert_eq!(figures["skipped_non_finite"], 1);
    assert_eq!(figures["bounds"], json!([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]));
}

#[test]
fn people_get_a_table_even_when_quiet() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    for line in ["info cube.ply", "info cube.ply --quiet"] {
        let outcome = bench.run(line);
        let text = &outcome.succeeded().stdout;
        for expected in ["cube.ply\n", "triangles", "x from -1 to 1", "bytes per triangle"] {
            assert!(text.contains(expected), "no {expected:?} in {text}");
        }
        assert!(!text.contains('\u{1b}'), "colours, though nobody sees them: {text:?}");
    }
}
