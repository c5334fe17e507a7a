//! Settings that make no sense, told apart from those that do before any ray is cast.

use halfline::error::{Error, Result};
use halfline::geometry::Vec3;
use halfline::mesh::Material;

use super::{
    Background, CameraSettings, Ground, GroundSurface, Light, MAX_DEPTH, MAX_PIXELS, MAX_SAMPLES,
    Projection, RenderSettings,
};

impl RenderSettings {
    /// Checks all that can be told without a model. [`render`](crate::render) does so itself.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the first setting that makes no sense, as the options of the command
    /// are named, in words.
    pub fn check(&self) -> Result<()> {
        let (width, height) = (self.width, self.height);
        ensure("resolution", width > 0 && height > 0, || {
            format!("{width},{height} has no pixels")
        })?;
        ensure("resolution", u64::from(width) * u64::from(height) <= MAX_PIXELS, || {
            format!("{width},{height} has more than {MAX_PIXELS} pixels")
        })?;
        self.camera.check()?;
        for (name, value, most) in [
            ("samples", self.samples, MAX_SAMPLES),
            ("occlusion rays", self.occlusion_rays, MAX_SAMPLES),
        ] {
            ensure(name, (1..=most).contains(&value), || {
                format!("{value} is not between 1 and {most}")
            })?;
        }
        ensure("max depth", self.max_depth <= MAX_DEPTH, || {
            format!("{} is not between 0 and {MAX_DEPTH}", self.max_depth)
        })?;
        ensure("occlusion reach", self.occlusion_reach > 0.0, || {
            format!("{} is not above 0", self.occlusion_reach)
        })?;
        if let Some(angle) = self.smooth_angle {
            ensure("smooth angle", (0.0..=180.0).contains(&angle), || {
                format!("{angle} is not between 0 and 180 degrees")
            })?;
        }
        if let Background::Color(color) = self.background {
            ensure_color("background color", color)?;
        }
        self.material.as_ref().map_or(Ok(()), check_material)?;
        self.ground.as_ref().map_or(Ok(()), check_ground)?;
        self.lights.iter().try_for_each(check_light)
    }
}

impl CameraSettings {
    /// Checks all that can be told without a model.
    pub(crate) fn check(&self) -> Result<()> {
        for (name, point) in [
            ("camera position", self.position),
            ("camera focal point", self.focal_point),
            ("camera view up", self.view_up),
        ] {
            point.map_or(Ok(()), |point| ensure_finite(name, point))?;
        }
        ensure("camera view up", self.view_up != Some(Vec3::ZERO), || "it has no length".into())?;
        let is_somewhere = self.position.is_none() || self.position != self.focal_point;
        ensure("camera position", is_somewhere, || {
            "it is the same point as the focal point".into()
        })?;

        let angle = self.view_angle;
        ensure("camera view angle", angle > 0.0 && angle < 180.0, || {
            format!("{angle} is not above 0 and below 180 degrees")
        })?;
        let azimuth = self.azimuth;
        ensure("camera azimuth angle", azimuth.is_finite(), || {
            format!("{azimuth} is not a finite angle")
        })?;
        let elevation = self.elevation;
        ensure("camera elevation angle", elevation > -90.0 && elevation < 90.0, || {
            format!("{elevation} is not above -90 and below 90 degrees")
        })?;
        let margin = self.margin;
        ensure("camera margin", (0.0..0.5).contains(&margin), || {
            format!("{margin} is not at least 0 and below 0.5")
        })?;
        let Projection::Orthographic { height: Some(height) } = self.projection else {
            return Ok(());
        };
        ensure("camera orthographic", height > 0.0 && height.is_finite(), || {
            format!("{height} is not a length above 0")
        })
    }
}

fn check_material(material: &Material) -> Result<()> {
    let [r, g, b, _] = material.base_color;
    ensure_color("material color", [r, g, b])?;
    for (name, value) in [
        ("material metallic", material.metallic),
        ("material roughness", material.roughness),
        ("material transmission", material.transmission),
    ] {
        ensure_share(name, value)?;
    }
    ensure("material ior", (1.0..=10.0).contains(&material.ior), || {
        format!("{} is not between 1 and 10", material.ior)
    })
}

fn check_ground(ground: &Ground) -> Result<()> {
    if let Some(height) = ground.height {
        ensure("ground height", height.is_finite(), || format!("{height} is not a finite number"))?;
    }
    ensure_share("ground reflectivity", ground.reflectivity)?;
    match ground.surface {
        GroundSurface::Shadow => Ok(()),
        GroundSurface::Matte(color) => ensure_color("ground color", color),
        GroundSurface::Checker(a, b) => {
            ensure_color("ground color", a)?;
            ensure_color("ground color", b)
        }
    }
}

fn check_light(light: &Light) -> Result<()> {
    match *light {
        Light::Point { position, intensity, radius } => {
            ensure_finite("light position", position)?;
            ensure_power("light intensity", intensity)?;
            ensure("light radius", radius >= 0.0 && radius.is_finite(), || {
                format!("{radius} is not a length of at least 0")
            })
        }
        Light::Directional { direction, irradiance, angular_radius } => {
            ensure_finite("light direction", direction)?;
            let length = direction.length();
            ensure("light direction", length > 0.0 && length.is_finite(), || {
                format!("its length, {length}, is no use")
            })?;
            ensure_power("light irradiance", irradiance)?;
            ensure("light angular radius", (0.0..90.0).contains(&angular_radius), || {
                format!("{angular_radius} is not at least 0 and below 90 degrees")
            })
        }
        Light::Area { corner, edge_u, edge_v, radiance } => {
            for vector in [corner, edge_u, edge_v] {
                ensure_finite("light corner", vector)?;
            }
            let area = edge_u.cross(edge_v).length();
            ensure("light area", area > 0.0 && area.is_finite(), || {
                format!("its area, {area}, is no use")
            })?;
            ensure_power("light radiance", radiance)
        }
    }
}

fn ensure(what: &str, holds: bool, reason: impl Fn() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(Error::invalid(what, reason())) }
}

fn ensure_share(what: &str, value: f32) -> Result<()> {
    ensure(what, (0.0..=1.0).contains(&value), || format!("{value} is not between 0 and 1"))
}

fn ensure_color(what: &str, color: [f32; 3]) -> Result<()> {
    color.into_iter().try_for_each(|channel| ensure_share(what, channel))
}

fn ensure_power(what: &str, power: [f32; 3]) -> Result<()> {
    ensure(what, power.iter().all(|&v| v >= 0.0 && v.is_finite()), || {
        format!("{power:?} is not three finite numbers of at least 0")
    })
}

fn ensure_finite(what: &str, point: Vec3) -> Result<()> {
    ensure(what, point.is_finite(), || "a coordinate is not a finite number".to_owned())
}
