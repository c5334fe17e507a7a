//! What a study found out, a sentence for each thing.

use halfline::explain::Rule;

use super::cache::{CacheEnd, DEARER};
use super::engine::Engine;
use super::fit::{Fits, Law, percent};
use super::growth::Quantity;
use super::measure::Measurement;
use super::{FamilyStudy, LECTURE_SIZES, Study};
use halfline_explain::units::{bytes, count, figure, nanoseconds};

/// The best of the textbook's trees.
const SURFACE_AREA: Engine = Engine::Textbook(Rule::SurfaceArea);

/// One thing that was found out.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What it is about, in a word or two.
    pub topic: String,
    /// What was found, in one sentence.
    pub text: String,
}

impl Study {
    /// The handful of things that matter, the most important first. All but the last two are of the
    /// first family.
    pub fn findings(&self) -> Vec<Finding> {
        let first = self.families.first();
        let of_first = |text: fn(&FamilyStudy) -> Option<String>| first.and_then(text);
        let all = [
            ("speed-up", of_first(FamilyStudy::speed_up_text)),
            ("time", of_first(FamilyStudy::time_text)),
            ("steps", of_first(FamilyStudy::steps_text)),
            ("memory", first.and_then(|family| self.memory_text(family))),
            ("the 95 %", self.share_text()),
            ("families", self.families_text()),
        ];
        let told = |(topic, text): (&str, Option<String>)| {
            Some(Finding { topic: topic.into(), text: text? })
        };
        all.into_iter().filter_map(told).collect()
    }

    fn share_text(&self) -> Option<String> {
        self.shares.first()?;
        let each = self.shares.iter().map(|shares| {
            format!("{} {}", percent_of(shares.intersection()), by_whom(shares.engine))
        });
        Some(format!("Of a picture's time intersection takes {}.", listed(each)))
    }

    fn families_text(&self) -> Option<String> {
        if self.families.len() < 2 {
            return None;
        }
        let mut is_extrapolated = false;
        let each: Vec<String> = self
            .families
            .iter()
            .filter_map(|family| {
                let largest = family.samples.last()?.triangles;
                let found = family.speed_up(Engine::Fast, largest)?;
                is_extrapolated |= found.brute.extrapolated;
                let (factor, name) = (figure(found.factor()), family.family.name());
                Some(format!("{factor} times on {name}"))
            })
            .collect();
        let reservation = if is_extrapolated { " (brute force extrapolated)" } else { "" };
        (!each.is_empty()).then(|| {
            format!(
                "At the largest size halfline is quicker than brute force {}{reservation}.",
                listed(each)
            )
        })
    }

    /// From which size on memory is what a visit costs.
    fn memory_text(&self, family: &FamilyStudy) -> Option<String> {
        let caches = self.machine.caches.iter().filter(|cache| cache.level > 1);
        let caches: Vec<String> =
            caches.map(|cache| format!("L{} {}", cache.level, bytes(cache.bytes))).collect();
        let told = |found: CacheEnd| {
            let (largest, factor) = found.largest;
            let whom = by_whom(found.engine);
            match found.end {
                Some(end) => format!(
                    "from {} on {whom}, {} times at {} triangles",
                    bytes(end.bytes as u64),
                    figure(factor),
                    count(largest as u64)
                ),
                None => format!("never up to {} triangles {whom}", count(largest as u64)),
            }
        };
        let engines = [SURFACE_AREA, Engine::Fast];
        let each: Vec<String> =
            engines.into_iter().filter_map(|engine| family.cache_end(engine)).map(told).collect();
        let known = match caches.is_empty() {
            true => String::new(),
            false => format!(" ({})", caches.join(", ")),
        };
        (!each.is_empty()).then(|| {
            format!(
                "A visit costs {DEARER} times its least or more {}{known}.",
                each.join(", and ")
            )
        })
    }

    /// Which trees were not built, and from which size on.
    pub fn left_out_text(&self) -> Option<String> {
        let of_family = |family: &FamilyStudy| {
            let first = |engine: Engine| {
                let refused = family.samples.iter().find(|sample| {
                    let is_refused = |m: &Measurement| m.engine == engine && m.refusal.is_some();
                    sample.measurements.iter().any(is_refused)
                })?;
                Some(format!("{} from {}", engine.title(), count(refused.triangles as u64)))
            };
            let all: Vec<String> = Engine::ALL.into_iter().filter_map(first).collect();
            (!all.is_empty()).then(|| format!("{}: {}", family.family.name(), all.join(", ")))
        };
        let all: Vec<String> = self.families.iter().filter_map(of_family).collect();
        (!all.is_empty()).then(|| {
            format!(
                "Left out, for they would take too long to build, or too much memory: {}.",
                all.join("; ")
            )
        })
    }
}

