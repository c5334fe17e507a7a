//! `halfline doctor`: what keeps a mesh from being a solid, and whether rays slip through it.

use std::path::PathBuf;

use clap::Args;
use halfline::progress::Stage;
use halfline::{Error, Mesh, Vec3};
use halfline_check::topology::{self, Facing, Found, Target, Topology};
use halfline_check::watertight::{self, Example, LeakReport};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::session::{Figures, Session};
use crate::source::Source;
use crate::table::Table;
use crate::tree_options::TreeOptions;
use crate::{input, session, units, values};

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
    let (report, _) = session.timed(Stage::Trace, |observer| {
        scene.guarded(|| watertight::aim(scene, &topology, &leak_options, observer))
    })?;

    let findings = Findings { mesh, topology: &topology, report: &report };
    let mut figures = Figures::new();
    let mut tell = |name: &str, value| figures.insert(name.into(), value);
    tell("mesh", json!(options.mesh.to_string_lossy()));
    findings.mesh_figures(&mut tell);
    findings.ray_figures(&mut tell);
    tell("seed", json!(options.seed));
    tell("preset", json!(source.preset));
    tell("content_hash", source.content_hash_figure());
    tell("verdict", json!(findings.verdict()));
    tell("load_seconds", json!(source.load_seconds));
    tell("examine_seconds", json!(examine_seconds));
    tell("build_seconds", json!(source.build_seconds));
    tell("peak_memory_bytes", json!(session::peak_memory_bytes()));

    let text = || {
        let mut table = Table::new(input::name(&options.mesh).display());
        findings.mesh_rows(&mut table);
        table.row("load", units::seconds(source.load_seconds), "");
        source.build_row(&mut table, "");
        table.row("examine", units::seconds(examine_seconds), "");
        findings.ray_rows(&mut table);
        table.print() + &findings.examples() + &findings.verdict() + "\n"
    };
    session.tell(figures, text, true)?;
    if report.is_clean() {
        return Ok(());
    }
    let reason = format!("halfline failed on its own aimed rays: {}", findings.ray_failures());
    Err(Error::invalid(options.mesh.to_string_lossy(), reason).into())
}

/// All that was found.
struct Findings<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    report: &'a LeakReport,
}

