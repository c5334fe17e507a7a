//! Rays that leave a surface from the origins that the library offers never hit the face they
//! leave; from the rounded points themselves, a good part does.

use crate::common::exact::{Point, Q, cross, dot, exact, minus};
use crate::common::proof::{Share, report};
use crate::common::{Random, grid_cube, meshes, soup, sphere};
use halfline::geometry::NO_FACE;
use halfline::numeric::{PreparedRay, SurfacePoint};
use halfline::progress::NoProgress;
use halfline::{Hit, Mesh, Ray, Scene, Vec3};
use halfline_io::models::{Kind, generate};
use num_traits::Signed;

/// The vector of length one, for vectors of any length but zero.
fn unit(v: Vec3) -> Vec3 {
    (v / v.abs().max_element()).normalized()
}

/// Anywhere, or at an angle of down to 10^-18 to the triangle, or along it as well as doubles can;
/// of any length that the promise covers.
fn direction(random: &mut Random, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let anywhere = unit(random.point());
    // Halves, so that edges do not overflow.
    let (ab, ac) = (b * 0.5 - a * 0.5, c * 0.5 - a * 0.5);
    let along = match random.below(3) {
        0 => unit(ab),
        1 => unit(ac),
        _ => unit(unit(ab) * random.signed() + unit(ac) * random.signed()),
    };
    let direction = match random.below(4) {
        0 => anywhere,
        1 => along * if random.below(2) == 0 { 1.0 } else { -1.0 },
        _ => along + anywhere * 10f64.powf(-18.0 * random.unit()),
    };
    // Long ones only where t does not round to zero, which is promised up to 2^1000 edges.
    let is_long_enough = ab.abs().max(ac.abs()).max_element() > 2f64.powi(-850);
    match random.below(8) {
        0 => unit(direction) * 2f64.powi(-(random.below(200) as i32)),
        1 if is_long_enough => direction * 2f64.powi(random.below(100) as i32),
        _ => unit(direction),
    }
}

/// Weights in a triangle, at corners and on edges more often than elsewhere.
fn weights(random: &mut Random) -> [f64; 2] {
    let share = random.unit();
    let tiny = [0.0, 5e-324, 1e-310, 1e-17, f64::EPSILON / 2.0][random.below(5)];
    match random.below(10) {
        0 => [tiny, tiny],
        1 => [1.0 - tiny, tiny],
        2 => [tiny, 1.0 - tiny],
        3 => [share, tiny],
        4 => [tiny, share],
        5 => [share, 1.0 - share],
        _ => [share, (1.0 - share) * random.unit()],
    }
}

/// True if the ray meets the triangle.
fn meets(origin: Vec3, direction: Vec3, corners: [Vec3; 3]) -> bool {
    PreparedRay::new(&Ray::new(origin, direction)).is_some_and(|ray| ray.meet(corners).is_some())
}

/// Secondary rays so far, and how many would have hit their own face from the rounded point.
#[derive(Default)]
struct Tally {
    rays: usize,
    plain_self_hits: usize,
}

impl Tally {
    /// Without these the tests would prove nothing.
    fn finish(&self, what: &str) {
        assert!(self.plain_self_hits > self.rays / 10, "only {}", self.plain_self_hits);
        report(what, self.rays);
    }
}

