//! Everything that can be asked of a picture, with defaults that give a good one unasked.

mod materials;
mod validate;

use std::str::FromStr;

use halfline::error::{Error, Result};
use halfline::geometry::{Vec3, vec3};
use halfline::mesh::Material;

pub use materials::StockMaterial;

/// What to draw, how large, from where and how.
///
/// Colours are given as they would be typed into a picture editor: red, green and blue between
/// 0 and 1, sRGB-encoded. Only a [`Material`] and the power of a [`Light`] are linear.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct RenderSettings {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// Rays from the eye through each pixel; 1 goes through its middle.
    pub samples: u32,
    /// Chooses among equally good random numbers. The same seed and settings give the same
    /// image, to the bit, on any number of threads.
    pub seed: u64,
    /// From where the picture is taken.
    pub camera: CameraSettings,
    /// How surfaces are turned into colours.
    pub shading: Shading,
    /// The material of the whole model instead of that of its file, vertex colours included.
    pub material: Option<Material>,
    /// Faces that meet at less than this angle, in degrees, look as one smooth surface; `None`
    /// shows each face as flat as it is. Changes the shading, never the outline.
    pub smooth_angle: Option<f64>,
    /// A plane under the model.
    pub ground: Option<Ground>,
    /// What is behind the model.
    pub background: Background,
    /// The lights of [`Shading::Whitted`]; if empty, a soft key light and a dim fill light that
    /// go with the camera.
    pub lights: Vec<Light>,
    /// How often light may be mirrored or refracted on its way to the eye, in
    /// [`Shading::Whitted`].
    pub max_depth: u32,
    /// How far a surface darkens its surroundings in [`Shading::Clay`], as a share of the
    /// diagonal of the model's box.
    pub occlusion_reach: f64,
    /// Rays that look for such surroundings, for each ray from the eye, in [`Shading::Clay`].
    pub occlusion_rays: u32,
}

impl RenderSettings {
    /// The usual settings, for a picture of another size in pixels.
    pub fn new(width: u32, height: u32) -> RenderSettings {
        RenderSettings { width, height, ..RenderSettings::default() }
    }

    /// These settings after a change, as in `settings.with(|s| s.samples = 64)`.
    pub fn with(mut self, change: impl FnOnce(&mut RenderSettings)) -> RenderSettings {
        change(&mut self);
        self
    }
}

impl Default for RenderSettings {
    fn default() -> RenderSettings {
        RenderSettings {
            width: 1280,
            height: 720,
            samples: 16,
            seed: 0,
            camera: CameraSettings::default(),
            shading: Shading::Clay,
            material: None,
            smooth_angle: None,
            ground: None,
            background: Background::Studio,
            lights: Vec::new(),
            max_depth: 8,
            occlusion_reach: 0.5,
            occlusion_rays: 2,
        }
    }
}

/// The most pixels a picture may have: its layers take 36 bytes a pixel.
pub const MAX_PIXELS: u64 = 1 << 27;

/// The most [`RenderSettings::samples`] and [`RenderSettings::occlusion_rays`].
pub const MAX_SAMPLES: u32 = 1 << 16;

/// The greatest [`RenderSettings::max_depth`].
pub const MAX_DEPTH: u32 = 64;

/// How surfaces are turned into colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Shading {
    /// Plaster under a soft sky with one soft key light: shape, and nothing else.
    #[default]
    Clay,
    /// Lights, shadows, mirrors and glass, after Whitted 1980.
    Whitted,
    /// The direction of the surface, x y z as red green blue.
    Normal,
    /// The distance from the camera's plane: near is bright.
    Depth,
    /// A random colour for each face of the file.
    Face,
    /// A heat map of the tree nodes and triangles that each pixel's ray visits.
    Steps,
}

impl Shading {
    /// Every mode, in the order of the documentation.
    pub const ALL: [Shading; 6] = [
        Shading::Clay,
        Shading::Whitted,
        Shading::Normal,
        Shading::Depth,
        Shading::Face,
        Shading::Steps,
    ];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Shading::Clay => "clay",
            Shading::Whitted => "whitted",
            Shading::Normal => "normal",
            Shading::Depth => "depth",
            Shading::Face => "face",
            Shading::Steps => "steps",
        }
    }

    /// What it shows, in a line for a help text.
    pub const fn description(self) -> &'static str {
        match self {
            Shading::Clay => "Plaster under a soft sky with one soft key light",
            Shading::Whitted => "Lights, shadows, mirrors and glass",
            Shading::Normal => "The direction of the surface as a colour",
            Shading::Depth => "The distance from the camera: near is bright",
            Shading::Face => "A random colour for each face",
            Shading::Steps => "A heat map of the tree nodes and triangles visited",
        }
    }
}

