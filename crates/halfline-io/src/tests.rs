//! Loading by path: formats told apart, compressed files, progress, the end on request.

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::gzip::tests::compress;
use super::*;
use halfline::mesh::Positions;
use halfline::progress::{NoProgress, Stage};

/// A grid of `n` by `n` squares, two triangles each.
fn grid(n: u32) -> Mesh {
    let point = |i: u32| [(i % (n + 1)) as f32, (i / (n + 1)) as f32, (i % 3) as f32];
    let positions = (0..(n + 1) * (n + 1)).map(point).collect::<Vec<_>>();
    let triangles = (0..n * n).flat_map(|i| {
        let a = i / n * (n + 1) + i % n;
        [[a, a + 1, a + n + 1], [a + 1, a + n + 2, a + n + 1]]
    });
    Mesh::new(Positions::F32(positions.into()), triangles.collect::<Vec<_>>()).unwrap()
}

fn ply_bytes(mesh: &Mesh) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh");
    save_ply(mesh, &path, &NoProgress).unwrap();
    std::fs::read(path).unwrap()
}

fn ascii_ply_bytes(mesh: &Mesh) -> Vec<u8> {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions().len(),
        mesh.triangle_count()
    );
    for i in 0..mesh.positions().len() {
        let p = mesh.positions().get(i);
        text += &format!("{} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in mesh.triangles() {
        text += &format!("3 {a} {b} {c}\n");
    }
    text.into_bytes()
}

