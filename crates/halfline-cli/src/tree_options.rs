//! How the tree is built: options of every subcommand that builds one.

use std::path::Path;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use halfline::{Mesh, Observer, Preset, Result, Scene};

use crate::failure::Failure;

/// What can be said about the tree.
#[derive(Debug, Default, Args)]
pub struct TreeOptions {
    /// How much time to spend on the tree; the answers are the same [default: balanced]
    #[arg(long, value_parser = preset_parser(), value_name = "NAME")]
    preset: Option<Preset>,
}

/// How much time each of [`Preset::ALL`] spends, for the help.
const PRESET_HELP: [&str; Preset::ALL.len()] = [
    "Little: the first picture soonest",
    "Some: for about as many rays as there are triangles, and more",
    "Much: the most rays a second",
];

fn preset_parser() -> impl TypedValueParser<Value = Preset> {
    let values = Preset::ALL.into_iter().zip(PRESET_HELP);
    let values = values.map(|(preset, help)| PossibleValue::new(preset.name()).help(help));
    PossibleValuesParser::new(values).try_map(|name| name.parse::<Preset>())
}

impl TreeOptions {
    /// Builds the tree over `mesh`.
    pub fn build(&self, mesh: Mesh, observer: &dyn Observer) -> Result<Scene> {
        let preset = self.preset.unwrap_or(Preset::Balanced);
        Scene::builder(mesh).preset(preset).observer(observer).build()
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
