//! Laws of growth, fitted to measurements.
//!
//! For each law f the curve y = a + b f(n) is found, a and b not negative, that has the least squares of
//! log-residuals: what counts is by which factor it is off, as on log-log paper. Only the logarithm may
//! have a below zero, for log(n / m), as a tree with leaves of m triangles has it, is a logarithm too.
//! Given the ratio of a and b, their size follows from the mean of the residuals; the ratio is sought.
//!
//! Laws are compared by Akaike's criterion, corrected for few points (C. M. Hurvich and C.-L. Tsai,
//! "Regression and Time Series Model Selection in Small Samples", Biometrika 76, 1989): the constant,
//! which has one parameter less, wins where the others are hardly better.

/// How something grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Law {
    /// The cost does not grow.
    Constant,
    /// The cost grows like log n.
    Logarithm,
    /// The cost grows like n^(1/3).
    CubeRoot,
    /// The cost grows like n^(1/2).
    SquareRoot,
    /// The cost grows like n.
    Linear,
}

impl Law {
    /// Every law, the slowest growth first.
    pub const ALL: [Law; 5] =
        [Law::Constant, Law::Logarithm, Law::CubeRoot, Law::SquareRoot, Law::Linear];

    /// The name of the law.
    pub const fn name(self) -> &'static str {
        match self {
            Law::Constant => "constant",
            Law::Logarithm => "log n",
            Law::CubeRoot => "n^(1/3)",
            Law::SquareRoot => "n^(1/2)",
            Law::Linear => "n",
        }
    }

    /// The value of the law at n; the logarithm is that to base 2.
    pub fn at(self, n: f64) -> f64 {
        match self {
            Law::Constant => 1.0,
            Law::Logarithm => n.log2(),
            Law::CubeRoot => n.cbrt(),
            Law::SquareRoot => n.sqrt(),
            Law::Linear => n,
        }
    }
}

/// A law with its curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The law.
    pub law: Law,
    /// What does not grow.
    pub a: f64,
    /// The factor of what grows; 0 for the constant.
    pub b: f64,
    /// By how much measurements are off the curve, as a root mean square: 0.05 for 5 %.
    pub deviation: f64,
    /// The corrected criterion of Akaike; less is better.
    pub aicc: f64,
}

impl Fit {
    /// The curve at n.
    pub fn at(&self, n: f64) -> f64 {
        match self.law {
            Law::Constant => self.a,
            law => self.a + self.b * law.at(n),
        }
    }
}

/// All laws, fitted to the same measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Fits {
    /// The best first.
    pub ranked: Vec<Fit>,
    /// How many measurements there were.
    pub points: usize,
}

/// Fewer tell nothing: with five points the criterion would take a constant for what rises sevenfold.
pub const FEWEST_POINTS: usize = 6;

/// Laws whose criterion is within this of the best one's "have support" beside it (K. P. Burnham and
/// D. R. Anderson, "Model Selection and Multimodel Inference", 2002, section 2.6).
const AS_GOOD: f64 = 4.0;

/// Curves further off than this do not describe what was measured.
const TOO_FAR: f64 = 0.2;

/// Curves that are nearer than this are as good as each other: measurements are no more exact.
const EXACT: f64 = 1e-3;

impl Fits {
    /// Fits all laws to (n, y). `None` for fewer than six points, and where y is not
    /// positive, for it has no logarithm.
    pub fn to(points: &[(f64, f64)]) -> Option<Fits> {
        let is_fit = |&(n, y): &(f64, f64)| n >= 1.0 && y > 0.0 && y.is_finite();
        if points.len() < FEWEST_POINTS || !points.iter().all(is_fit) {
            return None;
        }
        let mut ranked: Vec<Fit> = Law::ALL.iter().map(|&law| fit(law, points)).collect();
        // What does not describe the measurements comes last, however few parameters it has.
        let is_off = |fit: &Fit| fit.deviation > TOO_FAR;
        ranked.sort_by(|x, y| is_off(x).cmp(&is_off(y)).then(x.aicc.total_cmp(&y.aicc)));
        Some(Fits { ranked, points: points.len() })
    }

    /// The law that describes the measurements best.
    pub fn best(&self) -> &Fit {
        &self.ranked[0]
    }

    /// The best, and those that cannot be told from it. A constant is part of all the other curves, so
    /// where it is the best none of them says more.
    pub fn supported(&self) -> &[Fit] {
        if self.best().law == Law::Constant {
            return &self.ranked[..1];
        }
        let limit = self.best().aicc + AS_GOOD;
        let end = self
            .ranked
            .iter()
            .take_while(|fit| fit.aicc <= limit && (fit.deviation <= TOO_FAR || self.none_holds()))
            .count();
        &self.ranked[..end]
    }

