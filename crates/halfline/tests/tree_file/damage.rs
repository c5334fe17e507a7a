//! Files that are damaged after they were opened: wrong answers or errors, nothing worse.

use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::path::Path;

use halfline::geometry::vec3;
use halfline::progress::NoProgress;
use halfline::tree::Verify;
use halfline::{Error, Ray, RayF32, Scene};

use crate::common::Random;
use crate::{full_scene, rays};

/// Whether a question was answered; anything but an answer must be the one error that there is.
fn is_answered<T>(answer: Result<T, Error>) -> bool {
    match answer {
        Ok(_) => true,
        Err(Error::Format { .. }) => false,
        Err(error) => panic!("{error}"),
    }
}

/// Asks a scene all that can be asked, of one in `step` rays. Returns how many questions were answered.
pub fn ask_everything(scene: &Scene, step: usize) -> usize {
    let eye = vec3(0.3, 0.4, 5.0);
    let towards =
        |i: i32| vec3(f64::from(i % 16) * 0.05 - 0.6, f64::from(i / 16) * 0.05 - 0.6, -5.0);
    let packet = (0..512).map(|i| Ray::new(eye, towards(i)));
    let around = (0..200).map(|i| {
        let angle = f64::from(i) * 0.7;
        Ray::new(vec3(0.0, 0.0, 0.1), vec3(angle.cos(), angle.sin(), 0.3 * (2.0 * angle).sin()))
    });
    let all: Vec<Ray> = packet.chain(around).step_by(step).collect();
    let single = |ray: &Ray| RayF32 {
        origin: ray.origin.to_array().map(|x| x as f32),
        t_min: 0.0,
        direction: ray.direction.to_array().map(|x| x as f32),
        t_max: f32::INFINITY,
    };
    let singles: Vec<RayF32> = all.iter().map(single).collect();
    // At the surface, a little off, and too far away for single precision.
    let points: Vec<_> = all
        .iter()
        .zip([0.0, 1.0, 1e12].into_iter().cycle())
        .map(|(ray, far)| ray.at(0.9) + ray.direction * far)
        .collect();
    let by_one = || {
        for ray in &all {
            scene.caster().intersect(ray).unwrap_or(halfline::Hit::MISS);
            scene.caster().occluded(ray);
            scene.caster().intersect_all(ray, &mut Vec::new());
        }
        Ok(())
    };
    let answered = [
        is_answered(scene.observed(&NoProgress).intersect(&all)),
        is_answered(scene.observed(&NoProgress).intersect_f32(&singles)),
        is_answered(scene.observed(&NoProgress).occluded(&all)),
        is_answered(scene.observed(&NoProgress).intersect_all(&all)),
        is_answered(scene.observed(&NoProgress).count_intersections(&singles)),
        is_answered(scene.observed(&NoProgress).closest_points(&points, f64::INFINITY)),
        is_answered(scene.observed(&NoProgress).winding_numbers(&points)),
        is_answered(scene.observed(&NoProgress).contains(&points)),
        is_answered(scene.explain_point(eye, &NoProgress)),
        is_answered(scene.guarded(by_one)),
        is_answered(scene.guarded(|| Ok(scene.explain_winding(eye)))),
        is_answered(scene.guarded(|| Ok(scene.statistics()))),
        is_answered(scene.guarded(|| Ok(scene.mesh().bounds()))),
    ];
    answered.into_iter().filter(|answered| *answered).count()
}

/// Overwrites parts of a file, through its inode, as seen by all that map it.
fn damage(path: &Path, random: &mut Random) {
    let file = File::options().write(true).open(path).unwrap();
    let length = file.metadata().unwrap().len() as usize;
    for _ in 0..1 + random.below(40) {
        let at = 4096 + random.below(length - 4096);
        let bytes = match random.below(4) {
            0 => vec![0; 1 + random.below(5000)],
            1 => vec![0xff; 1 + random.below(100)],
            2 => (0..1 + random.below(64)).map(|_| random.below(256) as u8).collect(),
            // Node references and faces become others that could be.
            _ => (random.below(300) as u32 | (random.below(2) as u32) << 30).to_le_bytes().to_vec(),
        };
        let count = bytes.len().min(length - at);
        file.write_all_at(&bytes[..count], at as u64).unwrap();
    }
}

#[test]
fn damage_under_the_map_does_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    let scene = full_scene();
    scene.save(&path, &NoProgress).unwrap();
    let whole = fs::read(&path).unwrap();
    let mut random = Random(11);
    let (mut answered, mut asked) = (0, 0);
    for turn in 0..200 {
        fs::write(&path, &whole).unwrap();
        if turn % 2 == 0 {
            damage(&path, &mut random);
        }
        let opened = Scene::open(&path, Verify::Never, &NoProgress).expect("is not looked at");
        damage(&path, &mut random);
        answered += ask_everything(&opened, 1);
        asked += 13;
    }
    // Both happen.
    assert!(0 < answered && answered < asked, "{answered} of {asked}");
}

/// Every child is the root, and every box is everything.
#[test]
fn a_tree_that_goes_in_circles_is_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    full_scene().save(&path, &NoProgress).unwrap();
    let opened = Scene::open(&path, Verify::Always, &NoProgress).unwrap();
    let whole = fs::read(&path).unwrap();
    let section = |number: usize| {
        let word = |at: usize| u64::from_le_bytes(whole[at..at + 8].try_into().unwrap()) as usize;
        word(72 + 16 * number)..word(72 + 16 * number) + word(72 + 16 * number + 8)
    };
    let file = File::options().write(true).open(&path).unwrap();
    // One child, so that nothing is left on the stack, which so does not tell.
    let end = [0_u32.to_le_bytes(), (2_u32 << 30).to_le_bytes()];
    for node in section(0).step_by(256) {
        let sides = |lane: usize, side: usize| match (lane, side) {
            (0, 0) => -1e30_f32,
            (0, _) => 1e30,
            (_, 0) => f32::INFINITY,
            _ => f32::NEG_INFINITY,
        };
        let planes = (0..48).flat_map(|i| sides(i % 8, i / 8 % 2).to_le_bytes());
        let words = (0..8).flat_map(|lane| end[lane.min(1)]);
        let node_bytes: Vec<u8> = planes.chain(words).collect();
        file.write_all_at(&node_bytes, node as u64).unwrap();
    }
    let answered = ask_everything(&opened, 1);
    assert!(answered <= 2, "only the mesh's box and what never enters the tree: {answered}");
}

#[test]
fn a_file_cut_short_is_an_error_and_not_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    let scene = full_scene();
    let rays = rays(scene.mesh(), 2000);
    let expected = scene.intersect(&rays);
    scene.save(&path, &NoProgress).unwrap();
    let whole = fs::read(&path).unwrap();
    for length in [whole.len() / 2, 5000, 4096, 0] {
        fs::write(&path, &whole).unwrap();
        let opened = Scene::open(&path, Verify::Never, &NoProgress).unwrap();
        assert_eq!(opened.intersect(&rays), expected);
        File::options().write(true).open(&path).unwrap().set_len(length as u64).unwrap();
        let error = opened.observed(&NoProgress).intersect(&rays).unwrap_err().to_string();
        assert!(error.contains("tree.hlt") && error.contains("cut short"), "{error}");
        ask_everything(&opened, 1);
        assert!(opened.save(folder.path().join("copy.hlt"), &NoProgress).is_err());
        assert!(!folder.path().join("copy.hlt").exists());
    }
}
