//! A plane under the model, met by formula instead of by triangles.

use halfline::geometry::{Aabb, Ray, Vec3};
use halfline::numeric::SurfacePoint;

use crate::color::{Color, decode_srgb};
use crate::settings::{Ground, GroundSurface, Up};

/// The ground, made ready for rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroundPlane {
    up: Vec3,
    height: f64,
    center: Vec3,
    /// Two unit vectors that span the plane.
    across: [Vec3; 2],
    square: f64,
    fade: [f64; 2],
    pub(crate) paint: Paint,
    pub(crate) reflectivity: f64,
}

/// What the ground looks like at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Paint {
    /// Shows the background, darkened.
    Shadow,
    /// Linear colours, in squares.
    Checker(Color, Color),
}

impl GroundPlane {
    /// `size` is the diagonal of the model's `bounds`.
    pub(crate) fn new(ground: &Ground, up: Up, bounds: &Aabb, size: f64) -> GroundPlane {
        let center = if bounds.is_empty() { Vec3::ZERO } else { bounds.center() };
        let lowest = if bounds.is_empty() {
            -0.5 * size
        } else {
            // The axis is one of the box's own: its lowest corner along it is the lowest point.
            bounds.min.dot(up.vector()).min(bounds.max.dot(up.vector()))
        };
        // Flat faces on which a model stands must not fight with the ground for its place, in
        // spite of the rounding of the camera's rays; a ten-thousandth is not seen.
        let hair = size * 1e-4;
        let paint = match ground.surface {
            GroundSurface::Shadow => Paint::Shadow,
            GroundSurface::Matte(color) => Paint::Checker(decode_srgb(color), decode_srgb(color)),
            GroundSurface::Checker(a, b) => Paint::Checker(decode_srgb(a), decode_srgb(b)),
        };
        GroundPlane {
            up: up.vector(),
            height: ground.height.unwrap_or(lowest - hair),
            center,
            across: [up.right(), up.front()],
            square: size * 0.1,
            fade: [size * 2.0, size * 10.0],
            paint,
            reflectivity: f64::from(ground.reflectivity),
        }
    }

    /// The parameter at which `ray` meets the upper side of the plane, unless the plane has
    /// faded away there. Rays that run along the plane or come from below do not meet it.
    pub(crate) fn intersect(&self, ray: &Ray) -> Option<f64> {
        let falling = -ray.direction.dot(self.up);
        let above = ray.origin.dot(self.up) - self.height;
        if falling <= 0.0 || above < 0.0 {
            return None;
        }
        let t = above / falling;
        (t >= ray.t_min && t <= ray.t_max && self.opacity(ray.at(t)) > 0.0).then_some(t)
    }

    /// The point where `ray` meets the plane.
    pub(crate) fn point(&self, ray: &Ray, t: f64) -> SurfacePoint {
        SurfacePoint::on_plane(ray.at(t), self.up, t * ray.direction.length())
    }

    /// The colour of the paint at `point`; of [`Paint::Shadow`] white.
    pub(crate) fn color(&self, point: Vec3) -> Color {
        match self.paint {
            Paint::Shadow => Vec3::splat(1.0),
            Paint::Checker(a, b) => {
                let from_center = point - self.center;
                let [i, j] = self.across.map(|axis| (from_center.dot(axis) / self.square).floor());
                if (i + j).rem_euclid(2.0) < 1.0 { a } else { b }
            }
        }
    }

    /// How much is left of the ground at `point`: with distance it fades into the background.
    pub(crate) fn opacity(&self, point: Vec3) -> f64 {
        let from_center = point - self.center;
        let [x, y] = self.across.map(|axis| from_center.dot(axis));
        let s = ((x.hypot(y) - self.fade[0]) / (self.fade[1] - self.fade[0])).clamp(0.0, 1.0);
        // A NaN, from an infinite t, stays one and counts as nothing.
        1.0 - s * s * (3.0 - 2.0 * s)
    }
}
