//! A finished picture and its layers.

#[cfg(feature = "exr")]
mod exr;
mod png;

pub use png::write_png;

use halfline::geometry::NO_FACE;
use rayon::prelude::*;

use crate::color::srgb8_from_linear;
use crate::statistics::RenderStatistics;

/// A picture: rows from top to bottom, each from left to right.
///
/// The colour is the mean over all samples of a pixel. The other layers belong to the one ray
/// through the pixel's middle, since means of distances, normals or face numbers mean nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendering {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// Linear red, green, blue and straight (not premultiplied) alpha. Light may exceed 1.
    pub color: Vec<[f32; 4]>,
    /// Distance from the camera's plane, measured along its axis; infinite where there is nothing.
    pub depth: Vec<f32>,
    /// Unit normal of the surface by the orientation of its face, in the mesh's axes; zero where
    /// there is nothing.
    pub normal: Vec<[f32; 3]>,
    /// The triangle's index in the mesh, or [`NO_FACE`] for the ground and for nothing.
    pub face: Vec<u32>,
    /// Nodes and triangles that a sample's ray visited, on average;
    /// for [`Shading::Steps`](crate::Shading::Steps) only.
    pub steps: Option<Vec<[f32; 2]>>,
    /// What it cost.
    pub statistics: RenderStatistics,
}

impl Rendering {
    /// Number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The colours as a display wants them: sRGB-encoded red, green, blue and straight alpha,
    /// eight bits each, rounded to nearest.
    pub fn to_srgb8(&self) -> Vec<[u8; 4]> {
        self.color
            .par_iter()
            .with_min_len(1 << 12)
            .map(|&[r, g, b, a]| {
                let alpha = (a.clamp(0.0, 1.0) * 255.0).round() as u8;
                [srgb8_from_linear(r), srgb8_from_linear(g), srgb8_from_linear(b), alpha]
            })
            .collect()
    }

    /// True if every pixel is fully covered.
    pub fn is_opaque(&self) -> bool {
        self.color.iter().all(|c| c[3] >= 1.0)
    }

    /// Share of the pixels whose middle shows the mesh.
    pub fn coverage(&self) -> f64 {
        let covered = self.face.iter().filter(|&&f| f != NO_FACE).count();
        covered as f64 / self.pixel_count().max(1) as f64
    }
}
