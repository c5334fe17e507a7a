//! The options of a picture, for those who draw it by other means than the command.

use clap::Parser;
use clap::error::ErrorKind;
use halfline_render::RenderSettings;

use crate::commands::render::PictureOptions;
use crate::one_line::one_line;

/// The options of a picture and no others, not even `--help`.
#[derive(Debug, Parser)]
#[command(no_binary_name = true, disable_help_flag = true, disable_version_flag = true)]
struct Picture {
    #[command(flatten)]
    options: PictureOptions,
}

/// The settings that `options` mean: the long options of `halfline render`, without those of the mesh,
/// the tree and the output, as in `["--samples", "64", "--ground=checker"]`. They are checked as the
/// command checks them. Refused together are
///
/// - `--no-background` and `--background-color`,
/// - `--camera-position` and `--camera-azimuth-angle` or `--camera-elevation-angle`,
/// - `--camera-position` and `--camera-focal-point` at the same point,
/// - `--ground-height` or `--ground-reflectivity` without `--ground`,
/// - any option twice, but for `--light`.
///
/// # Errors
/// One plain line that names the option and says what was expected.
pub fn render_settings(options: &[String]) -> Result<RenderSettings, String> {
    // No value may hold control characters, so that they can be made visible first.
    let options = options.iter().map(|option| one_line(option));
    let picture = Picture::try_parse_from(options).map_err(|error| in_a_line(&error))?;
    let settings = picture.options.settings()?;
    settings.check().map_err(|error| one_line(&error.to_string()))?;
    Ok(settings)
}

/// What clap says, without its label, its hints and its layout.
fn in_a_line(error: &clap::Error) -> String {
    if error.kind() == ErrorKind::MissingRequiredArgument {
        // Clap would name the option that is missing alone, not those that need it.
        return "--ground-height and --ground-reflectivity need --ground".into();
    }
    let text = error.render().to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect::<Vec<_>>().join(" ")
}
