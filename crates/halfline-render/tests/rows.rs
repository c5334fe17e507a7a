//! Pictures put together from rows that were traced apart.

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use halfline::progress::{NoProgress, Observer, Stage};
use halfline::{Error, Scene};
use halfline_render::{Ground, Plan, RenderSettings, Rendering, Rows, Shading, assemble, render};
use support::{Builder, GLASS, MIRROR, matte};

fn scene() -> Scene {
    Builder::default()
        .icosphere([0.0, 1.0, 0.0], 1.0, 2, GLASS)
        .icosphere([2.0, 1.0, 0.0], 1.0, 2, MIRROR)
        .cuboid([-2.0, 0.0, -1.0], [-1.2, 1.5, 1.0], matte(0.5, 0.4, 0.3))
        .scene()
}

fn settings(shading: Shading) -> RenderSettings {
    RenderSettings::new(41, 35).with(|s| {
        s.samples = 3;
        s.shading = shading;
        s.seed = 5;
        s.ground = Some(Ground::default().mirroring(0.3));
        s.smooth_angle = Some(50.0);
    })
}

/// The whole picture in bands of so many rows, the last one less high, in an order that is no order.
fn bands(plan: &Plan<&Scene>, rows: u32) -> Vec<Rows> {
    let height = plan.settings().height;
    let mut bands: Vec<Rows> = (0..height)
        .step_by(rows as usize)
        .map(|first| plan.trace_rows(first..(first + rows).min(height), &NoProgress).unwrap())
        .collect();
    let count = bands.len();
    for i in 0..count {
        bands.swap(i, (i * 7 + 3) % count);
    }
    bands
}

/// All but the time that it took, so that the bits can be compared.
#[track_caller]
fn timeless(picture: Result<Rendering, Error>) -> Rendering {
    let mut picture = picture.unwrap();
    picture.statistics.trace_seconds = 0.0;
    picture
}

fn through_bytes(rows: &Rows) -> Rows {
    Rows::from_bytes(&rows.to_bytes()).unwrap()
}

#[test]
fn parts_make_the_same_bits_as_the_whole() {
    let scene = scene();
    for shading in Shading::ALL {
        let settings = settings(shading);
        let whole = timeless(render(&scene, &settings, &NoProgress));
        let plan = Plan::new(&scene, &settings).unwrap();
        for rows in [1, 7, 8, 13, 35] {
            let parts = bands(&plan, rows);
            let name = shading.name();
            let sent: Vec<Rows> = parts.iter().map(through_bytes).collect();
            assert!(sent == parts, "{name}: bytes change bands of {rows} rows");
            let picture = timeless(assemble(&settings, sent));
            assert_eq!(picture.statistics, whole.statistics, "{name}, bands of {rows} rows");
            assert!(picture == whole, "{name}, bands of {rows} rows");
        }
    }
}

#[test]
fn a_picture_of_a_single_pixel_and_one_of_nothing_have_rows_too() {
    let nothing = Builder::default().plain_scene();
    for (scene, width, height) in [(&scene(), 1, 1), (&scene(), 1, 9), (&nothing, 9, 5)] {
        for shading in Shading::ALL {
            let settings = settings(shading).with(|s| {
                s.width = width;
                s.height = height;
            });
            let whole = timeless(render(scene, &settings, &NoProgress));
            let plan = Plan::new(scene, &settings).unwrap();
            let parts = bands(&plan, 2);
            let picture = timeless(assemble(&settings, parts.iter().map(through_bytes)));
            assert!(picture == whole, "{}, {width} x {height}", shading.name());
        }
    }
}

/// A task may be run again, and its first answer lost; threads may share a plan that owns its scene.
#[test]
fn the_same_rows_again_are_the_same() {
    let plan = Plan::new(Arc::new(scene()), &settings(Shading::Whitted)).unwrap();
    let trace = || {
        let mut rows = plan.trace_rows(9..22, &NoProgress).unwrap().to_bytes();
        rows[88..96].fill(0); // The seconds.
        rows.truncate(rows.len() - 8);
        rows
    };
    let first = trace();
    let again = std::thread::scope(|scope| scope.spawn(trace).join().unwrap());
    assert!(first == again);
}

#[test]
fn rows_tell_which_they_are_and_what_they_cost() {
    let scene = scene();
    let plan = Plan::new(&scene, &settings(Shading::Normal)).unwrap();
    let rows = through_bytes(&plan.trace_rows(9..22, &NoProgress).unwrap());
    assert_eq!(rows.range(), 9..22);
    assert_eq!(rows.picture_size(), (41, 35));
    // Three samples and the middle of each pixel.
    assert_eq!(rows.statistics().rays.total(), 41 * 13 * 4);
    assert!(rows.statistics().trace_seconds > 0.0);
}

#[track_caller]
fn refused<T: std::fmt::Debug>(result: Result<T, Error>, reason: &str) {
    match result {
        Err(error @ Error::Invalid { .. }) => {
            let said = error.to_string();
            assert!(said.starts_with("row") && said.contains(reason), "{said:?}, not {reason:?}");
            assert!(!said.contains('\n'), "{said:?}");
        }
        other => panic!("{other:?}, not {reason:?}"),
    }
}

