//! Files made to harm: mutated at random, or short with great promises. Reading must neither
//! panic nor take more memory than a small multiple of the file's size.
//!
//! One test, for the memory in use is counted over the whole program.

use std::path::Path;

use base64::Engine;
use halfline::error::{Error, Result};
use halfline::geometry::random::Random;
use halfline::mesh::Mesh;
use halfline::progress::{NoProgress, Observer};
use halfline_io::{gltf, obj, off, ply};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// More than this is never allowed for a file of a few kilobytes. The decoders of PNG and JPEG
/// have buffers of up to some hundred kilobytes for any image.
const MOST_BYTES_FOR_SMALL_FILES: usize = 1 << 20;
const MOST_BYTES_PER_BYTE: usize = 100;

type Read = fn(&Path, &[u8], &dyn Observer) -> Result<Mesh>;

/// Reads, and returns the mesh and the memory that it took at most.
fn measured(read: Read, content: &[u8]) -> (Result<Mesh>, usize) {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let result = read(Path::new("no-such-folder/mesh"), content, &NoProgress);
    (result, MEMORY.peak_usage().saturating_sub(before))
}

fn assert_modest(name: &str, read: Read, content: &[u8]) -> Result<Mesh> {
    let (result, peak) = measured(read, content);
    let most = MOST_BYTES_FOR_SMALL_FILES.max(content.len() * MOST_BYTES_PER_BYTE);
    assert!(peak <= most, "{name}: {peak} bytes for a file of {}", content.len());
    if let Err(error) = &result {
        let message = error.to_string();
        assert!(matches!(error, Error::Format { .. }), "{name}: {message}");
        assert!(message.len() < 400 && !message.contains('\n'), "{name}: {message}");
    }
    result
}

/// Changes, inserts, removes and copies bytes, numbers above all.
fn mutate(content: &[u8], random: &mut Random) -> Vec<u8> {
    const NUMBERS: [&str; 14] = [
        "0",
        "1",
        "-1",
        "4000000000",
        "4294967295",
        "4294967296",
        "18446744073709551615",
        "99999999999999999999",
        "1e999",
        "nan",
        "255",
        "65535",
        "2.5",
        "\\\n",
    ];
    let mut content = content.to_vec();
    for _ in 0..=random.below(4) {
        if content.is_empty() {
            break;
        }
        let at = random.below(content.len());
        match random.below(6) {
            0 => content[at] = random.below(256) as u8,
            1 => content[at] ^= 1 << random.below(8),
            2 => {
                let end = (at + random.below(20)).min(content.len());
                content.drain(at..end);
            }
            3 => {
                let end = (at + random.below(40)).min(content.len());
                let copy = content[at..end].to_vec();
                let to = random.below(content.len());
                content.splice(to..to, copy);
            }
            // Put another number in the place of one.
            _ => {
                let is_part = |byte: &u8| byte.is_ascii_digit();
                let start = at + content[at..].iter().position(is_part).unwrap_or(0);
                let length = content[start..].iter().take_while(|&byte| is_part(byte)).count();
                let number = NUMBERS[random.below(NUMBERS.len())];
                content.splice(start..start + length, number.bytes());
            }
        }
    }
    content
}

const OBJ: &[u8] = b"mtllib x.mtl\nv 0 0 0 1 1 1\nv 1 0 0\nv 1 1 0\nv 0 1 \\\n0\nv 0.5 .1 0\n\
    usemtl a\nf 1/1 2//2 3/3/3 -1 -2\nf 1 2 3\nf 3 4 -1 1\n";

const OFF: &[u8] = b"STCNOFF # x\n4 2 0\n0 0 0 0 0 1 1 0 0 .5 .5\n1 0 0 0 0 1 0 .5 0 0 0\n\
    1 1 0 0 0 1 1 1 1 0 0\n0 1 0 0 0 1 1 1 1 0 0\n4 0 1 2 3\n3 0 1 2 0.1 0.1 0.1\n";

fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = png::Encoder::new(&mut bytes, 2, 2).write_header().unwrap();
    writer.write_image_data(&[0, 50, 100, 200]).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Positions, colours, texture coordinates, indices, sparse values, an image.
