//! How a picture's time is divided between the lecture's three tasks: ray generation, intersection,
//! shading.
//!
//! T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980, found 75 % of the
//! time spent in intersections for simple scenes, and over 95 % for complex ones.

use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use halfline::error::{Error, Result};
use halfline::explain::Rule;
use halfline::geometry::{Hit, Ray};
use halfline::progress::Observer;
use halfline::textbook::Visits;
use halfline::{Mesh, Scene};
use halfline_render::{Camera, Intersector, Plan, RenderSettings, Shading};

use super::Settings;
use super::budget::build_textbook;
use super::engine::{Engine, Ready, build_fast};
use super::progress::Part;
use super::stopwatch::Stopwatch;

/// Where the time of one picture goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Who answers the rays.
    pub engine: Engine,
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Pixels of the picture's sides.
    pub resolution: [u32; 2],
    /// Rays of one picture, those to lamps included.
    pub rays: u64,
    /// Seconds to make the rays from the eye, found by making them alone.
    pub generation_seconds: f64,
    /// Seconds in which the engine answers.
    pub intersection_seconds: f64,
    /// All the rest: shading, and the rays that it sends.
    pub shading_seconds: f64,
}

impl Shares {
    /// Seconds of the picture.
    pub fn seconds(&self) -> f64 {
        self.generation_seconds + self.intersection_seconds + self.shading_seconds
    }

    /// Ray generation, intersection and shading in parts of one.
    pub fn parts(&self) -> [f64; 3] {
        [self.generation_seconds, self.intersection_seconds, self.shading_seconds]
            .map(|seconds| seconds / self.seconds())
    }

    /// The part that the lecture says is 95 %.
    pub fn intersection(&self) -> f64 {
        self.parts()[1]
    }
}

/// The engines that draw the picture.
pub const ENGINES: [Engine; 3] =
    [Engine::BruteForce, Engine::Textbook(Rule::SurfaceArea), Engine::Fast];

/// Draws a picture of `mesh` by Whitted's shading with each of [`ENGINES`], on the calling thread.
///
/// # Errors
/// [`Error::Interrupted`]; [`Error::Invalid`] for a mesh that cannot be looked at.
pub fn shares(mesh: &Arc<Mesh>, settings: &Settings, part: &Part) -> Result<Vec<Shares>> {
    let [width, height] = settings.picture;
    let picture = RenderSettings::new(width, height).with(|settings| {
        settings.samples = 1;
        settings.shading = Shading::Whitted;
    });
    let Ready::Fast(scene) = build_fast(mesh, part)? else { unreachable!("it was just built") };
    let generation_seconds = generation_seconds(&picture, mesh, settings)?;
    let plan = Plan::new(&*scene, &picture)?;
    let mut found = Vec::new();
    for (i, engine) in ENGINES.into_iter().enumerate() {
        part.advance(i as f64 / ENGINES.len() as f64);
        let answerer = match engine {
            Engine::BruteForce => Answerer::Reference(Ready::BruteForce(mesh)),
            Engine::Fast => Answerer::Scene(&scene),
            Engine::Textbook(rule) => match build_textbook(rule, mesh, settings.budget, part)? {
                Ok((tree, _)) => Answerer::Reference(Ready::Textbook(tree)),
                Err(_) => continue,
            },
        };
        let timed = Timed { answerer, observer: part, nanoseconds: AtomicU64::new(0) };

        // Draw again and again until it took long enough to be timed.
        let (mut pictures, mut rays) = (0.0, 0);
        let started = Stopwatch::start();
        while pictures == 0.0 || started.seconds() < settings.picture_seconds {
            let rows = plan.trace_rows_by(&timed, 0..height, part)?;
            rays = halfline_render::assemble(&picture, [rows])?.statistics.rays.total();
            pictures += 1.0;
        }
        let seconds = started.seconds() / pictures;
        let intersection_seconds =
            timed.nanoseconds.load(Ordering::Relaxed) as f64 * 1e-9 / pictures;
        found.push(Shares {
            engine,
            triangles: mesh.triangle_count(),
            resolution: settings.picture,
            rays,
            generation_seconds,
            intersection_seconds,
            shading_seconds: (seconds - generation_seconds - intersection_seconds).max(0.0),
        });
    }
    part.check()?;
    Ok(found)
}

/// Seconds to make the rays from the eye of one picture.
fn generation_seconds(picture: &RenderSettings, mesh: &Mesh, settings: &Settings) -> Result<f64> {
    let camera = Camera::new(picture, mesh, &mesh.bounds())?;
    let mut pictures = 0.0;
    let started = Stopwatch::start();
    while pictures == 0.0 || started.seconds() < settings.picture_seconds / 10.0 {
        let pixels = (0..picture.height).flat_map(|y| (0..picture.width).map(move |x| (x, y)));
        let rays: Vec<Ray> =
            pixels.map(|(x, y)| camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5)).collect();
        black_box(rays);
        pictures += 1.0;
    }
    Ok(started.seconds() / pictures)
}

enum Answerer<'a> {
    Reference(Ready<'a>),
    Scene(&'a Scene),
}

/// Answers rays with a stopwatch in the hand. Once the work should end it answers anything, for the
/// renderer looks at the observer between its batches.
struct Timed<'a> {
    answerer: Answerer<'a>,
    observer: &'a dyn Observer,
    nanoseconds: AtomicU64,
}

impl Timed<'_> {
    fn timed<T>(&self, answer: impl FnOnce() -> T) -> T {
        let started = Stopwatch::start();
        let answer = answer();
        let nanoseconds = (started.seconds() * 1e9) as u64;
        self.nanoseconds.fetch_add(nanoseconds, Ordering::Relaxed);
        answer
    }

    fn by_reference(&self, engine: &Ready, rays: &[Ray]) -> Vec<Hit> {
        match engine.cast(rays, &mut Visits::default(), self.observer) {
            Ok(hits) => hits,
            Err(Error::Interrupted) => vec![Hit::MISS; rays.len()],
            Err(error) => unreachable!("a reference engine can only be interrupted: {error}"),
        }
    }
}

impl Intersector for Timed<'_> {
    fn closest(&self, rays: &[Ray]) -> Vec<Hit> {
        self.timed(|| match &self.answerer {
            Answerer::Reference(engine) => self.by_reference(engine, rays),
            Answerer::Scene(scene) => scene.intersect(rays),
        })
    }

    fn occluded(&self, rays: &[Ray]) -> Vec<bool> {
        self.timed(|| match &self.answerer {
            Answerer::Reference(engine) => {
                self.by_reference(engine, rays).iter().map(Hit::is_hit).collect()
            }
            Answerer::Scene(scene) => scene.occluded(rays),
        })
    }
}
