//! `halfline query`: the rays of a NumPy file in, what they hit out; or points in, and what is nearest.

mod nearest;

use std::borrow::Cow;
use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use halfline::AllHits;
use halfline::explain::Rule;
use halfline::geometry::{Hit, Ray};
use halfline::mesh::Mesh;
use halfline::progress::{Observer, Part, Stage};
use halfline::textbook::{KdTree, Termination};
use serde::Serialize;

use crate::engine::{BruteForce, Engine};
use crate::failure::Failure;
use crate::npy::RayFile;
use crate::npz::Archive;
use crate::output::Interruptible;
use crate::report::{Report, Skipped};
use crate::session::Session;
use crate::source::{MeshSource, Source};
use crate::table::Table;
use crate::tree_options::TreeOptions;
use crate::{input, output, report, session, units};

const EXAMPLES: &str = "\
RAYS.npy holds float32 or float64 of shape (n, 6) = ox oy oz dx dy dz, or (n, 8) with t_min t_max
appended. Directions need not be unit length: t counts in units of the direction. A ray that is
not finite, has no direction or has t_min > t_max hits nothing, and is counted.

HITS.npz then holds, for numpy.load:
  t            (n,)    float64  inf for a miss
  face         (n,)    int64    the triangle, -1 for a miss
  source_face  (n,)    int64    the face of the file that the triangle was cut from
  uv           (n, 2)  float64  barycentric weights of the triangle's second and third vertex
with --any instead
  occluded     (n,)    bool
and with --all, of m hits in all, `splits` (n + 1,) int64 as well: the hits of ray i are
splits[i]:splits[i + 1] of the others, ordered by t.

With --nearest the file holds points of shape (n, 3) instead, and NEAR.npz what is nearest to each:
  distance     (n,)    float64  inf for a point that is not finite
  point        (n, 3)  float64  the nearest point of the surface
  face         (n,)    int64    the triangle that has it, of several the first; -1 for none
  source_face  (n,)    int64    the face of the file that the triangle was cut from
  uv           (n, 2)  float64  barycentric weights of the triangle's second and third vertex
  feature      (n,)    str      where on the triangle it is: face, edge or vertex
and with --signed also
  signed_distance (n,) float64  negative inside, where the winding number is above a half
  winding_number  (n,) float64  how often the surface goes round the point

Examples:
  halfline query scan.ply rays.npy -o hits.npz
  halfline query scan.ply sun.npy -o shade.npz --any
  halfline query scan.ply rays.npy -o judge.npz --engine brute
  halfline query scan.ply points.npy -o near.npz --nearest --signed";

/// The options of `halfline query`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// The mesh to cast rays at, or - for standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,

    /// The rays, or with --nearest the points, or - for standard input
    #[arg(value_name = "RAYS.npy")]
    rays: PathBuf,

    /// Where the hits go
    #[arg(short, long, value_name = "HITS.npz")]
    #[arg(value_parser = output::path_with_extension(&["npz"]))]
    output: PathBuf,

    /// Who answers; the answers are the same
    #[arg(long, value_enum, default_value_t = EngineName::Fast)]
    engine: EngineName,

    /// Only tell whether each ray hits anything
    #[arg(long, conflicts_with = "all")]
    any: bool,

    /// All hits along each ray, not only the first
    #[arg(long)]
    all: bool,

    /// Find what is nearest to each of the points of the file, which then holds no rays
    #[arg(long, conflicts_with_all = ["any", "all", "engine"])]
    nearest: bool,

    /// Tell on which side of the surface points are
    #[arg(long, requires = "nearest")]
    signed: bool,

    #[command(flatten)]
    tree: TreeOptions,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum EngineName {
    /// A spatial-split BVH of eight children a node
    Fast,
    /// The lecture's kd-tree
    Textbook,
    /// No tree: every ray against every triangle
    Brute,
}

/// What the question for all hits is called.
const ALL: &str = "all";

/// The answers so far, in the order of the rays.
enum Answers {
    Closest(Vec<Hit>),
    Any(Vec<bool>),
    All(AllHits),
}

/// Rays read and cast at a time: enough to keep all threads busy, little enough not to count
/// beside the answers.
const BATCH: usize = 1 << 18;

