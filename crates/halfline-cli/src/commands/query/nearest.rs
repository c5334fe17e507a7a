//! `halfline query --nearest`: what is nearest to each of many points, and on which side they are.

use std::borrow::Cow;
use std::time::Instant;

use halfline::columns::{ClosestPointColumns, Column};
use halfline::progress::{Observer, Part, Stage};
use halfline::{Inside, Mesh, Scene, Vec3};
use serde::Serialize;

use super::{BATCH, Options};
use crate::failure::Failure;
use crate::npy::PointFile;
use crate::npz::{Archive, Element};
use crate::output::Interruptible;
use crate::report::{Report, Skipped};
use crate::session::Session;
use crate::source::Source;
use crate::table::Table;
use crate::{output, report, session, units};

/// Answers for all points of the file.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    // A wrong file of points should show before a large mesh is loaded.
    let mut points = PointFile::open(&options.rays)?;
    let source = Source::open(&options.mesh, &options.tree, &session)?;
    let scene = &source.scene;
    let mut answers = Answers { is_signed: options.signed, ..Answers::default() };
    let (mut batch, mut invalid_points) = (Vec::new(), 0);
    let (mut trace_seconds, count) = (0.0, points.row_count());
    session.begin(Stage::Trace);
    loop {
        session.observer().check()?;
        points.read(BATCH, &mut batch)?;
        if batch.is_empty() {
            break;
        }
        invalid_points += batch.iter().filter(|point| !point.is_finite()).count() as u64;
        let (observer, before) = (session.observer(), answers.distance.len() as u64);
        let observer = Part { observer, before, share: batch.len() as u64, total: count };
        let start = Instant::now();
        answers.extend(scene, &batch, &observer)?;
        trace_seconds += start.elapsed().as_secs_f64();
    }
    let ((), write_seconds) = session.timed(Stage::Write, |observer| {
        scene.guarded(|| {
            output::write(&options.output, observer, |file| {
                answers.write(scene.mesh(), file, observer)
            })
        })
    })?;

    session.tell(&NearestReport {
        mesh: report::name(&options.mesh),
        output: report::name(&options.output),
        question: "nearest",
        signed: options.signed,
        triangles: scene.mesh().triangle_count() as u64,
        skipped: Skipped::of(scene),
        points: count,
        invalid_points,
        inside_points: options.signed.then(|| answers.inside_points()),
        points_per_second: report::per_second(count, trace_seconds),
        load_seconds: source.load_seconds,
        build_seconds: source.build_seconds,
        trace_seconds,
        write_seconds,
        peak_memory_bytes: session::peak_memory_bytes(),
        source: &source,
    })
}

/// What was found so far, in the order of the points.
#[derive(Default)]
struct Answers {
    /// True if it is to be found on which side points are.
    is_signed: bool,
    distance: Vec<f64>,
    point: Vec<[f64; 3]>,
    face: Vec<i64>,
    uv: Vec<[f64; 2]>,
    feature: Vec<u8>,
    /// Empty unless asked for.
    signed_distance: Vec<f64>,
    /// Empty unless asked for.
    winding_number: Vec<f64>,
}

impl Answers {
    /// Asks `scene` about `points` and appends what it says.
    fn extend(
        &mut self,
        scene: &Scene,
        points: &[Vec3],
        observer: &dyn Observer,
    ) -> halfline::Result<()> {
        let rows: Vec<[f64; 3]> = points.iter().map(|point| point.to_array()).collect();
        let (first, last) = (self.distance.len(), self.distance.len() + rows.len());
        self.distance.resize(last, f64::INFINITY);
        self.point.resize(last, [f64::NAN; 3]);
        self.face.resize(last, -1);
        self.uv.resize(last, [f64::NAN; 2]);
        self.feature.resize(last, 0);
        let asked = scene.observed(observer);
        let nearest = ClosestPointColumns {
            distance: &mut self.distance[first..],
            point: &mut self.point[first..],
            face: &mut self.face[first..],
            uv: &mut self.uv[first..],
            feature: &mut self.feature[first..],
        };
        asked.closest_points_columns(Column::F64(&rows), Column::Same(f64::INFINITY), nearest)?;
        if !self.is_signed {
            return Ok(());
        }
        self.winding_number.resize(last, f64::NAN);
        asked.winding_numbers_columns(Column::F64(&rows), &mut self.winding_number[first..])?;
        // Not by comparing winding numbers, which are rounded: near a half, this decides with certainty.
        let mut inside = vec![false; rows.len()];
        asked.contains_columns(Column::F64(&rows), Inside::Winding, &mut inside)?;
        let signed = |((point, inside), &distance): ((&Vec3, bool), &f64)| match point.is_finite() {
            false => f64::NAN,
            // A point on the surface is inside, and has no negative zero.
            true if inside && distance > 0.0 => -distance,
            true => distance,
        };
        let found = points.iter().zip(inside).zip(&self.distance[first..]);
        self.signed_distance.extend(found.map(signed));
        Ok(())
    }

