//! What pictures must show, from what is known about light.

mod support;

use std::sync::atomic::{AtomicU64, Ordering};

use halfline::geometry::{NO_FACE, vec3};
use halfline::mesh::Positions;
use halfline::progress::{NoProgress, Observer, Stage};
use halfline::{Error, Level, Mesh, Ray, Scene};
use halfline_render::{
    Background, Camera, Ground, GroundSurface, Light, Projection, RenderSettings, Rendering,
    Shading, Up, render,
};
use support::{Builder, GLASS, MIRROR, matte};

fn sphere() -> Scene {
    Builder::default().icosphere([0.0; 3], 1.0, 3, matte(0.5, 0.5, 0.5)).plain_scene()
}

fn settings(shading: Shading) -> RenderSettings {
    RenderSettings::new(64, 64).with(|s| {
        s.samples = 4;
        s.shading = shading;
    })
}

fn draw(scene: &Scene, settings: &RenderSettings) -> Rendering {
    render(scene, settings, &NoProgress).unwrap()
}

fn pixel(picture: &Rendering, x: u32, y: u32) -> [f32; 4] {
    picture.color[(y * picture.width + x) as usize]
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let scene = Builder::default()
        .icosphere([0.0, 1.0, 0.0], 1.0, 2, GLASS)
        .icosphere([2.0, 1.0, 0.0], 1.0, 2, MIRROR)
        .scene();
    for shading in Shading::ALL {
        let settings = settings(shading).with(|s| {
            s.width = 41;
            s.height = 35;
            s.seed = 5;
            s.ground = Some(Ground::default());
        });
        let drawn = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut picture = pool.install(|| draw(&scene, &settings));
            picture.statistics.trace_seconds = 0.0;
            picture
        };
        assert!(drawn(1) == drawn(4), "{}", shading.name());
    }
}

#[test]
fn the_same_bits_by_every_instruction_set() {
    let mut scene = Builder::default()
        .icosphere([0.0, 1.0, 0.0], 1.0, 3, GLASS)
        .icosphere([2.0, 1.0, 0.0], 1.0, 3, MIRROR)
        .cuboid([-2.0, 0.0, -1.0], [-1.2, 1.5, 1.0], matte(0.5, 0.4, 0.3))
        .scene();
    for shading in [Shading::Clay, Shading::Whitted, Shading::Normal] {
        let settings = settings(shading).with(|s| s.ground = Some(Ground::default()));
        let mut drawn = |level| {
            scene.set_simd_level(level);
            let mut picture = draw(&scene, &settings);
            picture.statistics.trace_seconds = 0.0;
            picture
        };
        let scalar = drawn(Level::SCALAR);
        for level in Level::available() {
            assert!(drawn(level) == scalar, "{} by {}", shading.name(), level.name());
        }
    }
}

#[test]
fn another_seed_is_another_picture() {
    let scene = sphere();
    let first = draw(&scene, &settings(Shading::Clay));
    let second = draw(&scene, &settings(Shading::Clay).with(|s| s.seed = 1));
    assert_ne!(first.color, second.color);
}

/// Nothing hides the sky from a convex body, so that occlusion cannot change its picture.
#[test]
fn a_convex_body_sees_the_whole_sky() {
    let scene = sphere();
    let near = settings(Shading::Clay).with(|s| s.occlusion_reach = 1e-6);
    let far = settings(Shading::Clay).with(|s| s.occlusion_reach = f64::INFINITY);
    assert_eq!(draw(&scene, &near).color, draw(&scene, &far).color);
}

/// A box seen from within: with occlusion rays that reach its walls, every one is hidden, and all
/// light is what comes back from the walls themselves; with short ones, none is but in corners.
#[test]
fn the_inside_of_a_closed_box_sees_no_sky() {
    let scene = Builder::default().cuboid([-1.0; 3], [1.0; 3], matte(0.5, 0.5, 0.5)).plain_scene();
    let mut inside = settings(Shading::Clay);
    inside.camera.position = Some(vec3(0.1, 0.2, 0.9));
    inside.camera.focal_point = Some(vec3(0.0, 0.0, -1.0));
    let brightest = |reach: f64| {
        let picture = draw(&scene, &inside.clone().with(|s| s.occlusion_reach = reach));
        picture.color.iter().map(|c| c[1]).fold(0.0, f32::max)
    };
    // The sky is at most 0.66, white 0.595 of green, and 16 % of 0.595 of it come back.
    let closed = brightest(10.0);
    assert!(closed > 0.01 && closed < 0.66 * 0.595 * 0.595 * 0.17, "{closed}");
    assert!(brightest(0.001) > 3.0 * closed);
}

