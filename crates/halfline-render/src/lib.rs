#![doc = include_str!("../README.md")]

mod assemble;
mod camera;
mod checksum;
mod color;
mod color_bar;
mod color_scale;
mod colormap;
mod field;
mod font;
mod framing;
mod ground;
mod image;
mod integrator;
mod intersector;
mod lights;
mod optics;
mod plan;
mod render;
mod rows;
mod sampling;
mod settings;
mod sky;
mod smooth_normals;
mod statistics;
pub mod text;
mod tile;
mod trace;
mod tracer;
mod world;

pub use assemble::assemble;
pub use camera::Camera;
pub use color::srgb8_from_linear;
pub use color_scale::ColorScale;
pub use field::{VertexField, render_field};
pub use image::{Rendering, write_png};
pub use intersector::Intersector;
pub use plan::Plan;
pub use render::render;
pub use rows::Rows;
pub use settings::{
    Background, CameraSettings, Ground, GroundSurface, Light, MAX_DEPTH, MAX_PIXELS, MAX_SAMPLES,
    Projection, RenderSettings, Shading, StockMaterial, Up,
};
pub use statistics::{RayCounts, RenderStatistics};
