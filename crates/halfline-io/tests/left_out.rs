//! What a build without features says of files that it cannot read.
#![cfg(not(any(feature = "gltf", feature = "gzip")))]

use std::path::Path;

use halfline::progress::NoProgress;
use halfline_io::load;

#[test]
fn a_file_of_a_format_that_was_left_out_is_refused_in_a_line_that_names_the_feature() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, feature) in [
        ("a.gltf", &b"{}"[..], "gltf"),
        ("a.glb", b"glTF\x02\0\0\0", "gltf"),
        ("a.ply", b"glTF\x02\0\0\0", "gltf"),
        ("a.ply.gz", b"\x1f\x8b\x08\0", "gzip"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let error = load(&path, &NoProgress).unwrap_err().to_string();
        let reason = format!("this build of halfline-io was made without its feature `{feature}`");
        assert_eq!(error, format!("{}: byte 0: {reason}", path.display()));
    }
    let error = load(Path::new("no.gltf"), &NoProgress).unwrap_err().to_string();
    assert!(error.starts_with("no.gltf: "), "{error}");
}
