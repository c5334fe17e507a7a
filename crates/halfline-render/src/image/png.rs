//! PNG: what a display shows.

use std::io::{self, Write};

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
            pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect()
        } else {
            pixels.into_flattened()
        };
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(())
    }
}