#[test]
fn rows_that_make_no_picture_are_refused() {
    let (scene, settings) = (scene(), settings(Shading::Face));
    let plan = Plan::new(&scene, &settings).unwrap();
    let rows = |range| plan.trace_rows(range, &NoProgress).unwrap();
    let of = |settings: &RenderSettings, range| {
        Plan::new(&scene, settings).unwrap().trace_rows(range, &NoProgress).unwrap()
    };
    refused(assemble(&settings, []), "rows 0 to 34: missing");
    refused(assemble(&settings, [rows(0..8), rows(9..35)]), "row 8: missing");
    refused(assemble(&settings, [rows(20..35), rows(0..12)]), "rows 12 to 19: missing");
    refused(assemble(&settings, [rows(0..35), rows(3..4)]), "row 3: there twice");
    refused(
        assemble(&settings, [rows(8..20), rows(0..12), rows(20..35)]),
        "rows 8 to 11: there twice",
    );

    let smaller = settings.clone().with(|s| s.height = 34);
    let reason = "rows 0 to 9: of a picture of 41 x 34 pixels, not 41 x 35";
    refused(assemble(&settings, [of(&smaller, 0..10), rows(10..35)]), reason);
    let narrower = settings.clone().with(|s| s.width = 40);
    let reason = "row 34: of a picture of 40 x 35 pixels, not 41 x 35";
    refused(assemble(&settings, [rows(0..34), of(&narrower, 34..35)]), reason);
    for other in [
        settings.clone().with(|s| s.seed = 6),
        settings.clone().with(|s| s.shading = Shading::Steps),
        settings.clone().with(|s| s.smooth_angle = None),
    ] {
        let reason = "rows 10 to 34: traced with other settings";
        refused(assemble(&settings, [rows(0..10), of(&other, 10..35)]), reason);
    }
    let other = Builder::default().icosphere([0.0; 3], 1.0, 1, GLASS).scene();
    let other = Plan::new(&other, &settings).unwrap().trace_rows(10..35, &NoProgress).unwrap();
    let reason = "rows 10 to 34: traced of another scene than those before";
    refused(assemble(&settings, [rows(0..10), other]), reason);
}

#[test]
fn rows_beyond_the_picture_cannot_be_traced() {
    let scene = scene();
    let plan = Plan::new(&scene, &settings(Shading::Face)).unwrap();
    let beyond = 34..36;
    let none = 7..7;
    let backwards = std::ops::Range { start: 9, end: 3 };
    for range in [beyond, none, backwards, 0..u32::MAX] {
        refused(plan.trace_rows(range, &NoProgress), "is no part of 0..35");
    }
}

#[test]
fn bytes_that_are_no_rows_are_refused() {
    let scene = scene();
    let settings = settings(Shading::Steps);
    let plan = Plan::new(&scene, &settings).unwrap();
    let bytes = plan.trace_rows(4..7, &NoProgress).unwrap().to_bytes();
    assert_eq!(bytes.len(), 96 + 3 * 41 * 44 + 8);

    refused(Rows::from_bytes(b""), "do not begin as rows");
    refused(Rows::from_bytes(b"PLY\nformat ascii 1.0"), "do not begin as rows");
    for length in [8, 50, 95, 96, 1000, bytes.len() - 1] {
        refused(Rows::from_bytes(&bytes[..length]), "cut short");
    }
    refused(Rows::from_bytes(&[&bytes[..], &[0]].concat()), "more than");
    for at in 8..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        refused(Rows::from_bytes(&damaged), "");
    }
    // A header that promises four billion rows of four billion pixels makes nobody reserve them.
    let mut huge = bytes.clone();
    huge[16..32].fill(0xff);
    refused(Rows::from_bytes(&huge), "damaged");
    let mut newer = bytes;
    newer[8] = 2;
    refused(Rows::from_bytes(&newer), "version 2 of their layout");
}

#[test]
fn progress_is_told_in_pixels_of_the_rows_and_the_end_is_heard() {
    #[derive(Default)]
    struct Ear {
        done: AtomicU64,
        patience: u64,
    }
    impl Observer for Ear {
        fn report(&self, stage: Stage, done: u64, total: u64) {
            assert_eq!((stage, total), (Stage::Trace, 41 * 13));
            self.done.fetch_max(done, Ordering::Relaxed);
        }
        fn cancelled(&self) -> bool {
            self.done.load(Ordering::Relaxed) > self.patience
        }
    }
    let scene = scene();
    let plan = Plan::new(&scene, &settings(Shading::Clay)).unwrap();
    let patient = Ear { patience: u64::MAX, ..Ear::default() };
    plan.trace_rows(1..14, &patient).unwrap();
    assert_eq!(patient.done.into_inner(), 41 * 13);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let impatient = Ear::default();
    let traced = one_thread.install(|| plan.trace_rows(1..14, &impatient));
    assert!(matches!(traced, Err(Error::Interrupted)), "{traced:?}");
}
