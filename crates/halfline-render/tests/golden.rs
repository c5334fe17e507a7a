//! Pictures compared with committed ones.
//!
//! A picture fails if any channel of any pixel, averaged over the 3 x 3 pixels around it, differs
//! by more than `TOLERANCE` of 255, or the picture as a whole by more than `MEAN_TOLERANCE`.
//! The average forgives a ray that goes the other way at an outline because of another
//! platform's sine; it forgives no shadow that is missing.
//!
//! On failure the actual picture, the expected one and their difference are left in
//! `golden-failures` of the target folder. To accept the pictures as they now are, run the
//! tests with HALFLINE_BLESS=1 in the environment, and look at what changed.

mod support;

use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};

use halfline::Scene;
use halfline::geometry::vec3;
use halfline::mesh::Material;
use halfline::progress::NoProgress;
use halfline_render::{
    Background, Ground, GroundSurface, Light, Projection, RenderSettings, Shading, Up, render,
};
use support::{Builder, GLASS, MIRROR, matte};

const TOLERANCE: f64 = 12.0;
const MEAN_TOLERANCE: f64 = 0.5;

/// A sphere and a box, side by side.
fn pair() -> Scene {
    Builder::default()
        .icosphere([0.0, 1.0, 0.0], 1.0, 2, matte(0.6, 0.6, 0.6))
        .cuboid([1.2, 0.0, -0.5], [2.2, 1.4, 0.5], matte(0.6, 0.6, 0.6))
        .plain_scene()
}

/// One of each kind of material.
fn materials() -> Scene {
    let gold = Material { base_color: [1.0, 0.77, 0.34, 1.0], roughness: 0.3, ..MIRROR };
    let paint = Material { roughness: 0.25, ..matte(0.6, 0.05, 0.04) };
    Builder::default()
        .icosphere([0.0, 1.0, 0.0], 1.0, 3, GLASS)
        .icosphere([2.1, 0.9, -0.6], 0.9, 3, MIRROR)
        .icosphere([-1.9, 0.8, -0.4], 0.8, 3, paint)
        .icosphere([1.0, 0.4, 1.4], 0.4, 2, gold)
        .cuboid([-1.4, 0.0, 0.9], [-0.7, 0.7, 1.6], matte(0.05, 0.2, 0.6))
        .scene()
}

fn small(shading: Shading) -> RenderSettings {
    RenderSettings::new(96, 72).with(|s| {
        s.samples = 4;
        s.shading = shading;
    })
}

/// Light and dark.
const CHECKER: GroundSurface = GroundSurface::Checker([0.85, 0.85, 0.85], [0.3, 0.32, 0.35]);

#[test]
fn clay() {
    check("clay", &pair(), &small(Shading::Clay));
}

#[test]
fn clay_on_a_ground() {
    let settings = small(Shading::Clay).with(|s| s.ground = Some(Ground::default()));
    check("clay_ground", &pair(), &settings);
}

#[test]
fn clay_shadow_on_nothing() {
    let settings = small(Shading::Clay).with(|s| {
        s.ground = Some(Ground::default());
        s.background = Background::Transparent;
    });
    check("clay_transparent", &pair(), &settings);
}

#[test]
fn clay_with_smooth_normals() {
    let settings = small(Shading::Clay).with(|s| s.smooth_angle = Some(50.0));
    check("clay_smooth", &pair(), &settings);
}

#[test]
fn clay_with_vertex_colors() {
    let mut mesh = Builder::default().icosphere([0.0; 3], 1.0, 2, matte(1.0, 1.0, 1.0)).mesh();
    mesh.triangle_materials = None;
    let colors = (0..mesh.positions().len())
        .map(|i| {
            let p = mesh.positions().get(i).to_array();
            let [r, g, b] = p.map(|v| (127.5 + 120.0 * v).round() as u8);
            [r, g, b, 255]
        })
        .collect();
    mesh.vertex_colors = Some(colors);
    check("clay_vertex_colors", &Scene::new(mesh).unwrap(), &small(Shading::Clay));
}

#[test]
fn whitted() {
    let settings = small(Shading::Whitted).with(|s| s.ground = Some(Ground::new(CHECKER)));
    check("whitted", &materials(), &settings);
}

#[test]
fn whitted_under_its_own_lights() {
    let settings = small(Shading::Whitted).with(|s| {
        s.ground = Some(Ground::new(CHECKER).mirroring(0.3));
        s.background = Background::Color([0.25, 0.35, 0.5]);
        s.lights = vec![
            Light::Point { position: vec3(-3.0, 5.0, 4.0), intensity: [60.0; 3], radius: 0.0 },
            Light::Directional {
                direction: vec3(-1.0, -1.0, -0.3),
                irradiance: [1.2, 0.8, 0.4],
                angular_radius: 2.0,
            },
        ];
    });
    check("whitted_lights", &materials(), &settings);
}

#[test]
fn normals() {
    check("normal", &pair(), &small(Shading::Normal));
}

#[test]
fn depth() {
    check("depth", &pair(), &small(Shading::Depth));
}

#[test]
fn faces() {
    check("face", &pair(), &small(Shading::Face));
}

#[test]
fn orthographic_with_z_up() {
    let mut settings = small(Shading::Clay);
    settings.camera.projection = Projection::Orthographic { height: None };
    settings.camera.up = Up::PlusZ;
    settings.ground = Some(Ground::new(GroundSurface::Matte([0.7, 0.7, 0.7])));
    check("orthographic_z_up", &pair(), &settings);
}

