//! Meshes and rays on standard input, and what is refused in their place: pipes, devices, folders.

use std::io::{ErrorKind, Write};
use std::process::Stdio;

use npyz::Order;

use crate::files::{npy, write_rays};
use crate::{Bench, CUBE, Outcome, end_of};

/// Every subcommand that takes a mesh, with `MESH` in its place.
const COMMANDS: [&str; 8] = [
    "info MESH",
    "doctor MESH --rays 1000",
    "render MESH -o out.png --resolution 8,6",
    "build MESH -o out.hlt",
    "query MESH rays.npy -o out.npz",
    "query MESH rays.npy -o out.npz --engine brute",
    "explain MESH --ray 0,0,5,0,0,-1",
    "study MESH --quick --sizes 12 -o out",
];

/// A ray that hits the cube.
fn bench() -> Bench {
    let bench = Bench::new();
    write_rays(&bench.path("rays.npy"), &[0.0, 0.0, 5.0, 0.0, 0.0, -1.0], 6, "<f8", Order::C);
    bench
}

impl Bench {
    /// Runs the command with `input` on standard input.
    fn run_with(&self, line: &str, input: &[u8]) -> Outcome {
        let mut command = self.command(line);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let outcome = std::thread::scope(|scope| {
            scope.spawn(move || {
                // What is refused by its start is not read on.
                if let Err(error) = stdin.write_all(input) {
                    assert_eq!(error.kind(), ErrorKind::BrokenPipe);
                }
            });
            end_of(line, child)
        });
        Outcome::of(line, outcome)
    }
}

#[test]
fn a_mesh_may_come_on_standard_input() {
    let bench = bench();
    for command in COMMANDS {
        bench.run_with(&command.replace("MESH", "-"), CUBE.as_bytes()).succeeded();
    }
    let outcome = bench.run_with("info - --json", CUBE.as_bytes());
    let figures: serde_json::Value = serde_json::from_str(&outcome.succeeded().stdout).unwrap();
    assert_eq!((&figures["mesh"], &figures["triangles"]), (&"-".into(), &12.into()));
    assert!(figures["file_bytes"].is_null());
    let text = bench.run_with("info -", CUBE.as_bytes()).stdout;
    assert!(text.starts_with("standard input\n"), "{text}");
    // A regular file may be standard input as well.
    bench.write("cube.ply", CUBE);
    let file = std::fs::File::open(bench.path("cube.ply")).unwrap();
    let output = bench.command("info -").stdin(file).output().unwrap();
    Outcome::of("info - < cube.ply", output).succeeded();
    // And a file may have that name.
    bench.write("-", "no mesh");
    bench.run_with("info -", CUBE.as_bytes()).succeeded();
    bench.run("info ./-").failed("./-", "the format is not known");
}

#[test]
fn what_is_wrong_with_standard_input_is_told_in_a_line() {
    let bench = bench();
    bench.write("cube.ply", CUBE);
    bench.run("build cube.ply -o cube.hlt").succeeded();
    let tree = std::fs::read(bench.path("cube.hlt")).unwrap();
    let names = bench.names();
    let zeros = vec![0; 4 << 20];
    for command in COMMANDS {
        for (input, reason) in [
            (&b""[..], "byte 0: there is nothing in it"),
            (&zeros, "byte 0: the format is not known"),
            (&tree, "byte 0: this is not a mesh but a tree"),
            (&CUBE.as_bytes()[..CUBE.len() - 20], "the file ends"),
        ] {
            bench.run_with(&command.replace("MESH", "-"), input).failed("standard input", reason);
        }
    }
    let many = npy("<f8", false, "(1000000000000, 6)", &[]);
    let by_column = npy("<f8", true, "(1, 6)", &[0; 48]);
    for (input, reason) in [
        (&b""[..], "byte 0: not a NumPy .npy file"),
        (&zeros, "byte 0: not a NumPy .npy file"),
        (&many, "header: promises more bytes than may come this way"),
        (&by_column, "header: Fortran order needs a file"),
    ] {
        bench.run_with("query cube.ply - -o out.npz", input).failed("standard input", reason);
    }
    bench.run_with("query - - -o out.npz", b"").refused("only one of MESH and RAYS.npy");
    assert_eq!(bench.names(), names);
}

#[test]
#[cfg(unix)]
fn pipes_devices_and_folders_are_refused_in_a_line() {
    let bench = bench();
    bench.write("cube.ply", CUBE);
    for name in ["pipe.ply", "pipe.hlt", "pipe.npy"] {
        let made = std::process::Command::new("mkfifo").arg(bench.path(name)).status();
        assert!(made.unwrap().success());
        // Whoever opens it all the same finds its end, and no reason to wait.
        let path = bench.path(name);
        std::thread::spawn(move || while std::fs::write(&path, "").is_ok() {});
    }
    std::os::unix::fs::symlink("/dev/null", bench.path("device.ply")).unwrap();
    let _listener = std::os::unix::net::UnixListener::bind(bench.path("socket.ply")).unwrap();
    std::fs::create_dir(bench.path("folder.ply")).unwrap();
    let names = bench.names();
    let to_read =
        |kind: &str| format!("not a regular file but {kind}: give - to read standard input");
    for command in COMMANDS {
        for (name, reason) in [
            ("pipe.ply", &*to_read("a pipe")),
            ("pipe.hlt", &*to_read("a pipe")),
            ("device.ply", &*to_read("a device")),
            ("socket.ply", &*to_read("a socket")),
            ("folder.ply", "s a directory"),
        ] {
            bench.run(&command.replace("MESH", name)).failed(name, reason);
        }
        // As shells have it for <(...).
        let line = command.replace("MESH", "/dev/fd/0");
        bench.run_with(&line, CUBE.as_bytes()).failed("/dev/fd/0", &to_read("a pipe"));
    }
    for (name, reason) in [
        ("pipe.npy", &*to_read("a pipe")),
        ("device.ply", &*to_read("a device")),
        ("folder.ply", "s a directory"),
    ] {
        bench.run(&format!("query cube.ply {name} -o out.npz")).failed(name, reason);
    }
    assert_eq!(bench.names(), names);
}
