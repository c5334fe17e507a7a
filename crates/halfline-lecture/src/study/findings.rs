//! What a study found out, in sentences.

use super::cache::DEARER;
use super::engine::Engine;
use super::fit::{Fits, percent};
use super::growth::Quantity;
use super::measure::Measurement;
use super::speedup::SpeedUp;
use super::units::{bytes, count, figure, nanoseconds};
use super::{FamilyStudy, LECTURE_SIZES, Study};

/// Of whom sentences tell: halfline, and the best of the textbook's trees.
const BEST: [Engine; 2] = [Engine::Fast, Engine::SurfaceArea];

/// One thing that was found out.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What it is about, in a word or two.
    pub topic: String,
    /// It.
    pub text: String,
}

impl Study {
    /// All of it, the most important first.
    pub fn findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut tell = |topic: &str, text: Option<String>| {
            findings.extend(text.map(|text| Finding { topic: topic.into(), text }));
        };
        if let Some(first) = self.families.first() {
            tell("speed-up", self.speed_up_text(first));
        }
        tell("the 95 %", self.share_text());
        for family in &self.families {
            tell(family.family.name(), family.growth_text());
        }
        for family in self.families.iter().filter(|family| family.family.is_uniform_soup()) {
            tell("theory", family.theory_text());
        }
        for family in &self.families {
            let topic = format!("memory, {}", family.family.name());
            tell(&topic, self.cache_text(family));
        }
        tell("left out", self.left_out_text());
        findings
    }

    fn speed_up_text(&self, family: &FamilyStudy) -> Option<String> {
        let told = |n: usize| {
            let all = BEST.map(|engine| family.speed_up(engine, n));
            let [fast, textbook] = all;
            let fast = fast?;
            let mut text = format!(
                "at {} triangles halfline is {} times quicker than brute force ({} instead of {} a ray{})",
                count(n),
                figure(fast.factor()),
                nanoseconds(fast.tree.nanoseconds),
                nanoseconds(fast.brute.nanoseconds),
                reservation(&fast)
            );
            if let Some(textbook) = textbook {
                text += &format!(
                    ", the textbook's SAH tree {} times{}",
                    figure(textbook.factor()),
                    if textbook.tree.extrapolated { " (by its law)" } else { "" }
                );
            }
            Some(text)
        };
        let texts: Vec<String> = LECTURE_SIZES.into_iter().filter_map(told).collect();
        (!texts.is_empty()).then(|| format!("{}: {}.", family.family.name(), texts.join("; ")))
    }

    fn share_text(&self) -> Option<String> {
        let first = self.shares.first()?;
        let each = self.shares.iter().map(|shares| {
            format!("{} with {}", percent_of(shares.intersection()), shares.engine.title())
        });
        let each: Vec<String> = each.collect();
        Some(format!(
            "Of a picture's time ({} triangles, Whitted's shading, one ray a pixel) intersection takes {}. \
             The lecture's 95 % is for brute force, and a tree is what changes it.",
            count(first.triangles),
            each.join(", ")
        ))
    }

    fn cache_text(&self, family: &FamilyStudy) -> Option<String> {
        let level = |level: u32| match self.machine.cache_bytes(level) {
            Some(size) => format!("L{level} is {}", bytes(size)),
            None => format!("L{level} is unknown"),
        };
        let caches = format!("{}, {}", level(2), level(3));
        let told = |engine: Engine| {
            let found = family.cache_end(engine)?;
            let (largest, factor) = found.largest;
            let (name, floor) = (engine.title(), nanoseconds(found.floor));
            Some(match found.end {
                Some(end) => format!(
                    "{name}: from {} on ({caches}) a visit costs more than {DEARER} times its least, \
                     {floor}; at {} triangles {} times. That is memory, not the algorithm.",
                    bytes(end.bytes),
                    count(largest),
                    figure(factor)
                ),
                None => format!(
                    "{name}: up to {} triangles no visit costs {DEARER} times its least, {floor}.",
                    count(largest)
                ),
            })
        };
        let told: Vec<String> = BEST.into_iter().filter_map(told).collect();
        (!told.is_empty()).then(|| told.join(" "))
    }

    fn left_out_text(&self) -> Option<String> {
        let of_family = |family: &FamilyStudy| {
            let first = |engine: Engine| {
                let refused = family.samples.iter().find(|sample| {
                    let is_refused = |m: &Measurement| m.engine == engine && m.refusal.is_some();
                    sample.measurements.iter().any(is_refused)
                })?;
                Some(format!("{} from {}", engine.title(), count(refused.triangles)))
            };
            let all: Vec<String> = Engine::ALL.into_iter().filter_map(first).collect();
            (!all.is_empty()).then(|| format!("{}: {}", family.family.name(), all.join(", ")))
        };
        let all: Vec<String> = self.families.iter().filter_map(of_family).collect();
        (!all.is_empty()).then(|| {
            format!(
                "Trees that would take too long to build, or too much memory: {}.",
                all.join("; ")
            )
        })
    }
}

