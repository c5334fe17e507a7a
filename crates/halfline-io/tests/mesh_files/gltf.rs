use std::fs;

use halfline::mesh::{Material, Mesh};
use halfline::progress::NoProgress;
use halfline_io::gltf::read;
use serde_json::{Value, json};

use super::gltf_build::{Build, glb_of};
use super::{assert_fails, is_single_precision, mesh_of, points};

const TRIANGLE: [[f64; 3]; 3] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];

fn mesh(build: &Build) -> Mesh {
    let embedded = mesh_of(read, build.embedded());
    assert_eq!(embedded, mesh_of(read, build.glb()), "embedded and GLB");
    embedded
}

/// The document with one value replaced: `pointer` is a JSON pointer.
pub fn with(build: &Build, pointer: &str, value: Value) -> Build {
    let mut build = build.clone();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = build.json.pointer_mut(parent).unwrap_or_else(|| panic!("{parent}"));
    match key.parse::<usize>() {
        Ok(index) => parent[index] = value,
        Err(_) => parent[key] = value,
    }
    build
}

#[test]
fn one_triangle() {
    let build = Build::triangle();
    let mesh = mesh(&build);
    assert_eq!(points(&mesh), TRIANGLE);
    assert_eq!(mesh.triangles(), [[0, 1, 2]]);
    assert!(is_single_precision(&mesh));
    assert_eq!(mesh.source_faces, None);
    assert_eq!(mesh.vertex_colors, None);
    assert_eq!(mesh.triangle_materials, None);
    assert!(mesh.materials.is_empty());

    // Bytes after the end, chunks of unknown kinds, a byte order mark, no nodes at all.
    let mut glb = build.glb();
    glb.extend_from_slice(b"more");
    assert_eq!(mesh_of(read, glb), mesh);
    let json =
        serde_json::to_vec(&with(&build, "/buffers", json!([{"byteLength": 36}])).json).unwrap();
    let strange =
        glb_of(&[(b"JSON", &json), (b"ODD!", b"1234"), (b"BIN\0", &build.binary), (b"ODD!", b"")]);
    assert_eq!(mesh_of(read, strange), mesh);
    assert_eq!(mesh_of(read, [&b"\xef\xbb\xbf"[..], &build.embedded()].concat()), mesh);
    assert_eq!(mesh_of(read, with(&build, "/nodes", json!([])).embedded()), mesh);
    assert_eq!(mesh_of(read, br#"{"asset": {"version": "2.0"}}"#).triangle_count(), 0);
}

#[test]
fn modes_and_index_types() {
    let quad = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.];
    for component in [5121, 5123, 5125] {
        for (mode, indices, expected) in [
            (json!(null), &[0, 1, 2, 2, 1, 3][..], &[[0, 1, 2], [2, 1, 3]][..]),
            (json!(4), &[3, 1, 0], &[[3, 1, 0]]),
            (json!(5), &[0, 1, 2, 3], &[[0, 1, 2], [1, 3, 2]]),
            (json!(5), &[0, 1, 2, 3, 0], &[[0, 1, 2], [1, 3, 2], [2, 3, 0]]),
            (json!(6), &[0, 1, 3, 2], &[[1, 3, 0], [3, 2, 0]]),
            (json!(5), &[0, 1], &[]),
            (json!(0), &[0, 1, 2], &[]),
            (json!(1), &[0, 1], &[]),
            (json!(2), &[0, 1], &[]),
            (json!(3), &[0, 1], &[]),
        ] {
            let mut build = Build::new();
            let positions = build.floats("VEC3", &quad);
            let indices = build.indices(component, indices);
            let attributes = json!({"POSITION": positions});
            build.mesh(json!([{"attributes": attributes, "indices": indices, "mode": mode}]));
            build.push("nodes", json!({"mesh": 0}));
            assert_eq!(mesh(&build).triangles(), expected, "{component} {mode}");
        }
    }
    // Not indexed.
    for (mode, expected) in [(5, [[0, 1, 2], [1, 3, 2]]), (6, [[1, 2, 0], [2, 3, 0]])] {
        let mut build = Build::new();
        let positions = build.floats("VEC3", &quad);
        build.mesh(json!([{"attributes": {"POSITION": positions}, "mode": mode}]));
        assert_eq!(mesh(&build).triangles(), expected, "{mode}");
    }
}

#[test]
fn strides_offsets_and_sparse_accessors() {
    // Interleaved: eight bytes before each position, sixteen between the first bytes of two.
    let mut build = Build::triangle();
    let mut bytes = vec![0xee; 4];
    for corner in TRIANGLE {
        bytes.extend([0xee; 8]);
        bytes.extend(corner.iter().flat_map(|&x| (x as f32).to_le_bytes()));
    }
    let view = build.view(&bytes);
    build.json["bufferViews"][view]["byteStride"] = json!(20);
    build.json["accessors"][0] = json!({
        "bufferView": view, "byteOffset": 12, "type": "VEC3", "componentType": 5126, "count": 3
    });
    assert_eq!(points(&mesh(&build)), TRIANGLE);

    // Sparse over a base, and over nothing.
    for base in [true, false] {
        for (component, index_bytes) in
            [(5121, vec![0_u8, 2]), (5123, vec![0, 0, 2, 0]), (5125, vec![0, 0, 0, 0, 2, 0, 0, 0])]
        {
            let mut build = Build::triangle();
            let indices = build.view(&index_bytes);
            let values: Vec<u8> =
                [7_f32, 8., 9., -1., -2., -3.].iter().flat_map(|x| x.to_le_bytes()).collect();
            let values = build.view(&values);
            build.json["accessors"][0]["sparse"] = json!({
                "count": 2,
                "indices": {"bufferView": indices, "componentType": component},
                "values": {"bufferView": values},
            });
            if !base {
                build.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
            }
            let middle = if base { [1., 0., 0.] } else { [0.; 3] };
            assert_eq!(points(&mesh(&build)), [[7., 8., 9.], middle, [-1., -2., -3.]]);
        }
    }
    // Sparse indices.
    let mut build = Build::triangle();
    let index = build.indices(5121, &[0, 0, 0]);
    build.json["meshes"][0]["primitives"][0]["indices"] = json!(index);
    let (at, values) = (build.view(&[1, 2]), build.view(&[2, 1]));
    build.json["accessors"][index]["sparse"] = json!({
        "count": 2, "indices": {"bufferView": at, "componentType": 5121},
        "values": {"bufferView": values},
    });
    assert_eq!(mesh(&build).triangles(), [[0, 2, 1]]);
}

#[test]
fn quantized_positions() {
    for (component, normalized, bytes, expected) in [
        (5121, false, &[0_u8, 1, 255, 9][..], [0., 1., 255.]),
        (5120, false, &[0, 0xff, 0x80, 9], [0., -1., -128.]),
        (5120, true, &[0, 127, 0x80, 9], [0., 1., -1.]),
        (5121, true, &[0, 51, 255, 9], [0., f64::from(51.0_f32 / 255.0), 1.]),
        (5122, false, &[0, 0, 0xff, 0xff, 1, 0x80, 9, 9], [0., -1., -32767.]),
        (5123, true, &[0, 0, 0xff, 0xff, 0, 0, 9, 9], [0., 1., 0.]),
    ] {
        let mut build = Build::triangle();
        let position = build.accessor("VEC3", component, 3, &bytes.repeat(3));
        build.json["accessors"][position]["normalized"] = json!(normalized);
        let view = build.json["accessors"][position]["bufferView"].as_u64().unwrap() as usize;
        build.json["bufferViews"][view]["byteStride"] = json!(bytes.len());
        build.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(position);
        build.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        assert_eq!(points(&mesh(&build))[2], expected, "{component} {normalized}");
    }
}

#[test]
fn nodes_place_meshes() {
    let half = 0.5_f64.sqrt();
    for (node, expected) in [
        (
            json!({"translation": [4512345.678901, 0.0, -2.5]}),
            [[4512345.678901, 0., -2.5], [4512346.678901, 0., -2.5], [4512345.678901, 1., -2.5]],
        ),
        (json!({"scale": [2, 3, 4]}), [[0., 0., 0.], [2., 0., 0.], [0., 3., 0.]]),
        // A quarter turn about z, by a quaternion that is not of unit length.
        (json!({"rotation": [0, 0, 1, 1]}), [[0., 0., 0.], [0., 1., 0.], [-1., 0., 0.]]),
        (json!({"rotation": [0, 0, 0, 0]}), TRIANGLE),
        (
            json!({"translation": [1, 2, 3], "rotation": [1, 0, 0, 1], "scale": [1, 5, 1]}),
            [[1., 2., 3.], [2., 2., 3.], [1., 2., 8.]],
        ),
        (
            json!({"matrix": [0, 2, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 10, 20, 30, 1]}),
            [[10., 20., 30.], [10., 22., 30.], [10., 20., 32.]],
        ),
    ] {
        let mut build = Build::triangle();
        build.json["nodes"][0] = node.clone();
        build.json["nodes"][0]["mesh"] = json!(0);
        let mesh = mesh(&build);
        assert_eq!(points(&mesh), expected, "{node}");
        assert_eq!(mesh.triangles(), [[0, 1, 2]], "{node}");
    }

    // A rotation as files have it, in single precision, still keeps lengths.
    let mut build = Build::triangle();
    build.json["nodes"][0]["rotation"] = json!([0, 0, half as f32, half as f32]);
    let turned = points(&mesh(&build));
    assert!((turned[1][1] - 1.0).abs() < 1e-15 && turned[1][0].abs() < 1e-15, "{turned:?}");

    // Mirrors turn triangles over, two of them do not.
    let mut build = Build::triangle();
    build.json["nodes"] = json!([
        {"mesh": 0, "scale": [-1, 1, 1], "children": [1]},
        {"mesh": 0, "scale": [1, -1, 1]},
    ]);
    let mirrored = mesh(&build);
    assert_eq!(mirrored.triangles(), [[0, 2, 1], [3, 4, 5]]);
    assert_eq!(points(&mirrored)[4..], [[-1., 0., 0.], [0., -1., 0.]]);
}

#[test]
fn scenes_choose_nodes_in_order() {
    let mut build = Build::triangle();
    // Node 0 is the root of 3 and 1; 3 of 2; 4 is another root.
    build.json["nodes"] = json!([
        {"mesh": 0, "children": [3, 1]},
        {"mesh": 0, "translation": [1, 0, 0]},
        {"mesh": 0, "translation": [2, 0, 0]},
        {"translation": [10, 0, 0], "children": [2]},
        {"mesh": 0, "translation": [4, 0, 0]},
    ]);
    let firsts = |build: &Build| -> Vec<f64> {
        points(&mesh(build)).iter().step_by(3).map(|point| point[0]).collect()
    };
    assert_eq!(firsts(&build), [0., 12., 1., 4.], "all root nodes");
    build.json["scenes"] = json!([{"nodes": [4]}, {"nodes": [4, 0]}, {}]);
    assert_eq!(firsts(&build), [4.], "the first scene");
    build.json["scene"] = json!(1);
    assert_eq!(firsts(&build), [4., 0., 12., 1.], "the default scene");
    build.json["scene"] = json!(2);
    assert_eq!(firsts(&build), [0.; 0], "an empty scene");

    for (nodes, place, reason) in [
        (json!([{"children": [1]}, {"children": [0]}]), "nodes", "cycle"),
        (json!([{"children": [1]}, {"children": [2]}, {"children": [1]}]), "node 1", "twice"),
        (json!([{"children": [1, 1]}, {}]), "node 1", "twice"),
        (json!([{"children": [1, 1, 1, 1]}, {}]), "node 0", "twice"),
        (json!([{"children": [2]}, {"children": [2]}, {}]), "node 2", "twice"),
        (json!([{"children": [7]}]), "node 7", "the file has 1 nodes"),
        (json!([{"mesh": 1}]), "node 0", "mesh 1, but the file has 1"),
    ] {
        let build = with(&Build::triangle(), "/nodes", nodes);
        assert_fails(read, build.embedded(), place, reason);
    }
    let deep: Vec<Value> = (1..=100_000).map(|child| json!({"children": [child]})).collect();
    let mut build = with(&Build::triangle(), "/nodes", json!(deep));
    build.push("nodes", json!({"mesh": 0}));
    assert_eq!(mesh(&build).triangle_count(), 1);
}

#[test]
fn primitives_share_vertices_and_carry_materials() {
    let mut build = Build::new();
    let positions = build.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let (forward, back) = (build.indices(5121, &[0, 1, 2]), build.indices(5121, &[0, 2, 1]));
    let attributes = json!({"POSITION": positions});
    build.mesh(json!([
        {"attributes": attributes, "indices": forward, "material": 1},
        {"attributes": attributes, "indices": back},
        {"attributes": attributes, "indices": back, "material": 0},
        {"attributes": {}, "indices": back},
    ]));
    build.push("nodes", json!({"mesh": 0}));
    build.json["materials"] = json!([
        {},
        {"pbrMetallicRoughness":
            {"baseColorFactor": [0.5, 0.25, 1, 0.5], "metallicFactor": 0.25, "roughnessFactor": 0.75},
         "alphaMode": "BLEND",
         "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 0.875},
            "KHR_materials_ior": {"ior": 1.25},
            "OTHER_unknown": {"x": []}}},
        {"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}},
    ]);
    let mesh = mesh(&build);
    assert_eq!(points(&mesh), TRIANGLE, "three primitives, one block of vertices");
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 1], [0, 2, 1]]);
    let metal = Material { base_color: [1.0; 4], metallic: 1.0, ..Material::default() };
    let glass = Material {
        base_color: [0.5, 0.25, 1.0, 0.5],
        metallic: 0.25,
        roughness: 0.75,
        transmission: 0.875,
        ior: 1.25,
    };
    assert_eq!(mesh.materials, [metal, glass, metal, Material::default()]);
    assert_eq!(mesh.triangle_materials.as_deref(), Some(&[1, 3, 0][..]));
}

