//! PLY files of all shapes, right and wrong, written here.

use std::path::Path;

use proptest::prelude::*;

use super::scalar::Scalar;
use super::*;
use crate::{load, save_ply};

const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// An element: its name, its properties as in a header, and the numbers of its records, the counts
/// of lists among them.
type Table<'a> = (&'a str, &'a [&'a str], &'a [&'a [f64]]);

fn put(bytes: &mut Vec<u8>, encoding: &str, scalar: Scalar, value: f64) {
    macro_rules! put {
        ($type:ty) => {{
            let value = value as $type;
            match encoding {
                "ascii" => bytes.extend(format!("{value} ").bytes()),
                "binary_little_endian" => bytes.extend(value.to_le_bytes()),
                _ => bytes.extend(value.to_be_bytes()),
            }
        }};
    }
    match scalar {
        Scalar::I8 => put!(i8),
        Scalar::U8 => put!(u8),
        Scalar::I16 => put!(i16),
        Scalar::U16 => put!(u16),
        Scalar::I32 => put!(i32),
        Scalar::U32 => put!(u32),
        Scalar::I64 => put!(i64),
        Scalar::U64 => put!(u64),
        Scalar::F32 => put!(f32),
        Scalar::F64 => put!(f64),
    }
}

/// The PLY file with the given tables.
fn ply(encoding: &str, tables: &[Table]) -> Vec<u8> {
    let mut bytes = format!("ply\nformat {encoding} 1.0\ncomment made by a test\n").into_bytes();
    for (name, properties, rows) in tables {
        bytes.extend(format!("element {name} {}\n", rows.len()).bytes());
        for property in *properties {
            bytes.extend(format!("property {property}\n").bytes());
        }
    }
    bytes.extend(b"end_header\n");
    for (_, properties, rows) in tables {
        for row in *rows {
            let mut numbers = row.iter();
            for property in *properties {
                let words: Vec<&str> = property.split(' ').collect();
                let scalar = |i: usize| Scalar::from_name(words[i].as_bytes()).unwrap();
                if words[0] == "list" {
                    let count = *numbers.next().unwrap();
                    put(&mut bytes, encoding, scalar(1), count);
                    for _ in 0..count as usize {
                        put(&mut bytes, encoding, scalar(2), *numbers.next().unwrap());
                    }
                } else {
                    put(&mut bytes, encoding, scalar(0), *numbers.next().unwrap());
                }
            }
            assert_eq!(numbers.next(), None);
            if encoding == "ascii" {
                bytes.push(b'\n');
            }
        }
    }
    bytes
}

fn read_bytes(bytes: &[u8]) -> Result<Mesh> {
    read(Path::new("test.ply"), bytes, &NoProgress)
}

fn error_of(bytes: &[u8]) -> String {
    let error = read_bytes(bytes).unwrap_err().to_string();
    assert!(error.starts_with("test.ply: ") && !error.contains('\n'), "{error}");
    error
}

const XYZ: &[&str] = &["float x", "float y", "float z"];
const SQUARE: &[&[f64]] = &[&[0., 0., 0.], &[1., 0., 0.], &[1., 1., 0.], &[0., 1., 0.5]];
const FACES: &[&str] = &["list uchar int vertex_indices"];
const TWO: &[&[f64]] = &[&[3., 0., 1., 2.], &[3., 0., 2., 3.]];

fn square() -> Positions {
    Positions::F32(vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.5]].into())
}

/// Small valid files, of all encodings and with all paths through the readers.
fn samples() -> Vec<Vec<u8>> {
    let mixed: &[&[f64]] = &[&[3., 0., 1., 2.], &[4., 0., 1., 2., 3.], &[2., 0., 1.], &[0.]];
    let strip: &[&[f64]] = &[&[7., 0., 1., 2., -1., 1., 2., 3.]];
    let lists: &[&[f64]] =
        &[&[0., 0., 0., 0.], &[2., 7., 7., 1., 0., 0.], &[1., 7., 1., 1., 0.], &[0., 0., 1., 0.]];
    ENCODINGS
        .iter()
        .flat_map(|encoding| {
            [
                ply(encoding, &[("vertex", XYZ, SQUARE), ("face", FACES, TWO)]),
                ply(encoding, &[("face", FACES, mixed), ("vertex", XYZ, SQUARE)]),
                ply(
                    encoding,
                    &[
                        ("vertex", XYZ, SQUARE),
                        ("tristrips", &["list int int vertex_indices"], strip),
                    ],
                ),
                ply(
                    encoding,
                    &[
                        ("vertex", &["list uchar short l", "double x", "float y", "int z"], lists),
                        ("face", &["list uint ushort vertex_index"], TWO),
                    ],
                ),
            ]
        })
        .collect()
}

