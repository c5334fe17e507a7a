//! The options of a picture as they were said, to say them again elsewhere.

use clap::error::Result;
use clap::{ArgMatches, Args, Command, FromArgMatches};

use super::picture_options::PictureOptions;

/// [`PictureOptions`], and what was said.
#[derive(Debug)]
pub struct SpokenPicture {
    /// What the picture is like.
    pub options: PictureOptions,
    /// The same as [`render_settings`](crate::render_settings) takes it: what was not said is not here.
    pub words: Vec<String>,
}

impl Args for SpokenPicture {
    fn augment_args(command: Command) -> Command {
        PictureOptions::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        PictureOptions::augment_args_for_update(command)
    }
}

impl FromArgMatches for SpokenPicture {
    fn from_arg_matches(matches: &ArgMatches) -> Result<SpokenPicture> {
        let words = words_of(matches);
        Ok(SpokenPicture { options: PictureOptions::from_arg_matches(matches)?, words })
    }

    fn from_arg_matches_mut(matches: &mut ArgMatches) -> Result<SpokenPicture> {
        let words = words_of(matches);
        Ok(SpokenPicture { options: PictureOptions::from_arg_matches_mut(matches)?, words })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<()> {
        *self = SpokenPicture::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The picture's options in `matches`, each as one word.
fn words_of(matches: &ArgMatches) -> Vec<String> {
    let known = PictureOptions::augment_args(Command::new("picture"));
    let mut words = Vec::new();
    for option in known.get_arguments() {
        let id = option.get_id().as_str();
        if matches.value_source(id) != Some(clap::parser::ValueSource::CommandLine) {
            continue;
        }
        let name = option.get_long().expect("the options of a picture are long ones");
        for occurrence in matches.get_raw_occurrences(id).into_iter().flatten() {
            let value = occurrence.map(|value| value.to_string_lossy()).next();
            words.push(match value.filter(|_| option.get_action().takes_values()) {
                Some(value) => format!("--{name}={value}"),
                None => format!("--{name}"),
            });
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::SpokenPicture;
    use crate::render_settings;

    #[derive(Debug, Parser)]
    #[command(no_binary_name = true)]
    struct Program {
        #[command(flatten)]
        picture: SpokenPicture,
        #[arg(long)]
        other: bool,
    }

    fn spoken(words: &[&str]) -> SpokenPicture {
        Program::try_parse_from(words).unwrap().picture
    }

    #[test]
    fn what_was_said_means_the_same_again() {
        for words in [
            &[][..],
            &["--resolution", "7,5", "--samples=3", "--other", "--seed", "9"],
            &["--up", "-Z", "--camera-position", "-1,2,3", "--camera-orthographic"],
            &["--camera-orthographic=2.5", "--ground", "--ground-height=-1", "--no-background"],
            &["--ground=checker", "--color", "#102030", "--shading", "whitted"],
            &[
                "--light",
                "point:position=1,2,3:intensity=5",
                "--light=directional:direction=0,0,-1",
            ],
        ] {
            let said = spoken(words);
            let again = render_settings(&said.words).unwrap();
            assert_eq!(format!("{again:?}"), format!("{:?}", said.options.settings().unwrap()));
        }
    }

    #[test]
    fn defaults_and_other_options_are_no_words() {
        let said = spoken(&["--other", "--samples", "3", "--ground", "--no-background"]);
        assert_eq!(said.words, ["--samples=3", "--no-background", "--ground=shadow"]);
    }
}
