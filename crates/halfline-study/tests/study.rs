//! A study of small meshes, from end to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use halfline::Mesh;
use halfline::error::Error;
use halfline::explain::Rule;
use halfline::geometry::Vec3;
use halfline::progress::{NoProgress, Observer, Stage};
use halfline_io::models::{Kind, generate};
use halfline_study as study;
use halfline_study::{
    Budget, Engine, Family, Quantity, Refusal, Settings, Study, sampled, study, subdivided,
};

/// As few rays as tell something, and all of them however slow the machine is: nothing here looks at
/// times.
fn tiny(kinds: &[Kind], sizes: &[usize]) -> Settings {
    let families = kinds.iter().copied().map(Family::Generated).collect();
    Settings {
        sizes: sizes.to_vec(),
        turns: 2,
        rays_per_turn: 64,
        turn_seconds: 60.0,
        fewest_rays: 8,
        brute_seconds: 60.0,
        budget: Budget { seconds: 60.0, bytes: 1e9 },
        picture: [8, 6],
        picture_seconds: 0.0,
        ..Settings::quick(families)
    }
}

fn made(settings: &Settings) -> Study {
    study(settings, &NoProgress).unwrap()
}

/// The rows of study.csv, each with its columns' names.
fn rows(study: &Study) -> Vec<std::collections::HashMap<String, String>> {
    let text = study::csv(study);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader.deserialize().map(|row| row.unwrap()).collect()
}

#[test]
fn every_family_engine_and_size_has_its_row() {
    let study = made(&tiny(&[Kind::Scan, Kind::Sticks], &[100, 316, 1000]));
    let rows = rows(&study);
    let mut expected = Vec::new();
    for (family, sizes) in [("scan", ["96", "316", "1000"]), ("sticks", ["100", "316", "1000"])] {
        for n in sizes {
            for engine in ["brute", "middle", "median", "sah", "fast"] {
                expected.push([family, engine, n].map(str::to_owned));
            }
        }
    }
    let got: Vec<[String; 3]> =
        rows.iter().map(|row| ["family", "engine", "n"].map(|name| row[name].clone())).collect();
    assert_eq!(got, expected);

    for row in &rows {
        let figure = |name: &str| row[name].parse::<f64>().unwrap();
        assert!(figure("ns_per_ray") > 0.0, "{row:?}");
        assert!(figure("ns_per_ray_low") <= figure("ns_per_ray"), "{row:?}");
        assert!(figure("ns_per_ray") <= figure("ns_per_ray_high"), "{row:?}");
        assert!((0.3..=1.0).contains(&figure("hit_share")), "{row:?}");
        assert!((8.0..=128.0).contains(&figure("rays")), "{row:?}");
        assert_eq!((row["extrapolated"].as_str(), row["note"].as_str()), ("false", ""));
        let counts = ["nodes_per_ray", "leaves_per_ray", "triangles_per_ray"].map(figure);
        if row["engine"] == "brute" {
            assert_eq!(counts, [0.0, 0.0, figure("n")]);
            assert_eq!(
                (row["build_seconds"].as_str(), row["bytes_per_triangle"].as_str()),
                ("", "")
            );
        } else {
            assert!(counts[1] > 0.0 && counts[2] > 0.0, "{row:?}");
            assert!(figure("build_seconds") > 0.0 && figure("bytes_per_triangle") > 1.0);
        }
    }
}

#[test]
fn counts_are_those_of_the_textbook() {
    // A scan of 12 triangles is a cube, blown up: its tree is small enough to know about.
    let study = made(&tiny(&[Kind::Scan], &[1000]));
    let family = &study.families[0];
    let of = |engine, quantity| family.points(engine, quantity)[0].1;
    for engine in [
        Engine::Textbook(Rule::Middle),
        Engine::Textbook(Rule::Median),
        Engine::Textbook(Rule::SurfaceArea),
    ] {
        let (steps, leaves) = (of(engine, Quantity::Steps), of(engine, Quantity::Leaves));
        // Between any two leaves in a row a ray does not go up to more than the root again.
        assert!(leaves >= 0.8 && steps > leaves && steps < 40.0 * leaves, "{engine:?}");
    }
    // Nodes of eight children are fewer, and leaves hold up to eight triangles.
    assert!(
        of(Engine::Fast, Quantity::Steps)
            < of(Engine::Textbook(Rule::SurfaceArea), Quantity::Steps) / 2.0
    );
    let fill = of(Engine::Fast, Quantity::Triangles) / of(Engine::Fast, Quantity::Leaves);
    assert!((1.0..=8.0).contains(&fill), "{fill}");
}