#[test]
fn extra_elements_and_properties_are_passed_over_in_any_order() {
    for encoding in ENCODINGS {
        let bytes = ply(
            encoding,
            &[
                (
                    "camera",
                    &["float fov", "list uchar double matrix"],
                    &[&[1., 2., 3., 4.], &[1., 0.]],
                ),
                (
                    "face",
                    &["uchar flags", "list uchar uint vertex_index", "list uchar float uv"],
                    &[&[7., 3., 0., 1., 2., 0.], &[7., 3., 0., 2., 3., 1., 0.5]],
                ),
                ("nothing", &[], &[&[], &[], &[]]),
                (
                    "vertex",
                    &["double quality", "float z", "float y", "list short char l", "float x"],
                    &[
                        &[9., 0., 0., 2., 5., 5., 0.],
                        &[9., 0., 0., 0., 1.],
                        &[9., 0., 1., 0., 1.],
                        &[9., 0.5, 1., 1., 5., 0.],
                    ],
                ),
                ("edge", &["int a", "int b"], &[&[0., 1.]]),
            ],
        );
        let mesh = read_bytes(&bytes).unwrap();
        assert_eq!(*mesh.positions(), square(), "{encoding}");
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.source_faces, None);
    }
}

#[test]
fn all_integer_types_count_and_name_vertices() {
    let types = [
        "char", "uchar", "short", "ushort", "int", "uint", "int8", "uint8", "int16", "uint16",
        "int32", "uint32", "int64", "uint64",
    ];
    for encoding in ENCODINGS {
        for count in types {
            for item in types {
                let property = format!("list {count} {item} vertex_indices");
                let bytes = ply(encoding, &[("vertex", XYZ, SQUARE), ("face", &[&property], TWO)]);
                let mesh = read_bytes(&bytes).unwrap();
                assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]], "{encoding} {property}");
            }
        }
    }
}

#[test]
fn coordinates_keep_their_precision() {
    for encoding in ENCODINGS {
        for (types, double) in [
            (["float", "float", "float"], false),
            (["float32", "short", "uchar"], false),
            (["float", "double", "float"], true),
            (["float64", "float64", "float64"], true),
            (["int", "float", "float"], true),
            (["uint", "short", "char"], true),
            (["int64", "float", "uint64"], true),
        ] {
            let properties = [0, 1, 2].map(|i| format!("{} {}", types[i], ["x", "y", "z"][i]));
            let properties = properties.each_ref().map(|p| &**p);
            let bytes = ply(encoding, &[("vertex", &properties, &[&[3., 1., 2.]])]);
            let expected = if double {
                Positions::F64(vec![[3., 1., 2.]].into())
            } else {
                Positions::F32(vec![[3., 1., 2.]].into())
            };
            assert_eq!(*read_bytes(&bytes).unwrap().positions(), expected, "{encoding} {types:?}");
        }
    }
    let wide = [16_777_217.0, 0.1, -1e300];
    for encoding in ENCODINGS {
        let bytes = ply(encoding, &[("vertex", &["int x", "double y", "double z"], &[&wide])]);
        assert_eq!(*read_bytes(&bytes).unwrap().positions(), Positions::F64(vec![wide].into()));
    }
}

#[test]
fn polygons_are_cut_and_small_faces_skipped() {
    let faces: &[&[f64]] =
        &[&[0.], &[3., 0., 1., 2.], &[2., 0., 1.], &[4., 0., 1., 2., 3.], &[1., 3.]];
    for encoding in ENCODINGS {
        let bytes = ply(encoding, &[("vertex", XYZ, SQUARE), ("face", FACES, faces)]);
        let mesh = read_bytes(&bytes).unwrap();
        assert_eq!(mesh.triangle_count(), 3, "{encoding}");
        assert_eq!(mesh.triangles()[0], [0, 1, 2]);
        assert_eq!(mesh.source_faces, Some(vec![1, 3, 3].into()));
        let quads: &[&[f64]] = &[&[4., 0., 1., 2., 3.]];
        let bytes = ply(encoding, &[("vertex", XYZ, SQUARE), ("face", FACES, quads)]);
        assert_eq!(read_bytes(&bytes).unwrap().source_faces, Some(vec![0, 0].into()));
    }
}