#[test]
fn no_ray_hits_the_face_that_it_leaves() {
    let far = Vec3::from([500_000.0, 5_400_000.0, 12.0]);
    let mut meshes = meshes();
    meshes.push(("scan", generate(Kind::Scan, 20_000, 1, &NoProgress).expect("a scan")));
    meshes.push(("terrain", generate(Kind::Terrain, 5_000, 1, &NoProgress).expect("a terrain")));
    meshes.push(("sphere in map coordinates", sphere(5, far, 2.0)));
    meshes.push(("tiny sphere", sphere(4, Vec3::ZERO, 1e-30)));
    meshes.push(("huge sphere", sphere(4, Vec3::ZERO, 1e30)));
    meshes.push(("grid cube", grid_cube(8)));
    meshes.retain(|(_, mesh)| mesh.triangle_count() > 0);

    let rays_each = Share::SECONDARY_RAYS.rays() * 7 / 8 / meshes.len() + 1;
    let mut tally = Tally::default();
    for (name, mesh) in meshes {
        let scene = Scene::new(mesh.clone()).expect("builds");
        let random = &mut Random(5);
        let eye = mesh.bounds().center();
        let size = mesh.bounds().extent().max_element();
        let enough = tally.rays + rays_each;
        for i in 0.. {
            if tally.rays >= enough {
                break;
            }
            // Find a hit: where a ray aimed at a face comes upon the mesh.
            let aim = mesh.corners(random.below(mesh.triangle_count()) as u32);
            let target = [aim[0], aim[1], aim[0] * 0.5 + aim[2] * 0.5][i % 3];
            let from = eye + random.point() * (2.0 * size);
            let hit = scene.caster().intersect(&Ray::new(from, target - from)).unwrap_or(Hit::MISS);
            if !hit.is_hit() {
                continue;
            }
            let corners = mesh.corners(hit.face);
            let surface = scene.surface_point(&hit);
            for _ in 0..4 {
                let direction = direction(random, corners);
                let origin = surface.origin_towards(direction);
                let ray = Ray::new(origin, direction);
                assert!(ray.is_valid(), "{name}: {ray:?}");
                let what = || format!("{name}: {ray:?} from {hit:?} on {corners:?}");
                assert!(!meets(origin, direction, corners), "{}", what());
                assert_ne!(
                    scene.caster().intersect(&ray).unwrap_or(Hit::MISS).face,
                    hit.face,
                    "{}",
                    what()
                );
                tally.rays += 1;
                let plain = meets(surface.point, direction, corners);
                tally.plain_self_hits += usize::from(plain);
            }
        }
    }
    tally.finish("secondary rays");
}

/// A convex polyhedron, stretched by powers of two.
struct Convex {
    name: &'static str,
    scene: Scene,
    /// As it was before.
    base: Mesh,
    /// The exponents along the axes, from that of the whole.
    stretch: [i32; 3],
    /// The exponent of the whole.
    size: i32,
    /// The base's exact normals.
    exact_normals: Vec<Point>,
}

impl Convex {
    fn new(name: &'static str, base: Mesh, size: i32, stretch: [i32; 3]) -> Convex {
        let faces = 0..base.triangle_count() as u32;
        let place = |p: Vec3| Vec3::from([0, 1, 2].map(|i| times_power(p[i], size + stretch[i])));
        let mesh = soup(faces.clone().map(|face| base.corners(face).map(place)));
        let normal = |face: u32| {
            let [a, b, c] = base.corners(face).map(exact);
            cross(&minus(&b, &a), &minus(&c, &a))
        };
        let exact_normals = faces.clone().map(normal).collect();
        let scene = Scene::new(mesh).expect("builds");
        let convex = Convex { name, scene, base, stretch, size, exact_normals };
        for vertex in faces.clone().flat_map(|face| convex.base.corners(face)) {
            assert!(faces.clone().all(|face| convex.side(face, vertex) <= 0), "{name}: convex");
        }
        convex
    }

    /// What was `p` in the base, or in which direction it went, exactly.
    fn to_base(&self, p: Vec3, size: i32) -> Vec3 {
        let scale = |p: Vec3, sign: i32| {
            Vec3::from([0, 1, 2].map(|i| times_power(p[i], sign * (size + self.stretch[i]))))
        };
        let in_base = scale(p, -1);
        assert_eq!(scale(in_base, 1), p, "nothing is lost");
        in_base
    }

    /// 1 outside of the base's face, -1 inside, 0 in its plane: exactly.
    fn side(&self, face: u32, p: Vec3) -> i8 {
        let [a, b, c] = self.base.corners(face);
        let normal = (b - a).cross(c - a);
        let value = (p - a).dot(normal);
        // Half a dozen roundings of the differences and the products, and for differences that
        // lose digits the same of the coordinates; a hundred are more than enough.
        let size = (p.abs() + a.abs()).max_element();
        let edges = (b - a).abs().max_element() * (c - a).abs().max_element();
        if value.abs() > 100.0 * f64::EPSILON * size * edges {
            return if value > 0.0 { 1 } else { -1 };
        }
        sign(&dot(&minus(&exact(p), &exact(a)), &self.exact_normals[face as usize]))
    }