fn stl_bytes(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangle_count() as u32).to_le_bytes());
    for i in 0..mesh.triangle_count() as u32 {
        bytes.extend([0; 12]);
        for corner in mesh.corners(i) {
            bytes.extend(corner.to_array().iter().flat_map(|&c| (c as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn load_as(name: &str, bytes: &[u8]) -> Result<Mesh> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    load(&path, &NoProgress)
}

#[test]
fn the_content_decides_before_the_extension() {
    let mesh = grid(3);
    for name in ["a.ply", "a.PLY", "a.stl", "a", "a.txt", "a.ply.gz", ".ply"] {
        assert_eq!(load_as(name, &ply_bytes(&mesh)).unwrap(), mesh, "{name}");
        assert_eq!(load_as(name, &compress(&ply_bytes(&mesh))).unwrap(), mesh, "{name}");
    }
    for name in ["a.stl", "a.STL", "b.stl.gz", "c.Stl.GZ"] {
        let bytes = stl_bytes(&mesh);
        assert_eq!(load_as(name, &compress(&bytes)).unwrap().triangle_count(), 18, "{name}");
    }
    assert_eq!(load_as("a.stl", &stl_bytes(&mesh)).unwrap().triangle_count(), 18);
    let text = b"solid\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 \
                 endloop endfacet\nendsolid";
    for name in ["a", "a.ply", "a.stl"] {
        assert_eq!(load_as(name, text).unwrap().triangle_count(), 1, "{name}");
        assert_eq!(load_as(name, &compress(text)).unwrap().triangle_count(), 1, "{name}");
    }
}

#[test]
fn what_cannot_be_loaded_is_named() {
    let gz = compress(&ply_bytes(&grid(3)));
    for (name, bytes, expected) in [
        ("a.ply", &b""[..], "a.ply: byte 0: the file is empty"),
        ("a.xyz", b"1 2 3\n", "a.xyz: byte 0: the format is not known; supported are PLY"),
        ("a.gz", &compress(b"1 2 3"), "the format is not known"),
        ("a.ply", b"solar", "a.ply: header: the file ends before a line 'end_header'"),
        ("a.ply", b"solar\n", "a.ply: line 1: a PLY file begins with"),
        ("a.ply.gz", &gz[..gz.len() - 1], "the gzip stream is cut short"),
        ("a.ply.gz", &gz[..20], "a.ply.gz: compressed byte 20: the gzip stream is cut short"),
        ("a.ply.gz", b"\x1f\x8bxx", "gzip"),
    ] {
        let error = load_as(name, bytes).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{name}: {error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let error = load(folder.path(), &NoProgress).unwrap_err().to_string();
    assert!(error.contains("directory"), "{error}");
    let error = load(&folder.path().join("no.ply"), &NoProgress).unwrap_err().to_string();
    assert!(error.contains("no.ply"), "{error}");
}

#[test]
fn every_truncation_of_a_compressed_file_is_an_error() {
    for content in [ply_bytes(&grid(2)), stl_bytes(&grid(2)), ascii_ply_bytes(&grid(2))] {
        let bytes = compress(&content);
        for length in 0..bytes.len() {
            let error = load_as("a.stl.gz", &bytes[..length]).unwrap_err().to_string();
            assert!(!error.contains('\n'), "{error}");
        }
    }
}

#[test]
fn compressed_files_are_read_however_they_are_cut_into_members() {
    let mesh = grid(300);
    for content in [ply_bytes(&mesh), ascii_ply_bytes(&mesh)] {
        let mut bytes = Vec::new();
        for part in content.chunks(content.len() / 3 + 1) {
            bytes.extend(compress(part));
        }
        assert_eq!(load_as("a.ply.gz", &bytes).unwrap(), mesh);
    }
    let loaded = load_as("a.stl.gz", &compress(&stl_bytes(&mesh))).unwrap();
    assert_eq!(loaded.triangle_count(), mesh.triangle_count());
    assert_eq!(loaded.positions().len(), mesh.positions().len());
}

/// The content of a file, and 200 MB of zeros after it that shrink to nothing.
#[test]
fn bombs_behind_a_mesh_are_not_inflated() {
    let zeros = compress(&vec![0; 200 << 20]);
    for content in [ply_bytes(&grid(300)), stl_bytes(&grid(300)), ascii_ply_bytes(&grid(300))] {
        let mut bytes = compress(&content);
        bytes.extend(&zeros);
        let mesh = load_as("a.stl.gz", &bytes).unwrap();
        assert_eq!(mesh.triangle_count(), 180_000);
    }
    // Where the header promises as much, the limit holds.
    let mut bytes = compress(
        b"ply\nformat binary_little_endian 1.0\nelement vertex 900000000\nproperty uchar x\n\
          property uchar y\nproperty uchar z\nend_header\n",
    );
    bytes.extend(&zeros);
    let error = load_as("a.ply", &bytes).unwrap_err().to_string();
    assert!(error.contains("the header promises 900000000 of it"), "{error}");
    let mut bytes = compress(b"solid\n");
    bytes.extend(compress(&vec![b' '; 200 << 20]));
    let error = load_as("a.stl", &bytes).unwrap_err().to_string();
    assert!(error.contains("inflates to more than"), "{error}");
}

struct Recorder {
    reports: Mutex<Vec<(Stage, u64, u64)>>,
    checks: AtomicUsize,
    end_at_check: usize,
}

impl Recorder {
    fn ending_at(end_at_check: usize) -> Recorder {
        Recorder { reports: Mutex::default(), checks: AtomicUsize::new(0), end_at_check }
    }
}

impl Observer for Recorder {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        self.reports.lock().unwrap().push((stage, done, total));
    }

    fn cancelled(&self) -> bool {
        self.checks.fetch_add(1, Ordering::Relaxed) >= self.end_at_check
    }
}

fn all_kinds() -> Vec<(PathBuf, Vec<u8>)> {
    let mesh = grid(300);
    let (ply, stl, ascii) = (ply_bytes(&mesh), stl_bytes(&mesh), ascii_ply_bytes(&mesh));
    [("a.ply.gz", compress(&ply)), ("a.ply", ply), ("b.ply", ascii), ("a.stl", stl)]
        .map(|(name, bytes)| (name.into(), bytes))
        .into()
}

#[test]
fn progress_is_told_in_bytes_of_the_file_and_ends_complete() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in all_kinds() {
        let path = folder.path().join(&name);
        std::fs::write(&path, &bytes).unwrap();
        let recorder = Recorder::ending_at(usize::MAX);
        load(&path, &recorder).unwrap();
        let reports = recorder.reports.into_inner().unwrap();
        let total = bytes.len() as u64;
        assert!(reports.len() >= 3, "{name:?}: {reports:?}");
        assert!(reports.iter().all(|r| r.0 == Stage::Load && r.1 <= r.2 && r.2 == total));
        assert_eq!(reports.last().unwrap().1, total);
    }
}

#[test]
fn the_work_ends_whenever_the_observer_asks() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in all_kinds() {
        let path = folder.path().join(&name);
        std::fs::write(&path, &bytes).unwrap();
        let uninterrupted = Recorder::ending_at(usize::MAX);
        load(&path, &uninterrupted).unwrap();
        let checks = uninterrupted.checks.into_inner();
        assert!(checks >= 3, "{name:?} was asked {checks} times");
        for end in 0..checks {
            let result = load(&path, &Recorder::ending_at(end));
            assert!(matches!(result, Err(Error::Interrupted)), "{name:?} {end} of {checks}");
        }
    }
}

#[test]
fn an_interrupted_save_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.ply");
    let error = save_ply(&grid(300), &path, &Recorder::ending_at(1)).unwrap_err();
    assert!(matches!(error, Error::Interrupted));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    let recorder = Recorder::ending_at(usize::MAX);
    save_ply(&grid(300), &path, &recorder).unwrap();
    let length = std::fs::metadata(&path).unwrap().len();
    let reports = recorder.reports.into_inner().unwrap();
    assert_eq!(*reports.last().unwrap(), (Stage::Write, length, length));
}

fn load_from(stream: &[u8]) -> Result<Mesh> {
    load_stream(Path::new("the stream"), stream, 64 << 20, &NoProgress)
}

#[test]
fn a_stream_is_known_by_its_content() {
    let mesh = grid(100);
    let obj = "# a comment\n\no grid\nv 0 0 0\nv 1 0 0 # here\nv 0 1 0\nf 1 2 3\n";
    let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let gltf = "\n{\"asset\":{\"version\":\"2.0\"}}";
    let solid = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
                 endloop\nendfacet\nendsolid";
    let long_obj = format!("{}{}", obj, "f 1 2 3\n".repeat(START_BYTES));
    for (content, triangles) in [
        (ply_bytes(&mesh), 20_000),
        (ascii_ply_bytes(&mesh), 20_000),
        (stl_bytes(&mesh), 20_000),
        (solid.into(), 1),
        (obj.into(), 1),
        (obj.trim_end().into(), 1),
        (long_obj.into(), START_BYTES + 1),
        (off.into(), 1),
        (gltf.into(), 0),
    ] {
        assert_eq!(load_from(&content).unwrap().triangle_count(), triangles);
        assert_eq!(load_from(&compress(&content)).unwrap().triangle_count(), triangles);
    }
}

#[test]
fn a_stream_that_is_no_mesh_is_named() {
    for (content, expected) in [
        (&b""[..], "the stream: byte 0: there is nothing in it"),
        (b"1 2 3\n", "the stream: byte 0: the format is not known; supported are PLY"),
        (b"# notes\n", "the format is not known"),
        (b"v for vertex\n", "the format is not known"),
        (b"v 1 2 3\nimport x\nv 1 2 3\n", "the format is not known"),
        (&[0; 2000], "the format is not known"),
        (b"\x89HLT", "this is not a mesh but a tree"),
        (&stl_bytes(&grid(3))[..200], "the stream: facet 2: the file ends before its end"),
    ] {
        let error = load_from(content).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
    let bytes = ply_bytes(&grid(3));
    let most = bytes.len() as u64;
    let load = |most| load_stream(Path::new("the stream"), &bytes[..], most, &NoProgress);
    assert_eq!(load(most).unwrap(), grid(3));
    let error = load(most - 1).unwrap_err().to_string();
    assert!(error.starts_with(&format!("the stream: byte {}: more bytes", most - 1)), "{error}");
}

/// A stream that goes on for ever, and how much of it was asked for.
struct Endless<'a> {
    start: &'a [u8],
    asked: u64,
}

impl Read for &mut Endless<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.asked += buffer.len() as u64;
        if self.start.is_empty() {
            buffer.fill(0);
            return Ok(buffer.len());
        }
        self.start.read(buffer)
    }
}