#[test]
fn strips_become_triangles() {
    for encoding in ENCODINGS {
        for (item, restart) in [("int", -1.), ("short", -1.), ("uint", f64::from(u32::MAX))] {
            let property = format!("list int {item} vertex_indices");
            let strips: &[&[f64]] =
                &[&[8., 0., 1., 2., 3., restart, 3., 2., 1.], &[2., 0., 1.], &[3., 1., 2., 3.]];
            let bytes =
                ply(encoding, &[("vertex", XYZ, SQUARE), ("tristrips", &[&property], strips)]);
            let mesh = read_bytes(&bytes).unwrap();
            let expected = [[0, 1, 2], [2, 1, 3], [3, 2, 1], [1, 2, 3]];
            assert_eq!(mesh.triangles(), expected, "{encoding} {item}");
            assert_eq!(mesh.source_faces, None);
        }
    }
}

#[test]
fn colours_are_read_from_all_types() {
    for encoding in ENCODINGS {
        for (kind, scale) in [("uchar", 1.), ("ushort", 257.), ("float", 1. / 255.), ("int", 1.)] {
            let names = ["red", "green", "blue", "alpha"].map(|name| format!("{kind} {name}"));
            let mut properties = XYZ.to_vec();
            properties.extend(names.iter().map(|name| &**name));
            let row = [0., 0., 0., 255. * scale, 0., 128. * scale, 51. * scale];
            let bytes = ply(encoding, &[("vertex", &properties, &[&row])]);
            let colors = read_bytes(&bytes).unwrap().vertex_colors;
            assert_eq!(colors, Some(vec![[255, 0, 128, 51]].into()), "{encoding} {kind}");
            let bytes = ply(encoding, &[("vertex", &properties[..6], &[&row[..6]])]);
            let colors = read_bytes(&bytes).unwrap().vertex_colors;
            assert_eq!(colors, Some(vec![[255, 0, 128, 255]].into()), "{encoding} {kind}");
            let bytes = ply(encoding, &[("vertex", &properties[..5], &[&row[..5]])]);
            assert_eq!(read_bytes(&bytes).unwrap().vertex_colors, None);
        }
    }
}

#[test]
fn a_point_cloud_is_a_mesh_without_triangles() {
    for encoding in ENCODINGS {
        for tables in [
            &[("vertex", XYZ, SQUARE)][..],
            &[("vertex", XYZ, SQUARE), ("face", &["int flags"], &[])],
        ] {
            let mesh = read_bytes(&ply(encoding, tables)).unwrap();
            assert_eq!((mesh.positions().len(), mesh.triangle_count()), (4, 0));
        }
        let mesh = read_bytes(&ply(encoding, &[("vertex", XYZ, &[])])).unwrap();
        assert!(mesh.positions().is_empty());
    }
}

#[test]
fn all_line_ends_and_comments_are_read() {
    let ascii = "ply\nformat ascii 1.0\ncomment \u{e9}\nobj_info any thing\n\nelement vertex 3\n\
                 property float x\nproperty   float\ty \nproperty float z\n\
                 element face 1\nproperty list uchar int vertex_indices\nend_header\n\
                 0 0 0\n1\t0  0 \n\n 0 1 nan\n3 0 1 2";
    for end in ["\n", "\r\n", "\r"] {
        let text = ascii.replace('\n', end);
        let mesh = read_bytes(text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles(), [[0, 1, 2]], "{end:?}");
        assert!(mesh.positions().get(2).z.is_nan());
        let broken = text.replace("nan", "none");
        let error = error_of(broken.as_bytes());
        assert!(error.contains("line 16: 'none' is not a number"), "{end:?}: {error}");
    }
    // The first byte of the body is a line feed, which must not be taken for the header's.
    for end in ["\n", "\r\n", "\r"] {
        let header = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\n\
                      property uchar y\nproperty uchar z\nend_header\n";
        let mut bytes = header.replace('\n', end).into_bytes();
        bytes.extend([b'\n', b'\r', b'\n']);
        let mesh = read_bytes(&bytes).unwrap();
        assert_eq!(*mesh.positions(), Positions::F32(vec![[10., 13., 10.]].into()), "{end:?}");
    }
}

