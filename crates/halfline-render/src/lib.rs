//! Pictures of triangle meshes, traced with halfline.

mod camera;
mod color;
mod color_bar;
mod colormap;
mod font;
mod framing;
mod ground;
mod image;
mod integrator;
mod lights;
mod optics;
mod render;
mod sampling;
mod settings;
mod sky;
mod smooth_normals;
mod statistics;
mod tile;
mod tracer;
mod validate;
mod world;

pub use camera::Camera;
pub use color::srgb8_from_linear;
pub use image::Rendering;
pub use render::render;
pub use settings::{
    Background, CameraSettings, Ground, GroundSurface, Light, MAX_DEPTH, MAX_PIXELS, MAX_SAMPLES,
    Projection, RenderSettings, Shading, Up,
};
pub use statistics::{RayCounts, RenderStatistics};