fn gltf_parts() -> (String, Vec<u8>) {
    let mut binary = Vec::new();
    let mut views = Vec::new();
    let mut view = |bytes: &[u8]| {
        views.push(format!(
            r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#,
            binary.len(),
            bytes.len()
        ));
        binary.extend_from_slice(bytes);
    };
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    view(&floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.]));
    view(&[128; 16]);
    view(&floats(&[0., 0., 1., 0., 0., 1., 0.5, 0.5]));
    view(&[0, 0, 1, 0, 2, 0, 3, 0, 0, 0, 1, 0]);
    view(&[1, 3]);
    view(&floats(&[2., 2., 2., 3., 3., 3.]));
    view(&png());
    view(include_bytes!("mesh_files/red.jpg"));
    let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,2]}],
"nodes":[{"mesh":0,"children":[1]},{"mesh":1,"scale":[2,-2,2]},{"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,5,5,1],"mesh":1}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1,"TEXCOORD_0":2},"indices":3,"material":0}]},
{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":2},"mode":5,"material":1},{"attributes":{"POSITION":4},"mode":6}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
{"bufferView":1,"componentType":5121,"normalized":true,"count":4,"type":"VEC4"},
{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"},
{"bufferView":3,"componentType":5123,"count":6,"type":"SCALAR"},
{"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":2,"indices":{"bufferView":4,"componentType":5121},"values":{"bufferView":5}}}],
"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}},{"pbrMetallicRoughness":{"baseColorTexture":{"index":1}}}],
"textures":[{"source":0,"sampler":0},{"source":1}],"samplers":[{"wrapS":33071}],
"images":[{"bufferView":6},{"bufferView":7}],"bufferViews":[VIEWS],"buffers":[{URI"byteLength":LENGTH}]}"#;
    let json = json.replace("VIEWS", &views.join(",")).replace("LENGTH", &binary.len().to_string());
    (json, binary)
}

