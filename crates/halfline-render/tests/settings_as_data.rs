//! Settings that travel as JSON.

use halfline::geometry::vec3;
use halfline::mesh::Material;
use halfline_render::{
    Background, CameraSettings, Ground, GroundSurface, Light, Projection, RenderSettings, Shading,
    StockMaterial, Up,
};

/// Every part of the settings in some other state than the usual one, with numbers of many digits.
fn settings() -> [RenderSettings; 3] {
    let [third, tiny] = [1.0 / 3.0, 4.940_656_458_4e-324_f64];
    let point = vec3(third, -tiny, 0.1 + 0.2);
    [
        RenderSettings::default(),
        RenderSettings::new(7, 5).with(|s| {
            s.samples = 3;
            s.seed = u64::MAX;
            s.camera = CameraSettings::looking_at(point, vec3(1e300, -0.0, 5e-324));
            s.camera.up = Up::MinusZ;
            s.camera.view_up = Some(point);
            s.camera.projection = Projection::Orthographic { height: Some(third) };
            s.shading = Shading::Whitted;
            s.material = Some(StockMaterial::Glass.into());
            s.smooth_angle = Some(30.0 * third);
            s.ground = Some(Ground::new(GroundSurface::CHECKER).at_height(-third).mirroring(0.1));
            s.background = Background::Color([0.1, 0.2, 0.3]);
            s.lights = vec![
                Light::Point { position: point, intensity: [0.1, 1e-20, 3.3], radius: third },
                Light::Directional {
                    direction: point,
                    irradiance: [std::f32::consts::PI; 3],
                    angular_radius: third,
                },
                Light::Area { corner: point, edge_u: point, edge_v: -point, radiance: [16.7; 3] },
            ];
            s.occlusion_reach = 0.1 * third;
        }),
        RenderSettings::new(1, 1).with(|s| {
            s.camera.projection = Projection::Orthographic { height: None };
            s.material = Some(Material { roughness: 0.7, ..Material::default() });
            s.ground = Some(Ground::new(GroundSurface::Matte([0.3, 0.6, 0.9])));
            s.background = Background::Transparent;
        }),
    ]
}

#[test]
fn what_arrives_is_the_same_to_the_bit() {
    for settings in settings() {
        let json = serde_json::to_string(&settings).unwrap();
        let again: RenderSettings = serde_json::from_str(&json).unwrap();
        // Its text has every bit of every number, the sign of zero included.
        assert_eq!(format!("{again:?}"), format!("{settings:?}"), "{json}");
    }
}

#[test]
fn what_is_left_out_is_as_usual() {
    let some = r#"{"width": 64, "height": 48, "camera": {"up": "+Z"}, "shading": "depth"}"#;
    let expected = RenderSettings::new(64, 48).with(|s| {
        s.camera.up = Up::PlusZ;
        s.shading = Shading::Depth;
    });
    assert_eq!(serde_json::from_str::<RenderSettings>(some).unwrap(), expected);
}

#[test]
fn what_is_not_known_is_named() {
    for (json, name) in [
        (r#"{"wdith": 64}"#, "wdith"),
        (r#"{"camera": {"upp": "+Z"}}"#, "upp"),
        (r#"{"shading": "toon"}"#, "toon"),
        (r#"{"samples": -1}"#, "-1"),
    ] {
        let error = serde_json::from_str::<RenderSettings>(json).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
}
