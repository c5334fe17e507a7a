//! Meshes and rays that are made to hurt, and what every tree must be like.

// Each test program uses a part of it.
#![allow(dead_code)]

pub mod contact;
pub mod engines;
pub mod exact;
pub mod grid;
pub mod integer;
pub mod proof;
mod random;
mod shapes;

pub use random::Random;
pub use shapes::{grid_cube, soup, sphere};

use halfline::geometry::NO_FACE;
use halfline::mesh::Positions;
use halfline::numeric::PreparedRay;
use halfline::tree::{BLOCK_SIZE, Bounds, LeafBlock, MAX_STACK_SIZE, NodeRef, Tree};
use halfline::{Mesh, Ray, Vec3};

/// The triangles of a mesh in single precision, of which trees keep copies.
pub fn in_single_precision(mesh: &Mesh) -> Mesh {
    let Positions::F64(positions) = mesh.positions() else { return mesh.clone() };
    let positions = positions.iter().map(|p| p.map(|x| x as f32));
    Mesh::new(Positions::F32(positions.collect()), mesh.triangles().to_vec()).expect("a valid mesh")
}

/// The triangles of a mesh in double precision.
pub fn in_double_precision(mesh: &Mesh) -> Mesh {
    let positions = (0..mesh.positions().len()).map(|i| mesh.positions().get(i).to_array());
    Mesh::new(Positions::F64(positions.collect()), mesh.triangles().to_vec()).expect("a valid mesh")
}

/// Stairs of unit cubes: many squares in the same planes, at every height.
pub fn stairs(n: i32) -> Mesh {
    let mut triangles = Vec::new();
    for (x, y) in (0..n).flat_map(|x| (0..n).map(move |y| (x, y))) {
        let height = f64::from((x * 7 + y * 3) % n);
        let p = |dx: i32, dy: i32, z: f64| Vec3::from([f64::from(x + dx), f64::from(y + dy), z]);
        let [a, b, c, d] = [p(0, 0, height), p(1, 0, height), p(1, 1, height), p(0, 1, height)];
        triangles.extend([[a, b, c], [a, c, d]]);
        let [e, f] = [p(0, 0, 0.0), p(1, 0, 0.0)];
        triangles.extend([[e, f, b], [e, b, a]]);
        let g = p(0, 1, 0.0);
        triangles.extend([[e, g, d], [e, d, a]]);
    }
    soup(triangles)
}

