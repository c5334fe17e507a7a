//! Input or work that fails: exit code 1, one line, nothing left behind.

use std::process::Stdio;

use crate::{Bench, CUBE, Outcome, files};

#[test]
fn what_is_not_there_or_no_mesh_is_named() {
    let bench = Bench::new();
    bench.write("noise.ply", "no mesh at all");
    bench.write("mesh.xyz", "1 2 3");
    for command in ["info", "doctor", "render -o x.png"] {
        bench.run(&format!("{command} none.ply")).failed("none.ply", "No such file");
        bench.run(&format!("{command} noise.ply")).failed("noise.ply", "");
        bench.run(&format!("{command} mesh.xyz")).failed("mesh.xyz", "");
    }
    assert_eq!(bench.names(), ["mesh.xyz", "noise.ply"]);
}

#[test]
fn a_truncated_mesh_is_named() {
    let bench = Bench::new();
    bench.write("cube.ply", &CUBE[..CUBE.len() - 20]);
    bench.run("info cube.ply").failed("cube.ply", "");
    bench.run("info cube.ply --json").failed("cube.ply", "");
    bench.run("info cube.ply --quiet").failed("cube.ply", "");
}

#[test]
#[cfg(unix)]
fn line_breaks_in_a_name_do_not_break_the_message() {
    let bench = Bench::new();
    let output = bench.command("info").arg("a\nb\u{1b}[31m.ply").output().unwrap();
    Outcome::of("info a\\nb", output).failed("a\\nb\\u{1b}[31m.ply", "No such file");
}

#[test]
fn where_the_output_cannot_go_shows_before_the_work() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("folder.png")).unwrap();
    // No mesh is read: it is the output that is complained about.
    bench.run("render none.ply -o folder.png").failed("folder.png", "irectory");
    bench.run("render none.ply -o no/where.png").failed("no/where.png", "No such file");
    bench.run("generate sphere -n 10 -o no/where.ply").failed("no/where.ply", "No such file");
    bench.run("query none.ply none.npy -o no/where.npz").failed("no/where.npz", "No such file");
    assert_eq!(bench.names(), ["folder.png"]);
}

#[test]
fn a_failure_leaves_an_older_output_as_it_was() {
    let bench = Bench::new();
    bench.write("old.png", "old");
    bench.run("render none.ply -o old.png").failed("none.ply", "No such file");
    assert_eq!(std::fs::read(bench.path("old.png")).unwrap(), b"old");
    assert_eq!(bench.names(), ["old.png"]);
}

#[test]
fn wrong_rays_are_named_before_the_mesh_is_read() {
    let bench = Bench::new();
    let good = files::npy("<f8", false, "(2, 6)", &[0; 96]);
    let with = |dtype, fortran, shape: &str| files::npy(dtype, fortran, shape, &[0; 96]);
    let long_header = [b"\x93NUMPY\x02\x00", &u32::MAX.to_le_bytes()[..], b"{'descr'"].concat();
    let mut unknown = good.clone();
    unknown[6] = 9;
    for (content, reason) in [
        (with("<f8", false, "(2, 5)"), "shape is (2, 5), expected (n, 6)"),
        (with("<f8", false, "(12,)"), "shape is (12,), expected (n, 6)"),
        (with("<f8", false, "()"), "shape is (), expected (n, 6)"),
        (with("<i8", false, "(2, 6)"), "dtype is '<i8', expected float32 or float64"),
        (with("|O", false, "(2, 6)"), "dtype is '|O', expected float32 or float64"),
        (with("<f8", true, "(3, 6)"), "ends before the (3, 6) float64"),
        (with("<f8", false, "(18446744073709551615, 8)"), "ends before the"),
        (with("<f8", false, "(99999999999999999999, 6)"), "too large"),
        (with("<f8", false, "(((((((((2, 6)"), "`(`"),
        (good[..good.len() - 1].to_vec(), "ends before the (2, 6) float64"),
        (good[..20].to_vec(), "header: the file ends within it"),
        (good[..7].to_vec(), "not a NumPy .npy file"),
        (b"PK\x03\x04 and so on".to_vec(), "perhaps an .npz archive"),
        (Vec::new(), "not a NumPy .npy file"),
        (long_header, "4294967295 bytes long"),
        (unknown, "unknown version 9.0"),
    ] {
        bench.write("rays.npy", content);
        bench.run("query none.ply rays.npy -o hits.npz").failed("rays.npy", reason);
    }
    bench.write("rays.npy", good);
    bench.run("query none.ply rays.npy -o hits.npz").failed("none.ply", "No such file");
    assert_eq!(bench.names(), ["rays.npy"]);
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    for line in ["info cube.ply", "info cube.ply --json", "--help"] {
        let mut command = bench.command(line);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{line}");
        assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{line}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_named() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = bench.command("info cube.ply").stdout(full).output().unwrap();
    Outcome::of("info cube.ply > /dev/full", output).failed("standard output", "No space left");
}

#[test]
fn a_cluster_needs_the_python_package() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    let line = "render cube.ply -o cube.png --cluster tcp://127.0.0.1:8786";
    bench
        .run(line)
        .failed("--cluster", "it needs the Python package, pip install 'halfline[dask]'");
    // What is wrong with the arguments comes first.
    bench.run(&format!("{line} --ground-height 3")).refused("--ground");
    assert_eq!(bench.names(), ["cube.ply"]);
}
