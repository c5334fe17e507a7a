//! `halfline doctor`: what keeps a mesh from being a solid, and whether rays slip through it.

mod report;

use std::path::PathBuf;

use clap::Args;
use halfline::progress::Stage;
use halfline::{Error, Mesh, Vec3};
use halfline_check::topology::{self, Facing, Found, Target, Topology};
use halfline_check::watertight::{self, Example, LeakReport};

use crate::failure::Failure;
use crate::report::{name, per_second};
use crate::session::Session;
use crate::source::Source;
use crate::tree_options::TreeOptions;
use crate::{session, units, values};

use self::report::{Defect, DoctorReport, ExampleReport, RayReport, SurfaceReport};

const EXAMPLES: &str = "\
The mesh: vertices at exactly the same place count as one, so that an STL file, or any soup of
triangles, is judged by its surface. A surface is closed if every edge has an even number of
triangles; watertight if besides that rays find no gap.

The rays: from points inside, the middle of the mesh if it is one of them, at every vertex and at
the middle of every edge. Each must hit, and cross the surface an odd number of times. An open
surface is aimed at from the middle and from outside; there a ray must hit if it meets its target
without any rounding.

Exit code 0 whatever is wrong with the mesh; 1 if a ray did what it must not do, which is an error
of halfline.

Examples:
  halfline doctor scan.ply
  halfline doctor scan.stl --rays 10M
  halfline doctor scan.ply --json | jq .open_edges";

/// The options of `halfline doctor`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// The mesh to look into, or - for standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,

    /// Rays to aim at most: of more vertices and edges an even sample is taken
    #[arg(long, value_name = "N", default_value = "1M", value_parser = values::count)]
    rays: usize,

    /// Another seed takes another sample, and other points inside
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    #[command(flatten)]
    tree: TreeOptions,
}

/// Loads the mesh, builds its tree unless it comes with one, looks at how the mesh hangs together,
/// aims rays, and tells.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    let source = Source::open(&options.mesh, &options.tree, &session)?;
    let scene = &source.scene;
    let mesh = scene.mesh();
    let (topology, examine_seconds) = session
        .timed(Stage::Examine, |observer| scene.guarded(|| topology::examine(mesh, observer)))?;
    let leak_options = watertight::Options { rays: options.rays, seed: options.seed };
    let (aimed, _) = session.timed(Stage::Trace, |observer| {
        scene.guarded(|| watertight::aim(scene, &topology, &leak_options, observer))
    })?;

    let findings = Findings { mesh, topology: &topology, leaks: &aimed };
    session.tell(&DoctorReport {
        mesh: name(&options.mesh),
        surface: findings.surface(),
        rays: findings.rays(),
        seed: options.seed,
        preset: source.preset,
        content_hash: source.content_hash(),
        verdict: findings.verdict(),
        load_seconds: source.load_seconds,
        examine_seconds,
        build_seconds: source.build_seconds,
        peak_memory_bytes: session::peak_memory_bytes(),
        source: &source,
        failed_rays: findings.failed_rays(),
    })?;
    if aimed.is_clean() {
        return Ok(());
    }
    let reason = format!("halfline failed on its own aimed rays: {}", findings.ray_failures());
    Err(Error::invalid(options.mesh.to_string_lossy(), reason).into())
}

/// All that was found.
struct Findings<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    leaks: &'a LeakReport,
}

