//! How far the examination is.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::Result;
use crate::mesh::Mesh;
use crate::progress::{Observer, Stage};

/// Faces or vertices of one task: about a millisecond of work.
pub const CHUNK: usize = 1 << 14;

/// How many passes there are over all vertices, and over all faces.
const VERTEX_PASSES: u64 = 3;
const FACE_PASSES: u64 = 5;

/// A sum of elements passed, that several threads add to.
pub struct Progress<'a> {
    observer: &'a dyn Observer,
    done: AtomicU64,
    total: u64,
}

impl Progress<'_> {
    /// Nothing done yet.
    pub fn new<'a>(observer: &'a dyn Observer, mesh: &Mesh) -> Progress<'a> {
        let (vertices, faces) = (mesh.positions().len() as u64, mesh.triangle_count() as u64);
        let total = VERTEX_PASSES * vertices + FACE_PASSES * faces;
        Progress { observer, done: AtomicU64::new(0), total }
    }

    /// Reports that so many more elements are passed; an error if the work should end.
    pub fn advance(&self, elements: usize) -> Result<()> {
        let done = self.done.fetch_add(elements as u64, Ordering::Relaxed) + elements as u64;
        self.observer.report(Stage::Examine, done.min(self.total), self.total);
        self.observer.check()
    }

    /// Reports that all is done.
    pub fn finish(&self) {
        self.observer.report(Stage::Examine, self.total, self.total);
    }
}