    fn inside_points(&self) -> u64 {
        self.signed_distance.iter().filter(|&&distance| distance <= 0.0).count() as u64
    }

    fn write(
        &self,
        mesh: &Mesh,
        file: &mut Interruptible,
        observer: &dyn Observer,
    ) -> std::io::Result<()> {
        let row_bytes = 8 + 24 + 8 + 8 + 16 + FeatureName::SIZE as u64;
        let signed_bytes = 16 * self.signed_distance.len() as u64;
        let total = self.distance.len() as u64 * row_bytes + signed_bytes;
        let source_face = |&face: &i64| match u32::try_from(face) {
            Ok(face) => [i64::from(mesh.source_face(face))],
            Err(_) => [-1],
        };
        let mut archive = Archive::new(file, total, observer);
        archive.add("distance", self.distance.iter().map(|&distance| [distance]))?;
        archive.add("point", self.point.iter().copied())?;
        archive.add("face", self.face.iter().map(|&face| [face]))?;
        archive.add("source_face", self.face.iter().map(source_face))?;
        archive.add("uv", self.uv.iter().copied())?;
        let name = |number: usize| [FeatureName::of(self.face[number], self.feature[number])];
        archive.add("feature", (0..self.feature.len()).map(name))?;
        if self.is_signed {
            archive.add("signed_distance", self.signed_distance.iter().map(|&d| [d]))?;
            archive.add("winding_number", self.winding_number.iter().map(|&w| [w]))?;
        }
        archive.finish()
    }
}

/// The name of a feature; empty where nothing was found.
#[derive(Clone, Copy)]
struct FeatureName(&'static str);

impl FeatureName {
    fn of(face: i64, feature: u8) -> FeatureName {
        FeatureName(match feature {
            _ if face < 0 => "",
            0 => "face",
            1 => "edge",
            _ => "vertex",
        })
    }
}

impl Element for FeatureName {
    const DTYPE: &'static str = "<U6";
    const SIZE: usize = 6 * 4;

    fn put(self, bytes: &mut Vec<u8>) {
        let end = bytes.len() + FeatureName::SIZE;
        self.0.chars().for_each(|c| bytes.extend_from_slice(&u32::from(c).to_le_bytes()));
        bytes.resize(end, 0);
    }
}

/// What points were asked about, and what it cost to answer.
#[derive(Serialize)]
struct NearestReport<'a> {
    mesh: Cow<'a, str>,
    output: Cow<'a, str>,
    question: &'a str,
    signed: bool,
    triangles: u64,
    skipped: Skipped,
    points: u64,
    invalid_points: u64,
    inside_points: Option<u64>,
    points_per_second: f64,
    load_seconds: f64,
    build_seconds: f64,
    trace_seconds: f64,
    write_seconds: f64,
    peak_memory_bytes: Option<u64>,
    #[serde(skip)]
    source: &'a Source,
}

impl Report for NearestReport<'_> {
    const IS_THE_RESULT: bool = false;

    fn to_text(&self) -> String {
        let mut table = Table::new(&self.output);
        let note = format!("{} triangles", units::count(self.triangles));
        table.row("load", units::seconds(self.load_seconds), note);
        self.source.build_row(&mut table, "");
        let speed = units::metric(self.points_per_second);
        let note = format!("{} points, {speed}points/s", units::count(self.points));
        table.row("trace", units::seconds(self.trace_seconds), note);
        let note = self
            .inside_points
            .map_or(String::new(), |inside| format!("{} points inside", units::count(inside)));
        table.row("write", units::seconds(self.write_seconds), note);
        if self.invalid_points > 0 {
            let invalid = units::count(self.invalid_points);
            table.row("invalid", invalid, "points that are not finite: nothing is near them");
        }
        table.print()
    }
}
