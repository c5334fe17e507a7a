//! Compressed files of every format, loaded by their path.
//!
//! Blind mutations of a compressed stream hardly ever pass its checksum. So only some inputs are
//! the file itself; the others are content that is compressed here, in two members, and then
//! damaged or cut short.

#![no_main]

use std::io::Write;

use arbitrary::{Arbitrary, Unstructured};
use flate2::Compression;
use flate2::write::GzEncoder;
use halfline::progress::NoProgress;
use halfline_fuzz::{be_single_threaded, check_answer, write};
use halfline_io::load;
use libfuzzer_sys::fuzz_target;

/// Names that decide the format where the content does not.
const NAMES: [&str; 8] = [
    "mesh.ply.gz",
    "mesh.stl.gz",
    "mesh.obj.gz",
    "mesh.off.gz",
    "mesh.gltf.gz",
    "mesh.glb",
    "mesh.gz",
    "mesh",
];

/// How a file is made from content.
#[derive(Arbitrary)]
enum Wrapping {
    /// Compressed in two members, the first of so many bytes.
    Whole { first_member: u8 },
    /// Compressed in two members, with one byte of the stream changed.
    Damaged { first_member: u8, position: u16, change: u8 },
    /// Compressed in two members, without the last bytes.
    Short { first_member: u8, missing: u8 },
    /// The content is the file.
    Raw,
}

fn compress(content: &[u8], first_member: u8) -> Vec<u8> {
    let (first, second) = content.split_at(content.len().min(first_member.into()));
    let mut stream = Vec::new();
    for member in [first, second] {
        let mut encoder = GzEncoder::new(&mut stream, Compression::fast());
        encoder.write_all(member).and_then(|()| encoder.try_finish()).expect("memory");
    }
    stream
}

impl Wrapping {
    fn wrap(&self, content: &[u8]) -> Vec<u8> {
        match *self {
            Wrapping::Whole { first_member } => compress(content, first_member),
            Wrapping::Damaged { first_member, position, change } => {
                let mut stream = compress(content, first_member);
                let at = usize::from(position) % stream.len();
                stream[at] ^= change;
                stream
            }
            Wrapping::Short { first_member, missing } => {
                let mut stream = compress(content, first_member);
                stream.truncate(stream.len().saturating_sub(missing.into()));
                stream
            }
            Wrapping::Raw => content.to_vec(),
        }
    }
}

fuzz_target!(|input: &[u8]| {
    let mut input = Unstructured::new(input);
    let (Ok(name), Ok(wrapping)) = (input.choose(&NAMES), Wrapping::arbitrary(&mut input)) else {
        return;
    };
    be_single_threaded();
    let path = write(name, &wrapping.wrap(input.take_rest()));
    check_answer(load(&path, &NoProgress));
});