#[test]
fn vertex_colors_are_encoded() {
    // Linear 0.5 is 188 of 255 in sRGB.
    let expected = [[188, 0, 255, 255]; 3];
    for (kind, component, bytes) in [
        ("VEC3", 5126, [0.5_f32, 0., 1.].iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>()),
        ("VEC4", 5126, [0.5_f32, -1., 2., 1.].iter().flat_map(|x| x.to_le_bytes()).collect()),
        ("VEC4", 5121, vec![128, 0, 255, 255]),
        ("VEC4", 5123, vec![0, 0x80, 0, 0, 0xff, 0xff, 0xff, 0xff]),
        ("VEC4", 5121, vec![128, 0, 255, 0]),
    ] {
        let mut build = Build::triangle();
        let colors = build.accessor(kind, component, 3, &bytes.repeat(3));
        build.json["accessors"][colors]["normalized"] = json!(component != 5126);
        build.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        let colored = mesh(&build);
        assert_eq!(colored.vertex_colors.as_deref(), Some(&expected[..]), "{kind} {component}");

        // Alpha counts where the material says so; a primitive without colours is white.
        build.json["materials"] = json!([{"alphaMode": "MASK"}]);
        build.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        build.push("nodes", json!({"mesh": 1}));
        build.mesh(json!([{"attributes": {"POSITION": 0}}]));
        let colored = mesh(&build).vertex_colors.unwrap();
        let alpha = if bytes.len() == 4 { bytes[3] } else { 255 };
        assert_eq!(colored[..3], [[188, 0, 255, alpha]; 3]);
        assert_eq!(colored[3..], [[255; 4]; 3]);
    }
}

