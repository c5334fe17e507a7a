//! OFF files.

#![no_main]

use halfline_fuzz::try_reader;
use halfline_io::off;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|content: &[u8]| try_reader(off::read, "mesh.off", content));
