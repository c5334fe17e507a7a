//! What the fuzz targets share: a folder of their own, and what every answer of a reader must be like.

pub mod query_input;

use std::path::{Path, PathBuf};
use std::sync::{Once, OnceLock};

use halfline::error::{Error, Result};
use halfline::progress::{NoProgress, Observer};
use halfline::{Mesh, Scene};
use halfline_io::{ply, save_ply};
use tempfile::TempDir;

/// A reader of one format.
pub type Read = fn(&Path, &[u8], &dyn Observer) -> Result<Mesh>;

/// Meshes of more triangles are not built upon: the readers are what is tried.
const MOST_TRIANGLES_TO_BUILD: usize = 1000;

/// Error messages longer than this would quote the file instead of naming a place in it.
const LONGEST_MESSAGE: usize = 600;

/// Makes this thread the only one of the thread pool, so that every run takes the same course.
pub fn be_single_threaded() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .use_current_thread()
            .build_global()
            .expect("the pool has not been used yet");
    });
}

/// The place of a file called `name` in a folder of this process, which nobody removes:
/// `tools/fuzz.py` sets `TMPDIR` to a folder in memory, and removes that.
pub fn place(name: &str) -> PathBuf {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        tempfile::Builder::new().prefix("halfline-fuzz-").tempdir().expect("a folder")
    });
    folder.path().join(name)
}

/// Writes a file called `name` into the folder.
pub fn write(name: &str, content: &[u8]) -> PathBuf {
    let path = place(name);
    std::fs::write(&path, content).expect("room for a small file");
    path
}

/// Reads `content` as if it were the file called `name`, and fails unless the answer is a mesh that
/// can be used or an error of one line.
pub fn try_reader(read: Read, name: &str, content: &[u8]) {
    be_single_threaded();
    check_answer(read(&place(name), content, &NoProgress));
}

/// Fails unless `answer` is a mesh that can be used or an error of one line.
pub fn check_answer(answer: Result<Mesh>) {
    match answer {
        Ok(mesh) => check_mesh(mesh),
        Err(error) => check_error(&error),
    }
}

/// Fails unless `error` names the file and a place, in one line.
pub fn check_error(error: &Error) {
    let message = error.to_string();
    assert!(matches!(error, Error::Format { .. }), "not about the content: {message}");
    assert!(!message.contains('\n'), "more than one line: {message}");
    assert!(message.len() <= LONGEST_MESSAGE, "{} bytes long: {message}", message.len());
}

/// Fails unless `mesh` is whole, comes back the same from a saved file, and can be built upon.
fn check_mesh(mesh: Mesh) {
    let (vertices, triangles) = (mesh.positions().len(), mesh.triangle_count());
    assert!(mesh.triangles().iter().flatten().all(|&i| (i as usize) < vertices), "wrong index");
    assert!(mesh.source_faces.as_ref().is_none_or(|f| f.len() == triangles), "source faces");
    assert!(mesh.vertex_colors.as_ref().is_none_or(|c| c.len() == vertices), "vertex colours");
    if let Some(materials) = &mesh.triangle_materials {
        assert_eq!(materials.len(), triangles, "triangle materials");
        assert!(materials.iter().all(|&m| (m as usize) < mesh.materials.len()), "wrong material");
    }
    if triangles > MOST_TRIANGLES_TO_BUILD || vertices > 3 * MOST_TRIANGLES_TO_BUILD {
        return;
    }

    let path = place("saved.ply");
    save_ply(&mesh, &path, &NoProgress).expect("saves");
    let bytes = std::fs::read(&path).expect("the saved file");
    let again = ply::read(&path, &bytes, &NoProgress).expect("reads what was saved");
    assert_eq!(again.triangles(), mesh.triangles(), "saved triangles");
    assert_eq!(again.positions().len(), vertices, "saved vertices");
    let bits = |mesh: &Mesh, i: usize| mesh.positions().get(i).to_array().map(canonical_bits);
    assert!((0..vertices).all(|i| bits(&again, i) == bits(&mesh, i)), "saved coordinates");
    Scene::new(mesh).expect("builds");
}

/// The bits of a number; all NaN are one, for nobody promises which of them survives.
fn canonical_bits(x: f64) -> u64 {
    if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }
}