#[test]
fn bytes_after_the_end_are_accepted() {
    for mut bytes in samples() {
        let mesh = read_bytes(&bytes).unwrap();
        bytes.extend(b"\n4 whatever \0 follows\n");
        let again = read_bytes(&bytes).unwrap();
        assert_eq!(mesh, again);
    }
}

#[test]
fn every_truncation_is_an_error_or_harmless() {
    for bytes in samples() {
        let whole = read_bytes(&bytes).unwrap();
        let binary = !bytes.windows(5).any(|w| w == b"ascii");
        for length in 0..bytes.len() {
            match read_bytes(&bytes[..length]) {
                Ok(_) if binary => panic!("{length} of {} bytes were accepted", bytes.len()),
                // A number may have lost digits, but no number may be missing.
                Ok(mesh) => assert_eq!(mesh.triangle_count(), whole.triangle_count()),
                Err(error) => {
                    let error = error.to_string();
                    assert!(error.starts_with("test.ply: ") && !error.contains('\n'), "{error}");
                }
            }
        }
    }
}

#[test]
fn wrong_headers_are_named() {
    let vertex = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    for (text, expected) in [
        ("plyx\n", "line 1: a PLY file begins with"),
        ("ply\n", "header: the file ends before a line 'end_header'"),
        ("ply\nend_header\n", "line 2: the header ends without a line 'format'"),
        ("ply\nformat ascii 2.0\n", "line 2: unknown format version '2.0'; known is 1.0"),
        ("ply\nformat ascii\n", "line 2: unknown format version ''"),
        ("ply\nformat binary 1.0\n", "line 2: unknown format 'binary'"),
        ("ply\nformat ascii 1.0\nformat ascii 1.0\n", "line 3: a second line 'format'"),
        ("ply\nformat ascii 1.0 x\n", "line 2: 'x' is one word too many"),
        ("ply\nbogus\n", "line 2: unknown keyword 'bogus'"),
        ("ply\nelement vertex -5\n", "line 2: element vertex has the count '-5'"),
        ("ply\nelement vertex 1e9\n", "count '1e9'"),
        ("ply\nelement vertex 99999999999999999999\n", "count '99999999999999999999'"),
        ("ply\nelement vertex\n", "expected 'element NAME COUNT'"),
        ("ply\nelement a 1\nelement a 1\n", "line 3: a second element a"),
        ("ply\nproperty float x\n", "a property before the first element"),
        ("ply\nelement a 1\nproperty quad x\n", "line 3: unknown property type 'quad'"),
        ("ply\nelement a 1\nproperty float\n", "a property without a name"),
        ("ply\nelement a 1\nproperty float x\nproperty int x\n", "a second property x"),
        ("ply\nelement a 1\nproperty list float int x\n", "must have an integer type"),
        ("ply\nelement a 1\nproperty list int\n", "unknown property type ''"),
        ("ply\nformat ascii 1.0\nend_header\n", "header: there is no element vertex"),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty list int int y\n\
             end_header\n",
            "header: element vertex has no property y that is one number",
        ),
        (
            &format!("ply\nformat ascii 1.0\n{vertex}element face 1\nend_header\n0 0 0\n"),
            "element face has no property list vertex_indices",
        ),
        (
            &format!(
                "ply\nformat ascii 1.0\n{vertex}element face 1\n\
                 property list uchar float vertex_indices\nend_header\n0 0 0\n"
            ),
            "property vertex_indices of element face must be a list of an integer type",
        ),
    ] {
        let error = error_of(text.as_bytes());
        assert!(error.contains(expected), "{text:?}: {error}");
    }
    let mut many = "ply\n".to_owned();
    for i in 0..5000 {
        many += &format!("element e{i} 0\n");
    }
    assert!(error_of(many.as_bytes()).contains("more than 4096 elements and properties"));
}