/// Every mesh of the table, by name.
pub fn meshes() -> Vec<(&'static str, Mesh)> {
    let mut random = Random(7);
    let random_soup = soup((0..600).map(|_| {
        let p = random.point();
        [p, p + random.point() * 0.2, p + random.point() * 0.2]
    }));
    let slivers = soup((0..300).map(|_| {
        let (a, b) = (random.point(), random.point());
        [a, b, a * 0.3 + b * 0.7 + random.point() * 1e-9]
    }));
    let fan = soup((0..400).map(|i| {
        let rim = |i: i32| {
            let angle = f64::from(i) * std::f64::consts::TAU / 400.0;
            Vec3::from([angle.cos(), angle.sin(), 0.25])
        };
        [Vec3::ZERO, rim(i), rim(i + 1)]
    }));
    let beams = soup((0..300).map(|i| {
        let (x, y) = (random.signed(), random.signed());
        let mut t = [
            Vec3::from([x, y, -50.0]),
            Vec3::from([x + 0.01, y, -50.0]),
            Vec3::from([x, y + 0.01, 50.0]),
        ];
        for p in &mut t {
            *p = [*p, Vec3::from([p.y, p.z, p.x]), Vec3::from([p.z, p.x, p.y])][i % 3];
        }
        t
    }));
    let copies = {
        let [a, b, c] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from);
        let turned = [[a, b, c], [b, c, a], [c, a, b], [a, c, b]];
        soup((0..200).map(|i| turned[i % 4]))
    };
    let plane = soup((0..20).flat_map(|i| (0..20).map(move |j| (i, j))).flat_map(|(i, j)| {
        let p = |di: i32, dj: i32| Vec3::from([f64::from(i + di), f64::from(j + dj), 3.0]);
        [[p(0, 0), p(1, 0), p(1, 1)], [p(0, 0), p(1, 1), p(0, 1)]]
    }));
    let broken = {
        let nan = Vec3::from([f64::NAN, 0.0, 0.0]);
        let infinite = Vec3::from([0.0, f64::INFINITY, 0.0]);
        let p = Vec3::from([0.5, 0.5, 0.5]);
        let good = (0..40).map(|i| {
            let z = f64::from(i) * 0.125;
            [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]].map(Vec3::from)
        });
        let bad =
            [[nan, p, Vec3::ZERO], [p, infinite, Vec3::ZERO], [p, p, p], [p, p * 2.0, p * 3.0]];
        soup(bad.into_iter().chain(good))
    };
    // Sheets across each axis, one unit in the last place apart: from afar many have the same t, and
    // a plane between two of them is passed at that t or, with rounding, beside it.
    let sheets = soup((0..240).map(|i| {
        let (axis, sheet) = (i % 3, random.below(24) as f64);
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[p, q]| {
            let mut corner = Vec3::splat(1.0 + sheet * f64::EPSILON);
            corner[(axis + 1) % 3] = p;
            corner[(axis + 2) % 3] = q;
            corner
        })
    }));
    let far = Vec3::from([500_000.0, 5_400_000.0, 12.0]);
    vec![
        ("grid cube", grid_cube(4)),
        ("stairs", stairs(8)),
        ("sphere", sphere(3, Vec3::ZERO, 1.0)),
        ("sphere in single precision", in_single_precision(&sphere(3, Vec3::ZERO, 1.0))),
        ("stairs in single precision", in_single_precision(&stairs(8))),
        ("sphere in map coordinates", sphere(3, far, 2.0)),
        ("tiny sphere", sphere(2, Vec3::ZERO, 1e-30)),
        ("huge sphere", sphere(2, Vec3::splat(1e30), 1e30)),
        ("random soup", random_soup),
        ("slivers", slivers),
        ("fan", fan),
        ("beams", beams),
        ("coplanar copies", copies),
        ("plane", plane),
        ("sheets", sheets),
        ("broken faces", broken),
        (
            "one triangle",
            soup([[Vec3::ZERO, Vec3::from([1.0, 0.0, 0.0]), Vec3::from([0.0, 1.0, 0.0])]]),
        ),
        ("nothing", soup([])),
    ]
}

/// A finite point on or near a face: a vertex, the middle of an edge, a point of an edge or of the
/// face, a point beside a vertex.
pub fn target(mesh: &Mesh, face: u32, random: &mut Random) -> Option<Vec3> {
    let [a, b, c] = mesh.corners(face);
    let share = random.unit();
    let target = match random.below(5) {
        0 => a,
        1 => a * 0.5 + b * 0.5,
        2 => a * share + b * (1.0 - share),
        3 => a * (share * 0.5) + b * (0.5 - share * 0.5) + c * 0.5,
        _ => a + (b - a) * random.signed() * 1e-9,
    };
    target.is_finite().then_some(target)
}