impl FamilyStudy {
    /// How many times quicker than brute force the two best trees are at the lecture's sizes.
    fn speed_up_text(&self) -> Option<String> {
        let at = |n: usize| {
            let fast = self.speed_up(Engine::Fast, n)?;
            let about = if fast.is_extrapolated() { "about " } else { "" };
            let mut text = format!(
                "at {} triangles halfline is {about}{} times quicker than brute force ({} a ray \
                 instead of {})",
                count(n as u64),
                figure(fast.factor()),
                nanoseconds(fast.tree.nanoseconds),
                nanoseconds(fast.brute.nanoseconds),
            );
            if let Some(textbook) = self.speed_up(SURFACE_AREA, n) {
                let about = if textbook.is_extrapolated() { "about " } else { "" };
                text += &format!(
                    " and the textbook's SAH tree {about}{} times",
                    figure(textbook.factor())
                );
            }
            Some(text)
        };
        let texts: Vec<String> = LECTURE_SIZES.into_iter().filter_map(at).collect();
        (!texts.is_empty()).then(|| format!("On {} {}.", self.family.name(), texts.join("; ")))
    }

    fn time_text(&self) -> Option<String> {
        let engines = [Engine::BruteForce, SURFACE_AREA, Engine::Fast];
        let laws = self.laws_text(&engines, Quantity::Time)?;
        Some(format!("On {} the time of a ray grows {laws}.", self.family.name()))
    }

    fn steps_text(&self) -> Option<String> {
        let laws = self.laws_text(&[SURFACE_AREA, Engine::Fast], Quantity::Steps)?;
        Some(format!("On {} the nodes and leaves of a ray grow {laws}.", self.family.name()))
    }

    /// How a quantity grows, engine by engine: "like n by brute force (±3 %) and like log n with halfline
    /// (±1 %; n^(1/3) fits as well)".
    fn laws_text(&self, engines: &[Engine], quantity: Quantity) -> Option<String> {
        let each: Vec<String> = engines
            .iter()
            .filter_map(|&engine| Some(law_text(engine, &self.growth(engine, quantity).fits?)))
            .collect();
        (!each.is_empty()).then(|| listed(each))
    }

    /// What theory says about random triangles, and whether it is so.
    pub fn theory_text(&self) -> Option<String> {
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
        let [from, to] = [tests[0].0, tests[tests.len() - 1].0].map(|n| count(n as u64));
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

/// Which law holds for an engine, and which others fit as well.
fn law_text(engine: Engine, fits: &Fits) -> String {
    let (best, whom) = (fits.best(), by_whom(engine));
    let (name, deviation) = (best.law.name(), percent(best.deviation));
    if fits.none_holds() {
        return format!("by none of the five laws {whom} ({name} is nearest, ±{deviation})");
    }
    let others: Vec<&str> = fits.supported()[1..].iter().map(|fit| fit.law.name()).collect();
    let as_well = match others[..] {
        [] => String::new(),
        [other] => format!("; {other} fits as well"),
        _ => format!("; {} fit as well", listed(others)),
    };
    match best.law {
        Law::Constant => format!("not at all {whom} (±{deviation})"),
        _ => format!("like {name} {whom} (±{deviation}{as_well})"),
    }
}

/// The engine, at the end of a clause.
fn by_whom(engine: Engine) -> String {
    match engine {
        Engine::BruteForce => "by brute force".into(),
        SURFACE_AREA => "with the textbook's SAH tree".into(),
        Engine::Textbook(rule) => format!("with the textbook's {rule} tree"),
        Engine::Fast => "with halfline".into(),
    }
}

/// `a, b and c`.
fn listed(parts: impl IntoIterator<Item = impl ToString>) -> String {
    let parts: Vec<String> = parts.into_iter().map(|part| part.to_string()).collect();
    match &parts[..] {
        [] => String::new(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

/// 0.9991 as `99.9 %`.
pub fn percent_of(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_is_told_in_one_clause() {
        let told = |curve: fn(f64) -> f64| {
            let points: Vec<(f64, f64)> =
                (4..15).map(|i| 10f64.powf(f64::from(i) / 2.0)).map(|n| (n, curve(n))).collect();
            law_text(Engine::Fast, &Fits::to(&points).unwrap())
        };
        assert_eq!(told(|n| 5.0 + n.log2()), "like log n with halfline (±0 %)");
        assert_eq!(told(|_| 7.0), "not at all with halfline (±0 %)");
        let none = told(|n| n * n);
        assert!(
            none.starts_with("by none of the five laws with halfline (n is nearest, ±"),
            "{none}"
        );

        // Over a single octave nothing tells the roots apart.
        let points: Vec<(f64, f64)> = (0..8)
            .map(|i| 1000.0 * 2f64.powf(f64::from(i) / 7.0))
            .enumerate()
            .map(|(i, n)| (n, (2.0 + n.cbrt()) * if i % 2 == 0 { 1.02 } else { 0.98 }))
            .collect();
        let open = law_text(Engine::BruteForce, &Fits::to(&points).unwrap());
        assert!(open.starts_with("like ") && open.ends_with(" fit as well)"), "{open}");
        assert_eq!(open.matches(" by brute force (±2 %; ").count(), 1, "{open}");
    }
}
