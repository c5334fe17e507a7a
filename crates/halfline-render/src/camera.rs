//! Ray generation: pinhole and orthographic cameras.

use halfline::error::{Error, Result};
use halfline::geometry::{Aabb, Ray, Vec3};
use halfline::mesh::Mesh;

use crate::framing::{self, Axes, Slopes, unit};
use crate::settings::{CameraSettings, Projection, RenderSettings, Up};

/// Turns points of the picture into rays.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    eye: Vec3,
    axes: Axes,
    width: f64,
    height: f64,
    lens: Lens,
}

/// What one half of the picture's height stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lens {
    /// The tangent of half the view angle.
    Perspective(f64),
    /// A length in the model's units.
    Orthographic(f64),
}

impl Camera {
    /// The camera that `settings` describe for `mesh`, which lies within `bounds`.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the setting that makes no sense.
    pub fn new(settings: &RenderSettings, mesh: &Mesh, bounds: &Aabb) -> Result<Camera> {
        Camera::with_free_right_side(settings, mesh, bounds, 0.0)
    }

    /// [`Camera::new`], with automatic framing keeping the given share of the picture's width
    /// free at its right edge.
    pub(crate) fn with_free_right_side(
        settings: &RenderSettings,
        mesh: &Mesh,
        bounds: &Aabb,
        free_right: f64,
    ) -> Result<Camera> {
        let camera = &settings.camera;
        camera.check()?;
        let (center, size) = center_and_size(bounds)?;
        let (width, height) = (f64::from(settings.width), f64::from(settings.height));

        // Find where to look.
        let focal_point = camera.focal_point.unwrap_or(center);
        let axes = axes_towards(focal_point, camera)?;

        // Stand where the model fills the picture, unless told where to stand.
        let aspect = width / height;
        let framing = Framing { camera, mesh, center, size, focal_point, axes, aspect, free_right };
        let (eye, lens) = match camera.projection {
            Projection::Perspective => framing.perspective(),
            Projection::Orthographic { height } => framing.orthographic(height),
        };
        if !eye.is_finite() {
            return Err(Error::invalid(
                "camera view angle",
                format!("{} is so small that the camera would be too far away", camera.view_angle),
            ));
        }
        Ok(Camera { eye, axes, width, height, lens })
    }

    /// The ray through the point of the picture `x` pixels right of and `y` pixels below its
    /// top left corner: (0.5, 0.5) is the middle of the first pixel. Its direction has length 1.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let right = (2.0 * x - self.width) / self.height;
        let up = (self.height - 2.0 * y) / self.height;
        match self.lens {
            Lens::Perspective(slope) => {
                let direction = self.axes.forward
                    + self.axes.right * (right * slope)
                    + self.axes.up * (up * slope);
                Ray::new(self.eye, direction.normalized())
            }
            Lens::Orthographic(half_height) => {
                let origin = self.eye
                    + self.axes.right * (right * half_height)
                    + self.axes.up * (up * half_height);
                Ray::new(origin, self.axes.forward)
            }
        }
    }

    /// Distance of `point` from the camera's plane, along its axis.
    pub fn depth(&self, point: Vec3) -> f64 {
        (point - self.eye).dot(self.axes.forward)
    }

    /// Where the camera is.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// The direction in which it looks.
    pub fn forward(&self) -> Vec3 {
        self.axes.forward
    }

    /// The direction to the right of the picture.
    pub fn right(&self) -> Vec3 {
        self.axes.right
    }

    /// The direction to the top of the picture.
    pub fn up(&self) -> Vec3 {
        self.axes.up
    }
}

/// What decides where a camera stands.
struct Framing<'a> {
    camera: &'a CameraSettings,
    mesh: &'a Mesh,
    /// The middle of the model and the length of its diagonal.
    center: Vec3,
    size: f64,
    focal_point: Vec3,
    axes: Axes,
    /// The picture's width over its height.
    aspect: f64,
    /// The share of the picture's width that stays free at its right edge.
    free_right: f64,
}

