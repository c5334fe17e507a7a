//! What may be said about a picture, and the settings that it means.

use clap::{Args, ValueEnum};
use halfline::mesh::{Material, linear_from_srgb};
use halfline_render::{
    Background, Ground, GroundSurface, Light, MAX_DEPTH, MAX_SAMPLES, RenderSettings, Shading,
};

use crate::camera_options::CameraOptions;
use crate::values;

/// All that makes [`RenderSettings`].
#[derive(Debug, Args)]
pub struct PictureOptions {
    /// Size of the picture in pixels
    #[arg(long, value_name = "W,H", default_value = "1280,720", value_parser = values::resolution)]
    resolution: (u32, u32),

    /// How surfaces are turned into colours
    #[arg(long, value_enum, default_value_t = ShadingName::Clay)]
    shading: ShadingName,

    /// Rays from the eye through each pixel
    #[arg(long, value_name = "N", default_value_t = 16)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SAMPLES)))]
    samples: u32,

    /// Chooses among equally good random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    #[command(flatten)]
    camera: CameraOptions,

    #[command(flatten)]
    surroundings: SurroundingsOptions,

    #[command(flatten)]
    material: MaterialOptions,

    #[command(flatten)]
    light: LightOptions,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Surroundings")]
struct SurroundingsOptions {
    /// One colour behind the model, as R,G,B in 0..1 or #RRGGBB
    #[arg(long, value_name = "COLOR", value_parser = values::color)]
    background_color: Option<[f32; 3]>,

    /// Nothing behind the model: a transparent picture
    #[arg(long, conflicts_with = "background_color")]
    no_background: bool,

    /// A plane under the model: shadow (default), checker, or a colour
    #[arg(long, value_name = "LOOK", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "shadow", value_parser = ground_surface)]
    ground: Option<GroundSurface>,

    /// Where the plane lies along the up axis [default: touching the model]
    #[arg(long, value_name = "H", allow_hyphen_values = true, value_parser = values::finite)]
    #[arg(requires = "ground")]
    ground_height: Option<f64>,