/// One ray: aimed at a vertex, an edge, a face or a plane of `planes` (user coordinates, by axis),
/// from a random place, a lattice point or the surface itself; axis-parallel and lattice
/// directions; ranges that end at what is aimed at, to the bit.
pub fn nasty_ray(mesh: &Mesh, planes: &[(usize, f64)], random: &mut Random) -> Ray {
    let bounds = mesh.bounds();
    if bounds.is_empty() {
        return Ray::new(random.point(), random.point());
    }
    let size = bounds.extent().max_element().max(f64::MIN_POSITIVE);
    let anywhere = |random: &mut Random| bounds.center() + random.point() * size;
    let any_face = |random: &mut Random| random.below(mesh.triangle_count()) as u32;
    let aimed_face = any_face(random);
    let mut aim = target(mesh, aimed_face, random).unwrap_or_else(|| bounds.center());
    let mut origin = match random.below(6) {
        0 => bounds.center(),
        1 => target(mesh, any_face(random), random).unwrap_or_else(|| bounds.center()),
        2 => {
            // A lattice point, where the mesh is grid-aligned one of its planes.
            let p = anywhere(random);
            Vec3::from([p.x.round(), p.y.round(), p.z.round()])
        }
        _ => anywhere(random),
    };

    // Put one coordinate, or the coordinate of both ends, onto a splitting plane.
    if !planes.is_empty() && random.below(3) == 0 {
        let (axis, position) = planes[random.below(planes.len())];
        aim[axis] = position;
        if random.below(2) == 0 {
            origin[axis] = position;
        }
    }
    let direction = match random.below(5) {
        0 => {
            // Along an axis, through the coordinates of what is aimed at.
            let axis = random.below(3);
            let mut direction = Vec3::ZERO;
            direction[axis] = if random.below(2) == 0 { size } else { -size };
            let along = origin[axis];
            origin = aim;
            origin[axis] = along;
            direction
        }
        1 => {
            let step = |random: &mut Random| random.below(5) as f64 - 2.0;
            Vec3::from([step(random), step(random), step(random)]) * size
        }
        2 => random.point() * size,
        _ => aim - origin,
    };
    // A component of zero may have either sign.
    let negative_zeros = random.below(2) == 0;
    let direction = direction.to_array().map(|x| if x == 0.0 && negative_zeros { -0.0 } else { x });
    let direction = Vec3::from(direction);
    let line = Ray::with_range(origin, direction, f64::NEG_INFINITY, f64::INFINITY);
    let contact = PreparedRay::new(&line).and_then(|line| line.meet(mesh.corners(aimed_face)));
    if let (Some(contact), 0) = (contact, random.below(2)) {
        return match random.below(3) {
            0 => Ray { t_max: contact.t, ..line },
            1 => Ray { t_min: contact.t, ..line },
            _ => Ray { t_min: contact.t, t_max: contact.t, ..line },
        };
    }
    match random.below(8) {
        0 => Ray::with_range(origin, direction, 0.0, 1.0),
        1 => Ray::with_range(origin, direction, 1.0, f64::INFINITY),
        2 => Ray::with_range(origin, direction, -1.0, random.unit()),
        3 => line,
        4 => Ray::new(origin, direction * [1e-300, 1e-20, 1e20, 1e200][random.below(4)]),
        _ => Ray::new(origin, direction),
    }
}

/// The double that lies `steps` units in the last place above, or below if that is negative.
pub fn nudge(x: f64, steps: i32) -> f64 {
    (0..steps.abs()).fold(x, |x, _| if steps > 0 { x.next_up() } else { x.next_down() })
}

fn contains(outer: &Bounds, inner: &Bounds) -> bool {
    inner.is_empty() || (0..3).all(|a| outer.min[a] <= inner.min[a] && inner.max[a] <= outer.max[a])
}

/// A leaf's corners are the nearest that single precision has.
fn check_rounding(name: &str, tree: &Tree, mesh: &Mesh, block: &LeafBlock, lane: usize) {
    for (number, corner) in mesh.corners(block.faces[lane]).into_iter().enumerate() {
        let exact = tree.frame.point(corner);
        for axis in 0..3 {
            let stored = block.corners[number][axis][lane];
            assert_eq!(stored, exact[axis] as f32, "{name}: face {}", block.faces[lane]);
            assert!(stored.abs() <= tree.reach, "{name}: {stored} out of reach");
        }
    }
}