#[test]
fn what_brute_force_would_not_finish_is_extrapolated_and_marked() {
    let settings = Settings { brute_seconds: 0.0, ..tiny(&[Kind::Soup], &[100, 1000, 3000]) };
    let study = made(&settings);
    let family = &study.families[0];
    let brute: Vec<_> = family.measured(Engine::BruteForce, true).collect();
    let marks: Vec<bool> = brute.iter().map(|(_, cost)| cost.extrapolated).collect();
    assert_eq!(marks, [false, true, true]);
    // A straight line through the origin and what was measured.
    let measured = brute[0].1.nanoseconds;
    for (measurement, cost) in &brute[1..] {
        let expected = measured / 100.0 * measurement.triangles as f64;
        assert!((cost.nanoseconds / expected - 1.0).abs() < 1e-12);
        assert_eq!((cost.rays, cost.triangles), (0, measurement.triangles as f64));
    }
    assert_eq!(family.measured(Engine::BruteForce, false).count(), 1);

    let marked = rows(&study).into_iter().filter(|row| row["extrapolated"] == "true");
    assert!(marked.map(|row| row["engine"].clone()).eq(["brute", "brute"]));
    let text: String = study::sections(&study).iter().map(|s| s.body.clone()).collect();
    assert_eq!(text.matches(" ~").count(), 2 + 1, "{text}");
    // Open markers are white inside.
    let svg = study::svg(&study);
    assert_eq!(svg.matches("fill=\"#fff\" stroke=").count(), 2);
    let speed_up = family.speed_up(Engine::Fast, 3000).unwrap();
    assert!(speed_up.brute.extrapolated && !speed_up.tree.extrapolated);
}

#[test]
fn trees_that_take_too_long_are_left_out_with_the_reason() {
    let budget = Budget { seconds: 1e-6, bytes: 1e12 };
    let settings = Settings { budget, ..tiny(&[Kind::Soup], &[3000, 4000]) };
    let study = made(&settings);
    let refusals = |engine: Engine| {
        let samples = study.families[0].samples.iter();
        samples
            .map(|sample| {
                let measurement = sample.measurements.iter().find(|m| m.engine == engine).unwrap();
                assert_eq!(measurement.rays.is_none(), measurement.refusal.is_some());
                measurement.refusal
            })
            .collect::<Vec<_>>()
    };
    for engine in [
        Engine::Textbook(Rule::Middle),
        Engine::Textbook(Rule::Median),
        Engine::Textbook(Rule::SurfaceArea),
    ] {
        let [first, second] = refusals(engine)[..] else { panic!("two sizes") };
        // The first is tried, for nothing is known before; the second is not even begun.
        assert!(matches!(first, Some(Refusal::EndedAfter(_))), "{first:?}");
        assert!(matches!(second, Some(Refusal::Seconds(_))), "{second:?}");
    }
    assert_eq!(refusals(Engine::Fast), [None, None]);
    let rows = rows(&study);
    let notes = rows.iter().filter(|row| row["note"].starts_with("not built: ")).count();
    assert_eq!((rows.len(), notes), (10, 6));
}

#[test]
fn trees_that_take_too_much_memory_are_left_out() {
    let budget = Budget { seconds: 60.0, bytes: 3e5 };
    let settings = Settings { budget, ..tiny(&[Kind::Soup], &[10, 300]) };
    let study = made(&settings);
    let last = &study.families[0].samples[1];
    let middle =
        last.measurements.iter().find(|m| m.engine == Engine::Textbook(Rule::Middle)).unwrap();
    assert!(matches!(middle.refusal, Some(Refusal::Bytes(bytes)) if bytes > 3e5), "{middle:?}");
}

#[test]
fn the_three_tasks_make_up_the_picture() {
    let study = made(&tiny(&[Kind::Scan], &[100]));
    let engines: Vec<Engine> = study.shares.iter().map(|shares| shares.engine).collect();
    assert_eq!(engines, [Engine::BruteForce, Engine::Textbook(Rule::SurfaceArea), Engine::Fast]);
    for shares in &study.shares {
        let sum: f64 = shares.parts().iter().sum();
        assert!((sum - 1.0).abs() < 1e-12 && shares.parts().iter().all(|part| *part >= 0.0));
        assert_eq!((shares.triangles, shares.resolution), (96, [8, 6]));
        // The same picture, so the same rays: those of the pixels, and some from what they hit.
        assert_eq!(shares.rays, study.shares[0].rays);
        assert!(shares.rays > 48, "{shares:?}");
    }
}

