use std::fs;
use std::path::Path;

use halfline::mesh::Material;
use halfline::progress::NoProgress;
use halfline_io::obj::read;

use super::{assert_fails, assert_reports_and_stops, is_single_precision, mesh_of, points};

const TRIANGLE: [[f64; 3]; 3] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];

#[test]
fn forms_of_the_same_triangle() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for text in [
        format!("{v}f 1 2 3\n"),
        format!("{v}f 1 2 3"),
        format!("{v}f -3 -2 -1\n"),
        format!("{v}f 1/1 2/2 3/3\n"),
        format!("{v}f 1//1 2//2 3//3\n"),
        format!("{v}f 1/9/9 2/9/9 -1/-9/-9\n"),
        format!("{v}f +1 2/ 3//\n"),
        format!("f 1 2 3\n{v}"),
        format!("\u{feff}# comment\n\n{v}\n\nf\t1\t2   3  \n# end"),
        format!("{v}f 1 2 3\n").replace('\n', "\r\n"),
        format!("{v}f 1 2 3\n").replace('\n', "\r"),
        format!("{v}f 1 \\\n2 \\\r\n  3\n"),
        format!("# a path \\\n{v}f 1 2 3\n"),
        format!("{v}f 1 2 3  # top"),
        format!("{v}f 1 2 3 #top # 4"),
        format!("{v}f 1/1 2/2 3/3\t# a path \\\n"),
        format!("{v}f 1 \\\n2 3 # a path \\\n# end"),
        "v 0 0 0 # 1 1 1\nv 1 0 0 #\nv 0 1 0 0.5 # a path \\\nf 1 2 3\n".to_owned(),
        format!("{v}vt 0 0 # t\nvn 0 0 1 # n\ng a # g\ns 1 # s\nusemtl none # m\nf 1 2 3\n"),
        "v 0 0 0 1.0\nv 1 0 0 0.5\nv 0 1 0 1\nf 1 2 3\n".to_owned(),
        "v +0 -0.0 0e0\nv 1. 0 0\nv .0 1E+0 0\nf 1 2 3\n".to_owned(),
        format!(
            "mtllib\nmtllib gone.mtl\no thing\ng a b\ns off\nusemtl none\n{v}vt 0 0\nvn 0 0 1\nvp 1\nl 1 2\np 1\ncurv 0 1 1 2\nunknown x y\nf 1 2 3\n"
        ),
    ] {
        let mesh = mesh_of(read, &text);
        assert_eq!(points(&mesh), TRIANGLE, "{text:?}");
        assert_eq!(mesh.triangles(), [[0, 1, 2]], "{text:?}");
        assert!(is_single_precision(&mesh), "{text:?}");
        assert_eq!(mesh.source_faces, None);
        assert_eq!(mesh.vertex_colors, None);
        assert_eq!(mesh.triangle_materials, None);
        assert!(mesh.materials.is_empty());
    }
}

#[test]
fn coordinates_keep_double_precision() {
    let mesh = mesh_of(read, "v 4512345.678901 0.1 -1e-300\nv 1 2 3\nv 4 5 nan\nf 1 2 3");
    assert_eq!(points(&mesh)[..2], [[4512345.678901, 0.1, -1e-300], [1., 2., 3.]]);
    assert!(points(&mesh)[2][2].is_nan());
    assert!(!is_single_precision(&mesh));
}

#[test]
fn polygons_are_cut_and_traced_to_their_faces() {
    // A triangle, a concave quad, a triangle with backward indices, an L, a repeated corner.
    let text = "\
        v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n\
        v 0 0 1\nv 4 -2 1\nv 1 0 1\nv 4 2 1\nf 4 5 6 7\n\
        f -3 -2 -1\n\
        v 0 0 2\nv 2 0 2\nv 2 1 2\nv 1 1 2\nv 1 2 2\nv 0 2 2\nf 8 9 10 11 12 13\n\
        f 1 2 3 3\n";
    let mesh = mesh_of(read, text);
    assert_eq!(mesh.triangles()[..4], [[0, 1, 2], [3, 4, 5], [3, 5, 6], [4, 5, 6]]);
    assert_eq!(mesh.triangle_count(), 9);
    assert_eq!(mesh.triangles()[8], [0, 1, 2]);
    assert_eq!(mesh.source_faces.as_deref(), Some(&[0, 1, 1, 2, 3, 3, 3, 3, 4][..]));
    // The L is covered once: no triangle has its area outside.
    let area: f64 = (4..8)
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(c - a).z / 2.0
        })
        .inspect(|&area| assert!(area > 0.0))
        .sum();
    assert_eq!(area, 3.0);
}

