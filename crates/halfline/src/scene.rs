//! What users hold: a mesh with its tree, and the questions one can ask it.

mod closest_points;
mod inside;
mod signed_distances;

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Once, OnceLock};
use std::time::{Duration, Instant};

use crate::batch;
pub use crate::batch::{AllHitColumns, AllHits, AllHitsIter, BatchRay};
use crate::builder::{self, BuildParameters, Preset};
use crate::error::Result;
use crate::geometry::{Hit, HitF32, Ray, RayF32};
use crate::mesh::Mesh;
pub use crate::nearest::ClosestPointColumns;
use crate::numeric::SurfacePoint;
use crate::progress::{NoProgress, Observer};
pub use crate::rays::{Column, RayColumns, Scalars, Vectors};
use crate::simd::Level;
use crate::traverse::Target;
pub use crate::traverse::{Caster, HitColumns};
use crate::tree::file as tree_file;
use crate::tree::{Tree, TreeFile, TreeStatistics, Verify};
pub use inside::{Boundary, Inside, WindingParts};

/// A mesh and the tree over it, ready for rays.
///
/// Batches of rays are asked about by [`intersect`](Scene::intersect), [`occluded`](Scene::occluded),
/// [`intersect_all`](Scene::intersect_all) and [`count_intersections`](Scene::count_intersections); one ray at a
/// time by the methods of the same names of a [`Caster`]; and with progress, or into memory that is there, by
/// those of [`Scene::observed`]. All may be asked from many threads at once. What counts as a hit is defined in
/// [`numeric`](crate::numeric); a ray that is not [valid](Ray::is_valid) hits nothing.
///
/// A scene may be [saved](Scene::save) to a file and [opened](Scene::open) from it. The file is mapped,
/// and somebody may damage it or cut it short meanwhile. Then questions are answered wrongly, or end in an
/// [`Error::Format`](crate::Error::Format) that names the file; those that return no `Result` panic.
pub struct Scene {
    mesh: Arc<Mesh>,
    tree: Tree,
    /// The tree over the faces without area, once it was asked for.
    without_area: OnceLock<Tree>,
    parameters: BuildParameters,
    build_time: Duration,
    level: Level,
    file: Option<TreeFile>,
    boundary: OnceLock<Boundary>,
}

/// How many calls of [`Scene::guarded`] are under way for scenes from files.
static GUARDED: AtomicUsize = AtomicUsize::new(0);

/// A call of [`Scene::guarded`] that is under way, for a scene from a file.
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

/// Has the process's panic hook say nothing while [`is_guarded`] is true, from now on: the error
/// that comes of such a panic says enough. Other panics go to the hook that was there before.
pub fn quiet_guarded_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !is_guarded() {
                hook(panic);
            }
        }));
    });
}

impl Scene {
    /// Builds the tree over a mesh with the preset [`Preset::Balanced`]. A mesh that others hold too is not copied.
    ///
    /// # Errors
    /// As [`SceneBuilder::build`].
    pub fn new(mesh: impl Into<Arc<Mesh>>) -> Result<Scene> {
        Scene::builder(mesh).build()
    }

