//! Where a picture is seen from: options of every subcommand that has a camera.

use clap::Args;
use halfline::geometry::Vec3;
use halfline_render::{CameraSettings, Projection, Up, text};

use crate::values;

/// All that makes [`CameraSettings`].
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera (by itself it shows the whole model)")]
pub struct CameraOptions {
    /// Which axis points up: +X, -X, +Y, -Y, +Z or -Z
    #[arg(long, value_name = "AXIS", default_value = "+Y", allow_hyphen_values = true)]
    #[arg(value_parser = up)]
    up: Up,

    /// Where the camera is
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = text::vector)]
    camera_position: Option<Vec3>,

    /// What it looks at
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = text::vector)]
    camera_focal_point: Option<Vec3>,

    /// The direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    #[arg(value_parser = text::direction)]
    camera_view_up: Option<Vec3>,

    /// Angle between the picture's top and bottom edges, in degrees
    #[arg(long, value_name = "DEGREES", default_value = "30", allow_hyphen_values = true)]
    #[arg(value_parser = values::within(0.0, 180.0, false))]
    camera_view_angle: f64,

    /// How far to go round the model to the right of its front, in degrees
    #[arg(long, value_name = "DEGREES", default_value = "30", allow_hyphen_values = true)]
    #[arg(value_parser = text::finite, conflicts_with = "camera_position")]
    camera_azimuth_angle: f64,

    /// How far to rise above the model's middle, in degrees
    #[arg(long, value_name = "DEGREES", default_value = "18", allow_hyphen_values = true)]
    #[arg(value_parser = values::within(-90.0, 90.0, false), conflicts_with = "camera_position")]
    camera_elevation_angle: f64,

    /// Parallel lines stay parallel; the picture is HEIGHT units of the model high
    #[arg(long, value_name = "HEIGHT", num_args = 0..=1, require_equals = true)]
    #[arg(value_parser = values::within(0.0, f64::INFINITY, false))]
    camera_orthographic: Option<Option<f64>>,
}

impl CameraOptions {
    /// The settings of the camera; the reason if options that are right by themselves make no sense
    /// together.
    pub fn settings(&self) -> Result<CameraSettings, String> {
        if self.camera_position.is_some() && self.camera_position == self.camera_focal_point {
            return Err("--camera-position and --camera-focal-point are the same point".into());
        }
        let mut settings = CameraSettings::default();
        settings.projection = match self.camera_orthographic {
            Some(height) => Projection::Orthographic { height },
            None => Projection::Perspective,
        };
        settings.view_angle = self.camera_view_angle;
        settings.up = self.up;
        settings.position = self.camera_position;
        settings.focal_point = self.camera_focal_point;
        settings.view_up = self.camera_view_up;
        settings.azimuth = self.camera_azimuth_angle;
        settings.elevation = self.camera_elevation_angle;
        Ok(settings)
    }
}

fn up(text: &str) -> Result<Up, String> {
    text.parse().map_err(|_| "expected +X, -X, +Y, -Y, +Z or -Z".into())
}
