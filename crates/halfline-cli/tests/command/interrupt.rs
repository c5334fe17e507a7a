//! Ctrl-C.

use std::io::Read;
use std::process::Command;
use std::thread::sleep;
use std::time::Duration;

use npyz::Order;

use crate::child::{Started, wait_until};
use crate::files::write_rays;
use crate::{Bench, Outcome};

/// The promise is a second, which no busy machine can keep. All its threads work that long at most, less
/// where others work as well.
fn most_cpu_seconds(seconds: f64) -> f64 {
    seconds * std::thread::available_parallelism().map_or(1, usize::from) as f64
}

fn start(bench: &Bench, line: &str) -> Started {
    Started::new(line, bench.command(line))
}

/// Waits for the end, which a signal asked for when `cpu_before` seconds were spent, and demands that it was
/// an interruption that left nothing behind.
#[track_caller]
fn ends_interrupted(
    bench: &Bench,
    line: &str,
    child: Started,
    cpu_before: f64,
    seconds: f64,
    before: &[String],
) {
    let (output, cpu_seconds) = child.end();
    let outcome = Outcome::of(line, output);
    assert_eq!(outcome.code, Some(130), "`{line}`: {}", outcome.stderr);
    assert_eq!(outcome.stderr, "halfline: interrupted\n", "`{line}`");
    assert_eq!(outcome.stdout, "", "`{line}`");
    let spent = cpu_seconds - cpu_before;
    assert!(spent < most_cpu_seconds(seconds), "`{line}` spent {spent} CPU seconds on its end");
    assert_eq!(bench.names(), before, "`{line}` left something behind");
}

/// Sends a signal, and demands that it ends the work within a second.
#[track_caller]
fn interrupt(bench: &Bench, line: &str, child: Started, name: &str, before: &[String]) {
    let cpu_before = child.cpu_seconds();
    child.send(name);
    ends_interrupted(bench, line, child, cpu_before, 1.0, before);
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
            let child = start(&bench, line);
            // Somewhere in the work: where does not matter.
            sleep(Duration::from_millis(400));
            interrupt(&bench, line, child, name, &before);
        }
    }
    assert_eq!(std::fs::read(bench.path("old.png")).unwrap(), b"old");
}

#[test]
fn an_early_signal_is_heard_too() {
    let bench = bench();
    let before = bench.names();
    let line = "render sphere.ply -o new.png --samples 65536";
    interrupt(&bench, line, start(&bench, line), "-INT", &before);
}

#[test]
fn a_second_signal_ends_the_process_at_once() {
    let bench = bench();
    let before = bench.names();
    // The textbook's build does not ask whether to end.
    let line = "query sphere.ply rays.npy -o hits.npz --engine textbook";
    let child = start(&bench, line);
    wait_until("it builds", || child.cpu_seconds() > 0.2 || child.has_thread("signals").is_none());
    let cpu_before = child.cpu_seconds();
    // Two of one kind that come at once would be one.
    child.send("-INT");
    child.send("-TERM");
    // Without the second it would be 0.8 seconds of one thread.
    ends_interrupted(&bench, line, child, cpu_before, 0.5 / most_cpu_seconds(1.0), &before);
}

#[test]
fn work_that_cannot_ask_is_cut_off() {
    let bench = Bench::new();
    let line = "info -";
    let mut child = start(&bench, line);
    child.feed();
    interrupt(&bench, line, child, "-INT", &[]);
}

#[test]
fn a_signal_while_the_result_is_written_leaves_the_whole_or_nothing() {
    let bench = Bench::new();
    let line = "generate soup -n 2M -o soup.ply";
    let mut child = start(&bench, line);
    let is_half_written = |bench: &Bench| bench.names().iter().any(|name| name != "soup.ply");
    wait_until("half of the file is there", || is_half_written(&bench) || child.has_ended());
    child.send("-INT");
    let outcome = Outcome::of(line, child.end().0);
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
    interrupt(&bench, line, start(&bench, line), "-HUP", &before);

    let mut nohup = Command::new("sh");
    nohup.args(["-c", "trap '' HUP; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_halfline")]);
    nohup.args(line.split(' ')).current_dir(bench.path(""));
    let mut child = Started::new(line, nohup);
    let at_start = child.cpu_seconds();
    child.send("-HUP");
    sleep(Duration::from_millis(1500));
    wait_until("it has worked on", || {
        assert!(!child.has_ended(), "ended by a signal that was to be ignored");
        child.cpu_seconds() > at_start || child.has_thread("signals").is_none()
    });
    interrupt(&bench, line, child, "-INT", &before);
}

#[test]
fn the_end_is_told_once_even_if_whoever_tells_it_has_to_wait() {
    /// More than a pipe holds.
    const FILLING: u64 = 1 << 20;
    let bench = Bench::new();
    let line = "info -";
    // Nobody reads stderr, which is full: whoever wants to tell the end has to wait.
    let (mut reader, writer) = std::io::pipe().unwrap();
    let mut filler = writer.try_clone().unwrap();
    let filling = std::thread::spawn(move || {
        std::io::copy(&mut std::io::repeat(b' ').take(FILLING), &mut filler).unwrap();
    });
    let mut child = Started::with_stderr(line, bench.command(line), writer.into());
    child.feed();
    // Patience with the work ends, and then the work does: both want to tell.
    child.send("-INT");
    sleep(Duration::from_millis(1000));
    child.end_input();
    sleep(Duration::from_millis(200));
    let mut said = String::new();
    let reading = std::thread::spawn(move || {
        reader.read_to_string(&mut said).unwrap();
        said
    });
    let (output, _) = child.end();
    filling.join().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert_eq!(reading.join().unwrap().replace(' ', ""), "halfline:interrupted\n");
}
