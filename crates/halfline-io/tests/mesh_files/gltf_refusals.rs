//! glTF that is broken, or asks for too much.

use std::path::Path;

use halfline::progress::NoProgress;
use halfline_io::gltf::read;
use serde_json::{Value, json};

use super::gltf::{textured, with};
use super::gltf_build::Build;
use super::{assert_fails, assert_reports_and_stops};

#[test]
fn broken_documents() {
    let build = Build::triangle();
    let mut indexed = build.clone();
    let index = indexed.indices(5121, &[0, 1, 2]);
    indexed.json["meshes"][0]["primitives"][0]["indices"] = json!(index);
    for (pointer, value, place, reason) in [
        ("/asset/version", json!("1.0"), "asset", "version `1.0` is not supported"),
        ("/asset/version", json!("3.0"), "asset", "version `3.0` is not supported"),
        ("/asset/minVersion", json!("2.1"), "asset", "needs a reader of version `2.1`"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "extensionsRequired",
            "`KHR_draco_mesh_compression`",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_materials_ior", "EXT_meshopt_compression"]),
            "extensionsRequired",
            "`EXT_meshopt_compression`",
        ),
        (
            "/extensionsRequired",
            json!(["X_\n"]),
            "extensionsRequired",
            "`X_\\n` is required and not supported",
        ),
        (
            "/bufferViews/0/extensions",
            json!({"EXT_meshopt_compression": {}}),
            "buffer view 0",
            "EXT_meshopt_compression",
        ),
        ("/scene", json!(3), "scene 3", "the file has 0 scenes"),
        ("/meshes/0/primitives/0/mode", json!(7), "mesh 0 primitive 0", "unknown mode 7"),
        (
            "/meshes/0/primitives/0/material",
            json!(0),
            "mesh 0 primitive 0",
            "material 0, but the file has 0",
        ),
        ("/meshes/0/primitives/0/indices", json!(9), "accessor 9", "the file has 2 accessors"),
        ("/meshes/0/primitives/0/indices", json!(0), "accessor 0", "unsigned scalars"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(9),
            "accessor 9",
            "the file has 2 accessors",
        ),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(1),
            "accessor 1",
            "must be VEC3, not Scalar",
        ),
        (
            "/meshes/0/primitives/0/attributes/COLOR_0",
            json!(1),
            "accessor 1",
            "not of a type that COLOR_0",
        ),
        ("/accessors/0/type", json!("VEC4"), "accessor 0", "reach past"),
        ("/accessors/0/componentType", json!(5125), "accessor 0", "positions must be floats"),
        ("/accessors/0/componentType", json!(5124), "accessor 0", "unknown component type 5124"),
        ("/accessors/0/count", json!(4), "accessor 0", "4 elements of 12 bytes"),
        ("/accessors/0/count", json!(4_000_000_000_u32), "accessor 0", "reach past the 36 bytes"),
        ("/accessors/0/count", json!(u64::MAX), "accessor 0", "reach past"),
        ("/accessors/0/byteOffset", json!(1), "accessor 0", "reach past"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "accessor 0", "reach past"),
        ("/accessors/0/bufferView", json!(9), "buffer view 9", "the file has 2 buffer views"),
        (
            "/accessors/0/sparse",
            json!({"count": 9, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0}}),
            "accessor 0",
            "sparse indices: 9 elements",
        ),
        (
            "/accessors/0/sparse",
            json!({"count": 3, "indices": {"bufferView": 1, "componentType": 5121, "byteOffset": 1}, "values": {"bufferView": 0}}),
            "accessor 0",
            "sparse indices",
        ),
        (
            "/accessors/0/sparse",
            json!({"count": 3, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0, "byteOffset": 4}}),
            "accessor 0",
            "sparse values",
        ),
        (
            "/accessors/0/sparse",
            json!({"count": 3, "indices": {"bufferView": 1, "componentType": 5126}, "values": {"bufferView": 0}}),
            "accessor 0",
            "must be unsigned",
        ),
        ("/accessors/1/count", json!(2), "mesh 0 primitive 0", "2 corners do not make whole"),
        (
            "/bufferViews/0/byteStride",
            json!(8),
            "accessor 0",
            "elements of 12 bytes are 8 bytes apart",
        ),
        ("/bufferViews/0/byteStride", json!(u64::MAX), "accessor 0", "reach past"),
        ("/bufferViews/0/byteStride", json!(0), "accessor 0", "are 0 bytes apart"),
        (
            "/bufferViews/0/byteOffset",
            json!(u64::MAX),
            "buffer view 0",
            "reach past the 40 bytes of buffer 0",
        ),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "buffer view 0", "reach past"),
        ("/bufferViews/0/byteLength", json!(41), "buffer view 0", "reach past"),
        ("/bufferViews/0/buffer", json!(1), "buffer 1", "the file has 1 buffers"),
    ] {
        assert_fails(read, with(&indexed, pointer, value.clone()).embedded(), place, reason);
        assert_fails(read, with(&indexed, pointer, value).glb(), place, reason);
    }

    // Indices past the vertices, primitive restarts, sparse indices past the elements.
    for (component, indices, reason) in [
        (5121, [0, 1, 3], "index 2 is 3, but mesh 0 primitive 0 has 3 vertices"),
        (5121, [0, 255, 1], "index 1 is 255, a primitive restart"),
        (5123, [0, 65535, 1], "index 1 is 65535, a primitive restart"),
        (5125, [0, u32::MAX, 1], "index 1 is 4294967295, a primitive restart"),
        (5125, [0, u32::MAX - 1, 1], "index 1 is 4294967294, but"),
    ] {
        let mut build = build.clone();
        let index = build.indices(component, &indices);
        build.json["meshes"][0]["primitives"][0]["indices"] = json!(index);
        assert_fails(read, build.glb(), "accessor 1", reason);
    }
    let mut sparse = build.clone();
    let (at, to) = (sparse.view(&[3]), sparse.view(&[0; 12]));
    sparse.json["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": to}});
    assert_fails(read, sparse.glb(), "accessor 0", "sparse index 3 of 3 elements");

    // Draco without a fallback; elements that cost the file nothing.
    let mut draco = build.clone();
    draco.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    draco.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    assert_fails(read, draco.glb(), "mesh 0 primitive 0", "KHR_draco_mesh_compression");
    let mut empty = draco.clone();
    empty.json["accessors"][0]["count"] = json!(4_000_000_000_u32);
    assert_fails(read, empty.glb(), "accessor 0", "4000000000 elements without a buffer view");

    assert_fails(read, "{", "JSON line 1 column 1", "EOF");
    assert_fails(read, "", "JSON line 1 column 0", "EOF");
    assert_fails(read, "{}", "JSON line 1 column 2", "missing field `asset`");
    assert_fails(
        read,
        "{\"asset\": {\"version\": \"2.0\"},\n\"nodes\": -1}",
        "JSON line 2 column 11",
        "invalid type",
    );
    assert_fails(read, "[".repeat(100_000), "JSON line 1 column 2", "invalid type");
    let no_uri = with(&build, "/buffers", json!([{"byteLength": 36}]));
    let no_uri = serde_json::to_vec(&no_uri.json).unwrap();
    assert_fails(read, no_uri, "buffer 0", "has no uri");
}

