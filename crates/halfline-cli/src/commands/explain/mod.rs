//! `halfline explain`: why a ray hits what it hits, or nothing; or why a point is as far from the surface as it is.

mod point;

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use halfline::explain::{Cells, Explanation, Rule, Slice, SlicePlane, Step, Walk, check};
use halfline::geometry::{Ray, Vec3, vec3};
use halfline::progress::Stage;
use halfline::textbook::Termination;
use halfline::{Aabb, Error, Mesh, Scene};
use halfline_explain::{SLICE_SIZE, SliceOptions, draw_slice};
use halfline_render::{Plan, RenderSettings, text};
use serde::Serialize;

use crate::camera_options::CameraOptions;
use crate::failure::Failure;
use crate::report::{self, Report};
use crate::session::Session;
use crate::source::Source;
use crate::table::Table;
use crate::tree_options::TreeOptions;
use crate::{input, output, units, values};

const EXAMPLES: &str = "\
A ray's walk through the lecture's kd-tree, step by step: each cell and which case of the traversal
it is, each triangle and why it is hit or missed, and what the engine did for the same answer. For a
ray that hits nothing, which triangle it passes closest, and by how much. See docs/explain.md.
With --point, the engine's walk to what is nearest, and the parts of the point's winding number.

Examples:
  halfline explain scan.ply --ray 0,0,5,0,0,-1           as text
  halfline explain scan.ply --pixel 640,360 --up +Z      the ray of a pixel that render draws
  halfline explain scan.ply --pixel 640,360 -o walk.html a page to step through
  halfline explain scan.ply --pixel 640,360 --json | jq .nearest_miss
  halfline explain scan.ply --plane xz > cells.svg       the tree's cells, cut by a plane
  halfline explain scan.ply --point 0,0.1,0.2            what is nearest to a point, and on which side it is";

/// The options of `halfline explain`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// The mesh that the ray is cast at, or - for standard input
    #[arg(value_name = "MESH")]
    mesh: PathBuf,

    /// The ray: origin, direction of any length, and if wanted the smallest and largest t
    #[arg(long, value_name = "OX,OY,OZ,DX,DY,DZ[,T0,T1]", allow_hyphen_values = true)]
    #[arg(value_parser = values::ray, conflicts_with = "pixel")]
    #[arg(required_unless_present_any = ["pixel", "plane", "point"])]
    ray: Option<Ray>,

    /// The ray through the middle of a pixel of the camera below, from 0,0 at the top left
    #[arg(long, value_name = "COLUMN,ROW", value_parser = values::pixel)]
    pixel: Option<(u32, u32)>,

    /// A point instead of a ray: what is nearest to it, and on which side of the surface it is
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = text::vector)]
    #[arg(conflicts_with_all = ["ray", "pixel", "plane", "rule"])]
    point: Option<Vec3>,

    /// Draw the tree's cells where a plane cuts them, as SVG, and the ray, if any
    #[arg(long, value_enum, value_name = "AXES")]
    plane: Option<PlaneName>,

    /// Where the plane lies along the third axis [default: through the ray or the middle]
    #[arg(long, value_name = "C", allow_hyphen_values = true, value_parser = text::finite)]
    #[arg(requires = "plane")]
    at: Option<f64>,

    /// Where the lecture's tree splits cells
    #[arg(long, value_name = "NAME", default_value_t)]
    #[arg(value_parser = values::named(Rule::ALL, |rule| (rule.name(), rule.description())))]
    rule: Rule,

    /// Where the explanation goes: .html, .json or .txt; with --plane .svg [default: printed]
    #[arg(short, long, value_name = "FILE")]
    #[arg(value_parser = output::path_with_extension(&["html", "json", "txt", "svg"]))]
    output: Option<PathBuf>,

    #[command(flatten)]
    tree: TreeOptions,

    /// Size of the picture of which --pixel is one
    #[arg(long, value_name = "W,H", default_value = "1280,720", value_parser = values::resolution)]
    #[arg(help_heading = "Camera (by itself it shows the whole model)")]
    resolution: (u32, u32),

    #[command(flatten)]
    camera: CameraOptions,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum PlaneName {
    /// Seen along z
    Xy,
    /// Seen along y
    Xz,
    /// Seen along x
    Yz,
}

impl PlaneName {
    /// The axis along which it is seen.
    fn axis(self) -> usize {
        match self {
            PlaneName::Xy => 2,
            PlaneName::Xz => 1,
            PlaneName::Yz => 0,
        }
    }
}

/// Explains.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    check_output(options, &session)?;
    let source = Source::open(&options.mesh, &options.tree, &session)?;
    match (options.plane, options.point) {
        (Some(plane), _) => cut(options, plane.axis(), &source, session),
        (None, Some(point)) => point::tell(options, point, &source, session),
        (None, None) => tell(options, &source, session),
    }
}

