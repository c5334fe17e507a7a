//! `halfline study`: what a ray costs, as meshes grow.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use anstyle::Style;
use clap::Args;
use halfline::Error;
use halfline::progress::Stage;
use halfline_io::models::Kind;
use halfline_study::{self as study, Budget, Family, Origin, Settings, Study};
use serde::Serialize;
use serde_json::Value;

use crate::failure::Failure;
use crate::report::{self, Report};
use crate::session::Session;
use crate::source::MeshSource;
use crate::{input, output, session, units, values};

const EXAMPLES: &str = "\
Brute force, the lecture's kd-tree (split in the middle, at the median, by the surface-area
heuristic) and halfline answer the same rays, one thread each, on meshes of 10^2 to 10^7 triangles.
Nodes, leaves and triangles that a ray visits are counted, its time is taken, and laws of growth are
fitted to both. The report says which law holds, where the cache ends, and how much of a picture's
time is intersection. docs/study.md says what is in study.csv, and how it was measured.

Examples:
  halfline study --quick
  halfline study --output report
  halfline study scan.ply --output report
  halfline study --family scan,hall --sizes 1k,10k,100k --json";

/// The options of `halfline study`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// Study this mesh: itself, random samples of its triangles, and its triangles cut into four again and
    /// again; - is standard input
    #[arg(value_name = "MESH")]
    mesh: Option<PathBuf>,

    /// Families of generated meshes to study instead; see halfline generate --help [default:
    /// scan,soup,layers,sticks]
    #[arg(long, value_name = "KIND,...", value_delimiter = ',', conflicts_with = "mesh")]
    #[arg(value_parser = values::named(Kind::ALL, |kind| (kind.name(), kind.description())))]
    #[arg(hide_possible_values = true)]
    family: Vec<Kind>,

    /// Smaller meshes and fewer rays: less than a minute, where all takes a quarter of an hour
    #[arg(long)]
    quick: bool,

    /// Numbers of triangles, each of which may end in k or M
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = values::count)]
    sizes: Vec<usize>,

    /// Seconds that each of the textbook's trees may take to build; those that would take longer are left
    /// out [default: 45, or 1 with --quick]
    #[arg(long, value_name = "SECONDS", value_parser = values::within(0.0, f64::INFINITY, false))]
    budget: Option<f64>,

    /// The folder for study.csv, study.html and study.svg, which is made if need be
    #[arg(short, long, value_name = "FOLDER", default_value = "study")]
    output: PathBuf,
}

/// Studies, and writes what came of it.
pub fn run(options: &Options, session: Session) -> Result<(), Failure> {
    check_folder(&options.output)?;
    match &options.mesh {
        None => {
            let families = match &options.family[..] {
                [] => Family::USUAL.to_vec(),
                kinds => kinds.to_vec(),
            };
            study_and_tell(options, families.into_iter().map(Family::Generated).collect(), session)
        }
        Some(path) => {
            let (source, _) = MeshSource::open(path, &Default::default(), &session)?;
            source.guarded(|| {
                let mesh = Arc::new(source.mesh().clone());
                let path = input::name(path);
                let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into();
                study_and_tell(options, vec![Family::Own { name, mesh }], session)
            })
        }
    }
}

fn study_and_tell(
    options: &Options,
    families: Vec<Family>,
    session: Session,
) -> Result<(), Failure> {
    let mut settings = match options.quick {
        true => Settings::quick(families),
        false => Settings::full(families),
    };
    if !options.sizes.is_empty() {
        settings.sizes = options.sizes.clone();
    }
    if let Some(seconds) = options.budget {
        settings.budget = Budget { seconds, ..settings.budget };
    }
    let (study, study_seconds) =
        session.timed_as(Stage::Trace, "study", |observer| study::study(&settings, observer))?;

    let folder = &options.output;
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
    let write = |name: &str, text: &str| {
        output::write(&folder.join(name), session.observer(), |file| {
            std::io::Write::write_all(file, text.as_bytes())
        })
    };
    let origin = Origin {
        command_line: command_line(),
        version: env!("CARGO_PKG_VERSION").into(),
        unix_seconds: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs()),
        seconds: study_seconds,
        is_quick: options.quick,
    };
    write("study.csv", &study::csv(&study))?;
    write("study.svg", &study::svg(&study))?;
    write("study.html", &study::html(&study, &origin))?;

    session.tell(&StudyReport {
        output: report::name(folder),
        quick: options.quick,
        study_seconds,
        peak_memory_bytes: session::peak_memory_bytes(),
        figures: study::figures(&study),
        study: &study,
        folder,
    })
}

/// What a study found, and what it took.
#[derive(Serialize)]
struct StudyReport<'a> {
    output: Cow<'a, str>,
    quick: bool,
    study_seconds: f64,
    peak_memory_bytes: Option<u64>,
    #[serde(flatten)]
    figures: Value,
    #[serde(skip)]
    study: &'a Study,
    #[serde(skip)]
    folder: &'a Path,
}

impl Report for StudyReport<'_> {
    const IS_THE_RESULT: bool = true;

    fn to_text(&self) -> String {
        text(self.study, self.study_seconds, self.folder)
    }
}

/// Fails now if there could be no files in the folder after a quarter of an hour; leaves nothing behind.
fn check_folder(folder: &Path) -> Result<(), Failure> {
    // What has to be made for that is taken away again, the innermost folder first.
    let missing: Vec<&Path> = folder
        .ancestors()
        .take_while(|path| !path.as_os_str().is_empty() && !path.exists())
        .collect();
    let made = std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, error).into());
    let checked = made.and_then(|()| {
        ["study.csv", "study.html", "study.svg"]
            .iter()
            .try_for_each(|name| output::check(&folder.join(name), &[]))
    });
    for path in missing {
        let _ = std::fs::remove_dir(path);
    }
    checked
}

/// The command as it was given, without the folder in which the program lies.
fn command_line() -> String {
    let arguments: Vec<String> =
        std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into()).collect();
    format!("halfline {}", arguments.join(" "))
}

fn text(study: &Study, seconds: f64, folder: &Path) -> String {
    let bold = Style::new().bold();
    let mut text = String::new();
    for section in study::sections(study) {
        text += &format!("{bold}{}{bold:#}\n{}\n", section.heading, section.body);
    }
    let html = folder.join("study.html");
    text + &format!("{} in {}\n", html.display(), units::seconds(seconds))
}
