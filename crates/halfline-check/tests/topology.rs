//! What `topology::examine` says of meshes whose counts are known, and of random ones that a naive
//! judge counts with tables.

#[path = "../../halfline/tests/common/shapes.rs"]
mod shapes;

use std::collections::{BTreeSet, HashMap, HashSet};

use halfline::geometry::random::Random;
use halfline::mesh::Positions;
use halfline::progress::{NoProgress, Observer, Stage};
use halfline::{Error, Mesh, Vec3};
use halfline_check::topology::{Facing, Found, Target, Topology, examine};
use shapes::{grid_cube, soup, sphere};

fn topology(mesh: &Mesh) -> Topology {
    examine(mesh, &NoProgress).unwrap()
}

fn mesh(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    Mesh::new(Positions::F32(vertices.to_vec().into()), triangles.to_vec()).unwrap()
}

fn found(first_faces: &[u32]) -> Found {
    Found { count: first_faces.len(), first_faces: first_faces.to_vec() }
}

/// The triangles of the box from `low` to `high`, fronts outside.
fn cuboid(low: [f64; 3], high: [f64; 3]) -> Vec<[Vec3; 3]> {
    let corner =
        |bits: usize| Vec3::from([0, 1, 2].map(|axis| [low[axis], high[axis]][bits >> axis & 1]));
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .map(|t| t.map(corner))
        .collect()
}

/// Closed and consistent: no defect of edges.
#[track_caller]
fn assert_closed(t: &Topology, facing: Facing) {
    assert!(t.is_closed() && t.is_consistent(), "{t:?}");
    assert_eq!((t.open_edges.count, t.inconsistent_edges.count), (0, 0));
    assert_eq!(t.facing(), Some(facing));
}

#[test]
fn a_sphere_is_one_closed_piece() {
    // 8 * 4^3 triangles; a soup in the file, yet 258 places and no hole.
    let t = topology(&sphere(3, Vec3::from([5.0, -1.0, 2.0]), 2.0));
    assert_closed(&t, Facing::Outward);
    assert_eq!((t.triangles, t.vertices, t.edges, t.components), (512, 1536, 768, 1));
    assert_eq!(t.duplicate_vertices, 1536 - 258);
    assert_eq!(t.euler_characteristic(), 2);
    assert_eq!(t.target_count(), 258 + 768);
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
    assert!((0.95 * ball..ball).contains(&t.signed_volume), "{}", t.signed_volume);
    assert!(t.signed_volume_error < 1e-10);
}

#[test]
fn a_gridded_cube_has_its_volume_and_no_defect() {
    let t = topology(&grid_cube(4));
    assert_closed(&t, Facing::Outward);
    assert_eq!((t.triangles, t.edges, t.components), (768, 1152, 1));
    assert_eq!(t.signed_volume, 512.0);
    for defects in [t.degenerate_faces, t.duplicate_faces, t.non_finite_faces, t.non_manifold_edges]
    {
        assert_eq!(defects, Found::default());
    }
}

#[test]
fn a_cube_inside_out_faces_inward() {
    let inside_out = soup(cuboid([0.0; 3], [1.0, 2.0, 3.0]).into_iter().map(|[a, b, c]| [a, c, b]));
    let t = topology(&inside_out);
    assert_closed(&t, Facing::Inward);
    assert_eq!(t.signed_volume, -6.0);
}

#[test]
fn an_open_sheet_has_a_border() {
    // 20 x 20 squares.
    let p = |i: u32, j: u32| Vec3::from([f64::from(i), f64::from(j), 3.0]);
    let squares = (0..20).flat_map(|i| (0..20).map(move |j| (i, j)));
    let sheet = soup(squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1)];
        [[a, b, c], [a, c, d]]
    }));
    let t = topology(&sheet);
    assert!(!t.is_closed() && t.is_consistent());
    assert_eq!((t.edges, t.open_edges.count, t.odd_edges, t.components), (1240, 80, 80, 1));
    assert_eq!(t.open_edges.first_faces, [0, 1, 3, 5, 7]);
    assert_eq!(t.euler_characteristic(), 1);
    assert_eq!(t.facing(), None);
}

#[test]
fn a_moebius_strip_has_one_border_and_no_sides() {
    // Seven squares around, the last one joined upside down.
    let vertices: Vec<[f32; 3]> =
        (0..7).flat_map(|i| [[i as f32, 0.0, 0.0], [i as f32, 1.0, (i * i) as f32]]).collect();
    let triangles: Vec<[u32; 3]> = (0..7)
        .flat_map(|i| {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i < 6 { (2 * i + 2, 2 * i + 3) } else { (1, 0) };
            [[a, c, b], [c, d, b]]
        })
        .collect();
    let t = topology(&mesh(&vertices, &triangles));
    assert_eq!((t.edges, t.open_edges.count, t.euler_characteristic()), (28, 14, 0));
    assert_eq!(t.inconsistent_edges, found(&[0]));
    assert!(!t.is_closed() && !t.is_consistent());
}