fn gltf() -> Vec<u8> {
    let (json, binary) = gltf_parts();
    let data = base64::engine::general_purpose::STANDARD.encode(binary);
    json.replace("URI", &format!(r#""uri":"data:;base64,{data}","#)).into_bytes()
}

fn glb() -> Vec<u8> {
    let (json, binary) = gltf_parts();
    let mut json = json.replace("URI", "");
    while json.len() % 4 != 0 {
        json.push(' ');
    }
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((12 + 8 + json.len() as u32 + 8 + binary.len() as u32).to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(json.as_bytes());
    glb.extend((binary.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(binary);
    glb
}

/// Texts that repeat one short thing a hundred thousand times.
fn repetitive() -> Vec<(&'static str, Read, Vec<u8>)> {
    let many = |head: &str, part: &str, tail: &str| {
        format!("{head}{}{tail}", part.repeat(100_000)).into_bytes()
    };
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let asset = r#"{"asset":{"version":"2.0"},"#;
    vec![
        ("short faces", obj::read, many(v, "f 1 2 3\n", "")),
        ("short vertices", obj::read, many("", "v 0 0 0\n", "")),
        ("coloured vertices", obj::read, many("v 0 0 0 1 1 1\n", "v 0 0 0\n", "")),
        ("quads", obj::read, many(v, "f 1 2 3 3\n", "")),
        ("one polygon", obj::read, many(&format!("{v}f"), " 1 2 3", "")),
        ("continued lines", obj::read, many(v, "f 1\\\n", "")),
        ("libraries", obj::read, many(v, "mtllib a\n", "")),
        ("materials", obj::read, many(v, "usemtl a\n", "")),
        ("empty lines", obj::read, many(v, "\n", "")),
        ("one long word", obj::read, many(v, "xxxxx", "")),
        ("one long number", obj::read, many("v 0 0 ", "11111", "")),
        ("short vertices", off::read, many("OFF 100000 0\n", "0 0 0\n", "")),
        ("short faces", off::read, many("OFF 3 100000\n0 0 0\n1 0 0\n0 1 0\n", "3 0 1 2\n", "")),
        ("points", off::read, many("OFF 3 100000\n0 0 0\n1 0 0\n0 1 0\n", "1 0\n", "")),
        ("one polygon", off::read, many("OFF 3 1\n0 0 0\n1 0 0\n0 1 0\n300000", " 0 1 2", "")),
        ("nodes", gltf::read, many(&format!("{asset}\"nodes\":[{{}}"), ",{}", "]}")),
        ("materials", gltf::read, many(&format!("{asset}\"materials\":[{{}}"), ",{}", "]}")),
        ("images", gltf::read, many(&format!("{asset}\"images\":[{{}}"), ",{}", "]}")),
        ("scenes", gltf::read, many(&format!("{asset}\"scenes\":[{{}}"), ",{}", "]}")),
        ("unknown", gltf::read, many(&format!("{asset}\"x\":[[]"), ",[]", "]}")),
        ("nesting", gltf::read, many(&format!("{asset}\"x\":"), "[", "")),
        (
            "required",
            gltf::read,
            many(&format!("{asset}\"extensionsRequired\":[\"\""), ",\"\"", "]}"),
        ),
    ]
}

/// What fuzzing found, each once: the messages quoted the file's names without end.
fn found_by_fuzzing() -> Vec<(&'static str, Read, Vec<u8>)> {
    let long = "\u{fffd}".repeat(1000);
    let ply = |encoding: &str, element: &str, count: u32, property: &str, body: &[u8]| {
        let header = format!(
            "ply\nformat {encoding} 1.0\nelement vertex 1\nproperty char x\nproperty char y\n\
             property char z\nelement {element} {count}\n{property}\nend_header\n"
        );
        [header.as_bytes(), body].concat()
    };
    let (ascii, binary) = ("ascii", "binary_little_endian");
    let list = format!("property list char char {long}");
    let version = |key: &str| {
        let least = if key == "version" { "" } else { r#""version":"2.0","# };
        format!(r#"{{"asset":{{{least}"{key}":"{long}"}}}}"#).into_bytes()
    };
    vec![
        ("long element, few lines", ply::read, ply(ascii, &long, 1, "property char p", b"0 0 0\n")),
        ("long element, few bytes", ply::read, ply(binary, &long, 9, "property char p", &[0; 4])),
        ("long list", ply::read, ply(binary, "face", 1, &list, &[0, 0, 0, 255])),
        ("long element, bad list", ply::read, ply(binary, &long, 1, &list, &[0, 0, 0, 255])),
        ("long version", gltf::read, version("version")),
        ("long least version", gltf::read, version("minVersion")),
    ]
}

#[test]
fn hostile_files_neither_panic_nor_take_much_memory() {
    // The measure itself works.
    let (result, peak) = measured(
        |_, bytes, _| {
            std::hint::black_box(vec![1_u8; 10 * bytes.len()]);
            Err(Error::Interrupted)
        },
        &[0; 1 << 20],
    );
    assert!(result.is_err() && peak >= 10 << 20, "{peak}");

    // Good files are good, and great promises are not kept.
    let files: [(&str, Read, Vec<u8>); 4] = [
        ("OBJ", obj::read, OBJ.to_vec()),
        ("OFF", off::read, OFF.to_vec()),
        ("glTF", gltf::read, gltf()),
        ("GLB", gltf::read, glb()),
    ];
    for (name, read, content) in &files {
        assert_modest(name, *read, content).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    for (name, read, content) in repetitive() {
        let _ = assert_modest(name, read, &content);
    }
    for (name, read, content) in found_by_fuzzing() {
        assert!(assert_modest(name, read, &content).is_err(), "{name}");
    }

    // Truncate everywhere, and mutate at random.
    let mut random = Random::new(1, 0);
    for (name, read, content) in &files {
        for length in 0..content.len() {
            let _ = assert_modest(name, *read, &content[..length]);
        }
        let mut refused = 0;
        let mut read_all_the_same = 0;
        for round in 0..4000 {
            let name = format!("{name}, mutation {round}");
            match assert_modest(&name, *read, &mutate(content, &mut random)) {
                Ok(_) => read_all_the_same += 1,
                Err(_) => refused += 1,
            }
        }
        // Mutations that are all refused, or none, would test little.
        assert!(refused > 100 && read_all_the_same > 100, "{name}: {refused} refused");
    }
}