/// Casts the rays.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    output::check(&options.output, &[&options.mesh, &options.rays])?;
    if input::is_stdin(&options.mesh) && input::is_stdin(&options.rays) {
        let reason = "only one of MESH and RAYS.npy can be -, standard input";
        return Err(Failure::Usage(reason.into()));
    }
    if options.nearest {
        return nearest::run(options, session);
    }
    // A wrong ray file should show before a large mesh is loaded.
    let rays = RayFile::open(&options.rays)?;
    if matches!(options.engine, EngineName::Fast) {
        let source = Source::open(&options.mesh, &options.tree, &session)?;
        let (scene, load_seconds) = (&source.scene, source.load_seconds);
        let run = Run { options, session, rays, load_seconds };
        let skipped = Some(Skipped::of(scene));
        return scene
            .guarded(|| Ok(run.answer(scene, scene.mesh(), skipped, source.build_seconds)))?;
    }
    // The judges take the mesh alone, wherever it comes from.
    let (source, load_seconds) = MeshSource::open(&options.mesh, &options.tree, &session)?;
    let run = Run { options, session, rays, load_seconds };
    let mesh = source.mesh();
    source.guarded(|| {
        if matches!(options.engine, EngineName::Brute) {
            return run.answer(&BruteForce(mesh), mesh, None, 0.0);
        }
        let (tree, build_seconds) = run.session.timed(Stage::Build, |_| {
            let rule = Rule::SurfaceArea.splitting_rule();
            let termination = Termination::automatic(mesh.triangle_count());
            Ok(KdTree::init_kd_tree(mesh, rule, &termination))
        })?;
        run.answer(&tree, mesh, None, build_seconds)
    })
}

/// What is known before the first ray is cast.
struct Run<'a> {
    options: &'a Options,
    session: Session,
    rays: RayFile,
    load_seconds: f64,
}

impl Run<'_> {
    /// Casts all rays, writes the answers and tells the figures. `skipped` are the triangles that no
    /// ray can hit, for engines that look for them beforehand.
    fn answer(
        mut self,
        engine: &dyn Engine,
        mesh: &Mesh,
        skipped: Option<Skipped>,
        build_seconds: f64,
    ) -> Result<(), Failure> {
        let mut answers = match (self.options.any, self.options.all) {
            (true, _) => Answers::Any(Vec::new()),
            (_, true) => Answers::All(AllHits::default()),
            _ => Answers::Closest(Vec::new()),
        };
        let (mut batch, mut invalid_rays, mut trace_seconds) = (Vec::new(), 0, 0.0);
        let (mut first, ray_count) = (0, self.rays.row_count());
        self.session.begin(Stage::Trace);
        loop {
            self.session.observer().check()?;
            self.rays.read(BATCH, &mut batch)?;
            if batch.is_empty() {
                break;
            }
            invalid_rays += batch.iter().filter(|ray| !ray.is_valid()).count() as u64;
            let (observer, share) = (self.session.observer(), batch.len() as u64);
            let observer = Part { observer, before: first, share, total: ray_count };
            let start = Instant::now();
            answers.extend(engine, &batch, &observer)?;
            trace_seconds += start.elapsed().as_secs_f64();
            first += batch.len() as u64;
        }
        let ((), write_seconds) = self.session.timed(Stage::Write, |observer| {
            output::write(&self.options.output, observer, |file| {
                answers.write(mesh, file, observer)
            })
        })?;

        self.session.tell(&QueryReport {
            mesh: report::name(&self.options.mesh),
            output: report::name(&self.options.output),
            engine: self.options.engine.name(),
            question: answers.question(),
            triangles: mesh.triangle_count() as u64,
            skipped,
            rays: ray_count,
            invalid_rays,
            hit_rays: answers.hit_rays(),
            hits: answers.hits(),
            rays_per_second: report::per_second(ray_count, trace_seconds),
            load_seconds: self.load_seconds,
            build_seconds,
            trace_seconds,
            write_seconds,
            peak_memory_bytes: session::peak_memory_bytes(),
        })
    }
}

/// What rays were asked about, and what it cost to answer.
#[derive(Serialize)]
struct QueryReport<'a> {
    mesh: Cow<'a, str>,
    output: Cow<'a, str>,
    engine: &'a str,
    question: &'a str,
    triangles: u64,
    skipped: Option<Skipped>,
    rays: u64,
    invalid_rays: u64,
    hit_rays: u64,
    hits: u64,
    rays_per_second: f64,
    load_seconds: f64,
    build_seconds: f64,
    trace_seconds: f64,
    write_seconds: f64,
    peak_memory_bytes: Option<u64>,
}

