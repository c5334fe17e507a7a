//! The rays: what a renderer or a measurement would send.

use halfline::numeric::SurfacePoint;
use halfline::{Ray, RayF32, Scene, Vec3};

/// Pixels along a side of a tile of the picture.
const TILE: usize = 8;

/// Rays of a bundle that starts at one point of a surface.
const BUNDLE: usize = 8;

/// Rays of one kind.
pub struct Rays {
    pub name: &'static str,
    pub rays: Vec<RayF32>,
    /// Whether any hit is asked for, or the closest.
    pub is_any: bool,
}

struct Random(u64);

impl Random {
    /// In [0, 1) (SplitMix64).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform on the unit sphere.
    fn direction(&mut self) -> Vec3 {
        let z = 2.0 * self.next() - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::from([r * cos, r * sin, z])
    }
}

fn single(v: Vec3) -> [f32; 3] {
    v.to_array().map(|x| x as f32)
}

fn ray(origin: Vec3, direction: Vec3, t_max: f64) -> RayF32 {
    RayF32 { origin: single(origin), t_min: 0.0, direction: single(direction), t_max: t_max as f32 }
}

/// A ray that starts on a surface, at the origin that halfline offers. Rounded to single precision,
/// each coordinate goes away from the surface, so that the origin stays on its side.
fn ray_from(surface: &SurfacePoint, direction: Vec3, t_max: f64) -> RayF32 {
    let exact = surface.origin_towards(direction);
    let side = surface.normal.dot(direction);
    let mut ray = ray(exact, direction, t_max);
    for (axis, rounded) in ray.origin.iter_mut().enumerate() {
        let outward = side * surface.normal[axis];
        if outward > 0.0 && f64::from(*rounded) < exact[axis] {
            *rounded = rounded.next_up();
        } else if outward < 0.0 && f64::from(*rounded) > exact[axis] {
            *rounded = rounded.next_down();
        }
    }
    ray
}

/// All kinds of rays for a scene, at most `most` of each (but a tile of them if that is more).
pub fn for_scene(scene: &Scene, is_room: bool, most: usize) -> Vec<Rays> {
    let bounds = scene.mesh().bounds();
    let size = bounds.extent().length();
    let center = bounds.center();
    let mut random = Random(1);

    // Look at the scene from outside, or along a room from inside of it, tile by tile.
    let towards = Vec3::from([0.4, 0.3, 1.0]).normalized();
    let extent = bounds.extent();
    let eye = if is_room {
        center - Vec3::from([0.42 * extent.x, 0.36 * extent.y, -0.1 * extent.z])
    } else {
        center + towards * (1.2 * size)
    };
    let forward = (center - eye).normalized();
    let up = if is_room { Vec3::from([0.0, 0.0, 1.0]) } else { Vec3::from([0.0, 1.0, 0.0]) };
    let right = forward.cross(up).normalized();
    let up = right.cross(forward);
    let half = if is_room { 0.8 } else { 0.42 };
    // As many whole tiles along a side as `most` allows.
    let tiles = ((most as f64).sqrt() as usize / TILE).max(1);
    let mut primary = Vec::with_capacity((tiles * TILE).pow(2));
    for tile in 0..tiles * tiles {
        let corner = [tile % tiles * TILE, tile / tiles * TILE];
        for pixel in 0..TILE * TILE {
            let at = [corner[0] + pixel % TILE, corner[1] + pixel / TILE];
            let [x, y] = at.map(|p| ((p as f64 + 0.5) / (tiles * TILE) as f64 * 2.0 - 1.0) * half);
            primary.push(ray(eye, forward + right * x - up * y, f64::INFINITY));
        }
    }

    // From where they hit: towards a light, to near by, and anywhere. Most start off the surface by
    // a share of the scene's size, as renderers in single precision have it; those of `surface` and
    // `surface_closest` start on it, next to the face that they leave.
    let light = if is_room {
        center + Vec3::from([0.1 * extent.x, 0.05 * extent.y, 0.35 * extent.z])
    } else {
        center + (towards + right * 0.8 + up * 0.9).normalized() * (1.5 * size)
    };
    let hits = scene.intersect(&primary.iter().map(|&ray| Ray::from(ray)).collect::<Vec<_>>());
    let near = 0.1 * size;
    let [mut shadow, mut ambient, mut bundles, mut diffuse] = [const { Vec::new() }; 4];
    let [mut surface, mut surface_closest] = [const { Vec::new() }; 2];
    for (primary, hit) in primary.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
        let primary = Ray::from(*primary);
        let [a, b, c] = scene.mesh().corners(hit.face);
        let normal = (b - a).cross(c - a).normalized();
        let normal = if normal.dot(primary.direction) > 0.0 { -normal } else { normal };
        let at = primary.at(hit.t) + normal * (2e-5 * size);
        shadow.push(ray(at, light - at, 1.0));
        let mut hemisphere = || (normal + random.direction() * 0.999).normalized();
        let direction = hemisphere();
        let point = scene.surface_point(hit);
        ambient.push(ray(at, direction, near));
        diffuse.push(ray(at, direction, f64::INFINITY));
        surface_closest.push(ray_from(&point, direction, f64::INFINITY));
        if bundles.len() < most {
            let directions = [(); BUNDLE].map(|()| hemisphere());
            bundles.extend(directions.map(|direction| ray(at, direction, near)));
            surface.extend(directions.map(|direction| ray_from(&point, direction, near)));
        }
    }
    let mut shuffled = diffuse.clone();
    for i in (1..shuffled.len()).rev() {
        shuffled.swap(i, (random.next() * (i + 1) as f64) as usize);
    }
    let chords = (0..most).map(|_| {
        let [from, to] = [(); 2].map(|()| center + random.direction() * (0.5 * size));
        ray(from, to - from, f64::INFINITY)
    });
    let chords = chords.collect();

    let kinds = [
        ("primary", primary, false),
        ("shadow", shadow, true),
        ("ao", ambient, true),
        ("ao8", bundles, true),
        ("surface", surface, true),
        ("diffuse", diffuse, false),
        ("surface_closest", surface_closest, false),
        ("shuffled", shuffled, false),
        ("random", chords, false),
    ];
    let cut = |mut rays: Vec<RayF32>| {
        rays.truncate(most);
        rays
    };
    kinds
        .map(|(name, rays, is_any)| Rays { name, rays: cut(rays), is_any })
        .into_iter()
        .filter(|rays| !rays.rays.is_empty())
        .collect()
}