impl FamilyStudy {
    /// How counts and time of the two best trees grow.
    fn growth_text(&self) -> Option<String> {
        let told = |engine: Engine| {
            let verdict = |quantity| Some(self.growth(engine, quantity).fits?.verdict());
            let steps = verdict(Quantity::Steps)?;
            let triangles = verdict(Quantity::Triangles)?;
            let time = verdict(Quantity::Time)?;
            let name = engine.title();
            Some(format!("{name}: steps: {steps}; triangles: {triangles}; time: {time}."))
        };
        let told: Vec<String> = BEST.into_iter().filter_map(told).collect();
        (!told.is_empty()).then(|| told.join(" "))
    }

    /// What theory says about random triangles, and whether it is so.
    fn theory_text(&self) -> Option<String> {
        const FROM: f64 = 10_000.0;
        let engine = Engine::Fast;
        let large = |quantity: Quantity| {
            let mut points = self.points(engine, quantity);
            points.retain(|&(n, _)| n >= FROM);
            (points.len() >= 3).then_some(points)
        };
        let (tests, steps) = (large(Quantity::Triangles)?, large(Quantity::Steps)?);
        let time = large(Quantity::Time)?;
        let rise = |points: &[(f64, f64)]| points[points.len() - 1].1 / points[0].1;
        let [from, to] = [tests[0].0, tests[tests.len() - 1].0].map(|n| count(n as usize));
        let verdict = match (rise(&tests) - 1.0).abs() < 0.15 {
            true => "so it is",
            false => "that is not yet so here, or not with this tree",
        };
        Some(format!(
            "In theory a ray through a uniform soup tests as many triangles in a large one as in a small \
             one (Cleary and Wyvill 1988; Szirmay-Kalos and Márton 1998); only the way down to the first \
             leaf is longer in a deeper tree, like log n. From {from} to {to} triangles {verdict}: halfline \
             tests {} times as many, in {} times the steps. Its time rises {} times: what that is more \
             than steps is memory.",
            figure(rise(&tests)),
            figure(rise(&steps)),
            figure(rise(&time))
        ))
    }
}

/// Which law holds, in few words.
pub fn law_in_short(fits: &Fits) -> String {
    let best = fits.best();
    if fits.none_holds() {
        return format!("none ({} ±{})", best.law.name(), percent(best.deviation));
    }
    let names: Vec<&str> = fits.supported().iter().map(|fit| fit.law.name()).collect();
    format!("{} ±{}", names.join(" or "), percent(best.deviation))
}

/// What is not measured of the two.
fn reservation(speed_up: &SpeedUp) -> &'static str {
    match (speed_up.brute.extrapolated, speed_up.tree.extrapolated) {
        (false, false) => "",
        (true, false) => "; brute force extrapolated",
        (false, true) => "; halfline extrapolated by its law",
        (true, true) => "; both extrapolated",
    }
}

/// 0.9991 as `99.9 %`.
pub fn percent_of(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}