#[test]
fn vertex_colors_from_one_or_from_255() {
    let mesh = mesh_of(read, "v 0 0 0 1 0 0.5\nv 1 0 0\nv 0 1 0 0 1 0 0.25\nf 1 2 3");
    let expected = [[255, 0, 128, 255], [255; 4], [0, 255, 0, 64]];
    assert_eq!(mesh.vertex_colors.as_deref(), Some(&expected[..]));
    let mesh = mesh_of(read, "v 0 0 0\nv 1 0 0 10 0 127\nv 0 1 0 1000 -5 1\nf 1 2 3");
    let expected = [[255; 4], [10, 0, 127, 255], [255, 0, 1, 255]];
    assert_eq!(mesh.vertex_colors.as_deref(), Some(&expected[..]));
}

#[test]
fn broken_files() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, place, reason) in [
        (format!("{v}f 1 2 0"), "line 4", "index 0"),
        (format!("{v}f 1 2 4"), "line 4", "index 4, but the file has 3 vertices"),
        (format!("{v}# \n\nf 1 2 -4"), "line 6", "index -4, but 3 vertices come before"),
        (format!("v 0 0 0\nf 1 1 -2\n{v}"), "line 2", "but 1 vertices come before"),
        (format!("{v}f 1 2 99999999999999999999"), "line 4", "is not a corner"),
        (format!("{v}f 1 2 3.0"), "line 4", "`3.0` is not a corner"),
        (format!("{v}f 1 2 x"), "line 4", "`x` is not a corner"),
        (format!("{v}f 1 2 /3"), "line 4", "`/3` is not a corner"),
        (format!("{v}f 1/a 2 3"), "line 4", "`1/a` is not a corner"),
        (format!("{v}f 1/1/1/1 2 3"), "line 4", "is not a corner"),
        (format!("{v}f 1 2"), "line 4", "three corners, found 2"),
        (format!("{v}f"), "line 4", "three corners, found 0"),
        (format!("{v}f 1 2 \\\n 9"), "line 5", "index 9"),
        (format!("{v}v 1 2"), "line 4", "three coordinates, found 2"),
        (format!("{v}v"), "line 4", "three coordinates, found 0"),
        (format!("{v}v 1 2 1,5"), "line 4", "`1,5` is not a number"),
        (format!("{v}f 1 2 # 3"), "line 4", "three corners, found 2"),
        (format!("{v}v 1 2 # 3"), "line 4", "three coordinates, found 2"),
        (
            format!("{v}v 1 2 \u{1b}[31m{}", "9".repeat(100)).replace("31m9", "31mx"),
            "line 4",
            "is not a number",
        ),
        (format!("{v}v 0 0 0 1 0 red"), "line 4", "`red` is not a number"),
        ("solid ascii\nfacet\n".to_owned(), "line 1", "`solid` is no statement of Wavefront OBJ"),
    ] {
        assert_fails(read, &text, place, reason);
    }
    assert_eq!(mesh_of(read, "").triangle_count(), 0);
    assert_eq!(mesh_of(read, "# nothing\n").triangle_count(), 0);
}