#[test]
fn own_camera() {
    let mut settings = small(Shading::Clay);
    settings.camera.position = Some(vec3(-1.0, 4.0, 5.0));
    settings.camera.focal_point = Some(vec3(1.0, 0.5, 0.0));
    settings.camera.view_up = Some(vec3(0.3, 1.0, 0.0));
    settings.camera.view_angle = 50.0;
    settings.ground = Some(Ground::new(CHECKER));
    check("own_camera", &pair(), &settings);
}

/// Compares, or with HALFLINE_BLESS renews.
fn check(name: &str, scene: &Scene, settings: &RenderSettings) {
    let picture = render(scene, settings, &NoProgress).unwrap();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    let golden = golden.with_extension("png");
    if std::env::var_os("HALFLINE_BLESS").is_some() {
        fs::create_dir_all(golden.parent().unwrap()).unwrap();
        picture.write_png(BufWriter::new(File::create(&golden).unwrap())).unwrap();
        return;
    }
    let actual = picture.to_srgb8();
    let size = (settings.width as usize, settings.height as usize);
    let expected = read_png(&golden, size);
    let problem = match &expected {
        Err(reason) => reason.clone(),
        Ok(expected) => {
            let (worst, mean) = differences(&actual, expected, size);
            if worst <= TOLERANCE && mean <= MEAN_TOLERANCE {
                return;
            }
            format!("differs by {worst:.1} at worst and {mean:.2} on average")
        }
    };

    let folder = failures();
    fs::create_dir_all(&folder).unwrap();
    write_png(&folder.join(format!("{name}-actual.png")), &actual, settings);
    if let Ok(expected) = &expected {
        write_png(&folder.join(format!("{name}-expected.png")), expected, settings);
        let difference: Vec<[u8; 4]> = actual
            .iter()
            .zip(expected)
            .map(|(a, e)| {
                let [r, g, b, alpha] = std::array::from_fn(|c| a[c].abs_diff(e[c]));
                [r, g, b].map(|v| v.max(alpha).saturating_mul(8))
            })
            .map(|[r, g, b]| [r, g, b, 255])
            .collect();
        write_png(&folder.join(format!("{name}-difference-x8.png")), &difference, settings);
    }
    panic!("{name}: {problem}; see {name}-*.png in {}", folder.display());
}

/// `golden-failures` in the folder that holds this test's profile folder.
fn failures() -> PathBuf {
    let executable = std::env::current_exe().unwrap();
    executable.ancestors().nth(3).unwrap().join("golden-failures")
}

/// The largest difference of the means of 3 x 3 pixels, and the mean difference of all.
fn differences(
    actual: &[[u8; 4]],
    expected: &[[u8; 4]],
    (width, height): (usize, usize),
) -> (f64, f64) {
    let mean_around = |pixels: &[[u8; 4]], x: usize, y: usize, channel: usize| {
        let (mut sum, mut count) = (0.0, 0.0);
        for j in y.saturating_sub(1)..(y + 2).min(height) {
            for i in x.saturating_sub(1)..(x + 2).min(width) {
                sum += f64::from(pixels[j * width + i][channel]);
                count += 1.0;
            }
        }
        sum / count
    };
    let mut worst = 0.0_f64;
    let mut total = 0.0;
    for y in 0..height {
        for x in 0..width {
            for channel in 0..4 {
                let smoothed =
                    mean_around(actual, x, y, channel) - mean_around(expected, x, y, channel);
                worst = worst.max(smoothed.abs());
                let i = y * width + x;
                total += f64::from(actual[i][channel].abs_diff(expected[i][channel]));
            }
        }
    }
    (worst, total / (width * height * 4) as f64)
}

fn read_png(path: &Path, size: (usize, usize)) -> Result<Vec<[u8; 4]>, String> {
    let file = File::open(path).map_err(|e| format!("no picture to compare with: {e}"))?;
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    if (info.width as usize, info.height as usize) != size {
        return Err(format!("the golden picture has {} x {} pixels", info.width, info.height));
    }
    Ok(match info.color_type {
        png::ColorType::Rgb => bytes.chunks_exact(3).map(|p| [p[0], p[1], p[2], 255]).collect(),
        png::ColorType::Rgba => bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect(),
        other => return Err(format!("the golden picture is {other:?}")),
    })
}

fn write_png(path: &Path, pixels: &[[u8; 4]], settings: &RenderSettings) {
    let file = BufWriter::new(File::create(path).unwrap());
    let mut encoder = png::Encoder::new(file, settings.width, settings.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(pixels.as_flattened()).unwrap();
}

#[test]
fn the_comparison_sees_what_it_must() {
    let flat = vec![[100, 100, 100, 255]; 96 * 72];
    assert_eq!(differences(&flat, &flat, (96, 72)), (0.0, 0.0));
    // One pixel of noise is forgiven, a small missing shadow is not, nor a faint tint of all.
    let mut noisy = flat.clone();
    noisy[1000] = [180, 100, 100, 255];
    assert!(differences(&noisy, &flat, (96, 72)).0 <= TOLERANCE);
    let mut shadow = flat.clone();
    for y in 20..23 {
        for x in 20..23 {
            shadow[y * 96 + x] = [80, 80, 80, 255];
        }
    }
    assert!(differences(&shadow, &flat, (96, 72)).0 > TOLERANCE);
    let tinted = vec![[103, 100, 100, 255]; 96 * 72];
    assert!(differences(&tinted, &flat, (96, 72)).1 > MEAN_TOLERANCE);
}