#[test]
fn an_endless_stream_is_refused_by_its_start_or_at_the_bound() {
    const MOST: u64 = 8 << 20;
    for (start, expected, most_asked) in [
        (&b""[..], "the format is not known", 2 << 20),
        (b"{", "more bytes follow than may come this way", MOST + (2 << 20)),
    ] {
        let mut endless = Endless { start, asked: 0 };
        let error = load_stream(Path::new("zeros"), &mut endless, MOST, &NoProgress).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
        assert!(endless.asked <= most_asked, "{} bytes were asked for", endless.asked);
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_or_a_device_is_not_read_as_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.ply");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    // Whoever opens the pipe all the same finds its end, and no reason to wait.
    let writer = pipe.clone();
    std::thread::spawn(move || while std::fs::write(&writer, "").is_ok() {});
    for (path, kind) in [(&*pipe, "a pipe"), (Path::new("/dev/null"), "a device")] {
        let expected = format!("{}: not a regular file but {kind}", path.display());
        assert_eq!(load(path, &NoProgress).unwrap_err().to_string(), expected);
        // Neither are the files that a file names.
        let place = folder.path().join("side");
        std::os::unix::fs::symlink(path, &place).unwrap();
        for (name, content) in [
            ("a.obj", "mtllib side\nv 0 0 0\n"),
            (
                "a.gltf",
                r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"side","byteLength":12}],
                "bufferViews":[{"buffer":0,"byteLength":12}],"scenes":[{"nodes":[0]}],
                "nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
                "accessors":[{"bufferView":0,"componentType":5126,"count":1,"type":"VEC3"}]}"#,
            ),
        ] {
            let mesh = folder.path().join(name);
            std::fs::write(&mesh, content).unwrap();
            let error = load(&mesh, &NoProgress).unwrap_err().to_string();
            let expected = format!("{}: not a regular file but {kind}", place.display());
            assert_eq!(error, expected, "{name}");
        }
        std::fs::remove_file(place).unwrap();
    }
}
