//! Rays through known points of a picture, and models that fill theirs.

mod support;

use halfline::Mesh;
use halfline::geometry::{Vec3, vec3};
use halfline_render::{Camera, Projection, RenderSettings, Up};
use support::{Builder, matte};

/// A long box that is neither centred nor along an axis of the camera.
fn model() -> Mesh {
    Builder::default().cuboid([3.0, -1.0, 2.0], [4.0, 0.5, 7.0], matte(0.5, 0.5, 0.5)).mesh()
}

fn settings() -> RenderSettings {
    RenderSettings::new(200, 100)
}

fn camera(settings: &RenderSettings) -> Camera {
    let mesh = model();
    Camera::new(settings, &mesh, &mesh.bounds()).unwrap()
}

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-12
}

#[test]
fn pinhole_rays_have_the_view_angle() {
    let mut settings = settings();
    settings.camera.position = Some(vec3(1.0, 2.0, 8.0));
    settings.camera.focal_point = Some(vec3(1.0, 2.0, 0.0));
    settings.camera.view_angle = 90.0;
    let camera = camera(&settings);
    let direction = |x, y| {
        let ray = camera.ray(x, y);
        assert_eq!(ray.origin, vec3(1.0, 2.0, 8.0));
        assert!((ray.direction.length() - 1.0).abs() < 1e-15);
        ray.direction / -ray.direction.z
    };
    // 45 degrees up and down, and twice as far to the sides of a picture twice as wide.
    assert!(near(direction(100.0, 50.0), vec3(0.0, 0.0, -1.0)));
    assert!(near(direction(100.0, 0.0), vec3(0.0, 1.0, -1.0)));
    assert!(near(direction(0.0, 0.0), vec3(-2.0, 1.0, -1.0)));
    assert!(near(direction(200.0, 100.0), vec3(2.0, -1.0, -1.0)));
}

#[test]
fn orthographic_rays_are_parallel_and_as_far_apart_as_asked() {
    let mut settings = settings();
    settings.camera.position = Some(vec3(1.0, 2.0, 8.0));
    settings.camera.focal_point = Some(vec3(1.0, 2.0, 0.0));
    settings.camera.projection = Projection::Orthographic { height: Some(4.0) };
    let camera = camera(&settings);
    for (x, y, origin) in [
        (100.0, 50.0, vec3(1.0, 2.0, 8.0)),
        (100.0, 0.0, vec3(1.0, 4.0, 8.0)),
        (0.0, 100.0, vec3(-3.0, 0.0, 8.0)),
    ] {
        let ray = camera.ray(x, y);
        assert!(near(ray.origin, origin) && near(ray.direction, vec3(0.0, 0.0, -1.0)), "{x} {y}");
    }
    assert!((camera.depth(vec3(5.0, 5.0, 5.0)) - 3.0).abs() < 1e-12);
}

/// Where `point` lies in the picture, -1 to 1 from left to right and from bottom to top, found
/// from the rays through the middle and two edges alone.
fn place(camera: &Camera, projection: Projection, point: Vec3) -> [f64; 2] {
    let from_middle = point - camera.ray(100.0, 50.0).origin;
    let [right, up] = [camera.right(), camera.up()].map(|axis| from_middle.dot(axis));
    let (edge_right, edge_up) = (camera.ray(200.0, 50.0), camera.ray(100.0, 0.0));
    match projection {
        Projection::Perspective => {
            let depth = camera.depth(point);
            let slope =
                |direction: Vec3, axis: Vec3| direction.dot(axis) / direction.dot(camera.forward());
            [
                right / depth / slope(edge_right.direction, camera.right()),
                up / depth / slope(edge_up.direction, camera.up()),
            ]
        }
        Projection::Orthographic { .. } => {
            let middle = camera.ray(100.0, 50.0).origin;
            [
                right / (edge_right.origin - middle).dot(camera.right()),
                up / (edge_up.origin - middle).dot(camera.up()),
            ]
        }
    }
}

