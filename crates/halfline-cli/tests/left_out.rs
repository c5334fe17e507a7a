//! What the command says of what it was built without.
#![cfg(not(feature = "default"))]

use std::process::Command;

use tempfile::TempDir;

/// What `line` prints on stderr when it fails with exit code 1, in `folder`.
fn complaint(folder: &TempDir, line: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
    command.args(line.split_whitespace()).current_dir(folder.path());
    let output = command.output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0), "{line}: {stderr}");
    stderr
}

#[test]
fn what_was_left_out_is_refused_in_a_line_that_says_how_to_get_it() {
    let folder = tempfile::tempdir().unwrap();
    let how =
        "`make release` or `cargo build --release --package halfline-cli` builds all of halfline";
    let subcommand =
        format!("halfline: error: this subcommand: this build of halfline lacks it; {how}\n");
    for line in [
        "doctor a.ply --rays 1k",
        "query a.ply rays.npy -o hits.npz --any",
        "query --all a.ply rays.npy --json",
        "study",
    ] {
        assert_eq!(complaint(&folder, line), subcommand, "{line}");
    }

    let exr = complaint(&folder, "render a.ply -o a.exr");
    assert_eq!(exr, subcommand.replace("this subcommand", "--output as .exr"));

    for (name, bytes, feature) in
        [("a.glb", &b"glTF\x02\0\0\0"[..], "gltf"), ("a.ply.gz", b"\x1f\x8b\x08\0", "gzip")]
    {
        std::fs::write(folder.path().join(name), bytes).unwrap();
        let refused = complaint(&folder, &format!("info {name}"));
        let reason = format!("made without its feature `{feature}`; {how}\n");
        assert!(refused.starts_with(&format!("halfline: error: {name}: ")), "{refused}");
        assert!(refused.ends_with(&reason), "{refused}");
        assert_eq!(refused.lines().count(), 1, "{refused}");
    }
}