#[test]
fn a_mesh_of_ones_own_is_studied_coarser_and_finer() {
    let mesh = Arc::new(generate(Kind::Scan, 2000, 0, &NoProgress).unwrap());
    let family = Family::Own { name: "my scan.ply".into(), mesh };
    assert_eq!(family.sizes(&[100, 1000, 10_000, 40_000]), [100, 1000, 2000, 8000, 32_000]);
    assert_eq!(family.sizes(&[100, 1000]), [100, 1000, 2000]);
    let settings = Settings { families: vec![family], ..tiny(&[], &[500, 8000]) };
    let study = made(&settings);
    let sizes: Vec<usize> =
        study.families[0].samples.iter().map(|sample| sample.triangles).collect();
    assert_eq!(sizes, [500, 2000, 8000]);
    assert_eq!(study.shares[0].triangles, 2000);
    // The surface is the same, so rays hit the finer one as often, and the sample less often.
    let hits: Vec<f64> = study.families[0].samples.iter().map(|s| s.hit_share).collect();
    assert!(hits[0] < hits[1], "{hits:?}");
}

#[test]
fn a_mesh_without_anything_to_hit_is_refused_by_name() {
    let mesh =
        Arc::new(Mesh::new(halfline::mesh::Positions::F32(Vec::new().into()), vec![]).unwrap());
    let families = vec![Family::Own { name: "empty.ply".into(), mesh }];
    let error = study(&Settings { families, ..tiny(&[], &[100]) }, &NoProgress).unwrap_err();
    assert_eq!(error.to_string(), "empty.ply: no triangle that a ray could hit");
}

/// The corners of every triangle, and the area of all.
fn triangles(mesh: &Mesh) -> (Vec<[[f64; 3]; 3]>, f64) {
    let corners: Vec<[Vec3; 3]> =
        (0..mesh.triangle_count() as u32).map(|t| mesh.corners(t)).collect();
    let area = corners.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).length() / 2.0).sum();
    (corners.iter().map(|t| t.map(Vec3::to_array)).collect(), area)
}

#[test]
fn subdivision_keeps_the_surface() {
    let mesh = generate(Kind::Scan, 1000, 0, &NoProgress).unwrap();
    let finer = subdivided(&mesh, &NoProgress).unwrap();
    let ((old, area), (new, new_area)) = (triangles(&mesh), triangles(&finer));
    assert_eq!(new.len(), 4 * old.len());
    // Middles are rounded to single precision, 2^-24 of coordinates up to 1.
    assert!((new_area / area - 1.0).abs() < 1e-6, "{area} {new_area}");
    assert_eq!(finer.bounds(), mesh.bounds());
    // Each old corner is still a corner, and each of the four has a quarter of the area.
    for (old, new) in old.iter().zip(new.chunks(4)) {
        assert_eq!([new[0][0], new[1][1], new[2][2]], *old);
    }
    // Closed by position: every edge runs once each way.
    let mut edges = std::collections::HashMap::new();
    for t in &new {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let bits = |p: [f64; 3]| p.map(f64::to_bits);
            *edges.entry((bits(t[a]), bits(t[b]))).or_insert(0) += 1;
        }
    }
    assert!(edges.iter().all(|(&(a, b), &times)| times == 1 && edges.get(&(b, a)) == Some(&1)));
}

#[test]
fn a_sample_is_some_of_the_faces() {
    let mesh = generate(Kind::Scan, 1000, 0, &NoProgress).unwrap();
    let (all, _) = triangles(&mesh);
    for count in [1, 10, 500, 999, 1000] {
        let sample = sampled(&mesh, count, &NoProgress).unwrap();
        let (some, _) = triangles(&sample);
        assert_eq!(some.len(), count);
        let mut rest = all.iter();
        assert!(some.iter().all(|t| rest.any(|other| other == t)), "{count}: in their order");
        let mut used = vec![false; sample.positions().len()];
        sample.triangles().iter().flatten().for_each(|&v| used[v as usize] = true);
        assert!(used.iter().all(|&used| used), "{count}: a vertex is not used");
    }
    // Drawn from all over the mesh.
    let (some, _) = triangles(&sampled(&mesh, 100, &NoProgress).unwrap());
    let places: Vec<usize> =
        some.iter().map(|t| all.iter().position(|other| other == t).unwrap()).collect();
    for quarter in 0..4 {
        let there = places.iter().filter(|&&place| place / 250 == quarter).count();
        assert!((10..=42).contains(&there), "{there} of 100 in quarter {quarter}");
    }
}