#[test]
fn counts_that_the_file_cannot_hold_are_refused_before_anything_is_allocated() {
    for encoding in ENCODINGS {
        let whole = ply(encoding, &[("vertex", XYZ, SQUARE), ("face", FACES, TWO)]);
        for (old, new, expected) in [
            ("vertex 4", "vertex 4000000000", "the header promises 4000000000 of it"),
            ("vertex 4", "vertex 18446744073709551615", "more than the 4294967294"),
            ("face 2", "face 4000000000", "the header promises 4000000000 of it"),
            ("face 2", "face 3", "face 2: the file ends before"),
        ] {
            let end = whole.windows(11).position(|w| w == b"end_header\n").unwrap();
            let header = std::str::from_utf8(&whole[..end]).unwrap().replace(old, new);
            let bytes = [header.as_bytes(), &whole[end..]].concat();
            let error = error_of(&bytes);
            assert!(error.contains(expected), "{encoding} {new}: {error}");
        }
        // An element that is of no use can be as large, and no larger.
        for count in ["4000000000", "18446744073709551615"] {
            let text = format!(
                "ply\nformat {encoding} 1.0\nelement e {count}\nproperty int i\n\
                 element vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
                 end_header\n"
            );
            let error = error_of(text.as_bytes());
            assert!(error.contains("e 0: the file ends before"), "{error}");
        }
    }
}

#[test]
fn wrong_indices_and_counts_are_named() {
    for encoding in ENCODINGS {
        for (property, index, reason) in [
            ("list uchar int vertex_indices", 4., "vertex index 4 is not below"),
            ("list uchar int vertex_indices", 2e9, "vertex index 2000000000 is not below"),
            ("list uchar int vertex_indices", -1., "vertex index -1 is negative"),
            ("list uchar uint vertex_indices", 4e9, "vertex index 4000000000 is not below"),
            ("list uchar short vertex_indices", -7., "vertex index -7 is negative"),
            ("list uchar uchar vertex_indices", 200., "vertex index 200 is not below"),
            ("list uchar int64 vertex_indices", -7., "vertex index -7 is negative"),
            ("list uchar uint64 vertex_indices", 4294967296., "vertex index 4294967296 is not"),
        ] {
            for face in [&[3., 0., index, 2.][..], &[4., 0., 1., 2., index]] {
                let faces: &[&[f64]] = &[&[3., 0., 1., 2.], face, &[3., 9., 9., 9.]];
                let bytes = ply(encoding, &[("vertex", XYZ, SQUARE), ("face", &[property], faces)]);
                let error = error_of(&bytes);
                let place = if encoding == "ascii" { "line 16: " } else { "face 1: " };
                assert!(error.contains(place) && error.contains(reason), "{encoding}: {error}");
            }
        }
        let strips: &[&[f64]] = &[&[3., 0., 1., -2.]];
        let bytes = ply(
            encoding,
            &[("vertex", XYZ, SQUARE), ("tristrips", &["list int int vertex_indices"], strips)],
        );
        assert!(error_of(&bytes).contains("vertex index -2 is negative"));
        let bytes = ply(encoding, &[("vertex", XYZ, &[]), ("face", FACES, TWO)]);
        assert!(error_of(&bytes).contains("vertex index 0 is not below the number of vertices, 0"));
    }
    // The largest count and index of 64 bits.
    for encoding in &ENCODINGS[1..] {
        let most: &[&[f64]] = &[&[3., 0., 1., 2.], &[1., u64::MAX as f64]];
        let faces = &["list uchar uint64 vertex_indices"];
        let bytes = ply(encoding, &[("vertex", XYZ, SQUARE), ("face", faces, most)]);
        let error = error_of(&bytes);
        assert!(error.contains("face 1: vertex index") && error.contains("not below"), "{error}");
        let mut bytes = ply(encoding, &[("vertex", XYZ, SQUARE)]);
        let end = bytes.windows(10).position(|w| w == b"end_header").unwrap();
        let face = "element face 1\nproperty list uint64 int vertex_indices\n";
        bytes.splice(end..end, face.bytes());
        bytes.extend([0xff; 40]);
        let error = error_of(&bytes);
        assert!(error.contains("face 0: the file ends before its end"), "{error}");
    }
    let negative: &[&[f64]] = &[&[3., 0., 1., 2.], &[-3.]];
    for encoding in &ENCODINGS[1..] {
        let faces = &["list char int vertex_indices"];
        let bytes = ply(encoding, &[("vertex", XYZ, SQUARE), ("face", faces, negative)]);
        let error = error_of(&bytes);
        assert!(error.contains("face 1: list vertex_indices has the count -3"), "{error}");
    }
}

