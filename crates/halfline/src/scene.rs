//! What users hold: a mesh with its tree, and the questions one can ask it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::build::{self, BuildParameters, Preset};
use crate::error::Result;
use crate::geometry::{Hit, Ray, SingleHit, SingleRay};
use crate::mesh::Mesh;
use crate::numeric::SurfacePoint;
use crate::progress::{Observer, Silent};
use crate::simd::Level;
use crate::traverse;
#[cfg(feature = "variants")]
pub use crate::traverse::PlainCaster;
pub use crate::traverse::columns::{
    AllHitColumns, Column, HitColumns, RayColumns, Scalars, Vectors,
};
pub use crate::traverse::{AllHits, BatchRay, Caster, LeafVerdict, RayCounters, Visit, WorkCounts};
use crate::tree::file as tree_file;
use crate::tree::{KdTree, LeafBlock, TreeFile, TreeStatistics, Verify};

/// A mesh and the kd-tree over it.
///
/// All questions may be asked from many threads at once. What counts as a hit is defined in
/// [`numeric`](crate::numeric); a ray that is not [valid](Ray::is_valid) hits nothing.
///
/// A scene may be [saved](Scene::save) to a file and [opened](Scene::open) from it. The file is mapped,
/// and somebody may damage it or cut it short meanwhile. Then questions are answered wrongly, or end in an
/// [`Error::Format`](crate::Error::Format) that names the file; those that return no `Result` panic.
pub struct Scene {
    mesh: Arc<Mesh>,
    tree: KdTree,
    parameters: BuildParameters,
    build_time: Duration,
    level: Level,
    file: Option<TreeFile>,
}

/// How many calls of [`Scene::guarded`] are under way for scenes from files.
static GUARDED: AtomicUsize = AtomicUsize::new(0);

/// One of them.
struct Guarded;

impl Guarded {
    fn begin() -> Guarded {
        GUARDED.fetch_add(1, Ordering::SeqCst);
        Guarded
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        GUARDED.fetch_sub(1, Ordering::SeqCst);
    }
}

/// True while a panic may be what a damaged tree file leads to, and is turned into an error by
/// [`Scene::guarded`]: a program's panic hook should say nothing then.
pub fn is_guarded() -> bool {
    GUARDED.load(Ordering::SeqCst) > 0
}

impl Scene {
    /// Builds the tree over `mesh` with default parameters.
    ///
    /// # Errors
    /// [`Error::Invalid`](crate::Error::Invalid) for a mesh of more than 2^29 triangles.
    pub fn new(mesh: Mesh) -> Result<Scene> {
        Scene::build(mesh, &Silent)
    }