#[test]
fn two_cubes_may_share_an_edge() {
    let cubes = [cuboid([0.0; 3], [1.0; 3]), cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])].concat();
    let t = topology(&soup(cubes));
    // Four faces at that edge, as many each way: still closed, and any ray's parity is right.
    assert_closed(&t, Facing::Outward);
    assert_eq!(t.non_manifold_edges.count, 1);
    assert_eq!((t.edges, t.components), (35, 1));
    assert_eq!(t.signed_volume, 2.0);
}

#[test]
fn cubes_that_share_a_vertex_are_one_piece_and_others_are_not() {
    let first = cuboid([0.0; 3], [1.0; 3]);
    let touching = [first.clone(), cuboid([1.0; 3], [2.0; 3])].concat();
    assert_eq!(topology(&soup(touching)).components, 1);
    let apart = [first, cuboid([1.5; 3], [2.0; 3]), cuboid([5.0; 3], [6.0; 3])].concat();
    let t = topology(&soup(apart));
    assert_eq!((t.components, t.euler_characteristic()), (3, 6));
}

#[test]
fn duplicate_faces_are_found_in_any_order_of_their_corners() {
    let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Vertex 4 lies where 1 does.
    let t = topology(&mesh(
        &[a, b, c, d, b],
        &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 4], [0, 3, 2], [4, 0, 2]],
    ));
    assert_eq!(t.duplicate_faces, found(&[3, 5]));
    assert_eq!((t.duplicate_vertices, t.unreferenced_vertices), (1, 0));
    // A face that is there three times leaves the number of faces of its edges even.
    assert_eq!(t.non_manifold_edges, Found { count: 3, first_faces: vec![0] });
    assert!(t.is_closed());
    let t =
        topology(&mesh(&[a, b, c, d], &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 1], [0, 3, 2]]));
    assert_eq!((t.odd_edges, t.open_edges.count), (3, 0));
    assert!(!t.is_closed());
}

#[test]
fn a_turned_face_is_found() {
    let mut faces = cuboid([0.0; 3], [1.0; 3]);
    faces[7].swap(0, 1);
    let t = topology(&soup(faces));
    assert!(t.is_closed() && !t.is_consistent());
    assert_eq!(t.inconsistent_edges.count, 3);
    assert!(t.inconsistent_edges.first_faces.iter().all(|&face| face <= 7));
    assert_eq!(t.facing(), None);
}