impl Framing<'_> {
    /// The share of the picture's width and height that the model may fill.
    fn share(&self) -> f64 {
        1.0 - self.camera.margin
    }

    /// Where a camera with a view angle stands, and its lens.
    fn perspective(&self) -> (Vec3, Lens) {
        let Framing { camera, axes, .. } = self;
        let slope = (camera.view_angle.to_radians() / 2.0).tan();
        let eye = match (camera.position, camera.focal_point) {
            (Some(position), _) => position,
            (None, Some(focal_point)) => {
                let (framed_eye, clearance) = self.framed_eye(slope);
                let distance = (focal_point - framed_eye).dot(axes.forward).max(clearance);
                focal_point - axes.forward * distance
            }
            (None, None) => self.framed_eye(slope).0,
        };
        (eye, Lens::Perspective(slope))
    }

    /// The closest eye that sees the whole model, and how far it keeps from the nearest vertex.
    fn framed_eye(&self, slope: f64) -> (Vec3, f64) {
        let Framing { axes, size, aspect, .. } = self;
        let share = self.share();
        let slopes = Slopes {
            left: slope * aspect * share,
            right: slope * aspect * (share - 2.0 * self.free_right),
            down: slope * share,
            up: slope * share,
        };
        // Nearer than this to the nearest vertex, a picture of it would show nothing else.
        let clearance = size / 64.0;
        let stand = framing::perspective_stand(self.mesh, self.center, axes, slopes, clearance);
        let [x, y, z] = stand.map_or([0.0, 0.0, -size / slope], |stand| stand.eye);
        (self.center + axes.right * x + axes.up * y + axes.forward * z, clearance)
    }

    /// Where a camera without perspective stands, and its lens, of which `height` is asked for.
    fn orthographic(&self, height: Option<f64>) -> (Vec3, Lens) {
        let Framing { camera, axes, center, aspect, free_right, .. } = self;
        let model = framing::box_in_axes(self.mesh, *center, axes)
            .unwrap_or(Aabb { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) });
        let is_automatic = camera.position.is_none() && camera.focal_point.is_none();

        // Centre the picture on a point, in the camera's axes.
        let [x, y] = if is_automatic {
            let middle = model.center();
            [middle.x, middle.y]
        } else {
            let [x, y, _] = axes.coordinates(self.focal_point - *center);
            [x, y]
        };

        // Let it reach as far to all sides as the model does, unless told how far.
        let share = self.share();
        let reach_x = (model.max.x - x).max(x - model.min.x).max(0.0);
        let reach_y = (model.max.y - y).max(y - model.min.y).max(0.0);
        let fitting = (reach_y / share).max(reach_x / (aspect * (share - free_right)));
        let half_height = match height {
            Some(height) => height / 2.0,
            None if fitting > 0.0 => fitting,
            None => self.size / 2.0,
        };

        // Stand in front of the model.
        let eye = camera.position.unwrap_or_else(|| {
            let free = if is_automatic { free_right * half_height * aspect } else { 0.0 };
            *center
                + axes.right * (x + free)
                + axes.up * y
                + axes.forward * (model.min.z - self.size)
        });
        (eye, Lens::Orthographic(half_height))
    }
}

/// The axes of a camera that looks at `focal_point`.
fn axes_towards(focal_point: Vec3, camera: &CameraSettings) -> Result<Axes> {
    let forward = match camera.position {
        Some(position) => unit(focal_point - position).ok_or_else(|| {
            Error::invalid("camera position", "it is the same point as the focal point")
        })?,
        None => default_forward(camera),
    };
    let axes = match camera.view_up {
        Some(up) => Axes::looking(forward, up),
        None => Axes::looking(forward, camera.up.vector())
            .or_else(|| Axes::looking(forward, up_in_vertical_views(camera.up, forward))),
    };
    axes.ok_or_else(|| Error::invalid("camera view up", "it is parallel to the direction of view"))
}

/// The middle of `bounds` and the length of its diagonal; where there is no model or it is a
/// single point, a length that makes sense there.
pub(crate) fn center_and_size(bounds: &Aabb) -> Result<(Vec3, f64)> {
    if bounds.is_empty() {
        return Ok((Vec3::ZERO, 1.0));
    }
    let (center, size) = (bounds.center(), bounds.extent().length());
    // Scaled by a few dozens, the squares of lengths must still be finite.
    if !(size < f64::MAX.sqrt() / 1e6 && center.length() < f64::MAX.sqrt() / 1e6) {
        return Err(Error::invalid("mesh", "its coordinates are too large to be drawn"));
    }
    // A unit, but one that shows where the coordinates' last bits are coarser than that.
    let fallback = (center.abs().max_element() * f64::EPSILON * 1e6).max(1.0);
    Ok((center, if size > 0.0 { size } else { fallback }))
}

/// From the model's front, turned by azimuth and elevation.
fn default_forward(camera: &CameraSettings) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = camera.azimuth.to_radians().sin_cos();
    let (sin_elevation, cos_elevation) = camera.elevation.to_radians().sin_cos();
    let around = camera.up.front() * cos_azimuth + camera.up.right() * sin_azimuth;
    -(around * cos_elevation + camera.up.vector() * sin_elevation)
}

/// What is up in a picture taken along the `up` axis itself: what it would become if a camera
/// before the model's front rose, or sank, until it looks straight at the model.
fn up_in_vertical_views(up: Up, forward: Vec3) -> Vec3 {
    if forward.dot(up.vector()) < 0.0 { -up.front() } else { up.front() }
}