    /// The same, reporting [`Stage::Build`](crate::progress::Stage::Build) to `observer`.
    ///
    /// # Errors
    /// As [`Scene::new`], and [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn build(mesh: Mesh, observer: &dyn Observer) -> Result<Scene> {
        Scene::build_with(mesh, &BuildParameters::default(), observer)
    }

    /// The same with parameters. A mesh that others hold too is not copied.
    ///
    /// # Errors
    /// As [`Scene::build`], and [`Error::Invalid`](crate::Error::Invalid) for parameters out of
    /// range, and for an instruction set that the environment variable
    /// `HALFLINE_SIMD` names and this machine lacks.
    pub fn build_with(
        mesh: impl Into<Arc<Mesh>>,
        parameters: &BuildParameters,
        observer: &dyn Observer,
    ) -> Result<Scene> {
        let start = Instant::now();
        let (mesh, level) = (mesh.into(), Level::chosen()?);
        let tree = build::build(&mesh, parameters, level, observer)?;
        let build_time = start.elapsed();
        Ok(Scene { mesh, tree, parameters: *parameters, build_time, level, file: None })
    }

    /// Opens a scene that was [saved](Scene::save): maps the file, in the same time whatever its size,
    /// unless it is to be verified. Reports [`Stage::Load`](crate::progress::Stage::Load) in bytes then.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) if the file cannot be mapped;
    /// [`Error::Format`](crate::Error::Format) if it is not a tree, or one of another version, cut short
    /// or damaged; [`Error::Interrupted`](crate::Error::Interrupted); and
    /// [`Error::Invalid`](crate::Error::Invalid) as [`Scene::build_with`] for the instruction set.
    pub fn open(path: &Path, verify: Verify, observer: &dyn Observer) -> Result<Scene> {
        let level = Level::chosen()?;
        let tree_file::Opened { mesh, tree, parameters, build_time, file } =
            tree_file::open(path, verify, observer)?;
        Ok(Scene { mesh: Arc::new(mesh), tree, parameters, build_time, level, file: Some(file) })
    }

    /// Writes mesh and tree to a file, from which [`Scene::open`] has them back at once. The file appears
    /// whole or not at all, and is durable then. By convention its name ends in `.hlt`. Reports
    /// [`Stage::Write`](crate::progress::Stage::Write).
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io), [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn save(&self, path: &Path, observer: &dyn Observer) -> Result<()> {
        self.guarded(|| {
            let Scene { mesh, tree, parameters, build_time, file, .. } = self;
            let source = file.as_ref();
            tree_file::write(path, mesh, tree, parameters, *build_time, source, observer)
        })
    }

    /// The file from which the scene was opened.
    pub fn tree_file(&self) -> Option<&TreeFile> {
        self.file.as_ref()
    }

    /// Does `work` on the scene. If the scene comes from a file, and what the file holds makes no sense
    /// any more, or was cut off meanwhile, the answer is an error, even where `work` would panic. The
    /// questions that return a `Result` do this by themselves.
    ///
    /// # Errors
    /// Those of `work`, and [`Error::Format`](crate::Error::Format).
    pub fn guarded<T>(&self, work: impl FnOnce() -> Result<T>) -> Result<T> {
        let Some(file) = &self.file else { return work() };
        let guarded = Guarded::begin();
        let outcome = catch_unwind(AssertUnwindSafe(work));
        drop(guarded);
        file.check()?;
        outcome.unwrap_or_else(|_| Err(file.damaged()))
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The mesh, to be held by others too.
    pub fn shared_mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The tree.
    pub fn tree(&self) -> &KdTree {
        &self.tree
    }

    /// The tree's figures; counts through the whole tree.
    pub fn tree_statistics(&self) -> TreeStatistics {
        self.tree.statistics(self.mesh.triangle_count())
    }

    /// How the tree was built.
    pub fn build_parameters(&self) -> &BuildParameters {
        &self.parameters
    }

    /// The preset that the tree was built with; "custom" for parameters of no preset.
    pub fn preset_name(&self) -> &'static str {
        let is_preset = |preset: &Preset| BuildParameters::preset(*preset) == self.parameters;
        Preset::ALL.into_iter().find(is_preset).map_or("custom", Preset::name)
    }

    /// How long the tree took to build.
    pub fn build_time(&self) -> Duration {
        self.build_time
    }

    /// The instruction set that batches are cast by.
    pub fn simd_level(&self) -> Level {
        self.level
    }

    /// Casts batches by another instruction set. No answer depends on it.
    pub fn set_simd_level(&mut self, level: Level) {
        self.level = level;
    }

    fn target(&self) -> traverse::Target<'_> {
        traverse::Target { tree: &self.tree, mesh: &self.mesh, level: self.level }
    }

    /// For rays that come one after another, each depending on the last: one for each thread. A
    /// [batch](Scene::intersect) is the better way for rays that are known together.
    pub fn caster(&self) -> Caster<'_> {
        Caster::new(&self.tree, &self.mesh)
    }

    /// The hit with the smallest t of one ray; of equal ones that with the lowest face index.
    pub fn closest(&self, ray: &Ray) -> Hit {
        self.caster().closest(ray)
    }

    /// True if one ray hits anything.
    pub fn any(&self, ray: &Ray) -> bool {
        self.caster().any(ray)
    }

    /// What single precision knows about a ray and a leaf of the tree, as batches ask it; what it leaves
    /// open they decide exactly. `None` if the ray does not meet the root's box, or is so large or so
    /// small, or comes from so far away, that batches look at it by itself.
    pub fn leaf_verdict(&self, ray: &Ray, block: &LeafBlock) -> Option<LeafVerdict> {
        traverse::leaf_verdict(&self.tree, ray, block, self.level)
    }

    /// [`Scene::caster`] with a plain triangle test, which leaks: to measure what the exact one costs.
    #[cfg(feature = "variants")]
    pub fn plain_caster(&self) -> PlainCaster<'_> {
        PlainCaster::new(&self.tree, &self.mesh)
    }

    /// Appends all hits of one ray to `hits`, sorted by t and then by face: every crossing, and every
    /// contact with the border of an open surface; see [`numeric`](crate::numeric).
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        self.caster().all(ray, hits);
    }

    /// The closest hit of each ray, in parallel and in the rays' order; [`Hit::MISS`] for a ray that
    /// hits nothing.
    pub fn intersect(&self, rays: &[Ray]) -> Vec<Hit> {
        unobserved(self.intersect_observed(rays, &Silent))
    }

    /// [`Scene::intersect`] into memory that is there.
    ///
    /// # Panics
    /// If there are not as many hits as rays.
    pub fn intersect_into(&self, rays: &[Ray], hits: &mut [Hit]) {
        unobserved(self.guarded(|| traverse::intersect_into(self.target(), rays, hits, &Silent)));
    }

    /// [`Scene::intersect`], reporting [`Stage::Trace`](crate::progress::Stage::Trace) in rays.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn intersect_observed(&self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<Hit>> {
        self.guarded(|| traverse::intersect(self.target(), rays, observer))
    }

    /// The closest hit of each ray in single precision: its face is that of [`Scene::intersect`], and
    /// its t that t rounded. The quickest way, where barycentrics are not needed.
    pub fn intersect_single(&self, rays: &[SingleRay]) -> Vec<SingleHit> {
        unobserved(self.intersect_single_observed(rays, &Silent))
    }

    /// [`Scene::intersect_single`] into memory that is there.
    ///
    /// # Panics
    /// If there are not as many hits as rays.
    pub fn intersect_single_into(&self, rays: &[SingleRay], hits: &mut [SingleHit]) {
        let target = self.target();
        unobserved(self.guarded(|| traverse::intersect_single_into(target, rays, hits, &Silent)));
    }

    /// [`Scene::intersect_single`], reporting [`Stage::Trace`](crate::progress::Stage::Trace) in
    /// rays.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn intersect_single_observed(
        &self,
        rays: &[SingleRay],
        observer: &dyn Observer,
    ) -> Result<Vec<SingleHit>> {
        self.guarded(|| traverse::intersect_single(self.target(), rays, observer))
    }

    /// For each ray whether it hits anything, in parallel; rays may be in either precision.
    pub fn occluded<R: BatchRay>(&self, rays: &[R]) -> Vec<bool> {
        unobserved(self.occluded_observed(rays, &Silent))
    }

    /// [`Scene::occluded`], reporting [`Stage::Trace`](crate::progress::Stage::Trace) in rays.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn occluded_observed<R: BatchRay>(
        &self,
        rays: &[R],
        observer: &dyn Observer,
    ) -> Result<Vec<bool>> {
        let mut flags = vec![false; rays.len()];
        self.guarded(|| R::occluded_into(self.target(), rays, &mut flags, observer))?;
        Ok(flags)
    }

    /// [`Scene::occluded`] into memory that is there.
    ///
    /// # Panics
    /// If there are not as many flags as rays.
    pub fn occluded_into<R: BatchRay>(&self, rays: &[R], flags: &mut [bool]) {
        unobserved(self.guarded(|| R::occluded_into(self.target(), rays, flags, &Silent)));
    }

    /// What it costs to find the closest hits of rays, or whether there are any: nodes and leaves that
    /// were fetched, and exact decisions. Counts do not depend on the machine's mood, but on the
    /// instruction set: what is decided exactly does. Rays may be in either precision.
    pub fn count_work<R: BatchRay>(&self, rays: &[R], is_any: bool) -> WorkCounts {
        R::count_work(self.target(), rays, is_any)
    }

    /// [`Scene::closest`] as batches find it, and every node and leaf that the ray comes to, in order: as
    /// many as [`Scene::count_work`] counts. [`Scene::explain`] makes more of it.
    pub fn watch(&self, ray: &Ray) -> (Hit, Vec<Visit>) {
        traverse::watch(self.target(), ray)
    }

    /// All hits of each ray, in parallel, sorted by t and then by face: as [`Scene::all`].
    pub fn intersect_all<R: BatchRay>(&self, rays: &[R]) -> AllHits {
        unobserved(self.intersect_all_observed(rays, &Silent))
    }

    /// [`Scene::intersect_all`], reporting [`Stage::Trace`](crate::progress::Stage::Trace) in rays.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn intersect_all_observed<R: BatchRay>(
        &self,
        rays: &[R],
        observer: &dyn Observer,
    ) -> Result<AllHits> {
        self.guarded(|| R::intersect_all(self.target(), rays, observer))
    }

    /// How many hits each ray has, in parallel: the lengths of the rows of [`Scene::intersect_all`].
    pub fn count_intersections<R: BatchRay>(&self, rays: &[R]) -> Vec<usize> {
        unobserved(self.count_intersections_observed(rays, &Silent))
    }

    /// [`Scene::count_intersections`], reporting [`Stage::Trace`](crate::progress::Stage::Trace) in
    /// rays.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn count_intersections_observed<R: BatchRay>(
        &self,
        rays: &[R],
        observer: &dyn Observer,
    ) -> Result<Vec<usize>> {
        self.guarded(|| R::count(self.target(), rays, observer))
    }

    /// [`Scene::intersect`] for rays and answers that are columns, reporting
    /// [`Stage::Trace`](crate::progress::Stage::Trace) in rays. Few rays, up to some thousand, are cast
    /// by the calling thread itself; so it is with all that takes columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    ///
    /// # Panics
    /// If there are not as many places in `hits` as rays.
    pub fn intersect_columns(
        &self,
        rays: &RayColumns,
        hits: HitColumns,
        observer: &dyn Observer,
    ) -> Result<()> {
        self.guarded(|| traverse::columns::intersect(self.target(), rays, hits, observer))
    }

    /// [`Scene::occluded`] for columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    ///
    /// # Panics
    /// If there are not as many flags as rays.
    pub fn occluded_columns(
        &self,
        rays: &RayColumns,
        flags: &mut [bool],
        observer: &dyn Observer,
    ) -> Result<()> {
        self.guarded(|| traverse::columns::occluded(self.target(), rays, flags, observer))
    }

    /// [`Scene::count_intersections`] for columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    ///
    /// # Panics
    /// If there are not as many counts as rays.
    pub fn count_intersections_columns(
        &self,
        rays: &RayColumns,
        counts: &mut [i64],
        observer: &dyn Observer,
    ) -> Result<()> {
        self.guarded(|| traverse::columns::count(self.target(), rays, counts, observer))
    }

    /// [`Scene::intersect_all`] for columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn intersect_all_columns(
        &self,
        rays: &RayColumns,
        observer: &dyn Observer,
    ) -> Result<AllHitColumns> {
        self.guarded(|| traverse::columns::intersect_all(self.target(), rays, observer))
    }

    /// The point of a hit, from which rays can start that do not hit the same face again:
    /// `scene.surface_point(&hit).origin_towards(direction)` is the start of a ray along
    /// `direction`.
    ///
    /// # Panics
    /// For a miss, and for a face that the mesh does not have: ask [`Hit::is_hit`] first.
    pub fn surface_point(&self, hit: &Hit) -> SurfacePoint {
        assert!(hit.is_hit(), "a miss has no point");
        SurfacePoint::on_triangle(self.mesh.corners(hit.face), hit.u, hit.v)
    }
}

/// The answer of work that nobody could interrupt, and that only a damaged file could end.
fn unobserved<T>(result: Result<T>) -> T {
    match result {
        Ok(answer) => answer,
        Err(error) => panic!("{error}"),
    }
}
