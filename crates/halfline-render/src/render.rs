//! The whole of a picture: settings checked, world set up, bands of tiles traced in parallel.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use halfline::Scene;
use halfline::error::{Error, Result};
use halfline::geometry::{Aabb, NO_FACE};
use halfline::mesh::Material;
use halfline::progress::{Observer, Stage};
use rayon::prelude::*;

use crate::camera::{Camera, center_and_size};
use crate::color::srgb8_table;
use crate::color_bar::ColorBar;
use crate::ground::GroundPlane;
use crate::image::Rendering;
use crate::integrator::{Clay, Depth, FaceColors, Integrator, Normals, PLASTER, Steps, Whitted};
use crate::lights::default_lights;
use crate::settings::{RenderSettings, Shading};
use crate::sky::backdrop;
use crate::smooth_normals::SmoothNormals;
use crate::statistics::{RayCounts, RenderStatistics};
use crate::tile::{self, BLOCK, Brush, Pixel};
use crate::tracer::Tracer;
use crate::world::World;

/// Draws `scene` as `settings` ask, reporting [`Stage::Trace`] in pixels to `observer`.
///
/// # Errors
/// [`Error::Invalid`] if a setting makes no sense, naming it; [`Error::Interrupted`] soon after
/// `observer` asks for the end.
pub fn render(
    scene: &Scene,
    settings: &RenderSettings,
    observer: &dyn Observer,
) -> Result<Rendering> {
    render_in_batches(scene, settings, observer, tile::BATCH)
}

/// [`render`] with tiles of about `batch` rays from the eye.
fn render_in_batches(
    scene: &Scene,
    settings: &RenderSettings,
    observer: &dyn Observer,
    batch: usize,
) -> Result<Rendering> {
    settings.check()?;
    observer.check()?;

    // Place the camera, and everything that depends on the model's size.
    let mesh = scene.mesh();
    let bounds = mesh.bounds();
    let (center, size) = center_and_size(&bounds)?;
    let bar = ColorBar::new(settings.width, settings.height);
    let free_right = if settings.shading == Shading::Steps { bar.share() } else { 0.0 };
    let camera = Camera::with_free_right_side(settings, mesh, &bounds, free_right)?;
    let world = world(scene, settings, &bounds, size);

    let integrator: Box<dyn Integrator + '_> = match settings.shading {
        Shading::Clay => {
            let reach = settings.occlusion_reach * size;
            Box::new(Clay::new(&world, &camera, reach, settings.occlusion_rays))
        }
        Shading::Whitted => Box::new(Whitted {
            world: &world,
            lights: if settings.lights.is_empty() {
                default_lights(&camera, center, size)
            } else {
                settings.lights.clone()
            },
            background: settings.background,
            max_depth: settings.max_depth,
        }),
        Shading::Normal => Box::new(Normals { world: &world }),
        Shading::Depth => Box::new(Depth { world: &world, camera: &camera }),
        Shading::Face => Box::new(FaceColors { world: &world, seed: settings.seed }),
        Shading::Steps => Box::new(Steps { bar }),
    };
    let brush = Brush { settings, camera: &camera, integrator: integrator.as_ref(), batch };
    let job = Job { brush, world: &world, observer };

    let mut picture = job.trace()?;
    integrator.finish(&mut picture);
    add_backdrop(&mut picture, settings);
    Ok(picture)
}

fn world<'a>(scene: &'a Scene, settings: &RenderSettings, bounds: &Aabb, size: f64) -> World<'a> {
    let mesh = scene.mesh();
    let up = settings.camera.up;
    let mut default_material = PLASTER;
    if mesh.vertex_colors.is_some() {
        default_material.base_color = [1.0; 4];
    }
    let materials: Vec<Material> = mesh.materials.iter().map(tame).collect();
    let has_clear_material = match settings.material {
        Some(material) => material.transmission > 0.0,
        None => materials.iter().any(|material| material.transmission > 0.0),
    };
    World {
        scene,
        ground: settings.ground.map(|ground| GroundPlane::new(&ground, up, bounds, size)),
        up: up.vector(),
        material: settings.material,
        default_material,
        materials,
        has_clear_material,
        smooth: settings.smooth_angle.map(|angle| SmoothNormals::new(mesh, angle)),
        srgb: srgb8_table(),
    }
}

/// A file's material with every value in its range; NaN becomes the lowest one.
fn tame(material: &Material) -> Material {
    let within = |v: f32, lowest: f32, highest: f32| {
        if v.is_nan() { lowest } else { v.clamp(lowest, highest) }
    };
    let unit = |v: f32| within(v, 0.0, 1.0);
    Material {
        base_color: material.base_color.map(unit),
        metallic: unit(material.metallic),
        roughness: unit(material.roughness),
        transmission: unit(material.transmission),
        ior: within(material.ior, 1.0, 10.0),
    }
}

struct Job<'a> {
    brush: Brush<'a>,
    world: &'a World<'a>,
    observer: &'a dyn Observer,
}

/// The pixels of as many neighbouring rows as a tile has, in each layer.
struct Band<'a> {
    first_row: usize,
    color: &'a mut [[f32; 4]],
    depth: &'a mut [f32],
    normal: &'a mut [[f32; 3]],
    face: &'a mut [u32],
    steps: Option<&'a mut [[f32; 2]]>,
}

