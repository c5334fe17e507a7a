//! Mirror directions, Snell's law and Fresnel's equations.

use halfline::geometry::Vec3;

/// The direction of `incoming` after a mirror with the given unit normal, of either side.
pub(crate) fn reflect(incoming: Vec3, normal: Vec3) -> Vec3 {
    incoming - normal * (2.0 * incoming.dot(normal))
}

/// What happens where light crosses from one medium into another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// Share of the light that is mirrored, the mean of both polarisations; 1 for total internal
    /// reflection.
    pub(crate) reflectance: f64,
    /// The unit direction of the rest; zero if there is none.
    pub(crate) refracted: Vec3,
}

/// Light along the unit vector `incoming` meets a boundary with the unit normal `normal`,
/// turned against it. `relative_ior` is the index of refraction behind the boundary over that
/// in front of it.
///
/// Snell's law and Fresnel's equations for dielectrics, as in Born and Wolf 1999, section 1.5.
pub(crate) fn cross_boundary(incoming: Vec3, normal: Vec3, relative_ior: f64) -> Crossing {
    let cos_in = (-incoming.dot(normal)).clamp(0.0, 1.0);
    let sin2_out = (1.0 - cos_in * cos_in) / (relative_ior * relative_ior);
    if sin2_out >= 1.0 {
        return Crossing { reflectance: 1.0, refracted: Vec3::ZERO };
    }
    let cos_out = (1.0 - sin2_out).sqrt();
    let perpendicular = (cos_in - relative_ior * cos_out) / (cos_in + relative_ior * cos_out);
    let parallel = (relative_ior * cos_in - cos_out) / (relative_ior * cos_in + cos_out);
    let reflectance = 0.5 * (perpendicular * perpendicular + parallel * parallel);
    let refracted = incoming / relative_ior + normal * (cos_in / relative_ior - cos_out);
    Crossing { reflectance, refracted: refracted.normalized() }
}

/// Schlick's approximation (1994) of a metal's reflectance, from that at right angles.
pub(crate) fn metal_reflectance(at_right_angles: Vec3, cosine: f64) -> Vec3 {
    let grazing = (1.0 - cosine).clamp(0.0, 1.0).powi(5);
    at_right_angles + (Vec3::splat(1.0) - at_right_angles) * grazing
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::geometry::vec3;

    const UP: Vec3 = vec3(0.0, 1.0, 0.0);

    fn falling(degrees: f64) -> Vec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        vec3(sin, -cos, 0.0)
    }

    #[test]
    fn mirrors_keep_the_angle() {
        let out = reflect(falling(30.0), UP);
        assert!((out - vec3(0.5, 0.75_f64.sqrt(), 0.0)).length() < 1e-15);
        assert!((reflect(falling(30.0), -UP) - out).length() < 1e-15);
    }

    /// Air to glass of index 1.5 at 45 degrees: Hecht's textbook case, 28.1255 degrees and a
    /// reflectance of 9.2013 % across and 0.8466 % along the plane of incidence.
    #[test]
    fn glass_at_45_degrees() {
        let crossing = cross_boundary(falling(45.0), UP, 1.5);
        let angle = crossing.refracted.x.asin().to_degrees();
        assert!((angle - 28.125_5).abs() < 1e-3, "{angle}");
        assert!((crossing.refracted.length() - 1.0).abs() < 1e-15 && crossing.refracted.y < 0.0);
        let mean = 0.5 * (0.092_013 + 0.008_466);
        assert!((crossing.reflectance - mean).abs() < 1e-5, "{}", crossing.reflectance);
    }

    #[test]
    fn four_percent_at_right_angles_both_ways() {
        for ior in [1.5, 1.0 / 1.5] {
            let crossing = cross_boundary(-UP, UP, ior);
            assert!((crossing.reflectance - 0.04).abs() < 1e-12);
            assert!((crossing.refracted + UP).length() < 1e-15);
        }
    }

    /// From glass to air the critical angle is asin(1 / 1.5) = 41.81 degrees.
    #[test]
    fn total_internal_reflection_begins_at_the_critical_angle() {
        let inside = |degrees| cross_boundary(falling(degrees), UP, 1.0 / 1.5);
        assert!(inside(41.7).reflectance < 1.0);
        assert_eq!(inside(41.9), Crossing { reflectance: 1.0, refracted: Vec3::ZERO });
    }

    /// At Brewster's angle, atan 1.5, nothing polarised along the plane of incidence returns.
    #[test]
    fn brewster_s_angle_loses_one_polarisation() {
        let angle = 1.5_f64.atan();
        let crossing = cross_boundary(falling(angle.to_degrees()), UP, 1.5);
        let (n2, one) = (1.5_f64 * 1.5, 1.0);
        let perpendicular = ((one - n2) / (one + n2)).powi(2);
        assert!((crossing.reflectance - 0.5 * perpendicular).abs() < 1e-12);
    }

    #[test]
    fn no_boundary_no_effect() {
        let crossing = cross_boundary(falling(70.0), UP, 1.0);
        assert!(crossing.reflectance < 1e-15);
        assert!((crossing.refracted - falling(70.0)).length() < 1e-15);
    }

    #[test]
    fn metals_whiten_towards_grazing() {
        let gold = vec3(1.0, 0.77, 0.34);
        assert_eq!(metal_reflectance(gold, 1.0), gold);
        assert_eq!(metal_reflectance(gold, 0.0), Vec3::splat(1.0));
    }
}