    /// Begins to build the tree over a mesh, with options. A mesh that others hold too is not copied.
    pub fn builder(mesh: impl Into<Arc<Mesh>>) -> SceneBuilder<'static> {
        let parameters = BuildParameters::default();
        SceneBuilder { mesh: mesh.into(), parameters, observer: &NoProgress }
    }

    /// Opens a scene that was [saved](Scene::save): maps the file, in the same time whatever its size,
    /// unless it is to be verified. Reports [`Stage::Load`](crate::progress::Stage::Load) in bytes then.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) if the file cannot be mapped;
    /// [`Error::Format`](crate::Error::Format) if it is not a tree, or one of another version, cut short
    /// or damaged; [`Error::Interrupted`](crate::Error::Interrupted); and
    /// [`Error::Invalid`](crate::Error::Invalid) as [`SceneBuilder::build`] for the instruction set.
    pub fn open(path: impl AsRef<Path>, verify: Verify, observer: &dyn Observer) -> Result<Scene> {
        let level = Level::chosen()?;
        let tree_file::Opened { mesh, tree, parameters, build_time, file } =
            tree_file::open(path.as_ref(), verify, observer)?;
        Ok(Scene {
            mesh: Arc::new(mesh),
            tree,
            parameters,
            build_time,
            level,
            file: Some(file),
            without_area: OnceLock::new(),
            boundary: OnceLock::new(),
        })
    }

    /// Writes mesh and tree to a file, from which [`Scene::open`] has them back at once. The file appears
    /// whole or not at all, and is durable then. By convention its name ends in `.hlt`. Reports
    /// [`Stage::Write`](crate::progress::Stage::Write).
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io), [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn save(&self, path: impl AsRef<Path>, observer: &dyn Observer) -> Result<()> {
        let path = path.as_ref();
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

    /// The mesh that the scene answers for.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The tree over the mesh.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// The tree's figures; counts through the whole tree.
    pub fn statistics(&self) -> TreeStatistics {
        self.tree.statistics(self.mesh.triangle_count())
    }

    /// How the tree was built.
    pub fn build_parameters(&self) -> &BuildParameters {
        &self.parameters
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

    fn target(&self) -> Target<'_> {
        Target { tree: &self.tree, mesh: &self.mesh, level: self.level, tuner: None }
    }

    /// For rays that come one after another, each depending on the last: one for each thread. A
    /// [batch](Scene::intersect) is the better way for rays that are known together.
    pub fn caster(&self) -> Caster<'_> {
        Caster::new(self.target())
    }

    /// The questions that a scene answers, with progress reported to `observer`, who may end the work; and those for
    /// rays and answers in columns.
    pub fn observed<'a>(&'a self, observer: &'a dyn Observer) -> Observed<'a> {
        Observed { scene: self, observer }
    }

    /// The closest hit of each ray, in parallel and in the rays' order: that with the smallest t, of equal ones
    /// that with the lowest face index; [`Hit::MISS`] for a ray that hits nothing. Rays may be in either
    /// precision.
    pub fn intersect<R: BatchRay>(&self, rays: &[R]) -> Vec<Hit> {
        unobserved(self.observed(&NoProgress).intersect(rays))
    }

    /// The closest hit of each ray in single precision: its face is that of [`Scene::intersect`], and
    /// its t that t rounded. The quickest way, where barycentrics are not needed.
    pub fn intersect_f32(&self, rays: &[RayF32]) -> Vec<HitF32> {
        unobserved(self.observed(&NoProgress).intersect_f32(rays))
    }

    /// For each ray whether it hits anything, in parallel. Rays may be in either precision.
    pub fn occluded<R: BatchRay>(&self, rays: &[R]) -> Vec<bool> {
        unobserved(self.observed(&NoProgress).occluded(rays))
    }

    /// All hits of each ray, in parallel, sorted by t and then by face: every crossing, and every contact with
    /// the border of an open surface; see [`numeric`](crate::numeric). Rays may be in either precision.
    pub fn intersect_all<R: BatchRay>(&self, rays: &[R]) -> AllHits {
        unobserved(self.observed(&NoProgress).intersect_all(rays))
    }

    /// How many hits each ray has, in parallel: the lengths of the rows of [`Scene::intersect_all`].
    pub fn count_intersections<R: BatchRay>(&self, rays: &[R]) -> Vec<usize> {
        unobserved(self.observed(&NoProgress).count_intersections(rays))
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

/// In figures, and not triangle by triangle.
impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scene")
            .field("triangles", &self.mesh.triangle_count())
            .field("vertices", &self.mesh.positions().len())
            .field("parameters", &self.parameters)
            .field("level", &self.level)
            .field("file", &self.file.as_ref().map(TreeFile::path))
            .finish_non_exhaustive()
    }
}

/// How a tree is to be built: [`Scene::builder`] gives one.
#[must_use]
pub struct SceneBuilder<'a> {
    mesh: Arc<Mesh>,
    parameters: BuildParameters,
    observer: &'a dyn Observer,
}

impl<'a> SceneBuilder<'a> {
    /// Takes the parameters of a preset.
    pub fn preset(self, preset: Preset) -> Self {
        self.parameters(BuildParameters::preset(preset))
    }

    /// Takes these parameters.
    pub fn parameters(self, parameters: BuildParameters) -> Self {
        SceneBuilder { parameters, ..self }
    }

