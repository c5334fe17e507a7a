//! What cannot be opened, and why.

use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::time::SystemTime;

use halfline::progress::NoProgress;
use halfline::tree::Verify;
use halfline::{Error, Scene};

use crate::common::Random;
use crate::full_scene;

/// The line that says why a file is refused. It names the file.
fn refusal(path: &Path, verify: Verify) -> String {
    let error = match Scene::open(path, verify, &NoProgress) {
        Ok(_) => panic!("{} was opened", path.display()),
        Err(error) => error.to_string(),
    };
    assert!(error.contains(path.to_str().unwrap()), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    error
}

fn change(path: &Path, at: usize, bytes: &[u8]) {
    File::options().write(true).open(path).unwrap().write_all_at(bytes, at as u64).unwrap();
}

#[test]
fn every_damaged_byte_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    full_scene().save(&path, &NoProgress).unwrap();
    let whole = fs::read(&path).unwrap();
    let mut random = Random(3);
    let anywhere = (0..200).map(|_| random.below(whole.len()));
    let places = (0..400).chain([4095, 4096, whole.len() - 1]).chain(anywhere);
    for at in places.collect::<Vec<_>>() {
        change(&path, at, &[whole[at] ^ 0x10]);
        let error = refusal(&path, Verify::IfTouched);
        if at >= 16 {
            assert!(error.contains("damaged"), "{at}: {error}");
        }
        change(&path, at, &whole[at..=at]);
    }
    Scene::open(&path, Verify::Always, &NoProgress).expect("whole again");
}

#[test]
fn a_file_that_was_not_touched_is_not_verified_and_one_that_was_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    full_scene().save(&path, &NoProgress).unwrap();
    let time = path.metadata().unwrap().modified().unwrap();
    change(&path, 5000, &[99]);
    let file = File::options().write(true).open(&path).unwrap();

    // Damaged behind the back of the file system.
    file.set_modified(time).unwrap();
    Scene::open(&path, Verify::IfTouched, &NoProgress).expect("is not looked at");
    Scene::open(&path, Verify::Never, &NoProgress).expect("is not looked at");
    assert!(refusal(&path, Verify::Always).contains("bytes 4096 to"));
    file.set_modified(SystemTime::now()).unwrap();
    assert!(refusal(&path, Verify::IfTouched).contains("nodes"));
}

#[test]
fn truncated_longer_foreign_and_other_files_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    full_scene().save(&path, &NoProgress).unwrap();
    let whole = fs::read(&path).unwrap();
    for verify in [Verify::IfTouched, Verify::Never] {
        let refused = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            refusal(&path, verify)
        };
        for length in [1, 7, 8, 15, 16, 4095, 4096, 10_000, whole.len() - 1] {
            let error = refused(&whole[..length]);
            assert!(error.contains("cut short"), "{length}: {error}");
        }
        assert!(refused(&[]).contains("empty"));
        assert!(refused(&[&whole[..], &[0]].concat()).contains("made longer"));
        assert!(refused(b"ply\nformat ascii 1.0\n").contains("not a tree of halfline"));
        assert!(refused(&[0; 10_000]).contains("not a tree of halfline"));
        // Copied as text.
        let text: Vec<u8> = whole.iter().copied().filter(|&byte| byte != b'\r').collect();
        assert!(refused(&text).contains("not a tree of halfline"));

        let with = |at: usize, bytes: &[u8]| {
            let mut changed = whole.clone();
            changed[at..at + bytes.len()].copy_from_slice(bytes);
            changed
        };
        let newer = refused(&with(8, &[3]));
        assert!(newer.contains("version 3") && newer.contains("version 2"), "{newer}");
        let older = refused(&with(8, &[1]));
        assert!(
            older.contains("version 1") && older.contains("halfline build MESH -o TREE"),
            "{older}"
        );
        assert!(refused(&with(8, &[0])).contains("version 0"));
        assert!(refused(&with(12, &[1, 2, 3, 4])).contains("another order"));
    }

    let missing = Scene::open(folder.path().join("none.hlt"), Verify::Always, &NoProgress);
    assert!(matches!(missing, Err(Error::Io { .. })));
    assert!(refusal(folder.path(), Verify::Always).contains("directory"));
    assert!(refusal(Path::new("/dev/null"), Verify::Always).contains("regular file"));
}

/// A header with other bytes at some place, and the right checksum.
fn forge(whole: &[u8], at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut forged = whole.to_vec();
    forged[at..at + bytes.len()].copy_from_slice(bytes);
    forged[32..40].fill(0);
    let checksum = twox_hash::XxHash3_64::oneshot(&forged[..4096]);
    forged[32..40].copy_from_slice(&checksum.to_le_bytes());
    forged
}

#[test]
fn forged_headers_are_refused_for_what_is_wrong_with_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    full_scene().save(&path, &NoProgress).unwrap();
    let whole = fs::read(&path).unwrap();
    let number = |at: usize| u64::from_le_bytes(whole[at..at + 8].try_into().unwrap());
    let section = |section: usize| 72 + 16 * section;
    let refused = |at: usize, bytes: &[u8], verify: Verify| {
        fs::write(&path, forge(&whole, at, bytes)).unwrap();
        refusal(&path, verify)
    };
    // Another hash of the same contents.
    let error = refused(40, &[whole[40] ^ 1], Verify::Always);
    assert!(error.contains("checksums are not what was written"), "{error}");
    // Sections that overlap, that leave a page between them, and that leave the file.
    for (at, value) in [
        (section(3), number(section(3)) - 4096),
        (section(3), number(section(3)) + 4096),
        (section(0), u64::MAX - 4095),
        (section(8) + 8, u64::MAX),
    ] {
        let error = refused(at, &value.to_le_bytes(), Verify::Never);
        assert!(error.contains("not where they can be"), "{at}: {error}");
    }
    // A mesh that should have no colours, and has some; triangles that end within one.
    let flags = u32::from_le_bytes(whole[300..304].try_into().unwrap());
    let error = refused(300, &(flags & !8).to_le_bytes(), Verify::Never);
    assert!(error.contains("vertex colours have a length"), "{error}");
    let error = refused(section(4) + 8, &(number(section(4) + 8) - 4).to_le_bytes(), Verify::Never);
    assert!(error.contains("triangles have a length"), "{error}");
    // A stack of a terabyte.
    let error = refused(292, &u32::MAX.to_le_bytes(), Verify::Never);
    assert!(error.contains("a tree that cannot be"), "{error}");
}

/// Headers that say the right checksum of wrong things.
#[test]
fn impossible_headers_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    full_scene().save(&path, &NoProgress).unwrap();
    let whole = fs::read(&path).unwrap();
    let mut random = Random(9);
    let mut opened = 0;
    for turn in 0..300 {
        let mut forged = whole.clone();
        let at = 56 + random.below(330);
        let byte = [0, 1, 0x7f, 0x80, 0xff, random.below(256) as u8][turn % 6];
        forged[at] = byte;
        if turn % 3 == 0 {
            forged[at & !7..][..8].fill(byte);
        }
        forged[32..40].fill(0);
        let checksum = twox_hash::XxHash3_64::oneshot(&forged[..4096]);
        forged[32..40].copy_from_slice(&checksum.to_le_bytes());
        fs::write(&path, &forged).unwrap();
        match Scene::open(&path, Verify::Never, &NoProgress) {
            Ok(scene) => {
                opened += 1;
                crate::damage::ask_everything(&scene, 24);
            }
            Err(Error::Format { .. }) => {}
            Err(error) => panic!("{at} {byte}: {error}"),
        }
    }
    assert!(opened > 0 && opened < 300, "{opened}");
}
