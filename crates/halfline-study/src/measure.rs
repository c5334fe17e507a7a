//! One mesh: all engines built, and asked about the same rays in turns.

use std::collections::BTreeMap;
use std::sync::Arc;

use halfline::Mesh;
use halfline::error::{Error, Result};
use halfline::explain::Rule;
use halfline::geometry::{Hit, Ray};
use halfline::progress::Observer;
use halfline::textbook::Visits;

use super::Settings;
use super::budget::{Budget, Cost, Experience, Refusal, build_textbook};
use super::engine::{Engine, Ready, build_fast};
use super::progress::Part;
use super::rays::chords;
use super::stopwatch::Stopwatch;

/// What was found out about an engine with a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The engine.
    pub engine: Engine,
    /// Triangles of the mesh.
    pub triangles: usize,
    /// What a ray costs; `None` if the tree was not built.
    pub rays: Option<RayCost>,
    /// Seconds to build the tree; `None` if there is none.
    pub build_seconds: Option<f64>,
    /// Bytes of the tree.
    pub bytes: Option<usize>,
    /// Bytes in which rays find what they need.
    pub bytes_walked: Option<usize>,
    /// Why the tree was not built.
    pub refusal: Option<Refusal>,
}

/// What a ray costs, on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayCost {
    /// Rays that were timed; 0 if the time is extrapolated.
    pub rays: usize,
    /// Inner nodes visited.
    pub nodes: f64,
    /// Leaves visited.
    pub leaves: f64,
    /// Triangles tested.
    pub triangles: f64,
    /// The median over all turns.
    pub nanoseconds: f64,
    /// The quickest and the slowest turn.
    pub range: [f64; 2],
    /// True if no ray was timed: nanoseconds are those of a smaller mesh, times how much larger this one
    /// is.
    pub extrapolated: bool,
}

impl Measurement {
    /// Bytes of the tree for each triangle of the mesh.
    pub fn bytes_per_triangle(&self) -> Option<f64> {
        Some(self.bytes? as f64 / self.triangles as f64)
    }
}

impl RayCost {
    /// Steps through the tree: inner nodes and leaves.
    pub fn steps(&self) -> f64 {
        self.nodes + self.leaves
    }

    /// What is fetched from memory, one thing after the other: halfline's nodes, and leaves with all
    /// their triangles; of the others triangles lie apart, so that each counts.
    pub fn visits(&self, engine: Engine) -> f64 {
        match engine {
            Engine::Fast => self.steps(),
            _ => self.steps() + self.triangles,
        }
    }
}

/// A size of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Triangles.
    pub triangles: usize,
    /// Of the rays, the share that hit anything.
    pub hit_share: f64,
    /// All engines.
    pub measurements: Vec<Measurement>,
}

/// What smaller meshes of the family have taught.
#[derive(Default)]
pub struct History {
    textbook: BTreeMap<Rule, Experience>,
    /// Nanoseconds that brute force takes for a triangle.
    brute_pair: Option<f64>,
}

/// Of an engine that is ready: what its turns took.
struct Contender<'mesh> {
    engine: Engine,
    ready: Ready<'mesh>,
    build_seconds: Option<f64>,
    /// Rays of each turn; 0 for brute force that would not finish in time.
    batch: usize,
    visits: Visits,
    /// Nanoseconds a ray, turn by turn.
    turns: Vec<f64>,
}