    /// Reports [`Stage::Build`](crate::progress::Stage::Build) to an observer, who may end the work.
    pub fn observer<'b>(self, observer: &'b dyn Observer) -> SceneBuilder<'b> {
        let SceneBuilder { mesh, parameters, .. } = self;
        SceneBuilder { mesh, parameters, observer }
    }

    /// Builds the tree, on all threads. It does not depend on how many there are.
    ///
    /// # Errors
    /// [`Error::Invalid`](crate::Error::Invalid) for a mesh of more than 2^29 triangles, for parameters out of
    /// range, and for an instruction set that the environment variable `HALFLINE_SIMD` names and this machine
    /// lacks; [`Error::Interrupted`](crate::Error::Interrupted) if the observer ends the work.
    pub fn build(self) -> Result<Scene> {
        let SceneBuilder { mesh, parameters, observer } = self;
        let start = Instant::now();
        let level = Level::chosen()?;
        let tree = builder::build(&mesh, &parameters, level, observer)?;
        let build_time = start.elapsed();
        Ok(Scene {
            mesh,
            tree,
            parameters,
            build_time,
            level,
            file: None,
            without_area: OnceLock::new(),
            boundary: OnceLock::new(),
        })
    }
}

/// Questions whose progress is reported, as [`Stage::Trace`](crate::progress::Stage::Trace) in rays:
/// [`Scene::observed`] gives one.
///
/// All of them return [`Error::Interrupted`](crate::Error::Interrupted) if the observer ends the work, and
/// [`Error::Format`](crate::Error::Format) if the scene comes from a file that was damaged meanwhile. Those that
/// put answers into memory that is there panic if there are not as many places as rays.
#[derive(Clone, Copy)]
pub struct Observed<'a> {
    scene: &'a Scene,
    observer: &'a dyn Observer,
}

impl Observed<'_> {
    /// Answers as [`Scene::intersect`] does.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn intersect<R: BatchRay>(&self, rays: &[R]) -> Result<Vec<Hit>> {
        let mut hits = vec![Hit::MISS; rays.len()];
        self.intersect_into(rays, &mut hits)?;
        Ok(hits)
    }

    /// Answers as [`Scene::intersect`] does, into memory that is there.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn intersect_into<R: BatchRay>(&self, rays: &[R], hits: &mut [Hit]) -> Result<()> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| batch::intersect(scene.target(), R::source(rays), hits, observer))
    }

    /// Answers as [`Scene::intersect_f32`] does.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn intersect_f32(&self, rays: &[RayF32]) -> Result<Vec<HitF32>> {
        let mut hits = vec![HitF32::MISS; rays.len()];
        self.intersect_f32_into(rays, &mut hits)?;
        Ok(hits)
    }

    /// Answers as [`Scene::intersect_f32`] does, into memory that is there.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn intersect_f32_into(&self, rays: &[RayF32], hits: &mut [HitF32]) -> Result<()> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| batch::intersect_f32(scene.target(), RayF32::source(rays), hits, observer))
    }

    /// Answers as [`Scene::occluded`] does.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn occluded<R: BatchRay>(&self, rays: &[R]) -> Result<Vec<bool>> {
        let mut flags = vec![false; rays.len()];
        self.occluded_into(rays, &mut flags)?;
        Ok(flags)
    }

    /// Answers as [`Scene::occluded`] does, into memory that is there.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn occluded_into<R: BatchRay>(&self, rays: &[R], flags: &mut [bool]) -> Result<()> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| batch::occluded(scene.target(), R::source(rays), flags, observer))
    }

    /// Answers as [`Scene::intersect_all`] does.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn intersect_all<R: BatchRay>(&self, rays: &[R]) -> Result<AllHits> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| batch::find_all_hits(scene.target(), R::source(rays), observer))
    }

    /// Answers as [`Scene::count_intersections`] does.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn count_intersections<R: BatchRay>(&self, rays: &[R]) -> Result<Vec<usize>> {
        let Observed { scene, observer } = *self;
        let mut counts = vec![0; rays.len()];
        scene.guarded(|| {
            batch::count_hits(scene.target(), R::source(rays), &mut counts, observer)
        })?;
        Ok(counts)
    }

    /// Answers as [`Scene::intersect`] does, for rays and answers in columns. Few rays, up to some thousand,
    /// are cast by the calling thread itself; so it is with all that takes columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn intersect_columns(&self, rays: &RayColumns, hits: HitColumns) -> Result<()> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| batch::intersect_columns(scene.target(), (*rays).into(), hits, observer))
    }

    /// Answers as [`Scene::occluded`] does, for rays in columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn occluded_columns(&self, rays: &RayColumns, flags: &mut [bool]) -> Result<()> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| batch::occluded(scene.target(), (*rays).into(), flags, observer))
    }

    /// Answers as [`Scene::count_intersections`] does, for rays in columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn count_intersections_columns(&self, rays: &RayColumns, counts: &mut [i64]) -> Result<()> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| batch::count_hits(scene.target(), (*rays).into(), counts, observer))
    }

    /// Answers as [`Scene::intersect_all`] does, for rays and answers in columns.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) and [`Error::Format`](crate::Error::Format), as
    /// [`Observed`] tells.
    pub fn intersect_all_columns(&self, rays: &RayColumns) -> Result<AllHitColumns> {
        let Observed { scene, observer } = *self;
        scene.guarded(|| batch::find_all_hits_columns(scene.target(), (*rays).into(), observer))
    }
}