    /// True if even the best is too far off.
    pub fn none_holds(&self) -> bool {
        self.best().deviation > TOO_FAR
    }

    /// Which law holds, in words.
    pub fn verdict(&self) -> String {
        let told = |fit: &Fit| format!("{} (±{})", fit.law.name(), percent(fit.deviation));
        if self.none_holds() {
            return format!("none of the five holds, the nearest is {}", told(self.best()));
        }
        let supported = self.supported();
        match supported {
            [best] => {
                let next = &self.ranked[1];
                format!(
                    "{} holds (±{}), {} next (±{})",
                    best.law.name(),
                    percent(best.deviation),
                    next.law.name(),
                    percent(next.deviation)
                )
            }
            [rest @ .., last] => {
                let rest: Vec<String> = rest.iter().map(told).collect();
                format!("{} and {} cannot be told apart", rest.join(", "), told(last))
            }
            [] => unreachable!("the best is as good as itself"),
        }
    }
}

/// 0.034 as `3 %`, and less than a half as it is.
pub fn percent(share: f64) -> String {
    match share * 100.0 {
        p if p >= 0.95 => format!("{p:.0} %"),
        p if p >= 0.05 => format!("{p:.1} %"),
        _ => "0 %".into(),
    }
}

/// The best curve of a law.
fn fit(law: Law, points: &[(f64, f64)]) -> Fit {
    // The curve is c ((1 - w) + w g(n)), where g rises from no less than 0 to 1.
    let ends = |f: fn(f64, f64) -> f64| points.iter().map(|&(n, _)| n).reduce(f).unwrap_or(1.0);
    let (first, last) = (ends(f64::min), ends(f64::max));
    let base = if law == Law::Logarithm { law.at(first) } else { 0.0 };
    let height = (law.at(last) - base).max(f64::MIN_POSITIVE);
    let growth: Vec<f64> = points.iter().map(|&(n, _)| (law.at(n) - base) / height).collect();
    let residuals = |w: f64| {
        let off = |(&(_, y), g): (&(f64, f64), &f64)| y.ln() - ((1.0 - w) + w * g).ln();
        let off: Vec<f64> = points.iter().zip(&growth).map(off).collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let squares: f64 = off.iter().map(|r| (r - mean).powi(2)).sum();
        (squares, mean)
    };
    let w = if law == Law::Constant { 0.0 } else { least(|w| residuals(w).0) };
    let (squares, mean) = residuals(w);

    let (count, scale) = (points.len() as f64, mean.exp());
    let b = if law == Law::Constant { 0.0 } else { scale * w / height };
    let a = scale * (1.0 - w) - b * base;
    let parameters = if law == Law::Constant { 2.0 } else { 3.0 };
    let variance = (squares / count).max(EXACT * EXACT);
    let correction = 2.0 * parameters * (parameters + 1.0) / (count - parameters - 1.0);
    let aicc = count * variance.ln() + 2.0 * parameters + correction;
    Fit { law, a, b, deviation: (squares / count).sqrt(), aicc }
}

