//! glTF files, as JSON and as GLB; what they name beside them is there.

#![no_main]

use std::sync::Once;

use halfline_fuzz::{try_reader, write};
use halfline_io::gltf;
use libfuzzer_sys::fuzz_target;

const IMAGE: &[u8] = include_bytes!("../../crates/halfline-io/tests/mesh_files/red.jpg");

fuzz_target!(|content: &[u8]| {
    static BESIDE: Once = Once::new();
    BESIDE.call_once(|| {
        let buffer: Vec<u8> = (0..64).flat_map(|i| (i as f32 / 8.0).to_le_bytes()).collect();
        write("a.bin", &buffer);
        write("a.jpg", IMAGE);
    });
    try_reader(gltf::read, "mesh.gltf", content);
});
