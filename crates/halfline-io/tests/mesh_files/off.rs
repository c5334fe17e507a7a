use std::path::Path;

use halfline::progress::NoProgress;
use halfline_io::off::read;

use super::{assert_fails, assert_reports_and_stops, is_single_precision, mesh_of, points};

#[test]
fn forms_of_the_same_triangle() {
    for text in [
        "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "OFF\n3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2",
        "OFF 3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "OFF3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "# made\n\nOFF # it\n# counts\n3 1 0 # these\n\n0 0 0\n1 0 0\n#\n0 1 0 # last\n3 0 1 2\n",
        "OFF\r\n3 1 0\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2\r\n",
        "OFF\n3 1 0\n\t0\t0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\nbytes after the end\0\n",
        "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
        "STOFF\n3 1 0\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2 0.5 0.5 0.5 1\n",
        "STNOFF\n3 1 0\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 1\n3 0 1 2\n",
    ] {
        let mesh = mesh_of(read, text);
        assert_eq!(points(&mesh), [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], "{text:?}");
        assert_eq!(mesh.triangles(), [[0, 1, 2]], "{text:?}");
        assert_eq!(mesh.source_faces, None, "{text:?}");
        assert_eq!(mesh.vertex_colors, None, "{text:?}");
        assert!(is_single_precision(&mesh));
    }
    let exact = mesh_of(read, "OFF\n3 1 0\n4512345.678901 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    assert_eq!(points(&exact)[0], [4512345.678901, 0.0, 0.0]);
}

#[test]
fn vertex_colors() {
    let faces = "3 0 1 2\n";
    let red_half_white = [[255, 0, 0, 255], [0, 128, 0, 255], [255, 255, 255, 255]];
    for text in [
        "COFF\n3 1 0\n0 0 0 255 0 0\n1 0 0 0 128 0\n0 1 0 255 255 255\n",
        "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 128 0 255\n0 1 0 255 255 255 255\n",
        "COFF\n3 1 0\n0 0 0 1.0 0 0 1\n1 0 0 0 0.5 0 1\n0 1 0 1 1 1 1\n",
        "CNOFF\n3 1 0\n0 0 0 0 0 1 255 0 0\n1 0 0 0 0 1 0 128 0\n0 1 0 0 0 1 255 255 255\n",
        "NCOFF\n3 1 0\n0 0 0 0 0 1 255 0 0\n1 0 0 0 0 1 0 128 0\n0 1 0 0 0 1 255 255 255\n",
        "STCNOFF\n3 1 0\n0 0 0 0 0 1 1 0 0 .5 .5\n1 0 0 0 0 1 0 .5 0 0 0\n0 1 0 0 0 1 1 1 1 0 0\n",
        "OFF\n3 1 0\n0 0 0 255 0 0\n1 0 0 0 128 0\n0 1 0\n",
    ] {
        let mesh = mesh_of(read, format!("{text}{faces}"));
        assert_eq!(mesh.vertex_colors.as_deref(), Some(&red_half_white[..]), "{text:?}");
        assert_eq!(points(&mesh)[1], [1., 0., 0.], "{text:?}");
    }
}

#[test]
fn polygons_are_cut_and_traced_to_their_faces() {
    let text = "OFF\n5 5 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.1 0\n\
                4 0 1 2 3\n2 0 1\n1 4\n5 0 1 2 4 3\n3 0 1 2\n";
    let mesh = mesh_of(read, text);
    assert_eq!(mesh.triangle_count(), 6);
    assert_eq!(mesh.triangles()[..2], [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.source_faces.as_deref(), Some(&[0, 0, 3, 3, 3, 4][..]));
    for t in 2..5 {
        let [a, b, c] = mesh.corners(t);
        assert!((b - a).cross(c - a).z > 0.0, "{:?} is turned over", mesh.triangles()[t as usize]);
    }
}

#[test]
fn broken_files() {
    let vertices = "0 0 0\n1 0 0\n0 1 0\n";
    for (text, place, reason) in [
        ("".to_owned(), "line 1", "empty"),
        ("# only\n".to_owned(), "line 1", "empty"),
        ("OFF\n".to_owned(), "line 1", "before the number of vertices"),
        ("OFX\n".to_owned(), "line 1", "expected the keyword OFF, found `OFX`"),
        ("v 0 0 0\n".to_owned(), "line 1", "expected the keyword OFF"),
        ("OFF BINARY\n\0\0\0\u{3}".to_owned(), "line 1", "binary OFF is not supported"),
        ("COFF BINARY\n".to_owned(), "line 1", "binary OFF is not supported"),
        ("4OFF\n1 0 0\n0 0 0 0\n".to_owned(), "line 1", "`4OFF`: vertices with more than three"),
        ("nOFF\n3\n1 0 0\n".to_owned(), "line 1", "`nOFF`: vertices with more"),
        ("STC4nOFF\n3\n1 0 0\n".to_owned(), "line 1", "vertices with more"),
        ("OFF\n3\n".to_owned(), "line 2", "expected the numbers of vertices, faces and edges"),
        ("OFF\nthree 1 0\n".to_owned(), "line 2", "expected the numbers"),
        ("OFF\n1 2 3 4\n".to_owned(), "line 2", "expected the numbers"),
        ("OFF\n-3 1 0\n".to_owned(), "line 2", "negative"),
        ("OFF\n3.0 1 0\n".to_owned(), "line 2", "expected the numbers"),
        ("OFF\n4000000000 1 0\n0 0 0\n".to_owned(), "line 2", "more than the 6 bytes after it"),
        ("OFF\n999999999999999999 999999999999999999 0\n".to_owned(), "line 2", "more than"),
        (format!("OFF\n3 4000000000 0\n{vertices}3 0 1 2\n"), "line 2", "promises"),
        ("OFF\n3 0 0\n0 0 0\n1 0 0      \n\n\n".to_owned(), "line 6", "ends before vertex 2 of 3"),
        (
            "OFF\n3 0 0\n0 0 0\n1.5 0\n0 1 0\n".to_owned(),
            "line 4",
            "expected 3 numbers for a vertex, found 2",
        ),
        (
            "OFF\n3 0 0\n0 0 0\n1 0 0 0\n0 1 0\n".to_owned(),
            "line 4",
            "expected 3 numbers for a vertex, found 4",
        ),
        ("NOFF\n1 0 0\n0 0 0\n".to_owned(), "line 3", "expected 6 numbers for a vertex, found 3"),
        (
            "COFF\n1 0 0\n0 0 0\n".to_owned(),
            "line 3",
            "expected 6 or 7 numbers for a vertex, found 3",
        ),
        ("OFF\n1 0 0\n0 zero 0\n".to_owned(), "line 3", "`zero` is not a number"),
        (format!("OFF\n1 0 0\n{}\n", "1 ".repeat(50)), "line 3", "more than 12 numbers"),
        (format!("OFF\n3 2 0\n{vertices}3 0 1 2\n"), "line 6", "ends before face 1 of 2"),
        (format!("OFF\n3 1 0\n{vertices}3 0 1 3\n"), "line 6", "vertex index 3, but there are 3"),
        (format!("OFF\n3 1 0\n{vertices}3 0 1 -1\n"), "line 6", "vertex index -1"),
        (format!("OFF\n3 1 0\n{vertices}3 0 1 2.5\n"), "line 6", "`2.5` is not a vertex index"),
        (format!("OFF\n3 1 0\n{vertices}4 0 1 2\n"), "line 6", "promises 4 corners and has 3"),
        (format!("OFF\n3 1 0\n{vertices}999999999999999999 0 1 2\n"), "line 6", "and has 3"),
        (format!("OFF\n3 1 0\n{vertices}0 1 2 0\n"), "line 6", "expected a number of corners"),
        (format!("OFF\n3 1 0\n{vertices}x 0 1 2\n"), "line 6", "expected a number of corners"),
    ] {
        assert_fails(read, &text, place, reason);
    }
}

#[test]
fn progress_and_interruption() {
    let mut text = "OFF\n200000 0 0\n".to_owned();
    for i in 0..200_000 {
        text.push_str(&format!("{i} 0 0\n"));
    }
    assert_reports_and_stops(read, text.as_bytes());
}

#[test]
fn every_truncation_is_read_or_refused() {
    let text = b"STCNOFF # x\n4 2 0\n0 0 0 0 0 1 1 0 0 .5 .5\n1 0 0 0 0 1 0 .5 0 0 0\n1 1 0 0 0 1 1 1 1 0 0\n0 1 0 0 0 1 1 1 1 0 0\n4 0 1 2 3\n3 0 1 2 0.1 0.1 0.1\n";
    for length in 0..=text.len() {
        if let Ok(mesh) = read(Path::new("mesh"), &text[..length], &NoProgress) {
            assert!(mesh.triangle_count() <= 3);
        }
    }
}