#[test]
fn broken_containers() {
    let good = Build::triangle().glb();
    let patched = |position: usize, bytes: &[u8]| {
        let mut glb = good.clone();
        glb[position..position + bytes.len()].copy_from_slice(bytes);
        glb
    };
    let json_length = u32::from_le_bytes(good[12..16].try_into().unwrap()) as usize;
    let second = 20 + json_length;
    let second_place = format!("GLB chunk at byte {second}");
    for (glb, place, reason) in [
        (b"glTF".to_vec(), "GLB header", "needs 12 bytes, the file has 4"),
        (patched(4, &[1]), "GLB header", "version 1 is not supported"),
        (patched(4, &[3]), "GLB header", "version 3 is not supported"),
        (patched(8, &[0xff; 4]), "GLB header", "promises 4294967295 bytes"),
        (patched(8, &[11, 0, 0, 0]), "GLB header", "promises 11 bytes"),
        (patched(8, &[12, 0, 0, 0]), "GLB header", "no chunk follows"),
        (patched(8, &[15, 0, 0, 0]), "GLB chunk at byte 12", "header is cut off"),
        (patched(12, &[0xff; 4]), "GLB chunk at byte 12", "promises 4294967295 bytes"),
        (patched(16, b"BIN\0"), "GLB chunk at byte 12", "first chunk must be JSON"),
        (
            patched(second, &[0xff; 4]),
            second_place.as_str(),
            "promises 4294967295 bytes, 36 are left",
        ),
        (patched(second, &[37]), second_place.as_str(), "promises 37 bytes, 36 are left"),
        (patched(second, &[35]), "buffer 0", "byteLength is 36, but it has 35 bytes"),
        (good[..good.len() - 1].to_vec(), "GLB header", "promises"),
    ] {
        assert_fails(read, glb, place, reason);
    }
}

#[test]
fn a_short_file_cannot_ask_for_much_memory() {
    // A thousand nodes with a mesh of a thousand primitives over a thousand vertices.
    let mut build = Build::new();
    build.accessor("VEC3", 5121, 1000, &[0; 3000]);
    let primitives: Vec<Value> =
        (0..1000).map(|n| json!({"attributes": {"POSITION": 0}, "mode": 5 + n % 2})).collect();
    build.mesh(json!(primitives));
    for _ in 0..1000 {
        build.push("nodes", json!({"mesh": 0}));
    }
    assert_fails(read, build.embedded(), "scene", "1000000 vertices and 998000000 triangles");
}

#[test]
fn progress_and_interruption() {
    let mut build = Build::triangle();
    build.json["nodes"] = json!((0..1000).map(|_| json!({"mesh": 0})).collect::<Vec<_>>());
    assert_reports_and_stops(read, &build.glb());
}

#[test]
fn every_truncation_is_read_or_refused() {
    let mut build = textured([0.1; 6]);
    let index = build.indices(5123, &[0, 1, 2]);
    build.json["meshes"][0]["primitives"][0]["indices"] = json!(index);
    for content in [build.embedded(), build.glb()] {
        for length in 0..content.len() {
            let result = read(Path::new("mesh"), &content[..length], &NoProgress);
            // Only the white space at the end may be missing.
            assert!(result.is_err(), "{length} of {} bytes", content.len());
        }
    }
}