/// Walks the whole tree and fails unless it is what `tree/` says: leaves of up to eight faces that know their
/// corners, every reference in one leaf, each node and leaf once, boxes within boxes, all children visited in any
/// octant, and a stack as large as walks need.
pub fn check_structure(name: &str, tree: &Tree, mesh: &Mesh) {
    let mut seen = vec![false; mesh.triangle_count()];
    let mut visits = [vec![0; tree.nodes.len()], vec![0; tree.leaves.blocks.len()]];
    let mut referenced = 0;
    let mut stack_sizes = vec![0; tree.nodes.len()];
    let mut pending = vec![(tree.root, tree.bounds)];
    while let Some((place, bounds)) = pending.pop() {
        if place == NodeRef::END {
            assert_eq!(tree.references, 0, "{name}: an empty tree");
            continue;
        }
        visits[usize::from(place.is_leaf())][place.index()] += 1;
        if place.is_leaf() {
            let block = &tree.leaves.blocks[place.index()];
            let faces: Vec<u32> = tree.faces(place.index()).collect();
            assert!(!faces.is_empty() && faces.len() <= BLOCK_SIZE, "{name}: a leaf of {faces:?}");
            assert!(block.faces[faces.len()..].iter().all(|&face| face == NO_FACE), "{name}");
            for (lane, &face) in faces.iter().enumerate() {
                seen[face as usize] = true;
                let corners = tree.leaves.corners(mesh, &tree.frame, block, lane);
                assert_eq!(corners, mesh.corners(face), "{name}: corners of face {face}");
                check_rounding(name, tree, mesh, block, lane);
                check_overlap(name, tree, &bounds, block, lane);
            }
            referenced += faces.len();
            continue;
        }
        let node = &tree.nodes[place.index()];
        let children: Vec<NodeRef> = node.children().collect();
        assert!(children.len() >= 2, "{name}: {children:?}");
        for order in node.orders {
            let mut lanes: Vec<u32> = (0..8).map(|step| order >> (3 * step) & 7).collect();
            assert!(lanes[..children.len()].iter().all(|&lane| lane < children.len() as u32));
            lanes.sort_unstable();
            assert_eq!(lanes, [0, 1, 2, 3, 4, 5, 6, 7], "{name}: an order");
        }
        for (lane, &child) in children.iter().enumerate() {
            let inner = node.bounds(lane);
            assert!(contains(&bounds, &inner), "{name}: {inner:?} in {bounds:?}");
            assert!(
                child.is_leaf() || child.index() > place.index(),
                "{name}: children come later"
            );
            pending.push((child, inner));
        }
    }
    for (number, node) in tree.nodes.iter().enumerate().rev() {
        let below = node.children().filter(|child| child.is_node());
        let below = below.map(|child| stack_sizes[child.index()]).max().unwrap_or(0);
        stack_sizes[number] = node.children().count() - 1 + below;
    }
    assert_eq!(tree.max_stack_size, stack_sizes.first().copied().unwrap_or(0), "{name}");
    assert!(tree.max_stack_size <= MAX_STACK_SIZE, "{name}");
    let is_empty = tree.root == NodeRef::END;
    assert!(is_empty || visits.iter().flatten().all(|&count| count == 1), "{name}: each once");
    assert_eq!(referenced, tree.references, "{name}: every reference in one leaf");
    let missing = seen.iter().filter(|&&seen| !seen).count();
    let skipped = tree.skipped_zero_area + tree.skipped_non_finite;
    assert_eq!(missing, skipped, "{name}: faces without a reference");
}

/// A leaf's triangles reach into its box, within the rounding of their corners.
fn check_overlap(name: &str, tree: &Tree, bounds: &Bounds, block: &LeafBlock, lane: usize) {
    let room = 4.0 * f32::EPSILON * tree.reach;
    for axis in 0..3 {
        let corners = block.corners.map(|corner| corner[axis][lane]);
        let (low, high) = (
            corners.into_iter().fold(f32::INFINITY, f32::min),
            corners.into_iter().fold(f32::NEG_INFINITY, f32::max),
        );
        let overlaps = low - room <= bounds.max[axis] && bounds.min[axis] <= high + room;
        assert!(overlaps, "{name}: face {} is beside {bounds:?}", block.faces[lane]);
    }
}
