//! Ctrl-C.

use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use npyz::Order;

use crate::files::write_rays;
use crate::{Bench, Outcome};

/// The promise, and what a busy machine may need to tell us.
const A_SECOND: Duration = Duration::from_millis(1000 + 500);

fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

/// Starts what will not end by itself within the test, and waits until it listens to signals.
fn start(mut command: Command) -> Child {
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let listens = || {
        let status = std::fs::read_to_string(&status).ok()?;
        let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:"))?;
        Some(u64::from_str_radix(mask.trim(), 16).unwrap() >> 1 & 1 == 1)
    };
    let limit = Instant::now() + Duration::from_secs(10);
    // Where there is no /proc, two seconds have to do.
    while !listens().unwrap_or(Instant::now() > limit - Duration::from_secs(8)) {
        assert!(Instant::now() < limit, "never listens to signals");
        sleep(Duration::from_millis(5));
    }
    child
}

/// Waits for the end and demands that it was an interruption that left nothing behind.
#[track_caller]
fn ends_interrupted(bench: &Bench, line: &str, child: Child, before: &[String]) {
    let start = Instant::now();
    let outcome = Outcome::of(line, child.wait_with_output().unwrap());
    let seconds = start.elapsed();
    assert_eq!(outcome.code, Some(130), "`{line}`: {}", outcome.stderr);
    assert_eq!(outcome.stderr, "halfline: interrupted\n", "`{line}`");
    assert_eq!(outcome.stdout, "", "`{line}`");
    assert!(seconds < A_SECOND, "`{line}` took {seconds:?} to end");
    assert_eq!(bench.names(), before, "`{line}` left something behind");
}

/// A mesh, rays, and an older result.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.run("generate sphere -n 100000 -o sphere.ply").succeeded();
    let rays: Vec<f64> = (0..100_000)
        .flat_map(|i| [0.0, 0.0, -3.0, f64::from(i % 317) * 1e-3, f64::from(i) * 1e-6, 1.0])
        .collect();
    write_rays(&bench.path("rays.npy"), &rays, 6, "<f8", Order::C);
    bench.write("old.png", "old");
    bench
}

#[test]
fn the_work_ends_within_a_second_and_leaves_nothing() {
    let bench = bench();
    let before = bench.names();
    for line in [
        "render sphere.ply -o new.png --samples 65536",
        "render sphere.ply -o old.png --samples 65536 --json",
        "query sphere.ply rays.npy -o hits.npz --engine brute",
        "generate scan -n 20M -o scan.ply",
        "study sphere.ply --sizes 10M --budget 1000 --output new/study",
        "study --family soup --sizes 10M --output new",
    ] {
        for name in ["-INT", "-TERM"] {
            let child = start(bench.command(line));
            sleep(Duration::from_millis(400));
            signal(&child, name);
            ends_interrupted(&bench, line, child, &before);
        }
    }
    assert_eq!(std::fs::read(bench.path("old.png")).unwrap(), b"old");
}

#[test]
fn an_early_signal_is_heard_too() {
    let bench = bench();
    let before = bench.names();
    let line = "render sphere.ply -o new.png --samples 65536";
    let child = start(bench.command(line));
    signal(&child, "-INT");
    ends_interrupted(&bench, line, child, &before);
}

#[test]
fn a_second_signal_ends_the_process_at_once() {
    let bench = bench();
    let before = bench.names();
    // The textbook's build does not ask whether to end.
    let line = "query sphere.ply rays.npy -o hits.npz --engine textbook";
    let child = start(bench.command(line));
    sleep(Duration::from_millis(200));
    let start = Instant::now();
    signal(&child, "-INT");
    sleep(Duration::from_millis(20));
    signal(&child, "-INT");
    ends_interrupted(&bench, line, child, &before);
    assert!(start.elapsed() < Duration::from_millis(500), "took {:?}", start.elapsed());
}

#[test]
fn work_that_cannot_ask_is_cut_off() {
    let bench = bench();
    let before = bench.names();
    let line = "query sphere.ply rays.npy -o hits.npz --engine textbook";
    let child = start(bench.command(line));
    sleep(Duration::from_millis(200));
    signal(&child, "-INT");
    ends_interrupted(&bench, line, child, &before);
}

#[test]
fn a_signal_while_the_result_is_written_leaves_the_whole_or_nothing() {
    let bench = Bench::new();
    let line = "generate soup -n 2M -o soup.ply";
    let mut child = start(bench.command(line));
    let half_written = |bench: &Bench| bench.names().iter().any(|name| name != "soup.ply");
    while !half_written(&bench) && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(1));
    }
    signal(&child, "-INT");
    let outcome = Outcome::of(line, child.wait_with_output().unwrap());
    let (code, left): (_, &[&str]) = match bench.path("soup.ply").exists() {
        true => (0, &["soup.ply"]),
        false => (130, &[]),
    };
    assert_eq!(
        (outcome.code, bench.names()),
        (Some(code), left.iter().map(|s| s.to_string()).collect())
    );
}

#[test]
fn closing_the_terminal_interrupts_unless_nohup_says_otherwise() {
    let bench = bench();
    let before = bench.names();
    let line = "render sphere.ply -o new.png --samples 65536";
    let child = start(bench.command(line));
    signal(&child, "-HUP");
    ends_interrupted(&bench, line, child, &before);

    let mut nohup = Command::new("sh");
    nohup.args(["-c", "trap '' HUP; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_halfline")]);
    nohup.args(line.split(' ')).current_dir(bench.path(""));
    let mut child = start(nohup);
    signal(&child, "-HUP");
    sleep(A_SECOND);
    assert!(child.try_wait().unwrap().is_none(), "ended by a signal that was to be ignored");
    signal(&child, "-INT");
    ends_interrupted(&bench, line, child, &before);
}
