//! How the kd-tree is built: options of every subcommand that builds one.

use clap::{Args, ValueEnum};
use halfline::build::{BuildParameters, Preset};
use halfline::error::Result;
use halfline::progress::Observer;
use halfline::{Mesh, Scene};

/// What can be said about the tree.
#[derive(Debug, Args)]
pub struct TreeOptions {
    /// How much time to spend on the tree; the answers are the same
    #[arg(long, value_enum, value_name = "NAME", default_value_t = PresetName::Balanced)]
    preset: PresetName,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum PresetName {
    /// Little: the first picture soonest
    Fast,
    /// Some: for about as many rays as there are triangles, and more
    Balanced,
    /// Much: the most rays a second
    Best,
}

impl TreeOptions {
    fn preset(&self) -> Preset {
        match self.preset {
            PresetName::Fast => Preset::Fast,
            PresetName::Balanced => Preset::Balanced,
            PresetName::Best => Preset::Best,
        }
    }

    /// The name of the preset, as figures have it.
    pub fn name(&self) -> &'static str {
        self.preset().name()
    }

    /// Builds the tree over `mesh`.
    pub fn build(&self, mesh: Mesh, observer: &dyn Observer) -> Result<Scene> {
        Scene::build_with(mesh, &BuildParameters::preset(self.preset()), observer)
    }
}
