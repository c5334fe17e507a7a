//! From a file, be it a mesh or a tree, to what rays are cast at.

use std::path::Path;

use halfline::progress::Stage;
use halfline::tree::{Verify, is_tree_file};
use halfline::{Mesh, Scene};

use crate::failure::Failure;
use crate::input;
use crate::session::Session;
use crate::table::Table;
use crate::tree_options::TreeOptions;
use crate::units;

/// A scene, and what it took to have it.
pub struct Source {
    /// The mesh with its tree.
    pub scene: Scene,
    /// The preset that the tree was built with.
    pub preset: &'static str,
    /// Reading the mesh, or mapping the tree.
    pub load_seconds: f64,
    /// 0 for a tree, which was built before.
    pub build_seconds: f64,
}

impl Source {
    /// Opens the tree at `path`, or reads the mesh there or on standard input and builds its tree.
    pub fn open(path: &Path, tree: &TreeOptions, session: &Session) -> Result<Source, Failure> {
        if is_tree(path)? {
            let (scene, load_seconds) = open_tree(path, tree, session)?;
            let preset = scene.build_parameters().preset_name();
            return Ok(Source { scene, preset, load_seconds, build_seconds: 0.0 });
        }
        let (mesh, load_seconds) = session.load(path)?;
        let (scene, build_seconds) =
            session.timed(Stage::Build, |observer| tree.build(mesh, observer))?;
        let preset = scene.build_parameters().preset_name();
        Ok(Source { scene, preset, load_seconds, build_seconds })
    }

    /// The content hash of the tree's file.
    pub fn content_hash(&self) -> Option<String> {
        Some(self.scene.tree_file()?.content_hash().to_string())
    }

    /// Tells of the tree in one row: how long it was built, or that it is from a file.
    pub fn build_row(&self, table: &mut Table, note: &str) {
        match self.content_hash() {
            None => table.row(
                "build",
                units::seconds(self.build_seconds),
                format!("{}{note}", self.preset),
            ),
            Some(hash) => table.row("build", "before", format!("{}, {hash}{note}", self.preset)),
        };
    }
}

/// A mesh alone, for those who do without the tree.
pub enum MeshSource {
    /// From a mesh file.
    Mesh(Box<Mesh>),
    /// From a tree.
    Scene(Box<Scene>),
}

impl MeshSource {
    /// Reads the mesh at `path` or on standard input, or opens the tree there, and tells how many seconds
    /// it took.
    pub fn open(
        path: &Path,
        tree: &TreeOptions,
        session: &Session,
    ) -> Result<(MeshSource, f64), Failure> {
        if is_tree(path)? {
            let (scene, seconds) = open_tree(path, tree, session)?;
            return Ok((MeshSource::Scene(Box::new(scene)), seconds));
        }
        let (mesh, seconds) = session.load(path)?;
        Ok((MeshSource::Mesh(Box::new(mesh)), seconds))
    }

    /// The mesh with its tree, which is built unless it is there, and how many seconds that took.
    pub fn into_scene(
        self,
        tree: &TreeOptions,
        session: &Session,
    ) -> Result<(Scene, f64), Failure> {
        match self {
            MeshSource::Scene(scene) => Ok((*scene, 0.0)),
            MeshSource::Mesh(mesh) => {
                session.timed(Stage::Build, |observer| tree.build(*mesh, observer))
            }
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        match self {
            MeshSource::Mesh(mesh) => mesh,
            MeshSource::Scene(scene) => scene.mesh(),
        }
    }

    /// Does `work` on the mesh; if that is from a tree, as [`Scene::guarded`].
    pub fn guarded<T>(&self, work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
        match self {
            MeshSource::Mesh(_) => work(),
            MeshSource::Scene(scene) => scene.guarded(|| Ok(work()))?,
        }
    }
}

/// Whether a tree lies at `path`, which may be `-`.
fn is_tree(path: &Path) -> halfline::error::Result<bool> {
    if input::is_stdin(path) {
        return Ok(false);
    }
    input::check_regular(path)?;
    Ok(is_tree_file(path))
}

fn open_tree(path: &Path, tree: &TreeOptions, session: &Session) -> Result<(Scene, f64), Failure> {
    tree.check_unused(path)?;
    session.timed(Stage::Load, |observer| Scene::open(path, Verify::default(), observer))
}
