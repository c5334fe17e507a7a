//! What may be said about a picture, and the settings that it means.

use clap::Args;
use halfline::mesh::{Material, linear_from_srgb};
use halfline_render::{
    Background, Ground, GroundSurface, Light, MAX_DEPTH, MAX_SAMPLES, RenderSettings, Shading,
    StockMaterial, text,
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
    #[arg(long, default_value = "clay")]
    #[arg(value_parser = values::named(Shading::ALL, |s| (s.name(), s.description())))]
    shading: Shading,

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
    #[arg(long, value_name = "COLOR", value_parser = text::color)]
    background_color: Option<[f32; 3]>,

    /// Nothing behind the model: a transparent picture
    #[arg(long, conflicts_with = "background_color")]
    no_background: bool,

    /// A plane under the model: shadow (default), checker, or a colour
    #[arg(long, value_name = "LOOK", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "shadow", value_parser = text::ground_surface)]
    ground: Option<GroundSurface>,

    /// Where the plane lies along the up axis [default: touching the model]
    #[arg(long, value_name = "H", allow_hyphen_values = true, value_parser = text::finite)]
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
    #[arg(long, value_name = "NAME")]
    #[arg(value_parser = values::named(StockMaterial::ALL, |m| (m.name(), m.description())))]
    material: Option<StockMaterial>,

    /// Base colour, as R,G,B in 0..1 or #RRGGBB
    #[arg(long, value_name = "COLOR", value_parser = text::color)]
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
    #[arg(long, value_name = "LIGHT", value_parser = text::light, help = values::LIGHT_GRAMMAR)]
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
        let ground = surroundings.ground.map(|surface| {
            let plane = Ground::new(surface)
                .mirroring(surroundings.ground_reflectivity.unwrap_or(0.0) as f32);
            surroundings.ground_height.map_or(plane, |height| plane.at_height(height))
        });
        Ok(RenderSettings::new(self.resolution.0, self.resolution.1).with(|settings| {
            settings.samples = self.samples;
            settings.seed = self.seed;
            settings.camera = camera;
            settings.shading = self.shading;
            settings.material = self.material.material();
            settings.smooth_angle = self.material.smooth_angle;
            settings.ground = ground;
            settings.background = match surroundings.background_color {
                _ if surroundings.no_background => Background::Transparent,
                Some(color) => Background::Color(color),
                None => Background::Studio,
            };
            settings.lights.clone_from(&self.light.light);
            settings.max_depth = self.light.max_depth;
            settings.occlusion_reach = self.light.occlusion_reach;
            settings.occlusion_rays = self.light.occlusion_rays;
        }))
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use halfline::geometry::vec3;
    use halfline_render::Up;

    use super::*;

    #[derive(Debug, Parser)]
    #[command(no_binary_name = true)]
    struct Picture {
        #[command(flatten)]
        options: PictureOptions,
    }

    fn settings(line: &str) -> Result<RenderSettings, String> {
        let picture = Picture::try_parse_from(line.split_whitespace());
        let settings = picture.map_err(|error| error.to_string())?.options.settings()?;
        settings.check().map_err(|error| error.to_string())?;
        Ok(settings)
    }

    #[test]
    fn no_options_are_the_default_settings() {
        assert_eq!(settings(""), Ok(RenderSettings::default()));
    }

    #[test]
    fn options_reach_the_settings() {
        let line = "--resolution 64,48 --shading whitted --samples 9 --seed 7 --up -Z \
                    --camera-position 1,2,-3 --background-color #ffffff --ground=checker \
                    --ground-height -1 --material glass --base-ior 1.4 --smooth-angle 30 \
                    --light directional:direction=0,0,-1 --light directional:direction=0,-1,0 \
                    --max-depth 3";
        let settings = settings(line).unwrap();
        assert_eq!((settings.width, settings.height), (64, 48));
        assert_eq!(settings.shading, Shading::Whitted);
        assert_eq!((settings.samples, settings.seed, settings.max_depth), (9, 7, 3));
        assert_eq!(settings.camera.up, Up::MinusZ);
        assert_eq!(settings.camera.position, Some(vec3(1.0, 2.0, -3.0)));
        assert_eq!(settings.background, Background::Color([1.0; 3]));
        let ground = settings.ground.unwrap();
        assert!(matches!(ground.surface, GroundSurface::Checker(..)));
        assert_eq!(ground.height, Some(-1.0));
        let material = settings.material.unwrap();
        assert_eq!((material.transmission, material.ior), (1.0, 1.4));
        assert_eq!(settings.smooth_angle, Some(30.0));
        assert_eq!(settings.lights.len(), 2);
    }

    #[test]
    fn wrong_options_are_named() {
        for (line, option, reason) in [
            ("--samples 0", "--samples", "0 is not in 1..="),
            ("--samples many", "--samples", "invalid digit"),
            ("--samples", "--samples", "a value is required"),
            ("--samples 1 --samples 2", "--samples", "cannot be used multiple times"),
            ("--shading phong", "--shading", "[possible values: clay, whitted"),
            ("--material wood", "--material", "[possible values: plaster, plastic"),
            ("--resolution 0,5", "--resolution", "expected WIDTH,HEIGHT"),
            ("--resolution 100000,100000", "--resolution", "more than"),
            ("--camera-view-up 0,0,0", "--camera-view-up", "cannot be zero"),
            ("--camera-view-angle 180", "--camera-view-angle", "between 0 and 180"),
            ("--no-background --background-color 0,0,0", "--no-background", "--background-color"),
            ("--camera-position 1,2,3 --camera-azimuth-angle 4", "-position", "-azimuth-angle"),
            ("--camera-position 1,2,3 --camera-focal-point 1,2,3", "-position", "the same point"),
            ("--ground-height 1", "--ground", "required"),
            ("--light lamp", "--light", "none of point, directional, area"),
        ] {
            let said = settings(line).unwrap_err();
            assert!(said.contains(option) && said.contains(reason), "{line}: {said}");
        }
    }
}