/// Measures all engines with a mesh, on the calling thread.
///
/// # Errors
/// [`Error::Interrupted`]; [`Error::Invalid`] if engines do not give the same hits.
pub fn measure(
    mesh: &Arc<Mesh>,
    settings: &Settings,
    history: &mut History,
    part: &Part,
) -> Result<Sample> {
    // Turn 0 warms up. Each turn has rays of its own, so that none finds in the caches what the
    // turn before it left there for the very same rays.
    let stride = settings.rays_per_turn;
    let bounds = mesh.bounds();
    let rays = chords(&bounds, stride * (settings.turns + 1));
    let turns: Vec<&[Ray]> = rays.chunks(stride).collect();

    let (mut contenders, mut refused) = (Vec::new(), Vec::new());
    for (i, &engine) in Engine::ALL.iter().enumerate() {
        part.advance(0.1 + 0.12 * i as f64);
        match prepare(engine, mesh, settings, history, built_bytes(&contenders), part)? {
            Ok((ready, build_seconds)) => contenders.push(Contender {
                engine,
                ready,
                build_seconds,
                batch: stride,
                visits: Visits::default(),
                turns: Vec::new(),
            }),
            Err(refusal) => refused.push((engine, refusal)),
        }
    }
    for contender in &mut contenders {
        contender.warm_up(turns[0], settings, history, part)?;
    }

    let (mut hits, mut cast) = (0, 0);
    for (number, &rays) in turns.iter().enumerate().skip(1) {
        part.advance(0.7 + 0.3 * number as f64 / turns.len() as f64);
        let answers = take_turns(&mut contenders, rays, part)?;
        if let Some(longest) = answers.iter().max_by_key(|answer| answer.len()) {
            cast += longest.len();
            hits += longest.iter().filter(|hit| hit.is_hit()).count();
        }
    }

    let mut measurements: Vec<Measurement> = contenders
        .into_iter()
        .map(|contender| contender.finish(mesh, &turns, history))
        .chain(refused.into_iter().map(|(engine, refusal)| Measurement {
            engine,
            triangles: mesh.triangle_count(),
            rays: None,
            build_seconds: None,
            bytes: None,
            bytes_walked: None,
            refusal: Some(refusal),
        }))
        .collect();
    measurements.sort_by_key(|measurement| measurement.engine);
    let hit_share = hits as f64 / cast as f64;
    Ok(Sample { triangles: mesh.triangle_count(), hit_share, measurements })
}

/// Bytes of the trees that are there already.
fn built_bytes(contenders: &[Contender]) -> f64 {
    contenders.iter().map(|contender| contender.ready.bytes() as f64).sum()
}

type Prepared<'mesh> = std::result::Result<(Ready<'mesh>, Option<f64>), Refusal>;

/// The engine with its tree, and how many seconds that took.
fn prepare<'mesh>(
    engine: Engine,
    mesh: &'mesh Arc<Mesh>,
    settings: &Settings,
    history: &mut History,
    taken: f64,
    part: &Part,
) -> Result<Prepared<'mesh>> {
    let rule = match engine {
        Engine::BruteForce => return Ok(Ok((Ready::BruteForce(mesh), None))),
        Engine::Fast => {
            let started = Stopwatch::start();
            let ready = build_fast(mesh, part)?;
            return Ok(Ok((ready, Some(started.seconds()))));
        }
        Engine::Textbook(rule) => rule,
    };
    let triangles = mesh.triangle_count();
    let budget = Budget { bytes: settings.budget.bytes - taken, ..settings.budget };
    let experience = history.textbook.entry(rule).or_default();
    if let Some(refusal) = experience.refusal(triangles, budget) {
        return Ok(Err(refusal));
    }
    match build_textbook(rule, mesh, budget, part)? {
        Ok((tree, seconds)) => {
            let ready = Ready::Textbook(tree);
            experience.remember(Cost { triangles, seconds, bytes: ready.bytes() as f64 });
            Ok(Ok((ready, Some(seconds))))
        }
        Err(refusal) => {
            // A larger tree would take more than this one, which was not finished.
            let (seconds, bytes) = match refusal {
                Refusal::EndedAt(bytes) => (0.0, bytes),
                Refusal::EndedAfter(seconds) | Refusal::Seconds(seconds) => (seconds, 0.0),
                Refusal::Bytes(bytes) => (0.0, bytes),
            };
            experience.remember(Cost { triangles, seconds, bytes });
            Ok(Err(refusal))
        }
    }
}

