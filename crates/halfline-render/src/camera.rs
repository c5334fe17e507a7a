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
        check(camera)?;
        let (center, size) = center_and_size(bounds)?;
        let (width, height) = (f64::from(settings.width), f64::from(settings.height));
        let aspect = width / height;
        let slope = (camera.view_angle.to_radians() / 2.0).tan();

        // Find where to look.
        let focal_point = camera.focal_point.unwrap_or(center);
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
        let axes = axes.ok_or_else(|| {
            Error::invalid("camera up", "it is parallel to the direction of view")
        })?;

        // Stand where the model fills the picture, unless told where to stand.
        let share = 1.0 - camera.margin;
        let slopes = Slopes {
            left: slope * aspect * share,
            right: slope * aspect * (share - 2.0 * free_right),
            down: slope * share,
            up: slope * share,
        };
        // Nearer than this to the nearest vertex, a picture of it would show nothing else.
        let clearance = size / 64.0;
        let stand = framing::perspective_stand(mesh, center, &axes, slopes, clearance);
        let [x, y, z] = stand.map_or([0.0, 0.0, -size / slope], |stand| stand.eye);
        let framed_eye = center + axes.right * x + axes.up * y + axes.forward * z;
        let distance = (focal_point - framed_eye).dot(axes.forward).max(clearance);

        let built = match camera.projection {
            Projection::Perspective => {
                let eye = match (camera.position, camera.focal_point) {
                    (Some(position), _) => position,
                    (None, Some(focal_point)) => focal_point - axes.forward * distance,
                    (None, None) => framed_eye,
                };
                Camera { eye, axes, width, height, lens: Lens::Perspective(slope) }
            }
            Projection::Orthographic { height: asked_height } => {
                let model = framing::box_in_axes(mesh, center, &axes)
                    .unwrap_or(Aabb { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) });
                let middle = model.center();
                // The point on which the picture is centred, in the camera's axes.
                let centered_on = match (camera.position, camera.focal_point) {
                    (None, None) => [middle.x, middle.y],
                    _ => {
                        let [x, y, _] = axes.coordinates(focal_point - center);
                        [x, y]
                    }
                };
                let reach_x =
                    (model.max.x - centered_on[0]).max(centered_on[0] - model.min.x).max(0.0);
                let reach_y =
                    (model.max.y - centered_on[1]).max(centered_on[1] - model.min.y).max(0.0);
                let fitting = (reach_y / share).max(reach_x / (aspect * (share - free_right)));
                let half_height = match asked_height {
                    Some(height) => height / 2.0,
                    None if fitting > 0.0 => fitting,
                    None => size / 2.0,
                };
                let eye = camera.position.unwrap_or_else(|| {
                    let free = match (camera.position, camera.focal_point) {
                        (None, None) => free_right * half_height * aspect,
                        _ => 0.0,
                    };
                    center
                        + axes.right * (centered_on[0] + free)
                        + axes.up * centered_on[1]
                        + axes.forward * (model.min.z - size)
                });
                Camera { eye, axes, width, height, lens: Lens::Orthographic(half_height) }
            }
        };
        if !built.eye.is_finite() {
            return Err(Error::invalid(
                "camera view angle",
                format!("{} is so small that the camera would be too far away", camera.view_angle),
            ));
        }
        Ok(built)
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

fn check(camera: &CameraSettings) -> Result<()> {
    let points = [
        ("camera position", camera.position),
        ("camera focal point", camera.focal_point),
        ("camera up", camera.view_up),
    ];
    for (name, point) in points {
        if point.is_some_and(|p| !p.is_finite()) {
            return Err(Error::invalid(name, "a coordinate is not a finite number"));
        }
    }
    if camera.view_up == Some(Vec3::ZERO) {
        return Err(Error::invalid("camera up", "it has no length"));
    }
    let within = |name: &str, value: f64, inside: bool, range: &str| {
        if inside { Ok(()) } else { Err(Error::invalid(name, format!("{value} is not {range}"))) }
    };
    within(
        "camera view angle",
        camera.view_angle,
        camera.view_angle > 0.0 && camera.view_angle < 180.0,
        "above 0 and below 180 degrees",
    )?;
    within("camera azimuth", camera.azimuth, camera.azimuth.is_finite(), "a finite angle")?;
    within(
        "camera elevation",
        camera.elevation,
        camera.elevation > -90.0 && camera.elevation < 90.0,
        "above -90 and below 90 degrees",
    )?;
    within(
        "camera margin",
        camera.margin,
        camera.margin >= 0.0 && camera.margin < 0.5,
        "at least 0 and below 0.5",
    )?;
    if let Projection::Orthographic { height: Some(height) } = camera.projection {
        within(
            "orthographic height",
            height,
            height > 0.0 && height.is_finite(),
            "a length above 0",
        )?;
    }
    Ok(())
}
