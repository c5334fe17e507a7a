//! The tools, each with its tree, and all ways to ask them.

use halfline::progress::NoProgress;
use halfline::{HitF32, Mesh, RayF32, Scene};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::clock::Clock;
use crate::embree::{self, Embree, Quality, SingleMesh};
use crate::memory::peak_of;
use crate::obvhs_peer::{Obvhs, Tree};
use crate::packets::ALL_PACKETS;
#[cfg(feature = "tinybvh")]
use crate::tinybvh_peer::{self, TinyBvh};

/// Rays of one task of a rival; halfline divides a batch by itself.
const PART: usize = 4096;

/// Who is asked besides halfline.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Rivals {
    All,
    /// Embree alone, and not in its robust mode.
    Embree,
    None,
}

impl Rivals {
    pub fn named(name: &str) -> Option<Rivals> {
        match name {
            "all" => Some(Rivals::All),
            "embree" => Some(Rivals::Embree),
            "none" => Some(Rivals::None),
            _ => None,
        }
    }
}

/// A tool, ready to be asked.
pub enum Tool<'a> {
    Halfline(Box<Scene>),
    Embree {
        scene: embree::Scene<'a>,
        quality: Quality,
        is_robust: bool,
    },
    Obvhs(Box<Obvhs>),
    #[cfg(feature = "tinybvh")]
    TinyBvh(TinyBvh),
}

/// A built tool, and what its tree cost.
pub struct Built<'a> {
    pub tool: Tool<'a>,
    pub name: String,
    seconds: f64,
    /// Bytes of the tree, and the most that building it held at a time; where they are known.
    bytes: Option<usize>,
    peak_bytes: Option<usize>,
}

impl Built<'_> {
    pub fn figures(&self) -> Value {
        json!({
            "tool": self.name,
            "seconds": self.seconds,
            "bytes": self.bytes,
            "peak_bytes": self.peak_bytes,
        })
    }
}

/// halfline's scene.
pub fn halfline<'a>(mesh: Mesh, clock: Clock) -> Result<Built<'a>, String> {
    let (peak, (seconds, scene)) = peak_of(|| {
        clock.time(|| Scene::builder(mesh).observer(&NoProgress).build().map_err(|e| e.to_string()))
    });
    let scene = scene?;
    Ok(Built {
        name: "halfline".into(),
        seconds,
        bytes: Some(scene.statistics().bytes),
        peak_bytes: Some(peak),
        tool: Tool::Halfline(Box::new(scene)),
    })
}

/// The rivals' trees.
pub fn rivals<'a>(
    rivals: Rivals,
    embree: &'a Embree,
    mesh: &'static SingleMesh,
    threads: usize,
) -> Vec<Built<'a>> {
    let clock = Clock::of(threads);
    // In its robust mode Embree builds the same tree for either quality.
    let configurations = [(Quality::High, false), (Quality::Medium, false), (Quality::High, true)];
    let asked = match rivals {
        Rivals::All => 3,
        Rivals::Embree => 2,
        Rivals::None => 0,
    };
    let mut built = Vec::new();
    for &(quality, is_robust) in &configurations[..asked] {
        let (seconds, scene) = clock.time(|| embree.scene(mesh, quality, is_robust, threads));
        built.push(Built {
            name: format!("Embree {quality:?}{}", if is_robust { ", robust" } else { "" }),
            seconds,
            bytes: Some(scene.bytes()),
            peak_bytes: Some(scene.peak_bytes()),
            tool: Tool::Embree { scene, quality, is_robust },
        });
    }
    if rivals == Rivals::All {
        let (seconds, trees) = clock.time(|| Obvhs::new(mesh));
        built.push(Built {
            name: "obvhs, both trees, on one thread".into(),
            seconds,
            bytes: None,
            peak_bytes: None,
            tool: Tool::Obvhs(Box::new(trees)),
        });
        #[cfg(feature = "tinybvh")]
        if let (seconds, Some(trees)) = clock.time(|| TinyBvh::new(mesh)) {
            built.push(Built {
                name: format!("tinybvh {}, both trees", tinybvh_peer::version()),
                seconds,
                bytes: None,
                peak_bytes: None,
                tool: Tool::TinyBvh(trees),
            });
        }
    }
    built
}

/// Whose answer it is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Halfline,
    Embree,
    RobustEmbree,
    Obvhs,
    #[cfg(feature = "tinybvh")]
    TinyBvh,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Kind::Halfline => "halfline",
            Kind::Embree => "embree",
            Kind::RobustEmbree => "embree_robust",
            Kind::Obvhs => "obvhs",
            #[cfg(feature = "tinybvh")]
            Kind::TinyBvh => "tinybvh",
        }
    }
}

/// Casts rays, each with a place for its answer.
type Casts<'a, Answer> = Box<dyn Fn(&[RayF32], &mut [Answer]) + Sync + 'a>;

/// One way to ask a tool.
pub struct Way<'a> {
    pub name: String,
    pub kind: Kind,
    pub intersect: Casts<'a, HitF32>,
    pub occluded: Casts<'a, bool>,
}

/// Casts part by part, on as many threads as there are.
fn in_parts<'a, Answer: Send + 'a>(
    cast: impl Fn(&[RayF32], &mut [Answer]) + Sync + 'a,
) -> Casts<'a, Answer> {
    Box::new(move |rays, answers| {
        let parts = rays.par_chunks(PART).zip(answers.par_chunks_mut(PART));
        parts.for_each(|(rays, answers)| cast(rays, answers));
    })
}

/// All ways to ask a tool.
pub fn ways<'a>(tool: &'a Tool) -> Vec<Way<'a>> {
    match tool {
        Tool::Halfline(scene) => vec![Way {
            name: "halfline".into(),
            kind: Kind::Halfline,
            intersect: Box::new(|rays, hits| {
                scene.observed(&NoProgress).intersect_f32_into(rays, hits).expect("casts")
            }),
            occluded: Box::new(|rays, flags| {
                scene.observed(&NoProgress).occluded_into(rays, flags).expect("casts")
            }),
        }],
        Tool::Embree { scene, quality, is_robust } => ALL_PACKETS
            .map(|packets| Way {
                name: format!("{quality:?} {packets}"),
                kind: if *is_robust { Kind::RobustEmbree } else { Kind::Embree },
                intersect: in_parts(move |rays, hits| scene.intersect(packets, rays, hits)),
                occluded: in_parts(move |rays, flags| scene.occluded(packets, rays, flags)),
            })
            .into(),
        Tool::Obvhs(trees) => [Tree::Binary, Tree::Wide]
            .map(|tree| Way {
                name: format!("{tree:?}"),
                kind: Kind::Obvhs,
                intersect: in_parts(move |rays, hits| trees.intersect(tree, rays, hits)),
                occluded: in_parts(move |rays, flags| trees.occluded(tree, rays, flags)),
            })
            .into(),
        #[cfg(feature = "tinybvh")]
        &Tool::TinyBvh(trees) => [false, true]
            .map(|is_wide| Way {
                name: if is_wide { "BVH8_CPU" } else { "BVH4_CPU" }.into(),
                kind: Kind::TinyBvh,
                intersect: in_parts(move |rays, hits| trees.intersect(is_wide, rays, hits)),
                occluded: in_parts(move |rays, flags| trees.occluded(is_wide, rays, flags)),
            })
            .into(),
    }
}