/// Refuses what cannot be written before any work is done.
fn check_output(options: &Options, session: &Session) -> Result<(), Failure> {
    let usage = |reason: &str| Err(Failure::Usage(reason.into()));
    let is_svg = |path: &PathBuf| output::extension(path).is_some_and(|e| e == "svg");
    let Some(path) = &options.output else {
        return match options.plane.is_some() && session.wants_json() {
            true => usage("--json with --plane needs --output: both would be printed"),
            false => Ok(()),
        };
    };
    match (options.plane.is_some(), is_svg(path)) {
        (true, false) => return usage("with --plane the output's name must end in .svg"),
        (false, true) => return usage("an .svg shows a plane: say which by --plane"),
        _ if options.point.is_some() && output::extension(path).as_deref() == Some("html") => {
            return usage(
                "a page shows a ray: with --point the output's name must end in .json or .txt",
            );
        }
        _ => {}
    }
    output::check(path, &[&options.mesh])
}

/// The ray that was asked about.
fn ray_of(options: &Options, scene: &Scene) -> Result<Option<Ray>, Failure> {
    let Some((column, row)) = options.pixel else { return Ok(options.ray) };
    let camera = options.camera.settings().map_err(Failure::Usage)?;
    let (width, height) = options.resolution;
    let settings = RenderSettings::new(width, height).with(|settings| settings.camera = camera);
    Ok(Some(Plan::new(scene, &settings)?.pixel_ray(column, row)?))
}

/// The axis that points up in the picture of which a pixel is explained; z where there is none.
fn up_axis(options: &Options) -> Result<usize, Error> {
    let camera = options.camera.settings().map_err(|reason| Error::invalid("camera", reason))?;
    Ok(options.pixel.map_or(2, |_| camera.up.vector().abs().max_axis()))
}

/// What people know the mesh by.
fn name_of(mesh: &Path) -> String {
    let mesh = input::name(mesh);
    mesh.file_name().unwrap_or(mesh.as_os_str()).to_string_lossy().into_owned()
}

/// The walk of one ray.
fn tell(options: &Options, source: &Source, session: Session) -> Result<(), Failure> {
    let scene = &source.scene;
    let Some(ray) = ray_of(options, scene)? else { unreachable!("one of both is required") };
    let (explanation, _) = session.timed_as(Stage::Trace, "explaining", |observer| {
        scene.explain(&ray, options.rule, observer)
    })?;
    let name = name_of(&options.mesh);
    let explained =
        halfline_explain::Report { name: &name, mesh: scene.mesh(), explanation: &explanation };
    if let Some(path) = &options.output {
        let content = scene.guarded(|| {
            Ok(match output::extension(path).as_deref() {
                Some("html") => explained.to_page(up_axis(options)?),
                Some("json") => format!("{:#}\n", explained.to_json()),
                _ => explained.to_text(),
            })
        })?;
        write(path, &content, &session)?;
    }
    if session.wants_json() {
        let figures = scene.guarded(|| Ok(explained.to_json()))?;
        return session.tell_figures(&figures);
    }
    match &options.output {
        None => session.tell_text(|| explained.to_text(), true),
        Some(path) => session.tell_text(|| summary(path, &explanation), false),
    }
}

fn write(path: &Path, content: &str, session: &Session) -> Result<(), Failure> {
    session.timed(Stage::Write, |observer| {
        output::write(path, observer, |file| {
            file.write_all(content.as_bytes())?;
            Ok(())
        })
    })?;
    Ok(())
}

/// What is in a file that was written.
fn summary(path: &Path, explanation: &Explanation) -> String {
    let mut table = Table::new(path.display());
    let hit = &explanation.hit;
    match hit.is_hit() {
        true => table.row("hit", format!("face {}", hit.face), format!("at t = {}", hit.t)),
        false => table.row("hit", "none", ""),
    };
    let (textbook, engine) = (explanation.walk.visits, explanation.engine.visits);
    for (name, visits) in [("textbook", textbook), ("engine", engine)] {
        let note = format!(
            "nodes, {} of them leaves, {} triangles",
            units::count(visits.leaves),
            units::count(visits.triangles)
        );
        table.row(name, units::count(visits.nodes), note);
    }
    table.print()
}