impl Job<'_> {
    /// Everything but what `finish` adds: colours without the background.
    fn trace(&self) -> Result<Rendering> {
        let mut picture = blank(self.brush.settings, self.brush.integrator.counts_steps())?;
        let total = picture.pixel_count() as u64;
        let done = AtomicU64::new(0);
        self.observer.report(Stage::Trace, 0, total);
        let start = Instant::now();
        let rays = bands(&mut picture)
            .into_par_iter()
            .map(|mut band| {
                let counts = self.trace_band(&mut band)?;
                let pixels = band.color.len() as u64;
                let now_done = done.fetch_add(pixels, Ordering::Relaxed) + pixels;
                self.observer.report(Stage::Trace, now_done, total);
                Ok(counts)
            })
            .try_reduce(RayCounts::default, |mut a, b| {
                a += b;
                Ok(a)
            })?;
        picture.statistics =
            RenderStatistics { rays, trace_seconds: start.elapsed().as_secs_f64() };
        Ok(picture)
    }

    fn trace_band(&self, band: &mut Band) -> Result<RayCounts> {
        let mut tracer = Tracer::new(self.world, self.observer);
        let width = self.brush.settings.width as usize;
        let rows = band.first_row..band.first_row + band.color.len() / width;
        let columns = self.brush.tile_columns();
        for first in (0..width).step_by(columns) {
            let columns = first..(first + columns).min(width);
            for pixel in self.brush.draw(columns, rows.clone(), &mut tracer)? {
                self.keep(&pixel, band);
            }
        }
        Ok(tracer.counts)
    }

    /// Puts `pixel` into the layers of its band.
    fn keep(&self, pixel: &Pixel, band: &mut Band) {
        let settings = self.brush.settings;
        let i = (pixel.row - band.first_row) * settings.width as usize + pixel.column;
        let count = f64::from(settings.samples);
        if pixel.sum.alpha > 0.0 {
            let [r, g, b] = (pixel.sum.color / pixel.sum.alpha).to_array().map(|v| v as f32);
            band.color[i] = [r, g, b, (pixel.sum.alpha / count) as f32];
        }
        if let Some(layer) = &mut band.steps {
            layer[i] = pixel.steps.map(|sum| (sum / count) as f32);
        }
        if let Some(middle) = &pixel.middle {
            band.depth[i] = middle.depth;
            band.normal[i] = middle.normal;
            band.face[i] = middle.face;
        }
    }
}

/// A picture in which there is nothing.
fn blank(settings: &RenderSettings, counts_steps: bool) -> Result<Rendering> {
    let (width, height) = (settings.width, settings.height);
    let pixels = width as usize * height as usize;
    Ok(Rendering {
        width,
        height,
        color: layer(pixels, [0.0; 4])?,
        depth: layer(pixels, f32::INFINITY)?,
        normal: layer(pixels, [0.0; 3])?,
        face: layer(pixels, NO_FACE)?,
        steps: if counts_steps { Some(layer(pixels, [0.0; 2])?) } else { None },
        statistics: RenderStatistics::default(),
    })
}

fn layer<T: Clone>(pixels: usize, value: T) -> Result<Vec<T>> {
    let mut layer = Vec::new();
    layer.try_reserve_exact(pixels).map_err(|_| {
        Error::invalid("resolution", format!("no memory for a picture of {pixels} pixels"))
    })?;
    layer.resize(pixels, value);
    Ok(layer)
}

fn bands(picture: &mut Rendering) -> Vec<Band<'_>> {
    let size = picture.width as usize * BLOCK;
    let mut steps = picture.steps.as_mut().map(|steps| steps.chunks_mut(size));
    let layers = picture
        .color
        .chunks_mut(size)
        .zip(picture.depth.chunks_mut(size))
        .zip(picture.normal.chunks_mut(size))
        .zip(picture.face.chunks_mut(size));
    layers
        .enumerate()
        .map(|(i, (((color, depth), normal), face))| Band {
            first_row: i * BLOCK,
            color,
            depth,
            normal,
            face,
            steps: steps.as_mut().and_then(Iterator::next),
        })
        .collect()
}

/// Puts the background behind what was drawn.
fn add_backdrop(picture: &mut Rendering, settings: &RenderSettings) {
    let (width, height) = (picture.width as usize, picture.height as usize);
    picture.color.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
        let y = 1.0 - (2 * row + 1) as f64 / height as f64;
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let alpha = pixel[3];
            if alpha == 1.0 {
                continue;
            }
            let x = (2 * column + 1) as f64 / width as f64 - 1.0;
            let (behind, behind_alpha) = backdrop(&settings.background, x, y);
            if behind_alpha == 0.0 {
                continue;
            }
            for (channel, behind) in behind.to_array().into_iter().enumerate() {
                pixel[channel] = pixel[channel] * alpha + behind as f32 * (1.0 - alpha);
            }
            pixel[3] = 1.0;
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Ground;
    use halfline::mesh::generate::{Kind, generate};
    use halfline::progress::Silent;

    /// Every tile size cuts the picture, the samples and the waves of rays elsewhere.
    #[test]
    fn the_size_of_tiles_does_not_show() {
        let scene = Scene::new(generate(Kind::Scan, 3000, 0, &Silent).unwrap()).unwrap();
        let glass = Material { transmission: 1.0, roughness: 0.0, ..Material::default() };
        for shading in Shading::ALL {
            let material = (shading == Shading::Whitted).then_some(glass);
            for samples in [1, 6] {
                let settings = RenderSettings {
                    width: 37,
                    height: 22,
                    samples,
                    shading,
                    material,
                    ground: Some(Ground { reflectivity: 0.3, ..Ground::default() }),
                    smooth_angle: Some(60.0),
                    ..RenderSettings::default()
                };
                let drawn = |batch| {
                    let mut picture = render_in_batches(&scene, &settings, &Silent, batch).unwrap();
                    picture.statistics.trace_seconds = 0.0;
                    picture
                };
                let usual = drawn(tile::BATCH);
                for batch in [1, 40, 1000, 100_000] {
                    let name = shading.name();
                    assert!(drawn(batch) == usual, "{name}, {samples} samples, {batch} rays");
                }
            }
        }
    }
}