impl FromStr for Shading {
    type Err = Error;
    fn from_str(name: &str) -> Result<Shading> {
        Shading::ALL.into_iter().find(|shading| shading.name() == name).ok_or_else(|| {
            let names = Shading::ALL.map(Shading::name).join(", ");
            Error::invalid("shading", format!("{name:?} is none of {names}"))
        })
    }
}

/// From where the model is seen. Unless told otherwise, the camera stands at three quarters,
/// a little above the model, as near as the whole model fits into the picture.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct CameraSettings {
    /// Perspective or not.
    pub projection: Projection,
    /// The angle between the picture's top and bottom edges, in degrees, above 0 and below 180.
    /// In an orthographic picture it only sets the distance of the camera.
    pub view_angle: f64,
    /// Which axis of the model points up.
    pub up: Up,
    /// Where the camera is; found from the model if `None`.
    pub position: Option<Vec3>,
    /// What the camera looks at; the middle of the model if `None`.
    pub focal_point: Option<Vec3>,
    /// The direction that is up in the picture, instead of that of `up`; a camera that looks along
    /// `up` itself has the model's front at the bottom of the picture, seen from above.
    pub view_up: Option<Vec3>,
    /// How far the camera goes round the model to the right of its front, in degrees. Without
    /// effect once `position` is given.
    pub azimuth: f64,
    /// How far the camera is raised above the model's middle, in degrees, between -90 and 90,
    /// both excluded. Without effect once `position` is given.
    pub elevation: f64,
    /// The share of the picture's width and height, or more, that automatic framing leaves free
    /// in all; at least 0 and below 0.5.
    pub margin: f64,
}

impl Default for CameraSettings {
    fn default() -> CameraSettings {
        CameraSettings {
            projection: Projection::Perspective,
            view_angle: 30.0,
            up: Up::PlusY,
            position: None,
            focal_point: None,
            view_up: None,
            azimuth: 30.0,
            elevation: 18.0,
            margin: 0.1,
        }
    }
}

impl CameraSettings {
    /// A camera at `position` that looks at `focal_point`.
    pub fn looking_at(position: Vec3, focal_point: Vec3) -> CameraSettings {
        CameraSettings {
            position: Some(position),
            focal_point: Some(focal_point),
            ..CameraSettings::default()
        }
    }
}

/// How space is laid flat.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Projection {
    /// As a pinhole camera sees: what is far is small.
    #[default]
    Perspective,
    /// Parallel lines stay parallel.
    Orthographic {
        /// The height of the picture in the model's units; fits the model if `None`.
        height: Option<f64>,
    },
}

/// Which axis of the model points up. It also tells the model's front: with +Y up the model
/// looks along +Z, as in glTF; with +Z up along -Y, as in most scans and CAD files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Up {
    /// The model's +X axis points up.
    #[cfg_attr(feature = "serde", serde(rename = "+X"))]
    PlusX,
    /// The model's -X axis points up.
    #[cfg_attr(feature = "serde", serde(rename = "-X"))]
    MinusX,
    /// The model's +Y axis points up.
    #[default]
    #[cfg_attr(feature = "serde", serde(rename = "+Y"))]
    PlusY,
    /// The model's -Y axis points up.
    #[cfg_attr(feature = "serde", serde(rename = "-Y"))]
    MinusY,
    /// The model's +Z axis points up.
    #[cfg_attr(feature = "serde", serde(rename = "+Z"))]
    PlusZ,
    /// The model's -Z axis points up.
    #[cfg_attr(feature = "serde", serde(rename = "-Z"))]
    MinusZ,
}

