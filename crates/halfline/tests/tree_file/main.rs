//! A tree that is a file: what is opened answers as what was saved, what is damaged is refused, and
//! what is damaged later does no harm.

#[path = "../common/mod.rs"]
mod common;
mod damage;
mod refusals;

use std::path::Path;
use std::time::{Duration, UNIX_EPOCH};

use common::engines::{bits, build_variants, by_batch, by_engine};
use common::{Random, meshes, nasty_ray, sphere};
use halfline::mesh::{Material, Positions};
use halfline::progress::{NoProgress, Observer, Stage};
use halfline::tree::{TreeFile, Verify, is_tree_file};
use halfline::{Error, Mesh, Ray, Scene, Vec3};
use halfline_io::models::{Kind, generate};

/// A scene of some thousand triangles that has every array that a mesh can have.
fn full_scene() -> Scene {
    let mut mesh = generate(Kind::Scan, 3000, 0, &NoProgress).expect("generates");
    let (triangles, vertices) = (mesh.triangle_count() as u32, mesh.positions().len());
    mesh.source_faces = Some((0..triangles).map(|t| t / 2).collect());
    mesh.vertex_colors = Some((0..vertices).map(|v| [v as u8, 1, 2, 255]).collect());
    mesh.materials = vec![Material::default(), Material { ior: 1.25, ..Material::default() }];
    mesh.triangle_materials = Some((0..triangles).map(|t| t % 2).collect());
    Scene::new(mesh).expect("builds")
}

fn open(path: &Path) -> Scene {
    Scene::open(path, Verify::Always, &NoProgress).expect("opens")
}

fn rays(mesh: &Mesh, count: usize) -> Vec<Ray> {
    let mut random = Random(7);
    (0..count).map(|_| nasty_ray(mesh, &[], &mut random)).collect()
}

/// A mesh to be compared: coordinates may be NaN.
fn mesh_bits(mesh: &Mesh) -> (bool, Vec<[u64; 3]>, &[[u32; 3]]) {
    let bits = |i| mesh.positions().get(i).to_array().map(f64::to_bits);
    let is_double = matches!(mesh.positions(), Positions::F64(_));
    (is_double, (0..mesh.positions().len()).map(bits).collect(), mesh.triangles())
}

#[test]
fn what_is_opened_answers_as_what_was_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    for (name, mesh) in meshes() {
        for parameters in build_variants() {
            let mut scene = Scene::builder(mesh.clone())
                .parameters(parameters)
                .observer(&NoProgress)
                .build()
                .expect("builds");
            scene.save(&path, &NoProgress).expect("saves");
            let mut opened = open(&path);
            assert!(mesh_bits(opened.mesh()) == mesh_bits(scene.mesh()), "{name}");
            assert_eq!(opened.build_parameters(), &parameters, "{name}");
            assert_eq!(opened.statistics(), scene.statistics(), "{name}");
            let rays = rays(scene.mesh(), 64);
            let expected: Vec<_> = by_batch(&mut scene, &rays).iter().map(bits).collect();
            let found: Vec<_> = by_batch(&mut opened, &rays).iter().map(bits).collect();
            assert!(found == expected, "{name}");
            for (ray, expected) in rays.iter().zip(&expected) {
                assert!(bits(&by_engine(&opened, ray)) == *expected, "{name}");
            }
        }
    }
}

#[test]
fn a_mesh_keeps_all_that_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    let scene = full_scene();
    scene.save(&path, &NoProgress).unwrap();
    let opened = open(&path);
    assert!(opened.mesh() == scene.mesh());
    assert_eq!(opened.build_time(), Duration::from_secs_f64(scene.build_time().as_secs_f64()));
    assert_eq!(opened.mesh().materials[1].ior, 1.25);

    // Nothing was copied, but the materials.
    let Positions::F32(positions) = opened.mesh().positions() else { panic!("single precision") };
    assert_eq!(positions.bytes_in_memory(), 0);
    assert_eq!(opened.tree().nodes.bytes_in_memory(), 0);
    assert_eq!(opened.mesh().source_faces.as_ref().unwrap().bytes_in_memory(), 0);

    // What was opened can be saved, over itself too, and the one that is open goes on.
    let before = opened.tree_file().unwrap().content_hash();
    opened.save(&path, &NoProgress).unwrap();
    let again = open(&path);
    assert_eq!(again.tree_file().unwrap().content_hash(), before);
    assert!(again.mesh() == opened.mesh() && opened.mesh() == scene.mesh());
}

