//! The command as other programs call it.

use std::ffi::OsString;

use halfline::geometry::vec3;
use halfline_cli::{render_settings, run};
use halfline_render::{Background, GroundSurface, RenderSettings, Shading, Up};

fn settings(line: &str) -> Result<RenderSettings, String> {
    let options: Vec<String> = line.split_whitespace().map(String::from).collect();
    render_settings(&options)
}

#[test]
fn no_options_are_the_default_settings() {
    assert_eq!(settings(""), Ok(RenderSettings::default()));
}

#[test]
fn options_are_those_of_the_command() {
    let line = "--resolution 64,48 --shading whitted --samples 9 --seed 7 --up -Z \
                --camera-position 1,2,-3 --background-color #ffffff --ground=checker \
                --ground-height -1 --material glass --base-ior 1.4 --smooth-angle 30 \
                --light directional:direction=0,0,-1 --light directional:direction=0,-1,0 --max-depth 3";
    let settings = settings(line).unwrap();
    assert_eq!((settings.width, settings.height), (64, 48));
    assert_eq!(settings.shading, Shading::Whitted);
    assert_eq!((settings.samples, settings.seed, settings.max_depth), (9, 7, 3));
    assert_eq!(settings.camera.up, Up::MinusZ);
    assert_eq!(settings.camera.position, Some(vec3(1.0, 2.0, -3.0)));
    assert_eq!(settings.background, Background::Color([1.0; 3]));
    let ground = settings.ground.unwrap();
    assert!(matches!(ground.surface, GroundSurface::Checker(..)));
    assert_eq!(ground.height, Some(-1.0));
    let material = settings.material.unwrap();
    assert_eq!((material.transmission, material.ior), (1.0, 1.4));
    assert_eq!(settings.smooth_angle, Some(30.0));
    assert_eq!(settings.lights.len(), 2);
}

#[test]
fn wrong_options_are_refused_in_a_plain_line() {
    for (line, option, reason) in [
        ("--samples 0", "--samples", "0 is not in 1..="),
        ("--samples many", "--samples", "invalid digit"),
        ("--samples", "--samples", "a value is required"),
        ("--samples 1 --samples 2", "--samples", "cannot be used multiple times"),
        ("--shading phong", "--shading", "[possible values: clay, whitted"),
        ("--resolution 0,5", "--resolution", "expected WIDTH,HEIGHT"),
        ("--resolution 100000,100000", "--resolution", "more than"),
        ("--camera-view-up 0,0,0", "--camera-view-up", "cannot be zero"),
        ("--camera-view-angle 180", "--camera-view-angle", "between 0 and 180"),
        ("--no-background --background-color 0,0,0", "--no-background", "--background-color"),
        ("--camera-position 1,2,3 --camera-azimuth-angle 4", "-position", "--camera-azimuth-angle"),
        ("--camera-position 1,2,3 --camera-focal-point 1,2,3", "-position", "the same point"),
        ("--ground-height 1", "--ground-height", "need --ground"),
        ("--light lamp", "--light", "none of point, directional, area"),
        ("--smaples 4", "--smaples", "unexpected argument"),
        ("--output x.png", "--output", "unexpected argument"),
        ("--preset fast", "--preset", "unexpected argument"),
        ("--threads 2", "--threads", "unexpected argument"),
        ("--help", "--help", "unexpected argument"),
        ("--version", "--version", "unexpected argument"),
        ("scan.ply", "scan.ply", "unexpected argument"),
    ] {
        let said = settings(line).unwrap_err();
        assert!(said.contains(option) && said.contains(reason), "{line}: {said}");
        assert!(!said.contains(char::is_control), "{line}: {said:?}");
        for noise in ["error:", "Usage", "For more", "tip:"] {
            assert!(!said.contains(noise), "{line}: {said}");
        }
    }
    let said = render_settings(&["--samples".into(), "1\n\n\u{1b}[2J".into()]).unwrap_err();
    assert!(said.contains("--samples") && !said.contains(char::is_control), "{said:?}");
}

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