#[test]
fn a_sliver_closes_the_gap_that_it_fills() {
    // A tetrahedron, one edge of which is divided in one of its two faces only.
    let [a, b, c, d] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    let middle = [2.0, 0.0, 0.0];
    let vertices = [a, b, c, d, middle];
    let divided = [[0, 2, 4], [4, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let t = topology(&mesh(&vertices, &divided));
    assert_eq!((t.open_edges.count, t.is_closed()), (3, false));
    let with_sliver = [&divided[..], &[[0, 4, 1]]].concat();
    let t = topology(&mesh(&vertices, &with_sliver));
    assert_eq!(t.degenerate_faces, found(&[5]));
    assert_closed(&t, Facing::Outward);
    // A face with two corners in one place closes nothing, and opens nothing.
    let with_collapsed = [&with_sliver[..], &[[1, 1, 2], [0, 0, 0]]].concat();
    let t = topology(&mesh(&vertices, &with_collapsed));
    assert_eq!(t.degenerate_faces, found(&[5, 6, 7]));
    assert_closed(&t, Facing::Outward);
    assert_eq!((t.surface_faces, t.euler_characteristic()), (6, 2));
}

#[test]
fn what_is_not_finite_leaves_a_hole() {
    let mut vertices = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    assert!(topology(&mesh(&vertices, &triangles)).is_closed());
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        vertices[3][1] = bad;
        let t = topology(&mesh(&vertices, &triangles));
        assert_eq!(t.non_finite_faces, found(&[1, 2, 3]));
        assert_eq!((t.open_edges.count, t.surface_faces), (3, 1));
    }
}

#[test]
fn meshes_of_nothing_or_little() {
    for (vertices, triangles) in [
        (&[][..], &[][..]),
        (&[[0.0; 3]; 3], &[]),
        (&[[1.0; 3]; 3], &[[0, 1, 2], [1, 1, 1]]),
        (&[[f32::NAN; 3]; 3], &[[0, 1, 2]]),
    ] {
        let t = topology(&mesh(vertices, triangles));
        assert_eq!((t.edges, t.surface_faces, t.components, t.target_count()), (0, 0, 0, 0));
        assert!(!t.is_closed());
        assert_eq!(t.facing(), None);
        assert_eq!(t.signed_volume, 0.0);
        let unreferenced = if triangles.is_empty() { vertices.len() } else { 0 };
        assert_eq!(t.unreferenced_vertices, unreferenced);
    }
    let t = topology(&soup([[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from)]));
    assert_eq!(
        (t.edges, t.open_edges.clone(), t.components),
        (3, Found { count: 3, first_faces: vec![0] }, 1)
    );
}

#[test]
fn a_closed_surface_without_volume_faces_neither_way() {
    let p = |x: f64, y: f64| Vec3::from([x, y, 0.1]);
    let [a, b, c] = [p(0.3, 0.1), p(1.7, 0.9), p(0.2, 2.3)];
    assert_closed(&topology(&soup([[a, b, c], [a, c, b]])), Facing::Neither);
}

/// What a table of edges says.
fn count_naively(mesh: &Mesh) -> [usize; 8] {
    let corners = |face: u32| mesh.corners(face).map(|p| p.to_array().map(|c| (c + 0.0).to_bits()));
    let mut edges: HashMap<BTreeSet<[u64; 3]>, [usize; 2]> = HashMap::new();
    let mut faces: HashSet<BTreeSet<[u64; 3]>> = HashSet::new();
    let mut used: Vec<BTreeSet<[u64; 3]>> = Vec::new();
    let mut duplicates = 0;
    for face in 0..mesh.triangle_count() as u32 {
        let corners = corners(face);
        let set = BTreeSet::from(corners);
        if set.len() < 3 {
            continue;
        }
        duplicates += usize::from(!faces.insert(set.clone()));
        for slot in 0..3 {
            let (from, to) = (corners[slot], corners[(slot + 1) % 3]);
            edges.entry([from, to].into()).or_default()[usize::from(from < to)] += 1;
        }
        // Merge the pieces that the face touches.
        let (touched, mut apart): (Vec<_>, Vec<_>) =
            used.into_iter().partition(|piece| !piece.is_disjoint(&set));
        apart.push(touched.into_iter().fold(set, |mut all, piece| {
            all.extend(piece);
            all
        }));
        used = apart;
    }
    let count = |wanted: &dyn Fn(usize, usize) -> bool| {
        edges.values().filter(|&&[down, up]| wanted(down, up)).count()
    };
    [
        edges.len(),
        count(&|down, up| down + up == 1),
        count(&|down, up| down + up > 2),
        count(&|down, up| down + up == 2 && down != up),
        count(&|down, up| (down + up) % 2 == 1),
        count(&|down, up| down != up),
        duplicates,
        used.len(),
    ]
}

#[test]
fn random_meshes_are_counted_as_by_a_table() {
    let mut random = Random::new(11, 0);
    for case in 0..300 {
        let places = 4 + random.below(40);
        let coordinate = |random: &mut Random| [-0.0, 0.0, 1.0, 2.0][random.below(4)];
        let vertices: Vec<[f64; 3]> =
            (0..places).map(|_| [(); 3].map(|()| coordinate(&mut random))).collect();
        let vertex = |random: &mut Random| random.below(places) as u32;
        let triangles: Vec<[u32; 3]> =
            (0..random.below(120)).map(|_| [(); 3].map(|()| vertex(&mut random))).collect();
        let mesh = Mesh::new(Positions::F64(vertices.into()), triangles).unwrap();
        let t = topology(&mesh);
        let counts = [
            t.edges,
            t.open_edges.count,
            t.non_manifold_edges.count,
            t.inconsistent_edges.count,
            t.odd_edges,
            t.unbalanced_edges,
            t.duplicate_faces.count,
            t.components,
        ];
        assert_eq!(counts, count_naively(&mesh), "case {case}: {mesh:?}");
    }
}

#[test]
fn every_vertex_and_edge_is_a_target_once() {
    let mesh = grid_cube(2);
    let t = topology(&mesh);
    let mut positions = HashSet::new();
    let mut vertices = 0;
    for target in (0..t.target_count()).map(|i| t.target(i)) {
        let position = target.position(&mesh);
        assert!(positions.insert(position.to_array().map(|c| (c + 0.0).to_bits())), "{target:?}");
        if let Target::Vertex { face, corner } = target {
            vertices += 1;
            assert_eq!(position, mesh.corners(face)[corner as usize]);
        }
    }
    // 96 squares: 98 corners, and 192 sides and 96 diagonals, whose middles are no corners.
    assert_eq!((vertices, positions.len()), (98, 98 + 288));
}

/// Ends the work after so many questions.
struct Impatient(std::sync::atomic::AtomicUsize);

impl Observer for Impatient {
    fn report(&self, stage: Stage, done: u64, total: u64) {
        assert_eq!(stage, Stage::Examine);
        assert!(done <= total);
    }

    fn cancelled(&self) -> bool {
        use std::sync::atomic::Ordering;
        self.0
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1))
            .is_err()
    }
}

#[test]
fn it_can_be_interrupted_anywhere() {
    let mesh = sphere(6, Vec3::ZERO, 1.0);
    let mut interrupted = 0;
    while let Err(error) = examine(&mesh, &Impatient(interrupted.into())) {
        assert!(matches!(error, Error::Interrupted));
        interrupted += 1;
    }
    // Six passes over 98,304 vertices and over 32,768 faces, and what lies between them.
    assert!(interrupted > 20, "asked {interrupted} times");
}