#[test]
fn the_content_hash_tells_meshes_and_trees_apart_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    let hashes = |scene: &Scene| {
        scene.save(&path, &NoProgress).unwrap();
        let opened = open(&path);
        let file: &TreeFile = opened.tree_file().unwrap();
        (file.content_hash(), file.mesh_hash())
    };
    let mesh = sphere(3, Vec3::ZERO, 1.0);
    let first = hashes(&Scene::new(mesh.clone()).unwrap());
    // Another scene, which took another time to build, written at another time.
    assert_eq!(hashes(&Scene::new(mesh.clone()).unwrap()), first);

    let [.., other] = build_variants()[..] else { panic!("there are some") };
    let otherwise = hashes(
        &Scene::builder(mesh.clone()).parameters(other).observer(&NoProgress).build().unwrap(),
    );
    assert_ne!(otherwise.0, first.0);
    assert_eq!(otherwise.1, first.1);

    let mut colored = mesh;
    colored.vertex_colors = Some((0..colored.positions().len()).map(|_| [7; 4]).collect());
    let colored = hashes(&Scene::new(colored).unwrap());
    assert_ne!(colored.0, first.0);
    assert_eq!(colored.1, first.1);

    let moved = hashes(&Scene::new(sphere(3, Vec3::ZERO, 1.5)).unwrap());
    assert!(moved.0 != first.0 && moved.1 != first.1);
    assert_eq!(first.0.to_string().len(), 32);
}

/// Written down once: the file is the same on every machine, and the specification holds.
#[test]
fn the_specified_bytes_are_where_the_specification_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    let scene = full_scene();
    scene.save(&path, &NoProgress).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    assert_eq!(&bytes[..8], b"\x89HLT\r\n\x1a\n");
    assert_eq!(bytes[8..16], [2, 0, 0, 0, 4, 3, 2, 1]);
    assert_eq!(number(16), bytes.len() as u64);
    let modified = path.metadata().unwrap().modified().unwrap();
    assert_eq!(modified, UNIX_EPOCH + Duration::from_secs(number(24)));

    // The section of triangles, by hand.
    let (offset, length) = (number(72 + 4 * 16) as usize, number(72 + 4 * 16 + 8) as usize);
    let triangles: Vec<u32> = bytes[offset..offset + length]
        .chunks(4)
        .map(|word| u32::from_le_bytes(word.try_into().unwrap()))
        .collect();
    assert_eq!(triangles, scene.mesh().triangles().as_flattened());
}

#[test]
fn trees_are_known_by_their_first_bytes_or_their_name() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    full_scene().save(at("tree.bin"), &NoProgress).unwrap();
    std::fs::write(at("mesh.ply"), "ply\n").unwrap();
    std::fs::write(at("other.HLT"), "ply\n").unwrap();
    assert!(is_tree_file(&at("tree.bin")));
    assert!(!is_tree_file(&at("mesh.ply")));
    assert!(is_tree_file(&at("other.HLT")));
    assert!(is_tree_file(&at("missing.hlt")));
    assert!(!is_tree_file(&at("missing.ply")));
    // A mesh reader says what to do with one.
    let error = halfline_io::load(&at("tree.bin"), &NoProgress).unwrap_err().to_string();
    assert!(error.contains("tree.bin") && error.contains("tree"), "{error}");
}

/// Ends the work at its nth report of a stage.
struct EndsAt(Stage, std::sync::atomic::AtomicI64);

impl Observer for EndsAt {
    fn report(&self, stage: Stage, _: u64, _: u64) {
        if stage == self.0 {
            self.1.fetch_sub(1, std::sync::atomic::Ordering::Relaxed);
        }
    }

    fn cancelled(&self) -> bool {
        self.1.load(std::sync::atomic::Ordering::Relaxed) <= 0
    }
}

#[test]
fn writing_and_verifying_can_be_interrupted_and_leave_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tree.hlt");
    let scene = full_scene();
    scene.save(&path, &NoProgress).unwrap();
    let before = std::fs::read(&path).unwrap();
    for reports in [0, 1, 5, 12] {
        let error = scene.save(&path, &EndsAt(Stage::Write, reports.into())).unwrap_err();
        assert!(matches!(error, Error::Interrupted), "{error}");
        assert!(std::fs::read(&path).unwrap() == before);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
    }
    let ending = EndsAt(Stage::Load, 1.into());
    let error = Scene::open(&path, Verify::Always, &ending).err().unwrap();
    assert!(matches!(error, Error::Interrupted), "{error}");
}