#[test]
fn ground_that_nothing_shades_is_the_background() {
    let mut settings = settings(Shading::Clay).with(|s| {
        s.ground = Some(Ground::default().at_height(-50.0));
        s.background = Background::Transparent;
    });
    settings.camera.elevation = 40.0;
    let scene = sphere();
    let picture = draw(&scene, &settings);
    // The corner sees ground far from the sphere.
    assert_eq!(pixel(&picture, 0, 63), [0.0; 4]);
    settings.ground = Some(Ground::default());
    let picture = draw(&scene, &settings);
    let shaded = picture
        .color
        .iter()
        .zip(&picture.face)
        .filter(|(c, face)| **face == NO_FACE && c[3] > 0.1 && c[..3] == [0.0; 3]);
    assert!(shaded.count() > 50);
}

#[test]
fn a_mirror_shows_what_is_behind_the_eye() {
    // The camera looks down -Z at a mirror; a red wall stands behind the camera.
    let scene = Builder::default()
        .cuboid([-1.0, -1.0, -0.1], [1.0, 1.0, 0.0], MIRROR)
        .cuboid([-9.0, -9.0, 10.0], [9.0, 9.0, 10.1], matte(0.9, 0.0, 0.0))
        .scene();
    let mut settings = settings(Shading::Whitted);
    settings.camera.position = Some(vec3(0.0, 0.0, 5.0));
    settings.camera.focal_point = Some(vec3(0.0, 0.0, 0.0));
    settings.lights =
        vec![Light::Point { position: vec3(0.0, 0.0, 6.0), intensity: [50.0; 3], radius: 0.0 }];
    let [r, g, b, _] = pixel(&draw(&scene, &settings), 30, 30);
    assert!(r > 0.2 && g < 0.05 * r && b < 0.05 * r, "{r} {g} {b}");
    // With no depth left, the mirror shows the surroundings instead, which are grey.
    settings.max_depth = 0;
    let [r, g, ..] = pixel(&draw(&scene, &settings), 30, 30);
    assert!((r - g).abs() < 0.2 * r, "{r} {g}");
}

/// A thick lens: through a glass ball, what is left appears right and what is above, below.
#[test]
fn a_glass_ball_turns_the_world_upside_down() {
    let wall = |x: f64, y: f64| ([x, y, -6.0], [x + 8.0, y + 8.0, -5.9]);
    let (left_low, right_low, left_high) = (wall(-8.0, -8.0), wall(0.0, -8.0), wall(-8.0, 0.0));
    let scene = Builder::default()
        .icosphere([0.0; 3], 1.0, 5, GLASS)
        .cuboid(left_low.0, left_low.1, matte(0.9, 0.0, 0.0))
        .cuboid(right_low.0, right_low.1, matte(0.0, 0.9, 0.0))
        .cuboid(left_high.0, left_high.1, matte(0.0, 0.0, 0.9))
        .scene();
    let mut settings = settings(Shading::Whitted);
    settings.smooth_angle = Some(60.0);
    settings.camera.position = Some(vec3(0.0, 0.0, 5.0));
    settings.camera.focal_point = Some(vec3(0.0, 0.0, 0.0));
    settings.camera.view_angle = 20.0;
    settings.lights = vec![Light::Directional {
        direction: vec3(0.0, 0.0, -1.0),
        irradiance: [3.0; 3],
        angular_radius: 0.0,
    }];
    let picture = draw(&scene, &settings);
    let strongest = |x: u32, y: u32| {
        let c = pixel(&picture, x, y);
        (0..3).max_by(|&i, &j| c[i].total_cmp(&c[j])).unwrap()
    };
    // At the corners of the picture the walls themselves, inside the ball their images.
    assert_eq!([(2, 61), (61, 61), (2, 2)].map(|(x, y)| strongest(x, y)), [0, 1, 2]);
    assert_eq!([(40, 24), (24, 24), (40, 40)].map(|(x, y)| strongest(x, y)), [0, 1, 2]);
}