/// 2 x 2 pixels: red, green; blue, white with half alpha.
fn checkered_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer
        .write_image_data(&[255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128])
        .unwrap();
    writer.finish().unwrap();
    bytes
}

pub fn textured(coordinates: [f32; 6]) -> Build {
    let mut build = Build::triangle();
    let coordinates = build.floats("VEC2", &coordinates);
    build.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    build.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    build.json["materials"] = json!([
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "alphaMode": "BLEND"}
    ]);
    build.json["textures"] = json!([{"source": 0}]);
    let view = build.view(&checkered_png());
    build.json["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    build
}

#[test]
fn textures_are_sampled_at_the_vertices() {
    let [red, green, blue, white] =
        [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 128]];
    let colors = |build: &Build| mesh(build).vertex_colors.unwrap();
    let at = [0.25, 0.25, 0.75, 0.25, 0.25, 0.75];
    assert_eq!(colors(&textured(at)), [red, green, blue]);
    // Half way between red and green, in linear light; beyond the border; far beyond it.
    let middle = [188, 188, 0, 255];
    let build = textured([0.5, 0.25, 1.25, -0.25, -3.25, 1000.25]);
    assert_eq!(colors(&build), [middle, blue, green]);
    let clamped = with(&build, "/samplers", json!([{"wrapS": 33071, "wrapT": 33071}]));
    let clamped = with(&clamped, "/textures/0", json!({"source": 0, "sampler": 0}));
    let clamped_colors = colors(&clamped);
    assert_eq!(clamped_colors[1..], [green, blue]);
    let mirrored = with(&clamped, "/samplers/0", json!({"wrapS": 33648, "wrapT": 33648}));
    assert_eq!(colors(&mirrored), [middle, green, green]);
    assert_eq!(colors(&textured([f32::NAN, f32::INFINITY, 0.75, 0.75, 1e30, -1e30]))[1], white);

    // Times COLOR_0; turned a quarter about the corner and moved back by KHR_texture_transform.
    let mut build = textured(at);
    let half = build.floats("VEC3", &[0.5; 9]);
    build.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(half);
    assert_eq!(colors(&build)[0], [188, 0, 0, 255]);
    let turned = with(
        &textured([0.25, 0.25, 0.25, 0.75, 0.75, 0.25]),
        "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions",
        json!({"KHR_texture_transform": {"rotation": std::f32::consts::FRAC_PI_2, "offset": [0, 1]}}),
    );
    // (u, v) goes to (v, 1 - u).
    assert_eq!(colors(&turned), [blue, white, red]);
}

