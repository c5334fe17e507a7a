//! Ray files. The first byte says how many rays are asked for at once.

#![no_main]

use halfline::Error;
use halfline_cli::npy::RayFile;
use halfline_fuzz::{check_error, write};
use libfuzzer_sys::fuzz_target;

/// Reads all rays, `at_once` at a time, and returns their number.
fn read_all(file: &mut RayFile, at_once: usize) -> Result<u64, Error> {
    let mut rays = Vec::new();
    let mut count = 0;
    loop {
        file.read(at_once, &mut rays)?;
        if rays.is_empty() {
            return Ok(count);
        }
        assert!(rays.len() <= at_once, "{} rays instead of {at_once}", rays.len());
        count += rays.len() as u64;
    }
}

fuzz_target!(|input: &[u8]| {
    let Some((&at_once, content)) = input.split_first() else { return };
    let path = write("rays.npy", content);
    let mut file = match RayFile::open(&path) {
        Ok(file) => file,
        Err(error) => return check_error(&error),
    };
    let promised = file.row_count();
    let read = read_all(&mut file, usize::from(at_once) + 1).expect("the length was checked");
    assert_eq!(read, promised, "rays");
});