impl Findings<'_> {
    fn surface(&self) -> SurfaceReport {
        let t = self.topology;
        SurfaceReport {
            triangles: t.triangles,
            vertices: t.vertices,
            duplicate_vertices: t.duplicate_vertices,
            unreferenced_vertices: t.unreferenced_vertices,
            edges: t.edges,
            open_edges: self.defect(&t.open_edges),
            non_manifold_edges: self.defect(&t.non_manifold_edges),
            inconsistent_edges: self.defect(&t.inconsistent_edges),
            degenerate_faces: self.defect(&t.degenerate_faces),
            non_finite_faces: self.defect(&t.non_finite_faces),
            duplicate_faces: self.defect(&t.duplicate_faces),
            components: t.components,
            euler_characteristic: t.euler_characteristic(),
            closed: t.is_closed(),
            consistent: t.is_consistent(),
            facing: t.facing().map(facing_name),
            volume: t.facing().map(|_| t.signed_volume),
        }
    }

    fn defect(&self, found: &Found) -> Defect {
        let mut first_faces: Vec<u32> =
            found.first_faces.iter().map(|&face| self.mesh.source_face(face)).collect();
        first_faces.sort_unstable();
        first_faces.dedup();
        Defect { count: found.count, first_faces }
    }

    fn rays(&self) -> RayReport {
        let r = self.leaks;
        let [closest_seconds, all_seconds] =
            [r.closest_time, r.crossings_time].map(|time| time.as_secs_f64());
        RayReport {
            origins: r.origins.iter().map(|origin| origin.to_array()).collect(),
            from_inside: r.from_inside,
            targets: r.targets,
            rays: r.rays,
            certain_rays: r.certain_rays,
            crossings: r.crossings,
            leaks: r.leaks,
            wrong_parities: r.wrong_parities,
            late_hits: r.late_hits,
            examples: r.examples.iter().map(|example| self.example(example)).collect(),
            closest_rays_per_second: per_second(r.rays, closest_seconds),
            all_rays_per_second: per_second(r.rays, all_seconds),
            closest_seconds,
            all_seconds,
        }
    }

    fn example(&self, example: &Example) -> ExampleReport {
        let Example { ray, target, wrong, closest_t, crossings } = example;
        let (o, d) = (ray.origin, ray.direction);
        ExampleReport {
            ray: [o.x, o.y, o.z, d.x, d.y, d.z],
            aimed_at: target_name(*target),
            triangle: target.face(),
            source_face: self.mesh.source_face(target.face()),
            leak: wrong.leak,
            wrong_parity: wrong.parity,
            late_hit: wrong.late,
            closest_t: closest_t.is_finite().then_some(*closest_t),
            crossings: *crossings,
        }
    }

    /// The first rays that failed, as rows for `numpy.array`.
    fn failed_rays(&self) -> String {
        let mut text = String::new();
        for e in &self.leaks.examples {
            let vector = |v: Vec3| format!("{:?}, {:?}, {:?}", v.x, v.y, v.z);
            let hit = match e.closest_t.is_finite() {
                true => format!("hits at t = {:?}", e.closest_t),
                false => "hits nothing".into(),
            };
            text += &format!(
                "  [{}, {}],  # at {} of triangle {}: {hit}, {} crossings\n",
                vector(e.ray.origin),
                vector(e.ray.direction),
                target_name(e.target),
                e.target.face(),
                units::count(e.crossings as u64),
            );
        }
        text
    }

    /// What the rays did that they must not do.
    fn ray_failures(&self) -> String {
        let r = self.leaks;
        let counts = [
            (r.leaks, "leaked"),
            (r.wrong_parities, "crossed an even number of times"),
            (r.late_hits, "hit what lies behind something"),
        ];
        let failures: Vec<String> = counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{} {what}", units::count(*count)))
            .collect();
        format!("of {} rays {}", units::count(r.rays), failures.join(", "))
    }

    /// The mesh, and what the rays said of it, in one line.
    fn verdict(&self) -> String {
        let t = self.topology;
        if t.triangles == 0 {
            return "empty: there are no triangles".into();
        }
        if t.surface_faces == 0 {
            return "no surface: no triangle has three finite corners in three places".into();
        }
        let count = |n: usize, one: &str, many: &str| {
            format!("{} {}", units::count(n as u64), if n == 1 { one } else { many })
        };
        let mut parts = Vec::new();
        if t.is_closed() {
            parts.push("closed".into());
            match t.facing() {
                Some(Facing::Outward) => parts.push("consistently oriented, outward".into()),
                Some(Facing::Inward) => parts.push("consistently oriented, inward".into()),
                Some(Facing::Neither) => parts.push("consistently oriented, no volume".into()),
                None => parts.push("inconsistently oriented".into()),
            }
        } else {
            let open = t.open_edges.count;
            let odd = t.odd_edges - open;
            let mut counts = Vec::new();
            if open > 0 {
                counts.push(count(open, "border edge", "border edges"));
            }
            if odd > 0 {
                counts.push(count(odd, "edge", "edges") + " of 3, 5 or more triangles");
            }
            parts.push(format!("open: {}", counts.join(", ")));
            if !t.is_consistent() {
                parts.push("inconsistently oriented".into());
            }
        }
        if t.is_closed() && t.non_manifold_edges.count > 0 {
            let n = t.non_manifold_edges.count;
            parts.push(count(n, "non-manifold edge", "non-manifold edges"));
        }
        let surface = parts.join(", ");
        if !self.leaks.is_clean() {
            return format!("{surface}; but halfline failed: {}", self.ray_failures());
        }
        match (t.is_closed(), self.leaks.from_inside) {
            (true, true) => format!("{surface}: watertight"),
            (true, false) => format!("{surface}: no point inside was found"),
            (false, _) => surface,
        }
    }
}

fn facing_name(facing: Facing) -> &'static str {
    match facing {
        Facing::Outward => "outward",
        Facing::Inward => "inward",
        Facing::Neither => "neither",
    }
}

fn target_name(target: Target) -> String {
    match target {
        Target::Vertex { corner, .. } => format!("corner {corner}"),
        Target::EdgeMidpoint { edge, .. } => format!("the middle of edge {edge}"),
    }
}