#[test]
fn glass_lets_light_through_to_the_ground_and_stone_does_not() {
    let under = |material| {
        let scene = Builder::default().cuboid([-1.0, 0.5, -1.0], [1.0, 0.6, 1.0], material).scene();
        let mut settings = settings(Shading::Whitted);
        settings.camera.position = Some(vec3(0.0, 0.3, 3.0));
        settings.camera.focal_point = Some(vec3(0.0, 0.0, 0.0));
        settings.ground = Some(Ground::new(GroundSurface::Matte([1.0; 3])).at_height(0.0));
        settings.lights = vec![Light::Directional {
            direction: vec3(0.0, -1.0, 0.0),
            irradiance: [3.0; 3],
            angular_radius: 0.0,
        }];
        pixel(&draw(&scene, &settings), 32, 32)[1]
    };
    // Two crossings at right angles let 0.96² pass.
    let (open, glass, stone) = (
        under(halfline::mesh::Material { ior: 1.0, ..GLASS }),
        under(GLASS),
        under(matte(0.5, 0.5, 0.5)),
    );
    let direct = open - stone;
    assert!(direct > 0.5, "{direct}");
    assert!(((glass - stone) / direct - 0.96 * 0.96).abs() < 1e-3, "{glass} {stone} {open}");
}

/// A white floor that faces a light of irradiance pi shines with 1, plus what surrounds it.
#[test]
fn a_white_surface_returns_all_light() {
    let floor = |irradiance: f32| {
        let scene = Builder::default()
            .cuboid([-1.0, -0.1, -1.0], [1.0, 0.0, 1.0], matte(1.0, 1.0, 1.0))
            .scene();
        let mut settings = settings(Shading::Whitted);
        settings.camera.position = Some(vec3(0.0, 3.0, 0.1));
        settings.camera.focal_point = Some(vec3(0.0, 0.0, 0.0));
        settings.lights = vec![Light::Directional {
            direction: vec3(0.0, -1.0, 0.0),
            irradiance: [irradiance; 3],
            angular_radius: 0.0,
        }];
        pixel(&draw(&scene, &settings), 32, 32)[1]
    };
    let returned = floor(std::f32::consts::PI) - floor(0.0);
    // 96 % scattered, and 4 % in a highlight as broad as the surface is rough.
    assert!((returned - 1.0).abs() < 5e-3, "{returned}");
}

#[test]
fn layers_are_those_of_the_ray_through_the_pixel_s_middle() {
    let scene = sphere();
    for projection in [Projection::Perspective, Projection::Orthographic { height: None }] {
        let mut settings = settings(Shading::Normal);
        settings.camera.projection = projection;
        let picture = draw(&scene, &settings);
        let camera = Camera::new(&settings, scene.mesh(), &scene.mesh().bounds()).unwrap();
        for y in 0..64_usize {
            for x in 0..64_usize {
                let ray = camera.ray(x as f64 + 0.5, y as f64 + 0.5);
                let hit = scene.caster().intersect(&ray).unwrap_or(halfline::Hit::MISS);
                let i = y * 64 + x;
                assert_eq!(picture.face[i], hit.face);
                if hit.is_hit() {
                    let depth = camera.depth(ray.at(hit.t));
                    assert!((f64::from(picture.depth[i]) - depth).abs() < 1e-6 * depth);
                    let [a, b, c] = scene.mesh().corners(hit.face);
                    let normal = (b - a).cross(c - a).normalized();
                    assert_eq!(picture.normal[i], normal.to_array().map(|v| v as f32));
                } else {
                    assert_eq!(picture.depth[i], f32::INFINITY);
                    assert_eq!(picture.normal[i], [0.0; 3]);
                }
            }
        }
        assert!(picture.coverage() > 0.5 && picture.coverage() < 0.75);
    }
}

#[test]
fn steps_are_counted_and_scaled() {
    let scene = sphere();
    let settings = settings(Shading::Steps).with(|s| {
        s.width = 640;
        s.height = 480;
        s.samples = 1;
    });
    let picture = draw(&scene, &settings);
    let steps = picture.steps.as_ref().unwrap();
    let camera = Camera::new(&settings, scene.mesh(), &scene.mesh().bounds()).unwrap();
    assert_ne!(camera.ray(320.0, 240.0), Ray::new(camera.eye(), camera.forward()), "not centred");
    assert!(steps.iter().any(|[nodes, triangles]| *nodes + *triangles > 0.0));
    assert!(picture.is_opaque());
    // The bar's bright end and dark end.
    let column = (0..640).rev().find(|&x| pixel(&picture, x, 240)[0] > 0.3).unwrap();
    let [top, bottom] = [60, 420].map(|y| pixel(&picture, column, y)[0]);
    assert!(top > bottom, "{top} {bottom}");
    // The model leaves the bar its place.
    let rightmost = (0..640)
        .rev()
        .find(|&x| (0..480).any(|y| picture.face[y * 640 + x as usize] != NO_FACE))
        .unwrap();
    assert!(rightmost < column - 16, "{rightmost} {column}");
}