#[test]
fn wrong_lines_are_named() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                  property float z\nproperty uchar q\nelement face 1\n\
                  property list uchar int vertex_indices\nend_header\n";
    for (body, expected) in [
        ("0 0 0 0\n0 0 O 0\n0 0 0 0\n3 0 1 2\n", "line 12: 'O' is not a number"),
        ("0 0 0 0\n0 0 0\n0 0 0 0\n3 0 1 2\n", "line 12: the line ends where a whole number"),
        ("0 0 0 0\n0 0 0 1.5\n0 0 0 0\n3 0 1 2\n", "line 12: '1.5' is not a whole number"),
        ("0 0 0 0\n0 0 0 256\n0 0 0 0\n3 0 1 2\n", "line 12: 256 is outside its type's range"),
        ("0 0 0 0\n0 0 0 0 0\n0 0 0 0\n3 0 1 2\n", "line 12: '0' is one value too many"),
        ("0 0 0 0\n0 0 0 0\n0 0 0 0\n3 0 1\n", "line 14: the line ends where a whole number"),
        ("0 0 0 0\n0 0 0 0\n0 0 0 0\n3 0 1 2.0\n", "line 14: '2.0' is not a whole number"),
        ("0 0 0 0\n0 0 0 0\n0 0 0 0\n-3 0 1 2\n", "line 14: -3 is outside its type's range"),
        ("0 0 0 0\n0 0 0 0\n0 0 0 0\n3 0 1 3\n", "line 14: vertex index 3 is not below"),
        ("0 0 0 0\n0 0 0 0\n0 0 0 0\n200 0 1 2\n", "line 14: the line ends where"),
        ("0 0 0 0\n0 0 0 0\n", "vertex 2: the file ends before it"),
        ("0 0 0 0\n0 0 0 0\n0 0 0 0\n", "face 0: the file ends before it"),
    ] {
        let error = error_of(format!("{header}{body}").as_bytes());
        assert!(error.contains(expected), "{body:?}: {error}");
    }
    let negative = header.replace("list uchar", "list int");
    let error = error_of(format!("{negative}0 0 0 0\n0 0 0 0\n0 0 0 0\n-3 0 1 2\n").as_bytes());
    assert!(error.contains("line 14: a list has the count -3"), "{error}");
}

/// Enough faces for several chunks and blocks, with a quad among the triangles or without.
fn large(encoding: &str, quad_at: Option<usize>) -> Vec<u8> {
    let vertices: Vec<[f64; 3]> =
        (0..70_000).map(|i| [f64::from(i), f64::from(i % 7), 0.0]).collect();
    let vertices: Vec<&[f64]> = vertices.iter().map(|v| &v[..]).collect();
    let faces: Vec<Vec<f64>> = (0..69_997)
        .map(|i| {
            let count = if quad_at == Some(i) { 4 } else { 3 };
            [count].into_iter().chain(i..i + count).map(|n| n as f64).collect()
        })
        .collect();
    let faces: Vec<&[f64]> = faces.iter().map(|f| &f[..]).collect();
    ply(encoding, &[("vertex", XYZ, &vertices), ("face", FACES, &faces)])
}

#[test]
fn chunks_are_put_together_in_order() {
    for encoding in ENCODINGS {
        let mesh = read_bytes(&large(encoding, None)).unwrap();
        assert_eq!(mesh.positions().len(), 70_000);
        assert_eq!(mesh.positions().get(66_666).x, 66_666.0);
        assert!(mesh.triangles().iter().zip(0..).all(|(t, i)| *t == [i, i + 1, i + 2]));
        assert_eq!(mesh.source_faces, None);
        for quad in [0, 5, 32_767, 32_768, 65_536, 69_996] {
            let mesh = read_bytes(&large(encoding, Some(quad))).unwrap();
            assert_eq!(mesh.triangle_count(), 69_998, "{encoding} {quad}");
            let sources = mesh.source_faces.as_ref().unwrap();
            assert_eq!(sources.len(), 69_998);
            for (i, &source) in sources.iter().enumerate() {
                assert_eq!(source as usize, if i > quad { i - 1 } else { i }, "{encoding}");
                if source as usize != quad {
                    assert_eq!(mesh.triangles()[i], [source, source + 1, source + 2]);
                }
            }
        }
    }
}

