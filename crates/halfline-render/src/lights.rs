//! Lights as surfaces see them.

use halfline::geometry::{Ray, Vec3};

use crate::camera::Camera;
use crate::color::Color;
use crate::sampling::uniform_cone;
use crate::settings::Light;

/// The light from one point of a light on one point of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Incoming {
    /// Unit direction to the light.
    pub(crate) towards: Vec3,
    /// Distance to the light.
    pub(crate) distance: f64,
    /// What a surface that faces the light receives.
    pub(crate) irradiance: Color,
}

/// What reaches `point` from the point of the light that `sample` chooses; `None` if the light
/// shines elsewhere.
pub(crate) fn illuminate(light: &Light, point: Vec3, sample: [f64; 2]) -> Option<Incoming> {
    match *light {
        Light::Point { position, intensity, radius } => {
            let to_center = position - point;
            let distance = to_center.length();
            if distance <= radius || distance == 0.0 {
                return None;
            }
            let sin2 = (radius / distance) * (radius / distance);
            let towards = uniform_cone(to_center / distance, (1.0 - sin2).sqrt(), sample);
            let irradiance = Vec3::from(intensity) / (distance * distance);
            Some(Incoming { towards, distance, irradiance })
        }
        Light::Directional { direction, irradiance, angular_radius } => {
            let cos_radius = angular_radius.to_radians().cos();
            let towards = uniform_cone(-direction.normalized(), cos_radius, sample);
            Some(Incoming { towards, distance: f64::INFINITY, irradiance: Vec3::from(irradiance) })
        }
        Light::Area { corner, edge_u, edge_v, radiance } => {
            let to_light = corner + edge_u * sample[0] + edge_v * sample[1] - point;
            let distance = to_light.length();
            let towards = to_light / distance;
            // Its length is the area.
            let normal = edge_u.cross(edge_v);
            let projected_area = -towards.dot(normal);
            // False for the NaN of a point on the light.
            (projected_area > 0.0).then(|| Incoming {
                towards,
                distance,
                irradiance: Vec3::from(radiance) * (projected_area / (distance * distance)),
            })
        }
    }
}

/// True if the light casts soft shadows, so that one ray to it is not enough.
pub(crate) fn is_soft(light: &Light) -> bool {
    match *light {
        Light::Point { radius, .. } => radius > 0.0,
        Light::Directional { angular_radius, .. } => angular_radius > 0.0,
        Light::Area { .. } => true,
    }
}

/// The parameter and the radiance of the first light with a surface that `ray` meets from its
/// bright side. The others have none that could be seen.
pub(crate) fn first_visible(lights: &[Light], ray: &Ray) -> Option<(f64, Color)> {
    let mut first: Option<(f64, Color)> = None;
    for light in lights {
        let Light::Area { corner, edge_u, edge_v, radiance } = *light else { continue };
        let normal = edge_u.cross(edge_v);
        let falling = -ray.direction.dot(normal);
        if falling <= 0.0 {
            continue;
        }
        let t = (ray.origin - corner).dot(normal) / falling;
        let at = ray.at(t) - corner;
        let area2 = normal.dot(normal);
        let u = at.cross(edge_v).dot(normal) / area2;
        let v = edge_u.cross(at).dot(normal) / area2;
        let inside = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v);
        if t >= ray.t_min && t <= ray.t_max && inside && first.is_none_or(|(best, _)| t < best) {
            first = Some((t, Vec3::from(radiance)));
        }
    }
    first
}

/// A large soft light above the camera's left shoulder and a dim, broad one from the right.
pub(crate) fn default_lights(camera: &Camera, center: Vec3, size: f64) -> Vec<Light> {
    let away = camera.up() * 0.95 - camera.right() * 0.75 - camera.forward() * 0.7;
    let distance = 1.8 * size;
    let edge = 0.9 * size;
    let towards_model = -away.normalized();
    let edge_u = towards_model.cross(camera.up()).normalized() * edge;
    let edge_v = towards_model.cross(edge_u.normalized()) * edge;
    let corner = center - towards_model * distance - edge_u * 0.5 - edge_v * 0.5;
    // At the model's middle a facing surface receives this, on which a white one shines with 0.8.
    let received = 0.8 * std::f64::consts::PI;
    let radiance = received * distance * distance / (edge * edge);
    let tint = |r: f64, g: f64, b: f64, scale: f64| [r, g, b].map(|v| (v * scale) as f32);
    vec![
        Light::Area { corner, edge_u, edge_v, radiance: tint(1.0, 0.96, 0.9, radiance) },
        Light::Directional {
            direction: -camera.right() * 0.9 + camera.forward() * 0.5 - camera.up() * 0.4,
            irradiance: tint(0.85, 0.92, 1.0, 0.12 * received),
            angular_radius: 25.0,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::geometry::vec3;

    #[test]
    fn point_lights_fall_off_with_the_square() {
        let light = Light::Point {
            position: vec3(0.0, 3.0, 0.0),
            intensity: [18.0, 9.0, 0.0],
            radius: 0.0,
        };
        let incoming = illuminate(&light, Vec3::ZERO, [0.3, 0.7]).unwrap();
        assert_eq!(incoming.towards, vec3(0.0, 1.0, 0.0));
        assert_eq!(incoming.irradiance, vec3(2.0, 1.0, 0.0));
    }

    /// Over a half-space filled by a light of radiance 1 the irradiance is pi; a square of edge 2h
    /// at height h covers 4/sqrt(2) atan(1/sqrt(2)) of it (a configuration factor of 0.5541).
    #[test]
    fn an_area_light_gives_its_configuration_factor() {
        let light = Light::Area {
            corner: vec3(-1.0, 1.0, -1.0),
            edge_u: vec3(2.0, 0.0, 0.0),
            edge_v: vec3(0.0, 0.0, 2.0),
            radiance: [1.0; 3],
        };
        let n = 100;
        let mut sum = 0.0;
        for i in 0..n * n {
            let sample =
                [(f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n)];
            // u x v is -y: it shines down.
            let incoming = illuminate(&light, Vec3::ZERO, sample).unwrap();
            sum += incoming.irradiance.x * incoming.towards.y;
        }
        let factor = sum / f64::from(n * n) / std::f64::consts::PI;
        assert!((factor - 0.5541).abs() < 1e-4, "{factor}");
        assert!(illuminate(&light, vec3(0.0, 2.0, 0.0), [0.5, 0.5]).is_none());
    }

    #[test]
    fn only_the_bright_side_of_an_area_light_is_seen() {
        let light = Light::Area {
            corner: vec3(-1.0, 1.0, -1.0),
            edge_u: vec3(2.0, 0.0, 0.0),
            edge_v: vec3(0.0, 0.0, 2.0),
            radiance: [3.0; 3],
        };
        let seen = |origin, direction| first_visible(&[light], &Ray::new(origin, direction));
        let up = vec3(0.0, 1.0, 0.0);
        assert_eq!(seen(Vec3::ZERO, up), Some((1.0, vec3(3.0, 3.0, 3.0))));
        assert_eq!(seen(vec3(0.0, 2.0, 0.0), -up), None);
        assert_eq!(seen(vec3(1.5, 0.0, 0.0), up), None);
        assert_eq!(seen(Vec3::ZERO, -up), None);
    }
}
