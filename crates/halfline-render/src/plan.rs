//! A picture before its rays are cast: settings checked, camera placed, the world set up.

use std::ops::{Deref, Range};

use halfline::Scene;
use halfline::error::{Error, Result};
use halfline::geometry::{Ray, Vec3};
use halfline::mesh::Material;
use halfline::progress::Observer;

use crate::camera::{Camera, center_and_size};
use crate::color::srgb8_table;
use crate::field::VertexField;
use crate::ground::GroundPlane;
use crate::integrator::{
    Clay, Depth, FaceColors, Integrator, Normals, PLASTER, Steps, Whitted, steps_color_bar,
};
use crate::intersector::Intersector;
use crate::lights::default_lights;
use crate::rows::{Origin, Rows, scene_fingerprint, settings_fingerprint};
use crate::settings::{RenderSettings, Shading};
use crate::smooth_normals::SmoothNormals;
use crate::tile::{self, TileRenderer};
use crate::trace::Job;
use crate::world::World;

/// A picture whose rows can be traced, in any order and each as often as wanted, here or on other
/// machines, and put together by [`assemble`](crate::assemble).
///
/// Making one looks at every vertex, and for smooth normals at every triangle, several times:
/// whoever traces many parts of a picture makes one plan and keeps it. It holds the scene, as a
/// reference or by an [`Arc`](std::sync::Arc), and may be used by many threads at once.
pub struct Plan<S> {
    scene: S,
    /// Numbers that give the model its colours.
    field: Option<VertexField>,
    settings: RenderSettings,
    prepared: Preparation,
    origin: Origin,
    /// Rays from the eye that a tile casts together, more or less.
    batch: usize,
}

/// What is found out by looking at all of the mesh.
struct Preparation {
    camera: Camera,
    /// The middle of the model and the length of its diagonal.
    center: Vec3,
    size: f64,
    ground: Option<GroundPlane>,
    default_material: Material,
    materials: Vec<Material>,
    smooth: Option<SmoothNormals>,
    scene_fingerprint: u64,
}

impl Preparation {
    fn new(
        scene: &Scene,
        settings: &RenderSettings,
        field: Option<&VertexField>,
    ) -> Result<Preparation> {
        let mesh = scene.mesh();
        let bounds = mesh.bounds();
        let (center, size) = center_and_size(&bounds)?;
        let (width, height) = (settings.width, settings.height);
        let free_right = match field {
            Some(field) => field.color_bar(width, height).share(),
            None if settings.shading == Shading::Steps => steps_color_bar(width, height).share(),
            None => 0.0,
        };
        let camera = Camera::with_free_right_side(settings, mesh, &bounds, free_right)?;
        let mut default_material = PLASTER;
        if mesh.vertex_colors.is_some() {
            default_material.base_color = [1.0; 4];
        }
        let up = settings.camera.up;
        Ok(Preparation {
            camera,
            center,
            size,
            ground: settings.ground.map(|ground| GroundPlane::new(&ground, up, &bounds, size)),
            default_material,
            materials: mesh.materials.iter().map(sanitize).collect(),
            smooth: settings.smooth_angle.map(|angle| SmoothNormals::new(mesh, angle)),
            scene_fingerprint: scene_fingerprint(scene, &bounds),
        })
    }
}

impl<S: Deref<Target = Scene>> Plan<S> {
    /// Prepares the picture of `scene` that `settings` describe.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a setting makes no sense, naming it; [`Error::Format`] if the scene comes
    /// from a file that is damaged.
    pub fn new(scene: S, settings: &RenderSettings) -> Result<Plan<S>> {
        Plan::of(scene, settings, None)
    }

    /// [`Plan::new`], with numbers that give the model its colours, one for each vertex.
    pub(crate) fn of_field(
        scene: S,
        settings: &RenderSettings,
        field: VertexField,
    ) -> Result<Plan<S>> {
        Plan::of(scene, settings, Some(field))
    }

    fn of(scene: S, settings: &RenderSettings, field: Option<VertexField>) -> Result<Plan<S>> {
        settings.check()?;
        let prepared = scene.guarded(|| Preparation::new(&scene, settings, field.as_ref()))?;
        let origin =
            Origin { settings: settings_fingerprint(settings), scene: prepared.scene_fingerprint };
        let settings = settings.clone();
        Ok(Plan { scene, field, settings, prepared, origin, batch: tile::BATCH })
    }

    /// The numbers that give the model its colours.
    pub(crate) fn field(&self) -> Option<&VertexField> {
        self.field.as_ref()
    }

