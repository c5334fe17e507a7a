//! `halfline distance`: how far one mesh is from another.

mod deviation;
mod measure;
mod options;
mod picture;
mod report;
mod samples;

use std::path::Path;

use halfline::progress::Stage;
use halfline::{Mesh, Scene};
use halfline_render::ColorScale;

pub use options::Options;

use crate::failure::Failure;
use crate::report::Skipped;
use crate::session::Session;
use crate::source::{MeshSource, Source};
use crate::{input, output, session};
use deviation::{Deviation, Question};
use measure::{Points, check_faces, refused};
use picture::Picture;
use report::{DistanceReport, Found, Seconds};

/// Measures.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    check_arguments(options)?;
    let picture = Picture::new(options)?;
    let mut work = Work { options, session: &session, seconds: Seconds::default() };
    let found = work.find(picture)?;
    let report = DistanceReport::new(options, found, work.seconds, session::peak_memory_bytes());
    session.tell(&report)
}

/// Refuses what makes no sense together, and files that could not be written.
fn check_arguments(options: &Options) -> Result<(), Failure> {
    let usage = |reason: &str| Err(Failure::Usage(reason.into()));
    if input::is_stdin(&options.mesh) && input::is_stdin(&options.to) {
        return usage("only one of MESH and OTHER can be -, standard input");
    }
    if let (Some(range), Some(tolerance)) = (options.range, options.tolerance)
        && range <= tolerance
    {
        return usage("--range must be above --tolerance");
    }
    let inputs: [&Path; 2] = [&options.mesh, &options.to];
    for (option, path) in [("--output", &options.output), ("--picture", &options.picture)] {
        if let Some(path) = path {
            output::check_as(option, path, &inputs)?;
        }
    }
    Ok(())
}

/// A run under way.
struct Work<'a> {
    options: &'a Options,
    session: &'a Session,
    seconds: Seconds,
}

/// A mesh by the name that people know.
#[derive(Clone, Copy)]
struct NamedMesh<'a>(&'a Path, &'a Mesh);

/// A mesh with its tree, by the name that people know.
#[derive(Clone, Copy)]
struct NamedScene<'a>(&'a Path, &'a Scene);

impl Work<'_> {
    /// Measures, and writes the files.
    fn find(&mut self, picture: Option<Picture>) -> Result<Found, Failure> {
        let options = self.options;
        let (path, other_path) = (&options.mesh, &options.to);
        let samples_surface = options.samples.is_some();

        // Read both meshes, and build the tree over the other alone.
        let (mesh, load_seconds) = MeshSource::open(path, &options.tree, self.session)?;
        if samples_surface || options.symmetric || picture.is_some() {
            check_faces(path, mesh.mesh())?;
        }
        let other = Source::open(other_path, &options.tree, self.session)?;
        check_faces(other_path, other.scene.mesh())?;
        self.seconds.load = load_seconds + other.load_seconds;
        self.seconds.build = other.build_seconds;

        // Measure from the mesh to the other. Files show its vertices, whatever the figures are about.
        let to_other = NamedScene(other_path, &other.scene);
        let files = options.output.is_some() || picture.is_some();
        let (forward, distances) = mesh.guarded(|| {
            let (forward, distances) =
                self.measure(NamedMesh(path, mesh.mesh()), to_other, options.range)?;
            if !(files && samples_surface) {
                return Ok((forward, distances));
            }
            let vertices = Points::Vertices(mesh.mesh().positions());
            Ok((forward, self.distances(&vertices, to_other)?))
        })?;
        let range = forward.histogram.range();
        let scale = ColorScale::new(options.signed, range, options.tolerance)?;
        if let Some(path) = &options.output {
            mesh.guarded(|| self.write(mesh.mesh(), &distances, &scale, path))?;
        }

        // Only now is a tree over the mesh itself needed, if at all.
        let triangles = mesh.mesh().triangle_count() as u64;
        let mut backward = None;
        if options.symmetric || picture.is_some() {
            let (scene, build_seconds) = mesh.into_scene(&options.tree, self.session)?;
            self.seconds.build += build_seconds;
            if let Some(picture) = picture {
                picture.draw(&scene, distances, scale, self.session, &mut self.seconds)?;
            }
            if options.symmetric {
                let (from, to) =
                    (NamedMesh(other_path, other.scene.mesh()), NamedScene(path, &scene));
                let measured = other.scene.guarded(|| Ok(self.measure(from, to, Some(range))))?;
                backward = Some(measured?.0);
            }
        }
        Ok(Found {
            triangles,
            to_triangles: other.scene.mesh().triangle_count() as u64,
            to_skipped: Skipped::of(&other.scene),
            forward,
            backward,
        })
    }

    /// The distances from one mesh to another, and their figures; a histogram of them reaches to `range`.
    fn measure(
        &mut self,
        NamedMesh(path, mesh): NamedMesh,
        to: NamedScene,
        range: Option<f64>,
    ) -> Result<(Deviation, Vec<f64>), Failure> {
        let points = Points::of(path, mesh, self.options.samples, self.options.seed)?;
        let distances = self.distances(&points, to)?;
        let Options { signed, tolerance, .. } = *self.options;
        let question = Question { is_signed: signed, tolerance, range };
        let deviation = Deviation::of(&distances, &question)
            .ok_or_else(|| refused(path, "none of its vertices is finite"))?;
        Ok((deviation, distances))
    }

    /// The distances of points.
    fn distances(
        &mut self,
        points: &Points,
        NamedScene(path, scene): NamedScene,
    ) -> Result<Vec<f64>, Failure> {
        let (distances, seconds) = self.session.timed_as(Stage::Trace, "measure", |observer| {
            points.distances(path, scene, self.options.signed, observer)
        })?;
        self.seconds.measure += seconds;
        self.seconds.points += distances.len() as u64;
        Ok(distances)
    }

    /// Writes the mesh with the distances of its vertices.
    fn write(
        &mut self,
        mesh: &Mesh,
        distances: &[f64],
        scale: &ColorScale,
        path: &Path,
    ) -> Result<(), Failure> {
        let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 255];
        let colors: Vec<_> = distances.iter().map(|&d| opaque(scale.srgb8(d))).collect();
        let ((), seconds) = self.session.timed(Stage::Write, |observer| {
            halfline_io::save_ply_distances(mesh, distances, &colors, path, observer)
        })?;
        self.seconds.write += seconds;
        Ok(())
    }
}