impl Findings<'_> {
    /// Defects, by what JSON and people call them.
    fn defects(&self) -> [(&'static str, &'static str, &Found, &'static str); 6] {
        let t = self.topology;
        [
            ("open_edges", "open edges", &t.open_edges, "of one triangle"),
            ("non_manifold_edges", "non-manifold", &t.non_manifold_edges, "edges of 3 or more"),
            (
                "inconsistent_edges",
                "inconsistent",
                &t.inconsistent_edges,
                "edges whose two triangles run the same way",
            ),
            ("degenerate_faces", "degenerate", &t.degenerate_faces, "triangles without area"),
            ("non_finite_faces", "non-finite", &t.non_finite_faces, "triangles with NaN, infinity"),
            (
                "duplicate_faces",
                "duplicate",
                &t.duplicate_faces,
                "triangles with the corners of one before them",
            ),
        ]
    }

    /// The faces of the file in which a defect was found first.
    fn first_faces(&self, found: &Found) -> Vec<u32> {
        let mut faces: Vec<u32> =
            found.first_faces.iter().map(|&face| self.mesh.source_face(face)).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    fn mesh_figures(&self, tell: &mut impl FnMut(&str, Value) -> Option<Value>) {
        let t = self.topology;
        tell("triangles", json!(t.triangles));
        tell("vertices", json!(t.vertices));
        tell("duplicate_vertices", json!(t.duplicate_vertices));
        tell("unreferenced_vertices", json!(t.unreferenced_vertices));
        tell("edges", json!(t.edges));
        for (name, _, found, _) in self.defects() {
            let first_faces = self.first_faces(found);
            tell(name, json!({ "count": found.count, "first_faces": first_faces }));
        }
        tell("components", json!(t.components));
        tell("euler_characteristic", json!(t.euler_characteristic()));
        tell("closed", json!(t.is_closed()));
        tell("consistent", json!(t.is_consistent()));
        tell("facing", json!(t.facing().map(facing_name)));
        tell("volume", json!(t.facing().map(|_| t.signed_volume)));
    }

    fn ray_figures(&self, tell: &mut impl FnMut(&str, Value) -> Option<Value>) {
        let r = self.report;
        let origins: Vec<[f64; 3]> = r.origins.iter().map(|o| o.to_array()).collect();
        tell("origins", json!(origins));
        tell("from_inside", json!(r.from_inside));
        tell("targets", json!(r.targets));
        tell("rays", json!(r.rays));
        tell("certain_rays", json!(r.certain_rays));
        tell("crossings", json!(r.crossings));
        tell("leaks", json!(r.leaks));
        tell("wrong_parities", json!(r.wrong_parities));
        tell("late_hits", json!(r.late_hits));
        let examples: Vec<Value> = r.examples.iter().map(|e| self.example_figures(e)).collect();
        tell("examples", json!(examples));
        tell("closest_rays_per_second", json!(self.rays_per_second(r.closest_time)));
        tell("all_rays_per_second", json!(self.rays_per_second(r.crossings_time)));
        tell("closest_seconds", json!(r.closest_time.as_secs_f64()));
        tell("all_seconds", json!(r.crossings_time.as_secs_f64()));
    }

    fn rays_per_second(&self, time: std::time::Duration) -> f64 {
        match time.is_zero() {
            true => 0.0,
            false => self.report.rays as f64 / time.as_secs_f64(),
        }
    }

    fn example_figures(&self, example: &Example) -> Value {
        let Example { ray, target, wrong, closest_t, crossings } = example;
        let row = [ray.origin.to_array(), ray.direction.to_array()].concat();
        json!({
            "ray": row,
            "aimed_at": target_name(*target),
            "triangle": target.face(),
            "source_face": self.mesh.source_face(target.face()),
            "leak": wrong.leak,
            "wrong_parity": wrong.parity,
            "late_hit": wrong.late,
            "closest_t": closest_t.is_finite().then_some(closest_t),
            "crossings": crossings,
        })
    }

    fn mesh_rows(&self, table: &mut Table) {
        let t = self.topology;
        let count = |value: usize| units::count(value as u64);
        table.row("triangles", count(t.triangles), "");
        let mut notes = Vec::new();
        if t.duplicate_vertices > 0 {
            notes.push(format!("{} where another lies", count(t.duplicate_vertices)));
        }
        if t.unreferenced_vertices > 0 {
            notes.push(format!("{} of no triangle", count(t.unreferenced_vertices)));
        }
        table.row("vertices", count(t.vertices), notes.join(", "));
        table.row("edges", count(t.edges), "");
        for (_, label, found, meaning) in self.defects() {
            let faces = self.first_faces(found);
            let named: Vec<String> = faces.iter().map(u32::to_string).collect();
            let note = match found.count {
                0 => meaning.into(),
                // One face may have several of the edges, so count what could not be shown.
                n if n > faces.len() => format!("{meaning}: faces {}, ...", named.join(", ")),
                1 => format!("{meaning}: face {}", named[0]),
                _ => format!("{meaning}: faces {}", named.join(", ")),
            };
            table.row(label, count(found.count), note);
        }
        let note = format!("Euler characteristic {}", t.euler_characteristic());
        table.row("components", count(t.components), note);
        if t.facing().is_some() {
            table.row("volume", units::number(t.signed_volume), "");
        }
    }

    fn ray_rows(&self, table: &mut Table) {
        let r = self.report;
        if r.rays == 0 {
            return;
        }
        let whence = match r.from_inside {
            true => "inside",
            false => "in the middle and around",
        };
        let note = format!(
            "from {} {} {whence}, at {} vertices and edges",
            r.origins.len(),
            if r.origins.len() == 1 { "point" } else { "points" },
            units::count(r.targets as u64)
        );
        table.row("rays", units::count(r.rays), note);
        let note = "meet their target without any rounding";
        table.row("  certain", units::count(r.certain_rays), note);
        table.row("  leaks", units::count(r.leaks), "hit nothing, but must");
        if r.from_inside {
            let note = "cross the surface an even number of times, but it must be odd";
            table.row("  wrong parity", units::count(r.wrong_parities), note);
        }
        let note = "hit first what lies behind something";
        table.row("  late", units::count(r.late_hits), note);
        for (label, time) in [("closest hits", r.closest_time), ("all hits", r.crossings_time)] {
            let speed = format!("{}rays/s", units::metric(self.rays_per_second(time)));
            table.row(label, units::seconds(time.as_secs_f64()), speed);
        }
    }

    /// The first rays that failed, as rows for `numpy.array`.
    fn examples(&self) -> String {
        let mut text = String::new();
        for e in &self.report.examples {
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
        let r = self.report;
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
        if !self.report.is_clean() {
            return format!("{surface}; but halfline failed: {}", self.ray_failures());
        }
        match (t.is_closed(), self.report.from_inside) {
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