/// The cells where a plane cuts them.
fn cut(options: &Options, axis: usize, source: &Source, session: Session) -> Result<(), Failure> {
    let scene = &source.scene;
    let asked = ray_of(options, scene)?;
    let rule = options.rule;
    let name = name_of(&options.mesh);
    let drawing = session.timed_as(Stage::Trace, "cutting", |observer| {
        scene.guarded(|| {
            let mesh = scene.mesh();
            let termination = Termination::automatic(mesh.triangle_count());
            let mut cells = Cells::new(mesh, rule, termination, observer)?;
            let bounds = cells.get(0).bounds;
            let ray = match asked {
                Some(ray) => ray,
                None => ray_to_show(&mut cells, axis, options.at)?,
            };
            let walk = Walk::through(&mut cells, &ray, &check(&ray)?)?;
            let coordinate = options.at.unwrap_or_else(|| place_of(&walk, &ray, &bounds, axis));
            let plane = SlicePlane { axis, coordinate };
            let longest = plane.axes().map(|axis| bounds.extent()[axis]);
            let pixel = longest[0].max(longest[1]) / SLICE_SIZE;
            let slice = Slice::through(&mut cells, plane, SMALLEST * pixel, usize::MAX)?;
            let options = SliceOptions { name: &name, rule: rule.name(), ray: &ray, walk: &walk };
            Ok((draw_slice(&slice, &options), SliceReport::new(mesh, &slice, &walk)))
        })
    });
    let ((svg, mut report), _) = drawing?;
    let Some(path) = &options.output else {
        return session.tell_text(|| svg, true);
    };
    write(path, &svg, &session)?;
    report.output = report::name(path).into_owned();
    session.tell(&report)
}

/// Cells whose sides are shorter than so many pixels are not divided further.
const SMALLEST: f64 = 1.5;

/// The cells that a plane cuts.
#[derive(Serialize)]
struct SliceReport {
    triangles: usize,
    axis: &'static str,
    at: f64,
    cells: usize,
    deepest: Option<usize>,
    segments: usize,
    nodes_visited: u64,
    /// The drawing.
    output: String,
}

impl SliceReport {
    fn new(mesh: &Mesh, slice: &Slice, walk: &Walk) -> SliceReport {
        SliceReport {
            triangles: mesh.triangle_count(),
            axis: ["x", "y", "z"][slice.plane.axis],
            at: slice.plane.coordinate,
            cells: slice.cells.len(),
            deepest: slice.cells.iter().map(|cell| cell.depth).max(),
            segments: slice.segments.len(),
            nodes_visited: walk.visits.nodes,
            output: String::new(),
        }
    }
}

impl Report for SliceReport {
    const IS_THE_RESULT: bool = false;

    fn to_text(&self) -> String {
        let mut table = Table::new(&self.output);
        let deepest = units::count(self.deepest.unwrap_or(0) as u64);
        let note = format!("up to {deepest} levels deep");
        table.row("cells", units::count(self.cells as u64), note);
        table.print()
    }
}

/// A ray to show where none is asked about: of some that cross the picture the one that comes to the
/// most leaves.
fn ray_to_show(cells: &mut Cells, axis: usize, at: Option<f64>) -> Result<Ray, Error> {
    const HEIGHTS: [f64; 6] = [-0.42, -0.28, -0.11, 0.09, 0.26, 0.41];
    let bounds = cells.get(0).bounds;
    let mut chosen = (0, Ray::new(vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0)));
    for (from, to) in HEIGHTS.into_iter().flat_map(|from| HEIGHTS.map(|to| (from, to))) {
        let ray = ray_across(&bounds, axis, at, [from, to]);
        let Ok(prepared) = check(&ray) else { continue };
        let walk = Walk::through(cells, &ray, &prepared)?;
        if walk.visits.leaves > chosen.0 {
            chosen = (walk.visits.leaves, ray);
        }
    }
    Ok(chosen.1)
}

/// A ray within the plane, from left to right and from one height to another, in terms of the box's.
fn ray_across(bounds: &Aabb, axis: usize, at: Option<f64>, [from, to]: [f64; 2]) -> Ray {
    let [across, up] = SlicePlane { axis, coordinate: 0.0 }.axes();
    let (center, extent) = (bounds.center(), bounds.extent());
    let (mut origin, mut direction) = (center, vec3(0.0, 0.0, 0.0));
    origin[axis] = at.unwrap_or(center[axis]);
    origin[across] = center[across] - 0.52 * extent[across];
    origin[up] = center[up] + from * extent[up];
    direction[across] = extent[across];
    direction[up] = (to - from) * extent[up];
    Ray::new(origin, direction)
}

/// Where the plane lies unless it is said: at the hit, else in the middle of the ray's way through the box,
/// else in the middle of the box.
fn place_of(walk: &Walk, ray: &Ray, bounds: &Aabb, axis: usize) -> f64 {
    let t = match walk.steps.first() {
        _ if walk.hit.is_hit() => walk.hit.t,
        Some(Step::Clip { within: Some([near, far]) }) => (near + far) / 2.0,
        _ => return bounds.center()[axis],
    };
    ray.at(t)[axis].clamp(bounds.min[axis], bounds.max[axis])
}