    /// How much the plane mirrors, 0 to 1 (whitted)
    #[arg(long, value_name = "SHARE", value_parser = values::within(0.0, 1.0, true))]
    #[arg(requires = "ground")]
    ground_reflectivity: Option<f64>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Material (instead of the file's)")]
struct MaterialOptions {
    /// A material to start from
    #[arg(long, value_enum, value_name = "NAME")]
    material: Option<MaterialName>,

    /// Base colour, as R,G,B in 0..1 or #RRGGBB
    #[arg(long, value_name = "COLOR", value_parser = values::color)]
    color: Option<[f32; 3]>,

    /// 0 for a dielectric, 1 for a metal
    #[arg(long, value_name = "SHARE", value_parser = values::within(0.0, 1.0, true))]
    metallic: Option<f64>,

    /// 0 for a mirror, 1 for fully rough
    #[arg(long, value_name = "SHARE", value_parser = values::within(0.0, 1.0, true))]
    roughness: Option<f64>,

    /// Index of refraction, 1 to 4
    #[arg(long, value_name = "N", value_parser = values::within(1.0, 4.0, true))]
    base_ior: Option<f64>,

    /// Faces that meet at less than this angle look as one smooth surface, in degrees
    #[arg(long, value_name = "DEGREES", value_parser = values::within(0.0, 180.0, true))]
    smooth_angle: Option<f64>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Light")]
struct LightOptions {
    #[arg(long, value_name = "LIGHT", value_parser = values::light, help = values::LIGHT_GRAMMAR)]
    light: Vec<Light>,

    /// How often light may be mirrored or refracted (whitted)
    #[arg(long, value_name = "N", default_value_t = 8)]
    #[arg(value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_DEPTH)))]
    max_depth: u32,

    /// Rays into the surroundings for each ray from the eye (clay)
    #[arg(long, value_name = "N", default_value_t = 2)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SAMPLES)))]
    occlusion_rays: u32,

    /// How far surfaces darken each other, as a share of the model's diagonal (clay)
    #[arg(long, value_name = "SHARE", default_value = "0.5")]
    #[arg(value_parser = values::within(0.0, f64::INFINITY, false))]
    occlusion_reach: f64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ShadingName {
    /// Plaster under a soft sky with one soft key light
    Clay,
    /// Lights, shadows, mirrors and glass
    Whitted,
    /// The direction of the surface as a colour
    Normal,
    /// The distance from the camera: near is bright
    Depth,
    /// A random colour for each face
    Face,
    /// A heat map of the tree nodes and triangles visited
    Steps,
}

impl From<ShadingName> for Shading {
    fn from(name: ShadingName) -> Shading {
        match name {
            ShadingName::Clay => Shading::Clay,
            ShadingName::Whitted => Shading::Whitted,
            ShadingName::Normal => Shading::Normal,
            ShadingName::Depth => Shading::Depth,
            ShadingName::Face => Shading::Face,
            ShadingName::Steps => Shading::Steps,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MaterialName {
    /// Rough and light grey
    Plaster,
    /// Smooth and light grey
    Plastic,
    /// Brushed metal
    Metal,
    /// A perfect mirror
    Mirror,
    /// Clear glass
    Glass,
}

impl From<MaterialName> for Material {
    fn from(name: MaterialName) -> Material {
        let plain = Material::default();
        let metal = |base_color, roughness| Material {
            base_color,
            metallic: 1.0,
            roughness,
            ..Material::default()
        };
        match name {
            MaterialName::Plaster => plain,
            MaterialName::Plastic => Material { roughness: 0.0, ..plain },
            MaterialName::Metal => metal([0.6, 0.6, 0.62, 1.0], 0.4),
            MaterialName::Mirror => metal([0.95, 0.95, 0.95, 1.0], 0.0),
            MaterialName::Glass => {
                let base_color = [1.0; 4];
                Material { base_color, roughness: 0.0, transmission: 1.0, ..plain }
            }
        }
    }
}

fn ground_surface(text: &str) -> Result<GroundSurface, String> {
    match text {
        "shadow" => Ok(GroundSurface::Shadow),
        "checker" => Ok(GroundSurface::Checker([0.82; 3], [0.45; 3])),
        color => values::color(color)
            .map(GroundSurface::Matte)
            .map_err(|_| "expected shadow, checker, R,G,B in 0..1 or #RRGGBB".into()),
    }
}

impl MaterialOptions {
    /// The material that the options describe; `None` if they say nothing.
    fn material(&self) -> Option<Material> {
        let said = self.color.is_some()
            || self.metallic.is_some()
            || self.roughness.is_some()
            || self.base_ior.is_some();
        let mut material = match self.material {
            Some(name) => name.into(),
            None if said => Material::default(),
            None => return None,
        };
        if let Some(color) = self.color {
            let [r, g, b] = color.map(linear_from_srgb);
            material.base_color = [r, g, b, 1.0];
        }
        let replace = |field: &mut f32, value: Option<f64>| {
            *field = value.map_or(*field, |value| value as f32);
        };
        replace(&mut material.metallic, self.metallic);
        replace(&mut material.roughness, self.roughness);
        replace(&mut material.ior, self.base_ior);
        Some(material)
    }
}

impl PictureOptions {
    /// The settings of the picture; the reason if options that are right by themselves make no sense
    /// together.
    pub fn settings(&self) -> Result<RenderSettings, String> {
        let camera = self.camera.settings()?;
        let surroundings = &self.surroundings;
        Ok(RenderSettings {
            width: self.resolution.0,
            height: self.resolution.1,
            samples: self.samples,
            seed: self.seed,
            camera,
            shading: self.shading.into(),
            material: self.material.material(),
            smooth_angle: self.material.smooth_angle,
            ground: surroundings.ground.map(|surface| Ground {
                height: surroundings.ground_height,
                surface,
                reflectivity: surroundings.ground_reflectivity.unwrap_or(0.0) as f32,
            }),
            background: match surroundings.background_color {
                _ if surroundings.no_background => Background::Transparent,
                Some(color) => Background::Color(color),
                None => Background::Studio,
            },
            lights: self.light.light.clone(),
            max_depth: self.light.max_depth,
            occlusion_reach: self.light.occlusion_reach,
            occlusion_rays: self.light.occlusion_rays,
        })
    }
}