impl Report for QueryReport<'_> {
    const IS_THE_RESULT: bool = false;

    fn to_text(&self) -> String {
        let mut table = Table::new(&self.output);
        let note = format!("{} triangles", units::count(self.triangles));
        table.row("load", units::seconds(self.load_seconds), note);
        if let Some(skipped) = self.skipped {
            table.skipped(skipped);
        }
        table.row("build", units::seconds(self.build_seconds), "");
        let speed = units::metric(self.rays_per_second);
        let note = format!("{} rays, {speed}rays/s", units::count(self.rays));
        table.row("trace", units::seconds(self.trace_seconds), note);
        let (hits, hit_rays) = (units::count(self.hits), units::count(self.hit_rays));
        let note = match self.question {
            ALL => format!("{hits} hits on {hit_rays} rays"),
            _ => format!("{hit_rays} rays hit"),
        };
        table.row("write", units::seconds(self.write_seconds), note);
        if self.invalid_rays > 0 {
            let invalid = units::count(self.invalid_rays);
            table.row("invalid", invalid, "rays that hit nothing by definition");
        }
        table.print()
    }
}

impl EngineName {
    fn name(self) -> &'static str {
        match self {
            EngineName::Fast => "fast",
            EngineName::Textbook => "textbook",
            EngineName::Brute => "brute",
        }
    }
}

impl Answers {
    fn question(&self) -> &'static str {
        match self {
            Answers::Closest(_) => "closest",
            Answers::Any(_) => "any",
            Answers::All(_) => ALL,
        }
    }

    /// Hits found; for the other questions, rays that hit.
    fn hits(&self) -> u64 {
        match self {
            Answers::All(all) => all.hits.len() as u64,
            _ => self.hit_rays(),
        }
    }

    /// Rays that hit anything.
    fn hit_rays(&self) -> u64 {
        let count = match self {
            Answers::Closest(hits) => hits.iter().filter(|hit| hit.is_hit()).count(),
            Answers::Any(occluded) => occluded.iter().filter(|&&occluded| occluded).count(),
            Answers::All(all) => all.iter().filter(|hits| !hits.is_empty()).count(),
        };
        count as u64
    }

    /// Asks `engine` about `rays` and appends what it says.
    fn extend(
        &mut self,
        engine: &dyn Engine,
        rays: &[Ray],
        observer: &dyn Observer,
    ) -> halfline::error::Result<()> {
        match self {
            Answers::Closest(hits) => hits.append(&mut engine.closest(rays, observer)?),
            Answers::Any(occluded) => occluded.append(&mut engine.any(rays, observer)?),
            Answers::All(all) => {
                let mut part = engine.all(rays, observer)?;
                let before = all.hits.len();
                all.splits.extend(part.splits[1..].iter().map(|split| before + split));
                all.hits.append(&mut part.hits);
            }
        }
        Ok(())
    }

    fn write(
        &self,
        mesh: &Mesh,
        file: &mut Interruptible,
        observer: &dyn Observer,
    ) -> std::io::Result<()> {
        const HIT_BYTES: u64 = 8 + 8 + 8 + 16;
        match self {
            Answers::Closest(hits) => {
                let mut archive = Archive::new(file, hits.len() as u64 * HIT_BYTES, observer);
                write_hits(&mut archive, hits, mesh)?;
                archive.finish()
            }
            Answers::Any(occluded) => {
                let mut archive = Archive::new(file, occluded.len() as u64, observer);
                archive.add("occluded", occluded.iter().map(|&occluded| [occluded]))?;
                archive.finish()
            }
            Answers::All(AllHits { splits, hits, .. }) => {
                let bytes = splits.len() as u64 * 8 + hits.len() as u64 * HIT_BYTES;
                let mut archive = Archive::new(file, bytes, observer);
                archive.add("splits", splits.iter().map(|&split| [split as i64]))?;
                write_hits(&mut archive, hits, mesh)?;
                archive.finish()
            }
        }
    }
}

fn write_hits(
    archive: &mut Archive<&mut Interruptible>,
    hits: &[Hit],
    mesh: &Mesh,
) -> std::io::Result<()> {
    let index = |hit: &Hit, face: fn(&Mesh, u32) -> u32| match hit.is_hit() {
        true => i64::from(face(mesh, hit.face)),
        false => -1,
    };
    archive.add("t", hits.iter().map(|hit| [hit.t]))?;
    archive.add("face", hits.iter().map(|hit| [index(hit, |_, face| face)]))?;
    archive.add("source_face", hits.iter().map(|hit| [index(hit, Mesh::source_face)]))?;
    archive.add("uv", hits.iter().map(|hit| [hit.u, hit.v]))
}
