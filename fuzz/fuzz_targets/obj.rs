//! OBJ files, each with the material library `a.mtl` beside it: what follows [`SEPARATOR`], if the
//! input has it.

#![no_main]

use halfline_fuzz::{try_reader, write};
use halfline_io::obj;
use libfuzzer_sys::fuzz_target;

/// What parts the mesh from its materials.
const SEPARATOR: &[u8] = b"\0mtl\0";

fuzz_target!(|content: &[u8]| {
    let at = content.windows(SEPARATOR.len()).position(|window| window == SEPARATOR);
    let (mesh, materials) = match at {
        Some(at) => (&content[..at], &content[at + SEPARATOR.len()..]),
        None => (content, &[][..]),
    };
    write("a.mtl", materials);
    try_reader(obj::read, "mesh.obj", mesh);
});
