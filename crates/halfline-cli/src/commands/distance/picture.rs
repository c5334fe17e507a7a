//! The picture of distances.

use std::io::BufWriter;
use std::path::Path;

use halfline::Scene;
use halfline::progress::Stage;
use halfline_render::{ColorScale, RenderSettings, VertexField, render_field};

use super::options::Options;
use super::report::Seconds;
use crate::failure::Failure;
use crate::output;
use crate::session::Session;

/// A picture that was asked for.
pub struct Picture<'a> {
    path: &'a Path,
    settings: RenderSettings,
    caption: &'static str,
}

impl<'a> Picture<'a> {
    /// The picture that `options` ask for, if any.
    pub fn new(options: &'a Options) -> Result<Option<Picture<'a>>, Failure> {
        let Some(path) = &options.picture else { return Ok(None) };
        let camera = options.camera.settings().map_err(Failure::Usage)?;
        let (width, height) = options.resolution;
        let settings = RenderSettings::new(width, height).with(|settings| settings.camera = camera);
        let caption = if options.signed { "signed distance" } else { "distance" };
        Ok(Some(Picture { path, settings, caption }))
    }

    /// Draws it.
    pub fn draw(
        self,
        scene: &Scene,
        distances: Vec<f64>,
        scale: ColorScale,
        session: &Session,
        seconds: &mut Seconds,
    ) -> Result<(), Failure> {
        let field = VertexField { values: distances, scale, caption: self.caption };
        let (rendering, trace_seconds) = session
            .timed(Stage::Trace, |observer| render_field(scene, field, &self.settings, observer))?;
        let ((), write_seconds) = session.timed(Stage::Write, |observer| {
            output::write(self.path, observer, |file| rendering.write_png(BufWriter::new(file)))
        })?;
        seconds.trace += trace_seconds;
        seconds.write += write_seconds;
        Ok(())
    }
}