    /// 1 outside, -1 inside, 0 on the surface or on the continuation of a face.
    fn side_of_all(&self, p: Vec3) -> i8 {
        let faces = 0..self.base.triangle_count() as u32;
        faces.map(|face| self.side(face, p)).max().expect("faces")
    }
}

fn sign(value: &Q) -> i8 {
    i8::from(value.is_positive()) - i8::from(value.is_negative())
}

/// `x * 2^exponent`, where that is a double.
fn times_power(x: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    x * 2f64.powi(half) * 2f64.powi(exponent - half)
}

/// From a convex body, what leaves it meets nothing at all; what enters it from a point inside
/// leaves it once, and from a point that rounding moved beyond a neighbouring face, twice or not.
#[test]
fn convex_bodies_are_left_for_good_and_crossed_within() {
    let far = Vec3::from([500_000.0, 5_400_000.0, 12.0]);
    // Coordinates of 20 bits, so that denormals hold them.
    let round = |levels: u32| {
        let ball = sphere(levels, Vec3::ZERO, 1.0);
        let rounded =
            |p: Vec3| Vec3::from(p.to_array().map(|x| (x * 1048576.0).round() / 1048576.0));
        soup((0..ball.triangle_count() as u32).map(|face| ball.corners(face).map(rounded)))
    };
    let bodies = [
        Convex::new("ball", round(3), 0, [0; 3]),
        Convex::new("grid cube", grid_cube(4), 0, [0; 3]),
        Convex::new("ball in map coordinates", sphere(3, far, 2.0), 0, [0; 3]),
        Convex::new("disc of slivers", round(2), 0, [0, 0, -40]),
        Convex::new("needle", round(2), 0, [-60, 0, -55]),
        Convex::new("tiny ball", round(2), -100, [0; 3]),
        Convex::new("ball of denormals", round(2), -1054, [0; 3]),
        // The shortest directions are 2^-199, so that t stays finite.
        Convex::new("huge ball", round(2), 800, [0; 3]),
    ];

    // An eighth, since exact judging takes most of the time.
    let rays_each = Share::SECONDARY_RAYS.rays().div_ceil(8 * bodies.len());
    let mut tally = Tally::default();
    let (mut inward, mut inside, mut outside, mut plain_wrong) = (0, 0, 0, 0);
    for body in &bodies {
        let random = &mut Random(11);
        let mut hits = Vec::new();
        for _ in 0..rays_each {
            let face = random.below(body.base.triangle_count()) as u32;
            let corners = body.scene.mesh().corners(face);
            let [u, v] = weights(random);
            let surface = body.scene.surface_point(&Hit { t: 1.0, face, u, v });
            let direction = direction(random, corners);
            let origin = surface.origin_towards(direction);
            let ray = Ray::new(origin, direction);
            let what = || format!("{}: {ray:?} from {u}, {v} of {corners:?}", body.name);

            assert!(!meets(origin, direction, corners), "{}", what());
            let in_base = body.to_base(origin, body.size);
            let normal = &body.exact_normals[face as usize];
            // A normal in the base sees a stretched direction as the stretched normal does.
            let goes = sign(&dot(&exact(body.to_base(direction, 0)), normal));
            let lies = body.side(face, in_base);
            assert!(lies != 0 && (lies == goes || goes == 0), "lies {lies}, {}", what());

            hits.clear();
            body.scene.caster().intersect_all(&ray, &mut hits);
            let any = body.scene.caster().occluded(&ray);
            if lies > 0 {
                assert!(hits.is_empty() && !any, "{hits:?}, {}", what());
            } else {
                inward += 1;
                match body.side_of_all(in_base) {
                    -1 => {
                        assert!(hits.len() == 1 && any, "{hits:?}, {}", what());
                        inside += 1;
                    }
                    1 => {
                        assert!(hits.is_empty() || hits.len() == 2, "{hits:?}, {}", what());
                        outside += 1;
                    }
                    _ => {}
                }
            }
            tally.rays += 1;
            let plain = body
                .scene
                .caster()
                .intersect(&Ray::new(surface.point, direction))
                .unwrap_or(Hit::MISS);
            tally.plain_self_hits += usize::from(plain.face == face);
            plain_wrong += usize::from(goes > 0 && plain.face != NO_FACE);
        }
    }
    assert!(inside > inward / 2 && outside > 0, "{inside} inside, {outside} outside of {inward}");
    assert!(plain_wrong > tally.rays / 10, "only {plain_wrong} leave a body and hit it");
    tally.finish("secondary rays of convex bodies");
}