#[test]
fn the_model_fills_its_picture_up_to_the_margin() {
    let ups = [Up::PlusX, Up::MinusX, Up::PlusY, Up::MinusY, Up::PlusZ, Up::MinusZ];
    for projection in [Projection::Perspective, Projection::Orthographic { height: None }] {
        for up in ups {
            for (azimuth, elevation, view_angle) in
                [(30.0, 18.0, 30.0), (-140.0, -60.0, 100.0), (0.0, 0.0, 5.0)]
            {
                let mut settings = settings();
                settings.camera.projection = projection;
                settings.camera.up = up;
                settings.camera.azimuth = azimuth;
                settings.camera.elevation = elevation;
                settings.camera.view_angle = view_angle;
                let mesh = model();
                let camera = Camera::new(&settings, &mesh, &mesh.bounds()).unwrap();
                let mut low = [f64::INFINITY; 2];
                let mut high = [f64::NEG_INFINITY; 2];
                for i in 0..mesh.positions().len() {
                    let point = mesh.positions().get(i);
                    assert!(camera.depth(point) > 0.0);
                    let at = place(&camera, projection, point);
                    for axis in 0..2 {
                        low[axis] = low[axis].min(at[axis]);
                        high[axis] = high[axis].max(at[axis]);
                    }
                }
                // Ten percent are left free in the direction that decides, half on each side;
                // more in the other.
                let decides = if high[0] > high[1] { 0 } else { 1 };
                assert!((high[decides] - 0.9).abs() < 1e-9, "{up:?} {azimuth}: {low:?} {high:?}");
                assert!((low[decides] + 0.9).abs() < 1e-9, "{up:?} {azimuth}: {low:?} {high:?}");
                assert!(low.iter().chain(&high).all(|v| v.abs() < 0.9 + 1e-9));
                assert!(high[1 - decides] > 0.0 && low[1 - decides] < 0.0);
                assert!(camera.up().dot(up.vector()) > 0.0);
            }
        }
    }
}

#[test]
fn the_default_camera_sees_the_front_from_its_right_and_from_above() {
    for (up, front, right) in [
        (Up::PlusY, vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0)),
        (Up::PlusZ, vec3(0.0, -1.0, 0.0), vec3(1.0, 0.0, 0.0)),
    ] {
        let mut settings = settings();
        settings.camera.up = up;
        let forward = camera(&settings).forward();
        assert!(forward.dot(front) < -0.7, "{up:?} {forward:?}");
        assert!(forward.dot(right) < -0.3);
        assert!(forward.dot(up.vector()) < -0.3);
    }
}

#[test]
fn a_position_alone_looks_at_the_model_and_a_focal_point_alone_keeps_the_direction() {
    let mut settings = settings();
    let unasked = camera(&settings);
    settings.camera.position = Some(vec3(20.0, 5.0, 1.0));
    let placed = camera(&settings);
    assert_eq!(placed.eye(), vec3(20.0, 5.0, 1.0));
    let center = model().bounds().center();
    assert!(near(placed.forward(), (center - vec3(20.0, 5.0, 1.0)).normalized()));

    settings.camera.position = None;
    settings.camera.focal_point = Some(vec3(4.0, 0.5, 7.0));
    let pointed = camera(&settings);
    assert!(near(pointed.forward(), unasked.forward()));
    let to_focal_point = (vec3(4.0, 0.5, 7.0) - pointed.eye()).normalized();
    assert!(near(to_focal_point, pointed.forward()));
}

#[test]
fn straight_from_above_or_below_the_front_stays_where_it_was() {
    for (up, front) in [(Up::PlusY, vec3(0.0, 0.0, 1.0)), (Up::PlusZ, vec3(0.0, -1.0, 0.0))] {
        for height in [20.0, -20.0] {
            let mut settings = settings();
            settings.camera.up = up;
            settings.camera.position = Some(up.vector() * height);
            settings.camera.focal_point = Some(Vec3::ZERO);
            let above = camera(&settings).ray(100.0, 10.0).direction;
            assert!(above.dot(front) * height < 0.0, "{up:?} from {height}: {above:?}");
            // The same but for a hair's breadth, where the up axis itself still serves.
            settings.camera.position = Some(up.vector() * height + front * 1e-6);
            let nearly = camera(&settings).ray(100.0, 10.0).direction;
            assert!((above - nearly).length() < 1e-6, "{above:?} {nearly:?}");
        }
    }
}
