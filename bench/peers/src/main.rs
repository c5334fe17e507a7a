//! halfline against Embree: same meshes, same rays, in turns.
//!
//! `peers LIBEMBREE4 OUT.json [--rounds=N] [--rays=N] [--threads=N] [--only=RAYS,...]
//! [--rivals=all|embree|none] [--count=1] NAME=MESH...`
//!
//! MESH is a file, or `scan:1000` for a generated mesh of so many triangles. An array of 32-byte
//! rays goes in, and an array of t and face, or of booleans, that was written to before comes out,
//! inside of what is timed. Embree is taken in every configuration (quality, robust or not, single
//! rays or packets of 4, 8 or 16). obvhs, a Rust crate, is asked too,
//! and tinybvh if the feature `tinybvh` is on. Where HALFLINE_SIMD forces an
//! instruction set upon halfline, Embree uses the same.
//!
//! All times go to OUT.json as they are; `peers.py` puts those of several launches together.
//! Without rivals, halfline's rates are printed, in doubles too: for work on the engine.

mod clock;
mod embree;
mod measure;
mod memory;
mod obvhs_peer;
mod packets;
mod rays;
#[cfg(feature = "tinybvh")]
mod tinybvh_peer;
mod tools;
mod transpose;

use std::path::Path;

use clock::Clock;
use embree::Embree;
use halfline::Level;
use measure::Plan;
use tools::Rivals;

#[global_allocator]
static ALLOCATOR: memory::Counted = memory::Counted;

const USAGE: &str = "usage: peers LIBEMBREE4 OUT.json [--rounds=N] [--rays=N] [--threads=N] \
    [--only=RAYS,...] [--rivals=all|embree|none] [--count=1] NAME=MESH...";

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(2);
    }
}

fn run() -> Result<(), String> {
    let mut arguments = std::env::args().skip(1);
    let (Some(library), Some(out)) = (arguments.next(), arguments.next()) else {
        return Err(USAGE.into());
    };
    let mut plan = Plan::default();
    let mut meshes = Vec::new();
    for argument in arguments {
        let (name, value) = argument.split_once('=').ok_or(USAGE)?;
        let number = || value.parse::<usize>().map_err(|_| format!("{name}: not a number"));
        match name {
            "--rounds" => plan.rounds = number()?,
            "--rays" => plan.most = number()?,
            "--threads" => plan.threads = number()?,
            "--only" => plan.only = value.split(',').map(String::from).collect(),
            "--rivals" => plan.rivals = Rivals::named(value).ok_or(USAGE)?,
            "--count" => plan.is_counted = number()? != 0,
            _ if name.starts_with('-') => return Err(USAGE.into()),
            _ => meshes.push((name.to_string(), value.to_string())),
        }
    }
    let level = Level::chosen().map_err(|error| error.to_string())?;
    let is_forced = std::env::var_os("HALFLINE_SIMD").is_some_and(|value| !value.is_empty());
    let embree = Embree::open(Path::new(&library), is_forced.then_some(level))
        .map_err(|error| error.to_string())?;
    rayon::ThreadPoolBuilder::new()
        .num_threads(plan.threads)
        .build_global()
        .map_err(|error| error.to_string())?;
    let mut measured = Vec::new();
    for (name, mesh) in &meshes {
        measured.push(measure::measure(name, mesh, &embree, &plan)?);
    }
    let answer = serde_json::json!({
        "processor": processor(),
        "instruction_sets": { "halfline": level.name(), "embree": embree.instruction_set() },
        "embree_version": embree.version(),
        "threads": plan.threads,
        "clock": Clock::of(plan.threads).name(),
        "meshes": measured,
    });
    std::fs::write(&out, format!("{answer:#}\n")).map_err(|error| format!("{out}: {error}"))
}

/// What the processor calls itself, where Linux tells.
fn processor() -> Option<String> {
    let told = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = told.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_string())
}