#[test]
fn the_default_clay_picture_casts_the_rays_it_promises() {
    let picture = draw(&sphere(), &settings(Shading::Clay));
    let rays = picture.statistics.rays;
    assert_eq!(rays.primary, 64 * 64 * 5);
    let seen = rays.occlusion / 2;
    assert_eq!(rays.occlusion, seen * 2);
    assert!(seen as f64 > 0.5 * 64.0 * 64.0 * 4.0 && rays.shadow <= seen);
    assert_eq!(rays.total(), rays.primary + rays.occlusion + rays.shadow);
}

#[test]
fn nothing_to_see_is_a_picture_too() {
    let empty = Scene::new(Mesh::new(Positions::F32(vec![].into()), vec![]).unwrap()).unwrap();
    let point =
        Mesh::new(Positions::F64(vec![[3.0, 4.0, 5.0]; 3].into()), vec![[0, 1, 2]]).unwrap();
    let point = Scene::new(point).unwrap();
    for scene in [empty, point] {
        for shading in Shading::ALL {
            let settings = settings(shading).with(|s| {
                s.background = Background::Color([1.0, 0.0, 0.0]);
                s.ground = None;
            });
            let picture = draw(&scene, &settings);
            assert_eq!(picture.coverage(), 0.0);
            if shading != Shading::Steps {
                assert!(picture.to_srgb8().iter().all(|&p| p == [255, 0, 0, 255]));
            }
        }
    }
}

#[test]
fn far_from_the_origin_looks_as_near_it() {
    let at = |offset: f64| {
        let scene = Builder::default()
            .cuboid([offset, 0.0, 0.0], [offset + 1.0, 1.0, 1.0], matte(0.5, 0.5, 0.5))
            .plain_scene();
        draw(&scene, &settings(Shading::Clay)).to_srgb8()
    };
    let differing = at(0.0).iter().zip(at(67_108_864.0)).filter(|(a, b)| **a != *b).count();
    assert!(differing < 64 * 64 / 100, "{differing}");
}

/// Asks for the end after so many questions, and notes when.
struct Impatient {
    questions: AtomicU64,
    patience: u64,
}

impl Observer for Impatient {
    fn cancelled(&self) -> bool {
        self.questions.fetch_add(1, Ordering::Relaxed) >= self.patience
    }
}

#[test]
fn a_picture_stops_when_it_should() {
    let scene = sphere();
    let settings = settings(Shading::Clay).with(|s| {
        s.width = 2000;
        s.height = 2000;
    });
    for patience in [0, 1, 1000] {
        let observer = Impatient { questions: AtomicU64::new(0), patience };
        assert!(matches!(render(&scene, &settings, &observer), Err(Error::Interrupted)));
        assert!(observer.questions.into_inner() < patience + 100);
    }
}

#[derive(Default)]
struct Listener {
    highest: AtomicU64,
    total: AtomicU64,
}

impl Observer for Listener {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        assert_eq!(stage, Stage::Trace);
        assert!(done <= total);
        self.highest.fetch_max(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }
}

#[test]
fn progress_ends_at_all_pixels() {
    let listener = Listener::default();
    let settings = settings(Shading::Normal).with(|s| {
        s.width = 31;
        s.height = 17;
    });
    render(&sphere(), &settings, &listener).unwrap();
    assert_eq!(listener.highest.into_inner(), 31 * 17);
    assert_eq!(listener.total.into_inner(), 31 * 17);
}