/// Looks inside, for explanations, measurements and tests.
pub mod inspect {
    use super::{BatchRay, Hit, Observer, Ray, Result, Scene};
    pub use crate::batch::WorkCounts;
    use crate::geometry::{ClosestPoint, Vec3};
    pub use crate::nearest::PointVisit;
    pub use crate::traverse::{LeafVerdict, RayCounters, Visit};
    use crate::tree::LeafBlock;
    use crate::{batch, traverse};

    /// What single precision knows about a ray and a leaf of the tree, as batches ask it; what it leaves
    /// open they decide more closely. `None` if the ray does not meet the box of all that can be hit.
    pub fn leaf_verdict(scene: &Scene, ray: &Ray, block: &LeafBlock) -> Option<LeafVerdict> {
        traverse::leaf_verdict(scene.target(), ray, block)
    }

    /// The closest hit of a ray as batches find it, and every node and leaf that the ray comes to, in order: as
    /// many as [`count_work`] counts.
    pub fn record_visits(scene: &Scene, ray: &Ray) -> (Hit, Vec<Visit>) {
        traverse::record_visits(scene.target(), ray)
    }

    /// The closest point as batches find it, and every node and leaf that its walk comes to, in order. What has no
    /// area is in neither.
    pub fn record_point_visits(
        scene: &Scene,
        point: Vec3,
        observer: &dyn Observer,
    ) -> Result<(ClosestPoint, Vec<PointVisit>)> {
        let surface = scene.surface()?;
        batch::record_point_visits(surface, point, observer)
    }

    /// What it costs to find the closest hits of rays, or whether there are any: nodes and leaves that
    /// were fetched, and exact decisions. Counts do not depend on how busy the machine is, but on the
    /// instruction set: what is decided exactly does. Rays may be in either precision.
    pub fn count_work<R: BatchRay>(scene: &Scene, rays: &[R], is_any: bool) -> WorkCounts {
        batch::count_work(scene.target(), R::source(rays), is_any)
    }

    /// [`Scene::intersect_f32`](super::Scene::intersect_f32) where rounded signs and depths are taken as they
    /// come, as most ray tracers do: rays leak. To measure what exactness costs.
    #[cfg(feature = "variants")]
    pub fn intersect_plain<R: BatchRay>(scene: &Scene, rays: &[R], hits: &mut [super::HitF32]) {
        batch::intersect_plain(scene.target(), R::source(rays), hits);
    }

    /// [`Scene::occluded`](super::Scene::occluded) where rounded signs are taken as they come: rays leak. To
    /// measure what exactness costs.
    #[cfg(feature = "variants")]
    pub fn occluded_plain<R: BatchRay>(scene: &Scene, rays: &[R], flags: &mut [bool]) {
        batch::occluded_plain(scene.target(), R::source(rays), flags);
    }
}

/// The answer of work that nobody could interrupt, and that only a damaged file could end.
fn unobserved<T>(result: Result<T>) -> T {
    match result {
        Ok(answer) => answer,
        Err(error) => panic!("{error}"),
    }
}