    /// What the picture is to be like.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// The ray from the eye through the middle of a pixel, counted from 0 at the picture's left and top.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a pixel outside of the picture.
    pub fn pixel_ray(&self, column: u32, row: u32) -> Result<Ray> {
        let (width, height) = (self.settings.width, self.settings.height);
        if column >= width || row >= height {
            let reason =
                format!("{column},{row} is outside of the picture of {width} x {height} pixels");
            return Err(Error::invalid("pixel", reason));
        }
        Ok(self.prepared.camera.ray(f64::from(column) + 0.5, f64::from(row) + 0.5))
    }

    /// Traces `rows`, counted from the top, on all threads, reporting
    /// [`Stage::Trace`](halfline::progress::Stage::Trace) in their pixels to `observer`. Any rows will
    /// do, and none depends on what else is traced; multiples of four cost least, and each thread takes
    /// four at a time.
    ///
    /// All machines must give transcendental functions the same last bits for pictures to be the same
    /// to the bit, which is certain for those of the same system and kind of processor.
    ///
    /// # Errors
    /// [`Error::Invalid`] if `rows` are none, or not all of the picture;
    /// [`Error::Interrupted`] soon after `observer` asks for the end; [`Error::Format`] if the scene
    /// comes from a file that is damaged.
    pub fn trace_rows(&self, rows: Range<u32>, observer: &dyn Observer) -> Result<Rows> {
        self.trace_rows_by(&*self.scene, rows, observer)
    }

    /// Traces `rows` as [`Plan::trace_rows`] does, with another's answers to all rays, but for
    /// those whose steps are counted.
    ///
    /// # Errors
    /// Those of [`Plan::trace_rows`].
    pub fn trace_rows_by(
        &self,
        intersector: &dyn Intersector,
        rows: Range<u32>,
        observer: &dyn Observer,
    ) -> Result<Rows> {
        let height = self.settings.height;
        if rows.is_empty() || rows.end > height {
            let reason = format!("{}..{} is no part of 0..{height}", rows.start, rows.end);
            return Err(Error::invalid("rows", reason));
        }
        observer.check()?;
        let world = self.world(intersector);
        let integrator = self.integrator(&world);
        let tile_renderer = TileRenderer {
            settings: &self.settings,
            camera: &self.prepared.camera,
            integrator: integrator.as_ref(),
            batch: self.batch,
        };
        let first_row = rows.start;
        let job = Job { tile_renderer, world: &world, observer };
        let traced = self.scene.guarded(|| job.trace(rows))?;
        Ok(Rows { origin: self.origin, first_row, picture_height: height, traced })
    }

    fn world<'a>(&'a self, intersector: &'a dyn Intersector) -> World<'a> {
        let has_clear_material = match self.settings.material {
            Some(material) => material.transmission > 0.0,
            None => self.prepared.materials.iter().any(|material| material.transmission > 0.0),
        };
        World {
            scene: &self.scene,
            intersector,
            ground: self.prepared.ground,
            up: self.settings.camera.up.vector(),
            material: self.settings.material,
            default_material: self.prepared.default_material,
            materials: &self.prepared.materials,
            has_clear_material,
            smooth: self.prepared.smooth.as_ref(),
            field: self.field.as_ref(),
            srgb: srgb8_table(),
        }
    }

    fn integrator<'a>(&'a self, world: &'a World<'a>) -> Box<dyn Integrator + 'a> {
        let (settings, prepared) = (&self.settings, &self.prepared);
        let camera = &prepared.camera;
        match settings.shading {
            Shading::Clay => {
                let reach = settings.occlusion_reach * prepared.size;
                Box::new(Clay::new(world, camera, reach, settings.occlusion_rays))
            }
            Shading::Whitted => Box::new(Whitted {
                world,
                lights: if settings.lights.is_empty() {
                    default_lights(camera, prepared.center, prepared.size)
                } else {
                    settings.lights.clone()
                },
                background: settings.background,
                max_depth: settings.max_depth,
            }),
            Shading::Normal => Box::new(Normals { world }),
            Shading::Depth => Box::new(Depth { world, camera }),
            Shading::Face => Box::new(FaceColors { world, seed: settings.seed }),
            Shading::Steps => Box::new(Steps),
        }
    }

    /// This picture in tiles of another size.
    #[cfg(test)]
    pub(crate) fn with_batch(self, batch: usize) -> Plan<S> {
        Plan { batch, ..self }
    }
}

/// A file's material with every value in its range; NaN becomes the lowest one.
fn sanitize(material: &Material) -> Material {
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
