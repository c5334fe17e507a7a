//! Arguments that make no sense: exit code 2 before any work.

use crate::{Bench, CUBE};

#[test]
fn help_and_version_go_to_stdout() {
    let bench = Bench::new();
    for (line, expected) in [
        ("--help", "Examples:"),
        ("-h", "render"),
        ("render --help", "--camera-focal-point"),
        ("query --help", "splits"),
        ("info --help", "--json"),
    ] {
        let outcome = bench.run(line);
        assert!(outcome.succeeded().stdout.contains(expected), "{line}: {}", outcome.stdout);
    }
    let version = format!("halfline {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(bench.run("--version").succeeded().stdout, version);
}

#[test]
fn the_help_lists_every_kind_of_mesh_with_a_line() {
    let help = Bench::new().run("generate --help").stdout;
    for kind in halfline_io::models::Kind::ALL {
        let line = help.lines().find(|line| line.contains(&format!("- {}:", kind.name())));
        assert!(line.is_some_and(|line| line.contains(kind.description())), "{kind:?} in {help}");
    }
}

#[test]
fn without_a_subcommand_the_help_shows_and_the_exit_code_is_2() {
    let outcome = Bench::new().run("");
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("Usage:"), "{}", outcome.stderr);
}

#[test]
fn wrong_arguments_are_refused() {
    let bench = Bench::new();
    bench.write("cube.ply", CUBE);
    for (line, reason) in [
        ("fly", "unrecognized subcommand 'fly'"),
        ("render cube.ply", "--output <FILE>"),
        ("render cube.ply -o x.jpg", "must end in .png or .exr"),
        ("render cube.ply -o png", "must end in .png or .exr"),
        ("render cube.ply -o x.png --resolution 0,5", "expected WIDTH,HEIGHT"),
        ("render cube.ply -o x.png --resolution 100000,100000", "more than"),
        ("render cube.ply -o x.png --shading phong", "possible values: clay, whitted"),
        ("render cube.ply -o x.png --up +W", "expected +X, -X"),
        ("render cube.ply -o x.png --samples 0", "0 is not in 1.."),
        ("render cube.ply -o x.png --camera-position 1,2", "expected X,Y,Z"),
        ("render cube.ply -o x.png --camera-view-up 0,0,0", "cannot be zero"),
        ("render cube.ply -o x.png --camera-view-angle 180", "between 0 and 180"),
        ("render cube.ply -o x.png --background-color mauve", "#RRGGBB"),
        ("render cube.ply -o x.png --no-background --background-color 0,0,0", "cannot be used"),
        ("render cube.ply -o x.png --ground-height 1", "--ground"),
        ("render cube.ply -o x.png --light lamp", "none of point, directional, area"),
        ("render cube.ply -o x.png --max-depth 65", "65 is not in 0..="),
        ("render cube.ply -o x.png --threads -1", "unexpected argument '-1'"),
        ("render cube.ply -o x.png --threads many", "invalid digit"),
        ("query cube.ply rays.npy -o hits.npy", "must end in .npz"),
        ("query cube.ply rays.npy -o hits.npz --any --all", "cannot be used with '--all'"),
        ("query cube.ply rays.npy -o hits.npz --engine slow", "fast, textbook, brute"),
        ("render cube.ply -o x.png --preset slow", "possible values: fast, balanced, best"),
        ("query cube.ply rays.npy -o hits.npz --preset slow", "fast, balanced, best"),
        ("info cube.ply --preset slow", "invalid value 'slow' for '--preset <NAME>'"),
        ("doctor cube.ply --preset", "a value is required for '--preset <NAME>'"),
        ("generate sphere -n 10 -o x.ply --preset fast", "unexpected argument '--preset'"),
        ("generate dragon -n 10 -o x.ply", "possible values: scan, sphere"),
        ("generate sphere -o x.ply", "--triangles <N>"),
        ("generate sphere -n 0 -o x.ply", "expected a whole number of at least 1"),
        ("generate sphere -n 10 -o x.stl", "must end in .ply"),
        ("info", "<MESH>"),
        ("info cube.ply --verbose", "unexpected argument '--verbose'"),
    ] {
        bench.run(line).refused(reason);
    }
    assert_eq!(bench.names(), ["cube.ply"]);
}

#[test]
fn an_output_that_is_the_input_is_refused_under_any_name() {
    let bench = Bench::new();
    bench.write("mesh.png", CUBE);
    bench.run("render mesh.png -o mesh.png").refused("would overwrite the input mesh.png");
    bench.run("render mesh.png -o ./mesh.png").refused("would overwrite the input mesh.png");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("mesh.png", bench.path("link.png")).unwrap();
        bench.run("render mesh.png -o link.png").refused("would overwrite");
    }
    assert_eq!(std::fs::read_to_string(bench.path("mesh.png")).unwrap(), CUBE);
}
