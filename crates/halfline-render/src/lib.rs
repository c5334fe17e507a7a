//! Pictures of triangle meshes, traced with halfline.

mod color;
mod image;
mod settings;
mod statistics;

pub use color::{linear_from_srgb, srgb_from_linear, srgb8_from_linear};
pub use image::Rendering;
pub use settings::{
    Background, CameraSettings, Ground, GroundSurface, Light, MAX_DEPTH, MAX_PIXELS, MAX_SAMPLES,
    Projection, RenderSettings, Shading, Up,
};
pub use statistics::{RayCounts, RenderStatistics};

use halfline::Scene;
use halfline::error::Result;
use halfline::progress::Observer;

/// Draws `scene` as `settings` ask, reporting [`Stage::Trace`](halfline::progress::Stage) in
/// pixels to `observer`.
///
/// # Errors
/// [`Error::Invalid`](halfline::Error::Invalid) if a setting makes no sense, naming it;
/// [`Error::Interrupted`](halfline::Error::Interrupted) soon after `observer` asks for the end.
pub fn render(
    _scene: &Scene,
    _settings: &RenderSettings,
    _observer: &dyn Observer,
) -> Result<Rendering> {
    Err(halfline::Error::Interrupted)
}
