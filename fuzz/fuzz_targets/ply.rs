//! PLY files.

#![no_main]

use halfline_fuzz::try_reader;
use halfline_io::ply;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|content: &[u8]| try_reader(ply::read, "mesh.ply", content));
