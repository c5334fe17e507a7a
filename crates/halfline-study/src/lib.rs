//! What a ray costs, as meshes grow: measured, fitted and reported.
//!
//! The lecture claims that intersection takes nearly all the time of a picture, and that a kd-tree turns
//! n into log n. [`study`] measures both on the user's own machine and mesh.

mod budget;
mod cache;
mod csv;
mod engine;
mod family;
mod findings;
mod fit;
mod growth;
mod json;
mod machine;
mod measure;
mod progress;
mod rays;
mod report;
mod resolution;
mod share;
mod speedup;
mod stopwatch;
mod table;
mod utc;

pub use self::csv::csv;
pub use budget::{Budget, Refusal};
pub use cache::{CacheEnd, End};
pub use engine::Engine;
pub use family::Family;
pub use findings::Finding;
pub use fit::{Fit, Fits, Law};
pub use growth::{Growth, Quantity};
pub use json::figures;
pub use machine::{Cache, Machine};
pub use measure::{Measurement, RayCost, Sample};
pub use report::{Origin, html, standalone as svg};
pub use resolution::{sampled, subdivided};
pub use share::Shares;
pub use speedup::{Side, SpeedUp};
pub use stopwatch::COUNTS_PROCESSOR_TIME;
pub use table::{Section, sections};

use halfline::error::{Error, Result};
use halfline::progress::Observer;

use measure::{History, measure};
use progress::Part;

/// The lecture's mesh has 16,843 faces, and its largest 5.5 million.
pub const LECTURE_SIZES: [usize; 2] = [16_843, 5_500_000];

/// What to study, and how long.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Families of meshes, one after the other.
    pub families: Vec<Family>,
    /// Numbers of triangles, in rising order.
    pub sizes: Vec<usize>,
    /// Turns in which each engine is timed.
    pub turns: usize,
    /// Rays of a turn at most.
    pub rays_per_turn: usize,
    /// Seconds that the rays of a turn fill at most.
    pub turn_seconds: f64,
    /// Rays of all turns together at least.
    pub fewest_rays: usize,
    /// Seconds that brute force may take; where the fewest rays would take it more, it is
    /// extrapolated.
    pub brute_seconds: f64,
    /// What each of the textbook's trees may take.
    pub budget: Budget,
    /// Pixels of the sides of the picture whose time is divided.
    pub picture: [u32; 2],
    /// Seconds for which the picture is drawn again and again.
    pub picture_seconds: f64,
}

/// Bytes for all of the textbook's trees where the system does not tell how much there are.
const UNKNOWN_MEMORY: u64 = 16 << 30;

impl Settings {
    /// From a hundred to ten million triangles.
    pub fn full(families: Vec<Family>) -> Settings {
        let memory = Machine::this().memory_bytes.unwrap_or(UNKNOWN_MEMORY);
        Settings {
            families,
            sizes: vec![
                100,
                316,
                1000,
                3162,
                10_000,
                LECTURE_SIZES[0],
                31_623,
                100_000,
                316_228,
                1_000_000,
                3_162_278,
                LECTURE_SIZES[1],
                10_000_000,
            ],
            turns: 9,
            rays_per_turn: 16_384,
            turn_seconds: 0.06,
            fewest_rays: 32,
            brute_seconds: 6.0,
            budget: Budget { seconds: 45.0, bytes: memory as f64 / 4.0 },
            picture: [128, 96],
            picture_seconds: 0.5,
        }
    }

    /// In less than a minute.
    pub fn quick(families: Vec<Family>) -> Settings {
        let full = Settings::full(families);
        Settings {
            sizes: full.sizes.iter().copied().filter(|&n| n <= 1_000_000).collect(),
            turns: 5,
            rays_per_turn: 8192,
            turn_seconds: 0.012,
            brute_seconds: 0.4,
            budget: Budget { seconds: 1.0, ..full.budget },
            picture: [64, 48],
            picture_seconds: 0.1,
            ..full
        }
    }
}

impl Settings {
    /// A guess at how long a mesh takes, for the bar that tells how far the study is.
    fn rough_seconds(&self, triangles: usize) -> f64 {
        const BUILD_AND_GENERATE: f64 = 4e-6;
        const TEXTBOOK: f64 = 5e-5;
        let n = triangles as f64;
        let textbook = Some(TEXTBOOK * n).filter(|seconds| *seconds <= self.budget.seconds);
        let turns = (self.turns * Engine::ALL.len()) as f64 * self.turn_seconds;
        turns + BUILD_AND_GENERATE * n + textbook.unwrap_or(0.0)
    }
}

/// What was found out.
#[derive(Clone, Debug)]
pub struct Study {
    /// Family by family.
    pub families: Vec<FamilyStudy>,
    /// How a picture's time is divided, of the first family.
    pub shares: Vec<Shares>,
    /// The machine on which it was measured.
    pub machine: Machine,
}

/// One family, size by size.
#[derive(Clone, Debug)]
pub struct FamilyStudy {
    /// The family.
    pub family: Family,
    /// The sizes of the family, in rising order.
    pub samples: Vec<Sample>,
}

/// Studies on one thread; only meshes are made on all.
///
/// # Errors
/// [`Error::Interrupted`]; those of [`generate`](halfline_io::models::generate); and
/// [`Error::Invalid`] if engines do not agree, or a mesh has no extent.
pub fn study(settings: &Settings, observer: &dyn Observer) -> Result<Study> {
    for family in &settings.families {
        if let Family::Own { name, mesh } = family
            && mesh.bounds().is_empty()
        {
            return Err(Error::invalid(name, "no triangle that a ray could hit"));
        }
    }
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one_thread = one_thread.map_err(|error| Error::invalid("threads", error.to_string()))?;
    let plan: Vec<(&Family, Vec<usize>)> =
        settings.families.iter().map(|family| (family, family.sizes(&settings.sizes))).collect();
    let work_of = |size: usize| settings.rough_seconds(size);
    let largest = settings.sizes.iter().copied().max().unwrap_or(LECTURE_SIZES[0]);
    let picture_size = largest.min(LECTURE_SIZES[0]);
    let picture_work = work_of(picture_size);
    let sizes = plan.iter().flat_map(|(_, sizes)| sizes);
    let total = sizes.map(|&size| work_of(size)).sum::<f64>() + picture_work;
    let mut before = 0.0;
    let mut families = Vec::new();
    for (family, sizes) in plan {
        let mut history = History::default();
        let mut samples: Vec<Sample> = Vec::new();
        for size in sizes {
            let part = Part::new(observer, before, work_of(size), total);
            before += work_of(size);
            part.advance(0.0);
            let mesh = family.mesh(size, &part)?;
            // Kinds that only come near to a size may come to the same again.
            if samples.last().is_some_and(|last| last.triangles >= mesh.triangle_count()) {
                continue;
            }
            let sample = one_thread.install(|| measure(&mesh, settings, &mut history, &part))?;
            samples.push(sample);
        }
        families.push(FamilyStudy { family: family.clone(), samples });
    }
    let shares = match settings.families.first() {
        Some(family) => {
            let part = Part::new(observer, before, picture_work, total);
            let mesh = family.mesh_of_at_most(picture_size, &part)?;
            one_thread.install(|| share::shares(&mesh, settings, &part))?
        }
        None => Vec::new(),
    };
    Part::new(observer, total, 0.0, total).advance(1.0);
    observer.check()?;
    Ok(Study { families, shares, machine: Machine::this() })
}