#[test]
fn textures_that_cannot_be_had() {
    let build = textured([0.0; 6]);
    let without = |build: &Build| assert_eq!(mesh(build).vertex_colors.unwrap(), [[255; 4]; 3]);
    without(&with(&build, "/images/0", json!({"uri": "missing.png"})));
    without(&with(&build, "/images/0", json!({})));
    without(&with(&build, "/images/0", json!({"uri": "data:image/webp;base64,UklGRg=="})));
    for (pointer, value, place, reason) in [
        ("/images/0", json!({"uri": "../x.png"}), "image 0", "leaves the folder"),
        ("/images/0", json!({"uri": "https://host/x.png"}), "image 0", "scheme"),
        ("/images/0", json!({"bufferView": 9}), "buffer view 9", "the file has 3"),
        ("/images/0", json!({"uri": "data:;base64,iVBORw0KGgo="}), "image 0", "broken PNG"),
        ("/images/0", json!({"uri": "data:;base64,/9j/4AAQ"}), "image 0", "broken JPEG"),
        ("/textures/0", json!({"source": 5}), "texture 0", "image 5, but the file has 1"),
        ("/textures/0", json!({"source": 0, "sampler": 0}), "texture 0", "sampler 0"),
        ("/textures", json!([]), "texture 0", "the file has 0 textures"),
        ("/accessors/1/count", json!(2), "accessor 1", "2 of TEXCOORD for 3 vertices"),
        ("/accessors/1/type", json!("SCALAR"), "accessor 1", "not of a type"),
    ] {
        assert_fails(read, with(&build, pointer, value).embedded(), place, reason);
    }
    // A header that claims more pixels than its file may have.
    let mut png = checkered_png();
    png[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let crc = png_crc(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    let mut huge = build.clone();
    let view = huge.view(&png);
    huge.json["images"][0]["bufferView"] = json!(view);
    assert_fails(read, huge.embedded(), "image 0", "65535 x 65535 pixels are more than");
}

fn png_crc(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    !crc
}

#[test]
fn buffers_and_images_beside_the_file() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("scene");
    fs::create_dir_all(folder.join("my parts")).unwrap();
    let build = textured([0.25; 6]);
    fs::write(root.path().join("outside.bin"), &build.binary).unwrap();
    fs::write(folder.join("my parts/a.bin"), [&build.binary[..], b"padding"].concat()).unwrap();
    fs::write(folder.join("red.jpg"), include_bytes!("red.jpg")).unwrap();
    let path = folder.join("scene.gltf");
    let read_with = |uri: &str| read(&path, &build.with_uri(uri), &NoProgress);
    for uri in ["my parts/a.bin", "my%20parts/a.bin", "./my%20parts//./a.bin"] {
        assert_eq!(points(&read_with(uri).unwrap()), TRIANGLE, "{uri}");
    }
    let outside = root.path().join("outside.bin");
    let outside = outside.to_str().unwrap();
    for (uri, reason) in [
        ("../outside.bin", "leaves the folder"),
        ("%2e%2e/outside.bin", "leaves the folder"),
        ("my%20parts/%2E./../../outside.bin", "leaves the folder"),
        ("..%5Coutside.bin", "leaves the folder"),
        (outside, "is absolute"),
        (&outside.replace('/', "%2f"), "is absolute"),
        (&format!("file://{outside}"), "names a scheme"),
        ("http://127.0.0.1/outside.bin", "names a scheme"),
        ("http%3A//127.0.0.1/outside.bin", "names a scheme"),
        ("C:%5Coutside.bin", "names a scheme or a drive"),
        ("%ff.bin", "not UTF-8"),
        ("a%00b.bin", "not the name of a file"),
        ("", "not the name of a file"),
        ("my%20parts", "is not there"),
        ("gone.bin", "is not there"),
        ("data:application/octet-stream;base64,!!!!", "not valid base64"),
        ("data:application/octet-stream;base64", "needs a comma"),
        ("data:application/octet-stream;base64,AAAA", "but it has 3 bytes"),
    ] {
        let error = read_with(uri).expect_err(uri).to_string();
        assert!(error.contains("scene.gltf: buffer 0: "), "{uri}: {error}");
        assert!(error.contains(reason), "{uri}: {error}");
    }

    let build = with(&build, "/images/0", json!({"uri": "red.jpg"}));
    let mesh = read(&path, &build.embedded(), &NoProgress).unwrap();
    let [red, green, blue, alpha] = mesh.vertex_colors.unwrap()[0];
    assert!(red > 245 && green < 10 && blue < 10 && alpha == 255, "{red} {green} {blue}");
}
