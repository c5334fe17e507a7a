//! PNG: what a display shows.

use std::io::{self, Write};

use rayon::prelude::*;

use super::Rendering;

impl Rendering {
    /// Writes the colours as an eight-bit sRGB PNG: with alpha if anything is transparent,
    /// without if nothing is.
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_png(&self, writer: impl Write) -> io::Result<()> {
        let opaque = self.is_opaque();
        let mut encoder = png::Encoder::new(writer, self.width, self.height);
        encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        let pixels = self.to_srgb8();
        let bytes: Vec<u8> = if opaque {
            pixels.par_iter().map(|&[r, g, b, _]| [r, g, b]).collect::<Vec<_>>().into_flattened()
        } else {
            pixels.into_flattened()
        };
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(&bytes)?;
            writer.finish()
        });
        // The conversion that comes with the encoder would lose the kind of the error.
        written.map_err(|error| match error {
            png::EncodingError::IoError(error) => error,
            other => io::Error::other(other),
        })
    }
}