#[test]
fn settings_without_sense_are_named() {
    let scene = sphere();
    let complaint = |change: &dyn Fn(&mut RenderSettings)| {
        let mut settings = settings(Shading::Whitted);
        change(&mut settings);
        match render(&scene, &settings, &NoProgress) {
            Err(Error::Invalid { what, reason }) => {
                assert!(!reason.is_empty() && !reason.contains('\n'));
                what
            }
            Err(other) => panic!("{other}"),
            Ok(_) => "nothing".to_owned(),
        }
    };
    let nan = vec3(f64::NAN, 0.0, 0.0);
    let up = vec3(0.0, 1.0, 0.0);
    assert_eq!(complaint(&|_| ()), "nothing");
    assert_eq!(complaint(&|s| s.width = 0), "resolution");
    assert_eq!(complaint(&|s| (s.width, s.height) = (u32::MAX, u32::MAX)), "resolution");
    assert_eq!(complaint(&|s| s.samples = 0), "samples");
    assert_eq!(complaint(&|s| s.samples = u32::MAX), "samples");
    assert_eq!(complaint(&|s| s.occlusion_rays = 0), "occlusion rays");
    assert_eq!(complaint(&|s| s.occlusion_reach = f64::NAN), "occlusion reach");
    assert_eq!(complaint(&|s| s.max_depth = 1000), "max depth");
    assert_eq!(complaint(&|s| s.smooth_angle = Some(-1.0)), "smooth angle");
    assert_eq!(complaint(&|s| s.camera.position = Some(nan)), "camera position");
    assert_eq!(complaint(&|s| s.camera.focal_point = Some(nan)), "camera focal point");
    assert_eq!(complaint(&|s| s.camera.view_up = Some(nan)), "camera view up");
    assert_eq!(complaint(&|s| s.camera.view_up = Some(vec3(0.0, 0.0, 0.0))), "camera view up");
    assert_eq!(
        complaint(&|s| {
            s.camera.position = Some(up);
            s.camera.focal_point = Some(up);
        }),
        "camera position"
    );
    assert_eq!(
        complaint(&|s| {
            s.camera.position = Some(up * 5.0);
            s.camera.focal_point = Some(up);
            s.camera.view_up = Some(up);
        }),
        "camera view up"
    );
    for angle in [0.0, 180.0, -3.0, f64::NAN, 1e-320] {
        assert_eq!(complaint(&|s| s.camera.view_angle = angle), "camera view angle");
    }
    assert_eq!(complaint(&|s| s.camera.elevation = 90.0), "camera elevation angle");
    assert_eq!(complaint(&|s| s.camera.azimuth = f64::INFINITY), "camera azimuth angle");
    assert_eq!(complaint(&|s| s.camera.margin = 0.7), "camera margin");
    let flat = Projection::Orthographic { height: Some(-1.0) };
    assert_eq!(complaint(&|s| s.camera.projection = flat), "camera orthographic");
    let bright = Background::Color([2.0, 0.0, 0.0]);
    assert_eq!(complaint(&|s| s.background = bright), "background color");
    let ground = Ground::default().at_height(f64::NAN);
    assert_eq!(complaint(&|s| s.ground = Some(ground)), "ground height");
    let ground = Ground::default().mirroring(1.5);
    assert_eq!(complaint(&|s| s.ground = Some(ground)), "ground reflectivity");
    let heavy = halfline::mesh::Material { ior: 0.5, ..GLASS };
    assert_eq!(complaint(&|s| s.material = Some(heavy)), "material ior");
    let light = Light::Point { position: nan, intensity: [1.0; 3], radius: 0.0 };
    assert_eq!(complaint(&|s| s.lights = vec![light]), "light position");
    let light = Light::Area { corner: up, edge_u: up, edge_v: up, radiance: [1.0; 3] };
    assert_eq!(complaint(&|s| s.lights = vec![light]), "light area");
}

#[test]
fn coordinates_too_large_to_be_drawn_are_refused() {
    let far = 1e200;
    let mesh = Mesh::new(
        Positions::F64(vec![[0.0; 3], [far, 0.0, 0.0], [0.0, far, 0.0]].into()),
        vec![[0, 1, 2]],
    );
    let scene = Scene::new(mesh.unwrap()).unwrap();
    let answer = render(&scene, &settings(Shading::Clay), &NoProgress);
    assert!(matches!(answer, Err(Error::Invalid { what, .. }) if what == "mesh"));
}

#[test]
fn names_are_read_back() {
    for shading in Shading::ALL {
        assert_eq!(shading.name().parse::<Shading>().unwrap(), shading);
    }
    assert!("toon".parse::<Shading>().unwrap_err().to_string().contains("clay, whitted"));
    assert_eq!("-z".parse::<Up>().unwrap(), Up::MinusZ);
    assert_eq!("Y".parse::<Up>().unwrap(), Up::PlusY);
    assert!("Q".parse::<Up>().is_err());
}
