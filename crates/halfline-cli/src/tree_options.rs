//! How the kd-tree is built: options of every subcommand that builds one.

use std::path::Path;

use clap::{Args, ValueEnum};
use halfline::builder::{BuildParameters, Preset};
use halfline::error::Result;
use halfline::progress::Observer;
use halfline::{Mesh, Scene};

use crate::failure::Failure;

/// What can be said about the tree.
#[derive(Debug, Default, Args)]
pub struct TreeOptions {
    /// How much time to spend on the tree; the answers are the same [default: balanced]
    #[arg(long, value_enum, value_name = "NAME")]
    preset: Option<PresetName>,
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
            Some(PresetName::Fast) => Preset::Fast,
            Some(PresetName::Balanced) | None => Preset::Balanced,
            Some(PresetName::Best) => Preset::Best,
        }
    }

    /// Builds the tree over `mesh`.
    pub fn build(&self, mesh: Mesh, observer: &dyn Observer) -> Result<Scene> {
        Scene::builder(mesh)
            .parameters(BuildParameters::preset(self.preset()))
            .observer(observer)
            .build()
    }

    /// Refuses options about a tree that is built already, in the file at `path`.
    pub fn check_unused(&self, path: &Path) -> std::result::Result<(), Failure> {
        match self.preset {
            None => Ok(()),
            Some(_) => Err(Failure::Usage(format!(
                "--preset cannot be used with {}: it is a tree, whose preset is what it was built with",
                path.display()
            ))),
        }
    }
}
