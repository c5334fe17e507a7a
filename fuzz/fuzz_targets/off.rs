//! OFF files.

#![no_main]

use halfline_io::off;
use halfline_fuzz::try_reader;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|content: &[u8]| try_reader(off::read, "mesh.off", content));
