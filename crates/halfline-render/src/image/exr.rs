//! OpenEXR: every layer, in floating point.

use std::io::{self, Seek, Write};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SmallVec, WritableImage,
};

use super::Rendering;

impl Rendering {
    /// Writes all layers as one OpenEXR part, lossless, with these channels:
    ///
    /// | channel | type | |
    /// |---|---|---|
    /// | `R` `G` `B` `A` | float | linear, premultiplied by alpha, as OpenEXR wants it |
    /// | `Z` | float | distance from the camera's plane, infinite where there is nothing |
    /// | `N.X` `N.Y` `N.Z` | float | unit normal, zero where there is nothing |
    /// | `id` | uint | triangle index, 4294967295 where there is none |
    /// | `steps.nodes` `steps.triangles` | float | only if [`Rendering::steps`] is there |
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_exr(&self, writer: impl Write + Seek) -> io::Result<()> {
        let float = |name: &str, value: &dyn Fn(usize) -> f32| {
            let samples = (0..self.pixel_count()).map(value).collect();
            AnyChannel::new(name, FlatSamples::F32(samples))
        };
        let mut channels = SmallVec::new();
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push(float(name, &|i| self.color[i][c] * self.color[i][3]));
        }
        channels.push(float("A", &|i| self.color[i][3]));
        channels.push(float("Z", &|i| self.depth[i]));
        for (c, name) in ["N.X", "N.Y", "N.Z"].into_iter().enumerate() {
            channels.push(float(name, &|i| self.normal[i][c]));
        }
        if let Some(steps) = &self.steps {
            for (c, name) in ["steps.nodes", "steps.triangles"].into_iter().enumerate() {
                channels.push(float(name, &|i| steps[i][c]));
            }
        }
        channels.push(AnyChannel::new("id", FlatSamples::U32(self.face.clone())));

        let layer = Layer::new(
            (self.width as usize, self.height as usize),
            LayerAttributes::default(),
            Encoding { line_order: LineOrder::Increasing, ..Encoding::SMALL_LOSSLESS },
            AnyChannels::sort(channels),
        );
        // A buffer here would hide errors of the last flush: the caller owns the writer.
        Image::from_layer(layer).write().to_buffered(writer).map_err(|error| match error {
            exr::error::Error::Io(error) => error,
            other => io::Error::other(other.to_string()),
        })
    }
}