/// Where in [0, 1] a function is least: by a grid that is even in log(w / (1 - w)), and from its best
/// place on by the golden section.
fn least(f: impl Fn(f64) -> f64) -> f64 {
    const REACH: f64 = 30.0;
    const STEPS: i32 = 600;
    let weight = |x: f64| 1.0 / (1.0 + (-x).exp());
    let finite = |w: f64| Some(f(w)).filter(|value| value.is_finite()).unwrap_or(f64::INFINITY);
    let at = |i: i32| f64::from(i) * REACH / f64::from(STEPS);
    let best = (-STEPS..=STEPS)
        .min_by(|&i, &j| finite(weight(at(i))).total_cmp(&finite(weight(at(j)))))
        .unwrap_or(0);
    let (mut low, mut high) = (at(best - 1), at(best + 1));
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    for _ in 0..60 {
        let (x, y) = (high - golden * (high - low), low + golden * (high - low));
        if finite(weight(x)) <= finite(weight(y)) { high = y } else { low = x }
    }
    let inner = weight((low + high) / 2.0);
    [0.0, 1.0].into_iter().fold(inner, |w, end| if finite(end) <= finite(w) { end } else { w })
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::geometry::random::Random;

    /// A law at half decades, with noise of the given size.
    fn measured(curve: impl Fn(f64) -> f64, noise: f64, seed: u64) -> Vec<(f64, f64)> {
        let mut random = Random::new(seed, 0);
        (4..15)
            .map(|i| {
                let n = 10f64.powf(f64::from(i) / 2.0).round();
                (n, curve(n) * (noise * random.normal()).exp())
            })
            .collect()
    }

    #[test]
    fn each_law_is_recognised_through_noise() {
        for law in Law::ALL {
            for seed in 0..20 {
                let curve = |n: f64| 5.0 + 3.0 * law.at(n);
                let fits = Fits::to(&measured(curve, 0.02, seed)).unwrap();
                let best = fits.best();
                assert!(fits.supported().iter().any(|fit| fit.law == law), "{law:?}: {fits:#?}");
                // Of five parts in a hundred, or of whatever else AICc may take for noise.
                assert!(best.deviation < 0.04, "{law:?}: {fits:#?}");
                if law != Law::Constant {
                    assert_eq!(fits.supported().len(), 1, "{law:?}: {fits:#?}");
                    let factor = best.b / 3.0;
                    assert!((0.85..1.15).contains(&factor), "{law:?}: {best:?}");
                }
                assert!(!fits.none_holds());
            }
        }
    }

    #[test]
    fn a_constant_is_told_by_its_parameter_that_is_not_there() {
        let wins = (0..100)
            .filter(|&seed| {
                Fits::to(&measured(|_| 7.0, 0.03, seed)).unwrap().best().law == Law::Constant
            })
            .count();
        assert!(wins >= 80, "{wins} of 100");
    }

    #[test]
    fn the_logarithm_may_begin_late() {
        // A tree with leaves of fifty triangles.
        let fits = Fits::to(&measured(|n| (n / 50.0).log2(), 0.0, 0)).unwrap();
        let best = fits.best();
        assert_eq!(best.law, Law::Logarithm);
        assert!((best.b - 1.0).abs() < 1e-6 && (best.a + 50f64.log2()).abs() < 1e-5, "{best:?}");
        assert!(best.deviation < 1e-6);
    }

    #[test]
    fn what_is_alike_is_not_told_apart() {
        // Over a single octave the roots and the logarithm are the same but for a hundredth.
        let mut random = Random::new(3, 0);
        let points: Vec<(f64, f64)> = (0..8)
            .map(|i| {
                let n = 1000.0 * 2f64.powf(f64::from(i) / 7.0);
                (n, (2.0 + n.cbrt()) * (0.02 * random.normal()).exp())
            })
            .collect();
        let fits = Fits::to(&points).unwrap();
        let laws: Vec<Law> = fits.supported().iter().map(|fit| fit.law).collect();
        assert!(laws.contains(&Law::CubeRoot) && laws.contains(&Law::SquareRoot), "{fits:#?}");
        assert!(!laws.contains(&Law::Constant));
        assert!(fits.verdict().ends_with("cannot be told apart"), "{}", fits.verdict());
    }

    #[test]
    fn a_law_that_is_none_of_the_five_is_said_to_be_none() {
        let fits = Fits::to(&measured(|n| n * n, 0.0, 0)).unwrap();
        assert!(fits.none_holds());
        assert!(fits.verdict().starts_with("none of the five holds, the nearest is n (±"));
    }

    #[test]
    fn what_is_exact_goes_to_the_law_itself() {
        let fits = Fits::to(&measured(|n| n, 0.0, 0)).unwrap();
        assert_eq!((fits.best().law, fits.supported().len()), (Law::Linear, 1));
        assert!(
            fits.verdict().starts_with("n holds (±0 %), n^(1/2) next (±"),
            "{}",
            fits.verdict()
        );
    }

    #[test]
    fn few_points_are_not_taken_for_a_constant() {
        let points = &measured(|n| 100.0 + n.sqrt(), 0.05, 1)[..FEWEST_POINTS];
        let fits = Fits::to(points).unwrap();
        assert!(fits.best().law != Law::Constant && !fits.none_holds(), "{fits:#?}");
    }

    #[test]
    fn too_little_is_not_fitted() {
        let points = measured(|n| n, 0.0, 0);
        assert!(Fits::to(&points[..FEWEST_POINTS - 1]).is_none());
        assert!(Fits::to(&points[..FEWEST_POINTS]).is_some());
        let zero: Vec<_> = points.iter().map(|&(n, _)| (n, 0.0)).collect();
        assert!(Fits::to(&zero).is_none());
    }
}