#[test]
fn materials_come_from_libraries_in_the_folder() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("scene");
    fs::create_dir_all(folder.join("lib")).unwrap();
    fs::write(root.path().join("outside.mtl"), "newmtl out\nKd 1 0 0\n").unwrap();
    fs::write(
        folder.join("my lib.mtl"),
        "# comment\nKd 9 9 9\nnewmtl red\n  Kd 1 0 0\n  d 0.5\n\
         newmtl shiny wax\r\n\tKd 0.5\n Ks 0.1 0.1 0.1\nNs 30\nillum 2\n",
    )
    .unwrap();
    fs::write(
        folder.join("lib/more.mtl"),
        "newmtl mirror\nKd 0 0 0\nKs 0.9 0.8 0.7\nillum 3\nNs 1e9\n\
         newmtl glass\nKd 1 1 1\nTr 0.75\nNi 1.33\nillum 7\nKd spectral file.rfl\nmap_Kd x.png\n",
    )
    .unwrap();
    let path = folder.join("mesh.obj");
    let text = "mtllib my lib.mtl\nmtllib gone.mtl lib/more.mtl\n\
        mtllib ../outside.mtl\nmtllib /outside.mtl\nmtllib http://host/outside.mtl\n\
        v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
        f 1 2 3\nf 1 2 3 4\nusemtl red\nf 1 2 3 4\nusemtl shiny wax\nf 1 2 3\nusemtl out\nf 1 2 3\n\
        usemtl glass\nf 1 2 3\nusemtl mirror\nf 1 2 3";
    let mesh = read(&path, text.as_bytes(), &NoProgress).unwrap();
    let roughness = (2.0_f32 / 32.0).powf(0.25);
    let base = Material::default();
    let expected = [
        Material { base_color: [1.0, 0.0, 0.0, 0.5], ..base },
        Material { base_color: [0.5, 0.5, 0.5, 1.0], roughness, ..base },
        Material {
            base_color: [0.9, 0.8, 0.7, 1.0],
            metallic: 1.0,
            roughness: (2.0_f32 / (1e9 + 2.0)).powf(0.25),
            ..base
        },
        Material { base_color: [1.0; 4], roughness: 0.0, transmission: 0.75, ior: 1.33, ..base },
        base,
    ];
    assert_eq!(mesh.materials, expected);
    let materials = mesh.triangle_materials.unwrap();
    assert_eq!(materials, [4, 4, 4, 0, 0, 1, 4, 3, 2]);

    fs::write(folder.join("bad.mtl"), "newmtl a\nNs very\n").unwrap();
    let error = read(&path, b"mtllib bad.mtl\nv 0 0 0\n", &NoProgress).unwrap_err().to_string();
    assert!(error.ends_with("bad.mtl: line 2: `very` is not a number"), "{error}");
}

#[test]
fn comments_stand_behind_names_and_names_may_hold_their_mark() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.obj");
    fs::write(folder.path().join("a #1.mtl"), "newmtl plain # a comment\nKd 0.25 # 1 1\n").unwrap();
    fs::write(
        folder.path().join("b.mtl"),
        "newmtl red #1 # first\nKd 1 0 0 # red\nnewmtl red #2\nKd 0.5 0 0\nd 1 # opaque\n\
         newmtl #00ff00\nKd 0 1 0\nNs 10 # a path \\\nnewmtl blue\nKd 0 0 1\n",
    )
    .unwrap();
    let mut text =
        "mtllib a #1.mtl\nmtllib b.mtl # colours\nv 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    let cases = [
        ("plain", [0.25; 3]),
        ("plain # the same", [0.25; 3]),
        ("red #2", [0.5, 0.0, 0.0]),
        ("red #1 # first", [1.0, 0.0, 0.0]),
        ("#00ff00", [0.0, 1.0, 0.0]),
        ("#00ff00 # green", [0.0, 1.0, 0.0]),
        ("blue\t#", [0.0, 0.0, 1.0]),
        ("#0000ff", [0.8; 3]),
    ];
    for (name, _) in cases {
        text += &format!("usemtl {name}\nf 1 2 3\n");
    }
    let mesh = read(&path, text.as_bytes(), &NoProgress).unwrap();
    let default = Material::default().base_color[0];
    for (face, (name, expected)) in cases.into_iter().enumerate() {
        let material = mesh.triangle_materials.as_ref().unwrap()[face];
        let [r, g, b, _] = mesh.materials[material as usize].base_color;
        let expected = if name == "#0000ff" { [default; 3] } else { expected };
        assert_eq!([r, g, b], expected, "{name}");
    }
}

#[test]
fn a_number_may_hold_the_mark_of_comments() {
    let mesh = mesh_of(read, "v 0 0 1.#INF\nv 1 0 0\nv 0 1 0 # 1.#INF\nf 1 2 3\n");
    assert_eq!(points(&mesh)[0][2], f64::INFINITY);
}

#[test]
fn progress_and_interruption() {
    let mut text = String::new();
    for i in 0..100_000 {
        text.push_str(&format!("v {i} 0 0\nf -1 -1 -1\n"));
    }
    assert_reports_and_stops(read, text.as_bytes());
}

#[test]
fn every_truncation_is_read_or_refused() {
    let text = b"mtllib x.mtl\nv 0 0 0 1 1 1\nv 1 0 0\nv 1 1 0\nv 0 1 \\\n0\nusemtl a\nf 1/1 2//2 3/3/3 -1\nf 1 2 3\n";
    for length in 0..=text.len() {
        if let Ok(mesh) = read(Path::new("mesh"), &text[..length], &NoProgress) {
            assert!(mesh.triangle_count() <= 3);
        }
    }
}
