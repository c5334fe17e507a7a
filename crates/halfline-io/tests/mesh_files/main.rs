//! Small files of every kind, good ones with the exact mesh they hold and broken ones with the
//! message they earn.

mod gltf;
mod gltf_build;
mod gltf_refusals;
mod obj;
mod off;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use halfline::error::{Error, Result};
use halfline::mesh::{Mesh, Positions};
use halfline::progress::{NoProgress, Observer, Stage};

/// One of the readers.
type Read = fn(&Path, &[u8], &dyn Observer) -> Result<Mesh>;

/// The mesh in a file that has no folder around it.
fn mesh_of(read: Read, content: impl AsRef<[u8]>) -> Mesh {
    read(Path::new("no-such-folder/mesh"), content.as_ref(), &NoProgress).unwrap()
}

fn points(mesh: &Mesh) -> Vec<[f64; 3]> {
    (0..mesh.positions().len()).map(|i| mesh.positions().get(i).to_array()).collect()
}

fn is_single_precision(mesh: &Mesh) -> bool {
    matches!(mesh.positions(), Positions::F32(_))
}

/// Reading must fail with one line that names the file, the place and the reason.
fn assert_fails(read: Read, content: impl AsRef<[u8]>, place: &str, reason: &str) {
    let content = content.as_ref();
    let shown = String::from_utf8_lossy(&content[..content.len().min(300)]).into_owned();
    match read(Path::new("no-such-folder/mesh"), content, &NoProgress) {
        Ok(mesh) => panic!("{} triangles read from {shown}", mesh.triangle_count()),
        Err(error) => {
            let message = error.to_string();
            let start = format!("no-such-folder/mesh: {place}: ");
            assert!(message.starts_with(&start), "{message:?} has not {start:?}; file: {shown}");
            assert!(message.contains(reason), "{message:?} has not {reason:?}; file: {shown}");
            assert!(!message.contains('\n'), "{message:?} is more than one line");
        }
    }
}

/// Stops the work at the first question after `done` bytes are reported.
struct StopAfter {
    limit: u64,
    done: AtomicU64,
    total: AtomicU64,
}

impl Observer for StopAfter {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        assert_eq!(stage, Stage::Load);
        assert!(done <= total, "{done} of {total}");
        let before = self.done.swap(done, Ordering::Relaxed);
        assert!(before <= done, "{done} after {before}");
        self.total.store(total, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.done.load(Ordering::Relaxed) >= self.limit
    }
}

/// The reader reports all bytes of the file, and stops when it is told to.
fn assert_reports_and_stops(read: Read, content: &[u8]) {
    let observer = |limit| StopAfter { limit, done: AtomicU64::new(0), total: AtomicU64::new(0) };
    let patient = observer(u64::MAX);
    read(Path::new("mesh"), content, &patient).unwrap();
    assert_eq!(patient.done.into_inner(), content.len() as u64);
    assert_eq!(patient.total.into_inner(), content.len() as u64);

    let hasty = observer(content.len() as u64 / 2);
    let result = read(Path::new("mesh"), content, &hasty);
    assert!(matches!(result, Err(Error::Interrupted)), "read on: {result:?}");
    assert!(hasty.done.into_inner() < content.len() as u64, "read to the end all the same");
}
