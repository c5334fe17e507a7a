//! STL files of all shapes, right and wrong, written here.

use proptest::prelude::*;

use super::*;
use halfline::progress::NoProgress;

const TETRAHEDRON: [[[f32; 3]; 3]; 4] = [
    [[0., 0., 0.], [0., 1., 0.], [1., 0., 0.]],
    [[0., 0., 0.], [1., 0., 0.], [-0.0, 0., 1.]],
    [[0., 0., 0.], [0., 0., 1.], [0., 1., 0.]],
    [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]],
];

fn binary(header: &[u8], facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        bytes.extend([7; 12]);
        bytes.extend(facet.iter().flatten().flat_map(|c| c.to_le_bytes()));
        bytes.extend([0xab, 0xcd]);
    }
    bytes
}

fn ascii_text(facets: &[[[f32; 3]; 3]]) -> String {
    let mut text = "solid a tetrahedron\n".to_owned();
    for facet in facets {
        text += "facet normal 0 0 1e0\nouter loop\n";
        for [x, y, z] in facet {
            text += &format!("vertex {x:e} {y} {z:.3}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid a tetrahedron\n"
}

fn read_bytes(bytes: &[u8]) -> Result<Mesh> {
    read(Path::new("test.stl"), bytes, &NoProgress)
}

fn error_of(bytes: &[u8]) -> String {
    let error = read_bytes(bytes).unwrap_err().to_string();
    assert!(error.starts_with("test.stl: ") && !error.contains('\n'), "{error}");
    error
}

#[track_caller]
fn assert_tetrahedron(bytes: &[u8]) {
    let mesh = read_bytes(bytes).unwrap();
    let vertices = vec![[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [0., 0., 1.]];
    assert_eq!(*mesh.positions(), Positions::F32(vertices.into()));
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]]);
}

#[test]
fn binary_files_are_read_whatever_their_header_says() {
    for header in [&b""[..], b"solid", b"solid with facet in its name", &[b' '; 80], &[0xff; 80]] {
        let mut bytes = binary(header, &TETRAHEDRON);
        assert_tetrahedron(&bytes);
        bytes.extend(b"bytes after the end");
        assert_tetrahedron(&bytes);
    }
    let solid = [b"solid".to_vec(), vec![b' '; 75]].concat();
    assert_tetrahedron(&binary(&solid, &TETRAHEDRON));
    assert_eq!(read_bytes(&binary(b"", &[])).unwrap().triangle_count(), 0);
}

#[test]
fn ascii_files_are_read_in_all_styles() {
    let text = ascii_text(&TETRAHEDRON);
    assert_tetrahedron(text.as_bytes());
    assert_tetrahedron(text.replace('\n', "\r\n").as_bytes());
    assert_tetrahedron(text.replace('\n', "\r").as_bytes());
    assert_tetrahedron(text.replace('\n', "\n \t ").as_bytes());
    assert_tetrahedron(text.to_uppercase().as_bytes());
    assert_tetrahedron(text.replace(" a tetrahedron", "").as_bytes());
    assert_tetrahedron(text.replace("a tetrahedron", "\u{e9} solid facet").as_bytes());
    assert_tetrahedron(format!("\u{feff}\n {text}").as_bytes());
    assert_tetrahedron(format!("{text}\0\u{1a} bytes after the end").as_bytes());
    assert_tetrahedron(text.trim_end().as_bytes());
    // The facets in one line.
    assert_tetrahedron(text.replace('\n', " ").replacen(" facet", "\nfacet", 1).as_bytes());
}

#[test]
fn several_solids_are_one_mesh() {
    let text =
        [ascii_text(&TETRAHEDRON[..1]), ascii_text(&[]), ascii_text(&TETRAHEDRON[1..])].concat();
    assert_tetrahedron(text.as_bytes());
    assert_eq!(read_bytes(b"solid\nendsolid\n").unwrap().triangle_count(), 0);
}

#[test]
fn zeros_are_no_mesh_without_facets() {
    for (start, length) in [(&b"solid"[..], 84), (b"solid", 1000), (b"solid name\n", 90)] {
        let mut bytes = start.to_vec();
        bytes.resize(length, 0);
        let error = error_of(&bytes);
        assert!(error.contains("header: the file begins with 'solid' but is no text"), "{error}");
    }
    let error = error_of(&[0; 134]);
    assert!(error.contains("the header promises no facets, and 50 bytes follow"), "{error}");
    // In text, and in a binary file that ends there, nothing is a mesh of no triangles.
    for bytes in [&b"solid name\nendsolid name\n"[..], &[0; 84]] {
        assert_eq!(read_bytes(bytes).unwrap().triangle_count(), 0);
    }
}

#[test]
fn coordinates_with_more_digits_than_single_precision_stay_double() {
    let text = ascii_text(&TETRAHEDRON).replace("vertex 1e0 ", "vertex 412345.678 ");
    let mesh = read_bytes(text.as_bytes()).unwrap();
    assert_eq!(mesh.positions().get(2).x, 412_345.678);
    let text = ascii_text(&TETRAHEDRON).replace("vertex 1e0 ", "vertex 0.1000000015 ");
    let mesh = read_bytes(text.as_bytes()).unwrap();
    assert!(matches!(mesh.positions(), Positions::F32(p) if p[2][0] == 0.1));
}

#[test]
fn values_that_are_not_finite_are_kept() {
    let text = ascii_text(&TETRAHEDRON).replace("vertex 1e0 0", "vertex -nan(ind) inf");
    let mesh = read_bytes(text.as_bytes()).unwrap();
    let vertex = mesh.positions().get(2);
    assert!(vertex.x.is_nan() && vertex.y == f64::INFINITY);
}

#[test]
fn every_truncation_is_an_error_or_harmless() {
    let binary_bytes = binary(b"solid", &TETRAHEDRON);
    for length in 0..binary_bytes.len() {
        let error = error_of(&binary_bytes[..length]);
        let text = (5..80).contains(&length) && !binary_bytes[..length].contains(&0);
        let expected = if text { "endsolid" } else { "facet" };
        assert!(error.contains(expected) || error.contains("at least 84 bytes"), "{error}");
    }
    let text = ascii_text(&TETRAHEDRON);
    let end = text.rfind("endsolid").unwrap() + "endsolid".len();
    for length in 0..end {
        error_of(&text.as_bytes()[..length]);
    }
    for length in end..text.len() {
        assert_tetrahedron(&text.as_bytes()[..length]);
    }
}

#[test]
fn wrong_files_are_named() {
    let text = ascii_text(&TETRAHEDRON);
    let change = |old: &str, new: &str| error_of(text.replacen(old, new, 1).as_bytes());
    for (old, new, expected) in [
        ("vertex 0e0 1 0.000\n", "", "line 6: a facet with 2 vertices instead of 3"),
        ("endloop", "vertex 1 2 3\nendloop", "line 7: a facet with more than 3 vertices"),
        ("vertex 0e0 1 0.000", "vertex 0e0 1", "line 6: expected a number, not 'vertex'"),
        ("vertex 0e0 1 0.000", "vertex 0e0 1,0 0", "line 5: expected a number, not '1,0'"),
        ("normal 0 0 1e0", "normal 0 0 up", "line 2: expected a number, not 'up'"),
        ("normal 0 0 1e0", "", "line 3: expected 'normal', not 'outer'"),
        ("outer loop", "loop", "line 3: expected 'outer', not 'loop'"),
        ("endfacet\n", "", "line 8: expected 'endfacet', not 'facet'"),
        ("endfacet", "endfacet what", "line 8: expected 'facet' or 'endsolid', not 'what'"),
        ("endfacet", "endfacet\nendsolid", "line 10: a facet or an 'endsolid' outside"),
        ("endfacet", "endfacet\nsolid", "line 9: a 'solid' inside of a solid"),
        ("endsolid", "", "expected 'facet' or 'endsolid', not 'a'"),
    ] {
        let error = change(old, new);
        assert!(error.contains(expected), "{old:?} -> {new:?}: {error}");
    }
    let mut bytes = binary(b"", &TETRAHEDRON);
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = error_of(&bytes);
    assert!(error.contains("facet 4: the file ends before its end"), "{error}");
    assert!(error.contains("4294967295 facets"), "{error}");
    assert!(error_of(b"x").contains("at least 84 bytes, not 1"));
}

#[test]
fn blocks_are_put_together_in_order() {
    let facet = |i: usize| {
        let x = i as f32;
        [[x, 0., 0.], [x + 1., 0., 0.], [x, 1., (i % 5) as f32]]
    };
    let facets: Vec<_> = (0..40_000).map(facet).collect();
    let expected = read_bytes(&binary(b"", &facets)).unwrap();
    let text = ascii_text(&facets);
    assert!(text.len() > 10 * (256 << 10));
    assert_eq!(read_bytes(text.as_bytes()).unwrap(), expected);
    for (i, facet) in facets.iter().enumerate() {
        let corners = expected.corners(i as u32).map(|c| c.to_array().map(|x| x as f32));
        assert_eq!(corners, *facet);
    }
    // Nesting is checked within and across blocks, and lines are counted through all of them.
    let cut = ascii::end_of_block(text.as_bytes(), ascii::BLOCK_BYTES);
    assert!(text[cut..].starts_with("facet"));
    for place in [cut, text.len() / 2 + text[text.len() / 2..].find("facet normal").unwrap()] {
        let line = text[..place].matches('\n').count() + 1;
        let (before, after) = text.split_at(place);
        let error = error_of(format!("{before}endsolid\n{after}").as_bytes());
        assert!(error.contains(&format!("line {}: a facet or", line + 1)), "{error}");
        let error = error_of(format!("{before}solid\n{after}").as_bytes());
        assert!(error.contains(&format!("line {line}: a 'solid' inside")), "{error}");
        let error = error_of(format!("{before}what\n{after}").as_bytes());
        assert!(error.contains(&format!("line {line}: expected 'facet' or")), "{error}");
        let mesh = read_bytes(format!("{before}endsolid\nsolid\n{after}").as_bytes()).unwrap();
        assert_eq!(mesh, expected);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn no_change_of_bytes_makes_the_reader_panic(
        text in any::<bool>(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes =
            if text { ascii_text(&TETRAHEDRON).into_bytes() } else { binary(b"solid", &TETRAHEDRON) };
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Err(error) = read_bytes(&bytes) {
            prop_assert!(!error.to_string().contains('\n'), "{}", error);
        }
        is_complete(&bytes);
    }

    #[test]
    fn corners_are_those_of_the_file(
        facets in proptest::collection::vec(prop::array::uniform3(prop::array::uniform3(-3_i8..3)), 0..50)
    ) {
        let facets: Vec<_> = facets.iter().map(|f| f.map(|p| p.map(f32::from))).collect();
        let mesh = read_bytes(&binary(b"", &facets)).unwrap();
        prop_assert_eq!(mesh.triangle_count(), facets.len());
        for (i, facet) in facets.iter().enumerate() {
            prop_assert_eq!(mesh.corners(i as u32).map(|c| c.to_array().map(|x| x as f32)), *facet);
        }
        if let Positions::F32(vertices) = mesh.positions() {
            let mut bits: Vec<_> = vertices.iter().map(|v| v.map(f32::to_bits)).collect();
            bits.sort_unstable();
            bits.dedup();
            prop_assert_eq!(bits.len(), vertices.len());
        }
    }
}