/// Asks for the end after a number of looks, and listens.
struct Impatient {
    patience: AtomicU64,
    done: AtomicU64,
}

impl Observer for Impatient {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        assert!(stage == Stage::Trace && done <= total && total == 10_000);
        let before = self.done.fetch_max(done, Ordering::Relaxed);
        assert!(before <= done, "{done} after {before}");
    }

    fn cancelled(&self) -> bool {
        let next = |patience: u64| patience.checked_sub(1);
        self.patience.fetch_update(Ordering::Relaxed, Ordering::Relaxed, next).is_err()
    }
}

#[test]
fn a_study_can_be_ended_at_any_time_and_tells_how_far_it_is() {
    let settings = tiny(&[Kind::Scan, Kind::Layers], &[100, 1000]);
    let ended = |patience| {
        let observer = Impatient { patience: AtomicU64::new(patience), done: AtomicU64::new(0) };
        let outcome = study(&settings, &observer).map(|_| ());
        (outcome, observer.done.into_inner(), observer.patience.into_inner())
    };
    let plenty = 1 << 40;
    let (outcome, done, left) = ended(plenty);
    assert!(outcome.is_ok() && done == 10_000, "{done}");
    let looks = plenty - left;
    assert!(looks > 200, "asked {looks} times alone");
    for part in 0..8 {
        let (outcome, ..) = ended(looks * part / 8);
        assert!(matches!(outcome, Err(Error::Interrupted)), "after {part} of 8: {outcome:?}");
    }
}

#[test]
fn the_page_needs_nothing_else() {
    let study = made(&tiny(&[Kind::Scan, Kind::Soup], &[12, 30, 100, 200, 400, 1000]));
    let origin = study::Origin {
        command_line: "halfline study <&>".into(),
        version: "1.2.3".into(),
        unix_seconds: 0,
        seconds: 1.0,
        is_quick: true,
    };
    let page = study::html(&study, &origin);
    for outside in ["http:", "https:", "src=", "@import", "url(", "<script", "<link"] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("halfline study &lt;&amp;&gt;") && page.contains("1970-01-01"));
    for number in 1..=7 {
        assert!(page.contains(&format!("Figure {number}. ")), "{number}");
    }
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text}"));
    assert!(place("<svg") < place("<h2>Findings"), "the main plot comes first");
    assert!(place("<h2>Findings") < place("Figure 2. "));
    assert!(place("Figure 7. ") < place("best curve"), "laws in full come last");
    for finding in study.findings() {
        assert!(page.contains(&format!("<dt>{}</dt>", finding.topic)), "{finding:?}");
    }
    assert!(!page.contains("NaN") && !page.contains("inf"));
}

#[test]
fn findings_are_a_handful_of_sentences() {
    let study = made(&tiny(&[Kind::Scan, Kind::Soup], &[12, 30, 100, 200, 400, 1000]));
    let findings = study.findings();
    let topics: Vec<&str> = findings.iter().map(|finding| finding.topic.as_str()).collect();
    assert_eq!(topics, ["speed-up", "time", "steps", "memory", "the 95 %", "families"]);
    for finding in findings {
        let text = &finding.text;
        assert!(text.ends_with('.') && text.matches(". ").count() == 0, "{text}");
        assert!(text.contains(|c: char| c.is_ascii_digit()) && text.len() < 400, "{text}");
    }
    let alone = made(&tiny(&[Kind::Scan], &[12, 30, 100, 200, 400, 1000]));
    assert!(alone.findings().iter().all(|finding| finding.topic != "families"));
    let few = made(&tiny(&[Kind::Scan], &[12, 30]));
    assert!(
        few.findings().iter().all(|finding| finding.topic != "time"),
        "no law is fitted to two"
    );

    // The text begins with the first family's table, and ends with the laws.
    let headings: Vec<String> = study::sections(&study).into_iter().map(|s| s.heading).collect();
    let beginnings = ["scan: one", "Findings", "soup: random", "scan: how it", "soup: how it"];
    assert_eq!(headings.len(), beginnings.len());
    for (heading, beginning) in headings.iter().zip(beginnings) {
        assert!(heading.starts_with(beginning), "{headings:?}");
    }
}

#[test]
fn lines_of_the_text_are_short() {
    let study = made(&tiny(&[Kind::Scan, Kind::Layers], &[12, 30, 100, 200, 400, 1000]));
    for section in study::sections(&study) {
        for line in section.body.lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
    }
}
