//! Tree files that are damaged anywhere: opened they are refused in one line, or answer whatever is asked,
//! or say that they are damaged.
//!
//! The input is a list of changes to a file that is whole: where, and what stands there instead. So that
//! most of them get past the header, it is given the right checksum again.

#![no_main]

use std::panic::{set_hook, take_hook};
use std::sync::{Once, OnceLock};

use halfline::geometry::vec3;
use halfline::progress::NoProgress;
use halfline::tree::Verify;
use halfline::{Error, Hit, Ray, Scene, is_guarded};
use halfline_fuzz::{be_single_threaded, place, write};
use halfline_io::models::{Kind, generate};
use libfuzzer_sys::fuzz_target;
use twox_hash::XxHash3_64;

/// A file of a small scene.
fn whole() -> &'static [u8] {
    static WHOLE: OnceLock<Vec<u8>> = OnceLock::new();
    WHOLE.get_or_init(|| {
        let mesh = generate(Kind::Scan, 200, 0, &NoProgress).expect("generates");
        let path = place("whole.hlt");
        Scene::new(mesh).expect("builds").save(&path, &NoProgress).expect("saves");
        std::fs::read(path).expect("reads")
    })
}

/// The hook of libFuzzer ends the process at every panic; those that are caught are no crashes.
fn hush_what_is_guarded() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let hook = take_hook();
        set_hook(Box::new(move |info| {
            if !is_guarded() {
                hook(info);
            }
        }));
    });
}

fn check<T>(answer: Result<T, Error>) {
    if let Err(error) = answer {
        assert!(matches!(error, Error::Format { .. }), "{error}");
        assert!(!error.to_string().contains('\n'), "{error}");
    }
}

fuzz_target!(|bytes: &[u8]| {
    be_single_threaded();
    hush_what_is_guarded();
    let mut file = whole().to_vec();
    for change in bytes.chunks_exact(8) {
        let [a, b, c, d, rest @ ..] = change else { continue };
        let at = u32::from_le_bytes([*a, *b, *c, *d]) as usize % file.len();
        let count = rest.len().min(file.len() - at);
        file[at..at + count].copy_from_slice(&rest[..count]);
    }
    file[32..40].fill(0);
    let checksum = XxHash3_64::oneshot(&file[..4096]);
    file[32..40].copy_from_slice(&checksum.to_le_bytes());

    let path = write("damaged.hlt", &file);
    let scene = match Scene::open(&path, Verify::Never, &NoProgress) {
        Ok(scene) => scene,
        Err(error) => return check::<()>(Err(error)),
    };
    let rays: Vec<Ray> = (0..128)
        .map(|i| {
            let angle = f64::from(i) * 0.7;
            let way = vec3(angle.cos(), angle.sin(), 0.3 * (2.0 * angle).sin());
            if i < 64 { Ray::new(vec3(0.0, 0.0, 0.1), way) } else { Ray::new(way * -3.0, way) }
        })
        .collect();
    check(scene.observed(&NoProgress).intersect(&rays));
    check(scene.observed(&NoProgress).occluded(&rays));
    check(scene.observed(&NoProgress).intersect_all(&rays));
    check(scene.observed(&NoProgress).count_intersections(&rays));
    check(scene.guarded(|| Ok(scene.caster().intersect(&rays[0]).unwrap_or(Hit::MISS))));
    check(scene.guarded(|| Ok(scene.statistics())));
    check(scene.guarded(|| Ok(scene.mesh().bounds())));
});