/// Each engine casts its share of the rays, and they must agree on those that they share.
fn take_turns(
    contenders: &mut [Contender],
    rays: &[Ray],
    observer: &dyn Observer,
) -> Result<Vec<Vec<Hit>>> {
    let mut answers: Vec<Vec<Hit>> = Vec::new();
    for contender in contenders {
        let rays = &rays[..contender.batch.min(rays.len())];
        if rays.is_empty() {
            continue;
        }
        let hits = contender.take_turn(rays, observer)?;
        if let Some(others) = answers.first()
            && let Some(i) = (0..hits.len().min(others.len())).find(|&i| hits[i] != others[i])
        {
            let ray = rays[i];
            let name = contender.engine.title();
            let reason = format!("{name} and another engine differ on {ray:?}");
            return Err(Error::invalid("halfline failed its own study", reason));
        }
        answers.push(hits);
    }
    Ok(answers)
}

impl Contender<'_> {
    /// Casts ever more rays until their time tells something, and finds how many to cast in a turn.
    fn warm_up(
        &mut self,
        rays: &[Ray],
        settings: &Settings,
        history: &History,
        observer: &dyn Observer,
    ) -> Result<()> {
        let wanted = settings.turn_seconds;
        let fewest = settings.fewest_rays.div_ceil(settings.turns).min(rays.len());
        if let (Ready::BruteForce(mesh), Some(pair)) = (&self.ready, history.brute_pair) {
            let rays = fewest * settings.turns;
            if rays as f64 * mesh.triangle_count() as f64 * pair * 1e-9 > settings.brute_seconds {
                self.batch = 0;
                return Ok(());
            }
        }
        let mut cast = 0;
        let mut next = 1;
        let started = Stopwatch::start();
        while cast < rays.len() && (cast == 0 || started.seconds() < wanted / 4.0) {
            let end = (cast + next).min(rays.len());
            self.ready.cast(&rays[cast..end], &mut Visits::default(), observer)?;
            (cast, next) = (end, 2 * next);
        }
        let seconds_a_ray = started.seconds() / cast as f64;
        self.batch = ((wanted / seconds_a_ray) as usize).clamp(fewest, rays.len());
        Ok(())
    }

    fn take_turn(&mut self, rays: &[Ray], observer: &dyn Observer) -> Result<Vec<Hit>> {
        let started = Stopwatch::start();
        let hits = self.ready.cast(rays, &mut self.visits, observer)?;
        self.turns.push(started.seconds() * 1e9 / rays.len() as f64);
        Ok(hits)
    }

    fn finish(mut self, mesh: &Mesh, turns: &[&[Ray]], history: &mut History) -> Measurement {
        let triangles = mesh.triangle_count();
        let rays = self.batch * self.turns.len();
        let timed: Vec<Ray> =
            turns[1..].iter().flat_map(|turn| &turn[..self.batch]).copied().collect();
        if let Some(visits) = self.ready.count(&timed) {
            self.visits = visits;
        }
        let mean = |count: u64| count as f64 / rays.max(1) as f64;
        let cost = if self.batch == 0 {
            let nanoseconds = history.brute_pair.unwrap_or(f64::NAN) * triangles as f64;
            RayCost {
                rays: 0,
                nodes: 0.0,
                leaves: 0.0,
                triangles: triangles as f64,
                nanoseconds,
                range: [nanoseconds; 2],
                extrapolated: true,
            }
        } else {
            self.turns.sort_by(f64::total_cmp);
            RayCost {
                rays,
                nodes: mean(self.visits.nodes - self.visits.leaves),
                leaves: mean(self.visits.leaves),
                triangles: mean(self.visits.triangles),
                nanoseconds: median(&self.turns),
                range: [self.turns[0], self.turns[self.turns.len() - 1]],
                extrapolated: false,
            }
        };
        if self.engine == Engine::BruteForce && !cost.extrapolated {
            history.brute_pair = Some(cost.nanoseconds / triangles as f64);
        }
        let has_tree = self.engine != Engine::BruteForce;
        Measurement {
            engine: self.engine,
            triangles,
            rays: Some(cost),
            build_seconds: self.build_seconds,
            bytes: has_tree.then(|| self.ready.bytes()),
            bytes_walked: Some(self.ready.bytes_walked(mesh)),
            refusal: None,
        }
    }
}

/// Of sorted values.
fn median(sorted: &[f64]) -> f64 {
    let middle = sorted.len() / 2;
    match sorted.len() % 2 {
        1 => sorted[middle],
        _ => (sorted[middle - 1] + sorted[middle]) / 2.0,
    }
}