/// Triangles of every size, shape and place, up to where doubles end: judged in rationals.
#[test]
fn origins_lie_on_their_side_of_the_exact_plane() {
    let random = &mut Random(3);
    let mut tally = Tally::default();
    while tally.rays < 4000 {
        let size = 2f64.powi(random.below(2060) as i32 - 1050);
        let thickness = [1.0, 1e-6, 1e-9, 1e-13, 1e-16, 1e-20][random.below(6)];
        let place = [0.0, 1.0, 1e6, 1e12][random.below(4)];
        let flat = random.below(5) == 0;
        let lay = |p: Vec3| if flat { Vec3::from([p.x, 0.0, p.z]) } else { p };
        let offset = lay(random.point() * (size * place));
        let long = random.point();
        let wide = long * random.unit() + random.point() * thickness;
        let corners = [offset, offset + lay(long) * size, offset + lay(wide) * size];
        if !corners.into_iter().all(Vec3::is_finite) {
            continue;
        }
        let [a, b, c] = corners.map(exact);
        let normal = cross(&minus(&b, &a), &minus(&c, &a));
        let [u, v] = weights(random);
        let surface = SurfacePoint::on_triangle(corners, u, v);
        if normal.iter().all(|x| sign(x) == 0) {
            assert!(surface.normal.x.is_nan(), "no normal for {corners:?}");
            continue;
        }
        for _ in 0..4 {
            let direction = direction(random, corners);
            let origin = surface.origin_towards(direction);
            let lies = sign(&dot(&minus(&exact(origin), &a), &normal));
            let goes = sign(&dot(&exact(direction), &normal));
            let what = || format!("{direction:?} from {u}, {v} of {corners:?}: {origin:?}");
            assert!(
                lies != 0 && (lies == goes || goes == 0),
                "lies {lies}, goes {goes}: {}",
                what()
            );
            assert!(!meets(origin, direction, corners), "{}", what());
            tally.rays += 1;
            tally.plain_self_hits += usize::from(meets(surface.point, direction, corners));
        }
    }
    tally.finish("secondary rays in rationals");
}

/// Origins on a plane of any tilt, at any distance from where the ray came.
#[test]
fn planes_are_left_as_triangles_are() {
    let random = &mut Random(9);
    for _ in 0..2000 {
        // An axis has an exact length; the unit normals of other planes are off by a rounding, but
        // a height and a normal are a plane whatever the length.
        let mut normal = Vec3::ZERO;
        normal[random.below(3)] = if random.below(2) == 0 { 1.0 } else { -1.0 };
        if random.below(2) == 0 {
            normal = unit(random.point());
        }
        let height = random.signed() * 10f64.powi(random.below(9) as i32 - 4);
        let ray =
            Ray::new(random.point() * 10f64.powi(random.below(7) as i32), unit(random.point()));
        let t = (height - normal.dot(ray.origin)) / normal.dot(ray.direction);
        if !(t > 0.0 && t < 1e12) {
            continue;
        }
        let surface = SurfacePoint::on_plane(ray.at(t), normal, t);
        let across = unit(normal.cross(random.point()));
        let direction = across + unit(random.point()) * 10f64.powf(-18.0 * random.unit());
        let origin = surface.origin_towards(direction);
        let exact_height = Q::from_float(height).expect("finite");
        let lies = sign(&(dot(&exact(origin), &exact(normal)) - exact_height));
        let goes = sign(&dot(&exact(direction), &exact(normal)));
        assert!(lies != 0 && (lies == goes || goes == 0), "{ray:?} at {normal:?}, {height}");
    }
}
