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
        let (bytes, channels) = self.to_bytes();
        write_png(writer, self.width, self.height, &bytes, channels)
    }

    /// The colours of [`Rendering::to_srgb8`], and how many there are for each pixel: four if anything
    /// is transparent, else three.
    pub fn to_bytes(&self) -> (Vec<u8>, usize) {
        let pixels = self.to_srgb8();
        if !self.is_opaque() {
            return (pixels.into_flattened(), 4);
        }
        let opaque = pixels.par_iter().map(|&[r, g, b, _]| [r, g, b]);
        (opaque.collect::<Vec<_>>().into_flattened(), 3)
    }
}

/// Writes eight-bit sRGB pixels as a PNG. They have three channels, or four with alpha.
///
/// # Errors
/// What the writer says; pixels that are not as many as width and height say.
pub fn write_png(
    writer: impl Write,
    width: u32,
    height: u32,
    pixels: &[u8],
    channels: usize,
) -> io::Result<()> {
    let mut encoder = png::Encoder::new(writer, width, height);
    encoder.set_color(if channels == 3 { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(pixels)?;
        writer.finish()
    });
    // The conversion that comes with the encoder would lose the kind of the error.
    written.map_err(|error| match error {
        png::EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    })
}