#[test]
fn the_first_wrong_face_is_named_whatever_the_threads() {
    let mut bytes = large("binary_little_endian", None);
    let start = bytes.len() - 69_997 * 13;
    for face in [40_000, 69_000] {
        bytes[start + face * 13 + 8] = 0xff;
    }
    assert!(error_of(&bytes).contains("face 40000: vertex index -"));
    let text = String::from_utf8(large("ascii", None)).unwrap();
    let text = text.replace("\n3 60000 ", "\n3 x ").replace("\n3 69000 ", "\n3 y ");
    let line = 10 + 70_000 + 60_001;
    assert!(error_of(text.as_bytes()).contains(&format!("line {line}: 'x' is not a whole")));
}

#[test]
fn distances_are_written_beside_colours() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.1]];
    let mut mesh = Mesh::new(corners, [[0, 1, 2]]).unwrap();
    let (distances, colors) = ([0.1, -2.0, f64::NAN], [[1, 2, 3, 255], [4, 5, 6, 255], [7; 4]]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.ply");
    save_distances(&mesh, &distances, &colors, &path, &NoProgress).unwrap();
    // The mesh is read again, with the colours and without the distances.
    mesh.vertex_colors = Some(colors.to_vec().into());
    assert_eq!(load(&path, &NoProgress).unwrap(), mesh);
    let content = std::fs::read(&path).unwrap();
    let header =
        b"uchar alpha\nproperty float quality\nproperty double scalar_distance\nelement face 1\n";
    assert!(content.windows(header.len()).any(|window| window == header));
    let second = [(-2.0_f32).to_le_bytes().as_slice(), &(-2.0_f64).to_le_bytes()].concat();
    assert!(content.windows(second.len()).any(|window| window == second));

    let error = save_distances(&mesh, &distances[..2], &colors, &path, &NoProgress).unwrap_err();
    assert_eq!(error.to_string(), "distances: expected one for each of 3 vertices, found 2");
}

fn any_mesh() -> impl Strategy<Value = Mesh> {
    (1_usize..40, 0_usize..60, any::<bool>(), any::<bool>(), any::<u64>()).prop_map(
        |(vertices, faces, double, colored, seed)| {
            let mut state = seed;
            let mut next = move || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                state >> 16
            };
            let mut point = || [0; 3].map(|_| f64::from(next() as i32) / 1000.0);
            let points: Vec<[f64; 3]> = (0..vertices).map(|_| point()).collect();
            let positions = if double {
                Positions::F64(points.into())
            } else {
                Positions::F32(points.iter().map(|p| p.map(|c| c as f32)).collect())
            };
            let mut index = || next() as u32 % vertices as u32;
            let triangles: Vec<_> = (0..faces).map(|_| [index(), index(), index()]).collect();
            let mut mesh = Mesh::new(positions, triangles).unwrap();
            let mut color = || [0; 4].map(|_| next() as u8);
            mesh.vertex_colors = colored.then(|| (0..vertices).map(|_| color()).collect());
            mesh
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn what_is_written_is_read_again(mesh in any_mesh()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        save_ply(&mesh, &path, &NoProgress).unwrap();
        prop_assert_eq!(load(&path, &NoProgress).unwrap(), mesh);
    }

    #[test]
    fn no_change_of_bytes_makes_the_reader_panic(
        sample in 0_usize..12,
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = samples().swap_remove(sample);
        for (place, value) in changes {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Err(error) = read_bytes(&bytes) {
            prop_assert!(!error.to_string().contains('\n'), "{}", error);
        }
        is_complete(&bytes, 1 << 20);
    }

    #[test]
    fn no_bytes_after_a_header_make_the_reader_panic(
        encoding in prop::sample::select(&ENCODINGS[..]),
        body in proptest::collection::vec(any::<u8>(), 0..200),
    ) {
        let mut bytes = ply(encoding, &[
            ("vertex", &["list char short l", "float x", "uchar y", "double z"], &[]),
            ("face", &["list int short vertex_indices"], &[]),
        ]);
        let header = String::from_utf8(bytes).unwrap();
        bytes = header.replace("vertex 0", "vertex 3").replace("face 0", "face 2").into_bytes();
        bytes.extend(body);
        let _ = read_bytes(&bytes);
    }
}