impl Up {
    /// The unit vector.
    pub const fn vector(self) -> Vec3 {
        match self {
            Up::PlusX => vec3(1.0, 0.0, 0.0),
            Up::MinusX => vec3(-1.0, 0.0, 0.0),
            Up::PlusY => vec3(0.0, 1.0, 0.0),
            Up::MinusY => vec3(0.0, -1.0, 0.0),
            Up::PlusZ => vec3(0.0, 0.0, 1.0),
            Up::MinusZ => vec3(0.0, 0.0, -1.0),
        }
    }

    /// The direction to the right of someone who looks at the model's front.
    pub const fn right(self) -> Vec3 {
        match self {
            Up::PlusX | Up::MinusX => vec3(0.0, 1.0, 0.0),
            _ => vec3(1.0, 0.0, 0.0),
        }
    }

    /// The direction in which the model looks.
    pub fn front(self) -> Vec3 {
        self.right().cross(self.vector())
    }
}

impl FromStr for Up {
    type Err = Error;
    /// Reads `+Y`, `Y`, `y`, `-z` and so on.
    fn from_str(text: &str) -> Result<Up> {
        match text.to_ascii_uppercase().as_str() {
            "X" | "+X" => Ok(Up::PlusX),
            "-X" => Ok(Up::MinusX),
            "Y" | "+Y" => Ok(Up::PlusY),
            "-Y" => Ok(Up::MinusY),
            "Z" | "+Z" => Ok(Up::PlusZ),
            "-Z" => Ok(Up::MinusZ),
            _ => Err(Error::invalid("up", format!("{text:?} is none of +X, -X, +Y, -Y, +Z, -Z"))),
        }
    }
}

/// A plane at right angles to the up axis. It is not part of the mesh, and only seen from above.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct Ground {
    /// Where it lies along the up axis; touching the model from below if `None`.
    pub height: Option<f64>,
    /// What it looks like.
    pub surface: GroundSurface,
    /// How much it mirrors, from 0 to 1, in [`Shading::Whitted`].
    pub reflectivity: f32,
}

impl Ground {
    /// A plane that touches the model from below and does not mirror.
    pub fn new(surface: GroundSurface) -> Ground {
        Ground { surface, ..Ground::default() }
    }

    /// This plane at another height along the up axis.
    pub fn at_height(self, height: f64) -> Ground {
        Ground { height: Some(height), ..self }
    }

    /// This plane, mirroring a share of the light, from 0 to 1.
    pub fn mirroring(self, reflectivity: f32) -> Ground {
        Ground { reflectivity, ..self }
    }
}

/// What the ground looks like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum GroundSurface {
    /// The ground looks as the background, only darker where the model keeps light away: a studio's
    /// backdrop.
    #[default]
    Shadow,
    /// The ground has one colour.
    Matte([f32; 3]),
    /// The ground has two colours, in squares of a tenth of the model's diagonal.
    Checker([f32; 3], [f32; 3]),
}

impl GroundSurface {
    /// Light and middle grey, in squares.
    pub const CHECKER: GroundSurface = GroundSurface::Checker([0.82; 3], [0.45; 3]);
}

/// What is behind the model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Background {
    /// A light grey that falls off softly from the middle, as a photographer's paper backdrop.
    #[default]
    Studio,
    /// The background has one colour.
    Color([f32; 3]),
    /// Nothing: the picture's alpha tells how much of a pixel the model covers.
    Transparent,
}

/// A source of light. Colours of light are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Light {
    /// Shines from a small sphere, or from a point if `radius` is 0.
    Point {
        /// Where the light is.
        position: Vec3,
        /// Radiant intensity: a surface at distance d, facing it, receives this / d².
        intensity: [f32; 3],
        /// Radius of the sphere; the larger, the softer the shadows.
        radius: f64,
    },
    /// Shines everywhere from the same direction, as the sun.
    Directional {
        /// Where the light travels to.
        direction: Vec3,
        /// What a surface that faces it receives.
        irradiance: [f32; 3],
        /// Half the angle under which it is seen, in degrees, from 0 to below 90; the larger,
        /// the softer the shadows.
        angular_radius: f64,
    },
    /// Shines from a parallelogram, to the side of `edge_u` x `edge_v`.
    Area {
        /// A corner of the parallelogram.
        corner: Vec3,
        /// The edge from `corner` to the second corner.
        edge_u: Vec3,
        /// The edge from `corner` to the fourth corner.
        edge_v: Vec3,
        /// The radiance that the light sends out, the same in all directions.
        radiance: [f32; 3],
    },
}
