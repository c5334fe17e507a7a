//! STL files.

#![no_main]

use halfline_fuzz::try_reader;
use halfline_io::stl;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|content: &[u8]| try_reader(stl::read, "mesh.stl", content));
