//! The command as other programs call it.

use std::ffi::OsString;

use halfline_cli::run;

fn halfline(line: &str) -> u8 {
    run(["halfline"].into_iter().chain(line.split_whitespace()).map(OsString::from))
}

/// All of it in one test, since threads and signals belong to the process.
#[test]
fn a_host_outlives_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let sphere = file("sphere.ply");
    assert_eq!(halfline("--version"), 0);
    assert_eq!(halfline("render --help"), 0);
    assert_eq!(halfline(""), 2);
    assert_eq!(halfline("fly"), 2);

    // The first call makes the threads, and no later one can.
    let generate = format!("generate sphere -n 1000 -o {sphere} --quiet");
    assert_eq!(halfline(&format!("{generate} --threads 2")), 0);
    assert_eq!(halfline(&generate), 0);
    assert_eq!(halfline(&format!("{generate} --threads 2")), 0);
    assert_eq!(halfline(&format!("{generate} --threads 3")), 1);
    assert_eq!(halfline(&format!("info {} --quiet", file("missing.ply"))), 1);

    #[cfg(unix)]
    {
        use std::time::Duration;
        let slow = format!("render {sphere} -o {} --samples 65536 --quiet", file("sphere.png"));
        let interrupt = std::thread::spawn(|| {
            std::thread::sleep(Duration::from_millis(500));
            let pid = std::process::id().to_string();
            assert!(
                std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success()
            );
        });
        assert_eq!(halfline(&slow), 130);
        interrupt.join().unwrap();
        // Longer than the command waits for its work to end, and what was cancelled is so no more.
        std::thread::sleep(Duration::from_millis(1000));
        assert_eq!(halfline(&generate), 0);
        assert!(!folder.path().join("sphere.png").exists());
    }
}
