//! Meshes on a coarse grid and lines that meet them where it hurts, for proptest.

use halfline::Mesh;
use proptest::prelude::*;

use super::contact::{Case, Range};
use super::integer::{GridLine, GridMesh, Point, TETRAHEDRON};

/// The corners of meshes are multiples of it, so that the middles of edges, their quarters and the
/// centroids of faces are points of the grid as well.
const STEP: i128 = 12;

/// How many lines each mesh gets.
pub const LINES: usize = 16;

/// Where a line begins, or what it is aimed at.
#[derive(Clone, Copy, Debug)]
enum Place {
    Point(Point),
    Vertex,
    MiddleOfEdge,
    QuarterOfEdge,
    Centroid,
    /// On the line along an edge, but outside.
    BeyondEdge,
    /// In the face's plane, but outside.
    BesideFace,
    /// One step of the grid beside a vertex.
    NearVertex(Point),
}

/// Where a line goes.
#[derive(Clone, Copy, Debug)]
enum Course {
    /// To a place of the face with this number, modulo how many there are.
    To(Place, usize),
    Along(Point),
}

/// A line relative to a mesh, and a range of t.
#[derive(Clone, Copy, Debug)]
pub struct Aim {
    start: (Place, usize),
    course: Course,
    speed: i32,
    has_negative_zeros: bool,
    range: Range,
}

impl Aim {
    /// The line, for the mesh with these faces.
    pub fn line(&self, faces: &[[Point; 3]]) -> GridLine {
        let (place, face) = self.start;
        let origin = position(place, face, faces);
        let direction = match self.course {
            Course::Along(direction) => direction,
            Course::To(place, face) => {
                let target = position(place, face, faces);
                [0, 1, 2].map(|axis| target[axis] - origin[axis])
            }
        };
        let &Aim { speed, has_negative_zeros, .. } = self;
        GridLine { origin, direction, speed, has_negative_zeros }
    }
}

fn position(place: Place, face: usize, faces: &[[Point; 3]]) -> Point {
    let mix = |weights: [i128; 3], divisor: i128| {
        let corners = faces[face % faces.len()];
        let sum = |axis: usize| (0..3).map(|i| corners[i][axis] * weights[i]).sum::<i128>();
        [0, 1, 2].map(|axis| sum(axis) / divisor)
    };
    match place {
        Place::Point(point) => point,
        Place::Vertex => mix([1, 0, 0], 1),
        Place::MiddleOfEdge => mix([1, 1, 0], 2),
        Place::QuarterOfEdge => mix([0, 1, 3], 4),
        Place::Centroid => mix([1, 1, 1], 3),
        Place::BeyondEdge => mix([2, -1, 0], 1),
        Place::BesideFace => mix([1, 1, -1], 1),
        Place::NearVertex(by) => {
            let vertex = mix([1, 0, 0], 1);
            [0, 1, 2].map(|axis| vertex[axis] + by[axis])
        }
    }
}

fn point(reach: i128) -> impl Strategy<Value = Point> {
    prop::array::uniform3(-reach..=reach)
}

/// A point that corners may have.
pub fn corner(reach: i128) -> impl Strategy<Value = Point> {
    point(reach).prop_map(|p| p.map(|x| x * STEP))
}

fn place() -> impl Strategy<Value = (Place, usize)> {
    let place = prop_oneof![
        3 => point(6).prop_map(|p| Place::Point(p.map(|x| x * STEP / 2))),
        1 => point(6 * STEP).prop_map(Place::Point),
        1 => Just(Place::Vertex),
        1 => Just(Place::MiddleOfEdge),
        1 => Just(Place::QuarterOfEdge),
        1 => Just(Place::Centroid),
        1 => Just(Place::BeyondEdge),
        1 => Just(Place::BesideFace),
        1 => point(1).prop_map(Place::NearVertex),
    ];
    (place, 0..1000usize)
}

/// Ranges that are whole, cut, behind the origin, and that begin or end at a contact.
pub fn range() -> impl Strategy<Value = Range> {
    prop_oneof![
        3 => Just(Range::HalfLine),
        2 => Just(Range::Line),
        1 => Just(Range::Fixed(0.0, 1.0)),
        1 => Just(Range::Fixed(-1.0, 0.5)),
        1 => Just(Range::Fixed(-0.0, 0.0)),
        1 => (0..9usize).prop_map(Range::At),
        1 => (0..9usize).prop_map(Range::From),
        1 => (0..9usize).prop_map(Range::UpTo),
        1 => (0..9usize).prop_map(Range::After),
        1 => (0..9usize).prop_map(Range::Before),
    ]
}

fn aim() -> impl Strategy<Value = Aim> {
    let course = prop_oneof![
        4 => place().prop_map(|(place, face)| Course::To(place, face)),
        1 => point(2).prop_map(Course::Along),
        1 => (0..3usize, prop_oneof![Just(-1), Just(1)]).prop_map(|(axis, sign)| {
            let mut along = [0; 3];
            along[axis] = sign;
            Course::Along(along)
        }),
    ];
    let speed = prop_oneof![Just(0), -3..=3, Just(-800), Just(800)];
    (place(), course, speed, any::<bool>(), range()).prop_map(
        |(start, course, speed, has_negative_zeros, range)| Aim {
            start,
            course,
            speed,
            has_negative_zeros,
            range,
        },
    )
}

/// Meshes of such faces on grids of every size, with lines.
pub fn aimed_at(
    faces: impl Strategy<Value = Vec<[Point; 3]>>,
) -> impl Strategy<Value = (GridMesh, Vec<Aim>)> {
    let unit = prop_oneof![3 => Just(0), 1 => -100..=100];
    (faces, unit, prop::collection::vec(aim(), LINES))
        .prop_map(|(faces, unit, aims)| (GridMesh { faces, unit }, aims))
}

/// The mesh and its lines as rays, with what the integer judge says of them.
pub fn judged((grid, aims): &(GridMesh, Vec<Aim>)) -> (Mesh, Vec<Case>) {
    let case = |aim: &Aim| {
        let line = aim.line(&grid.faces);
        Case::new(grid.to_ray(&line), grid.contacts(&line), aim.range)
    };
    (grid.to_mesh(), aims.iter().map(case).collect())
}

/// Triangles anywhere on the grid, many of which share corners and edges, or have no area.
pub fn soups() -> impl Strategy<Value = Vec<[Point; 3]>> {
    prop::collection::vec(prop::array::uniform3(corner(2)), 1..48)
}

/// Triangles across the axes: what splitting planes lie in.
pub fn plates() -> impl Strategy<Value = Vec<[Point; 3]>> {
    let plate = (prop::array::uniform3(corner(3)), 0..3usize).prop_map(|(mut corners, axis)| {
        let level = corners[0][axis];
        corners.iter_mut().for_each(|corner| corner[axis] = level);
        corners
    });
    prop::collection::vec(plate, 1..48)
}

/// Many triangles around one vertex.
pub fn fans() -> impl Strategy<Value = Vec<[Point; 3]>> {
    (corner(2), prop_oneof![7 => 3..30usize, 1 => 30..200usize], 0..40i128, 0..8i128).prop_map(
        |(apex, count, radius, wave)| {
            let rim = |i: usize| {
                let angle = (i % count) as f64 / count as f64 * std::f64::consts::TAU;
                let on_circle = |x: f64| (x * radius as f64).round() as i128 * STEP;
                [
                    on_circle(angle.cos()),
                    on_circle(angle.sin()),
                    (i % count) as i128 * wave % 5 * STEP,
                ]
            };
            (0..count).map(|i| [apex, rim(i), rim(i + 1)]).collect()
        },
    )
}

/// Copies of few triangles, their corners in any order: at each point many faces tie.
pub fn stacks() -> impl Strategy<Value = Vec<[Point; 3]>> {
    let triangles = prop::collection::vec(prop::array::uniform3(corner(2)), 1..4);
    let copies = prop::collection::vec((0..4usize, 0..6usize), 1..24);
    (triangles, copies).prop_map(|(triangles, copies)| {
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        let copy = |(which, order): (usize, usize)| {
            orders[order].map(|i: usize| triangles[which % triangles.len()][i])
        };
        copies.into_iter().map(copy).collect()
    })
}

/// Triangles a hundred thousand times longer than wide.
pub fn needles() -> impl Strategy<Value = Vec<[Point; 3]>> {
    let needle = (corner(2), corner(2), point(1), point(2), 0..=16i128).prop_map(
        |(tip, to, thick, shift, along)| {
            let far = [0, 1, 2].map(|axis| tip[axis] + (to[axis] - tip[axis]) * (1 << 13));
            let third = |axis: usize| {
                tip[axis] + (far[axis] - tip[axis]) / 16 * along + thick[axis] + shift[axis]
            };
            [tip, far, [third(0), third(1), third(2)]]
        },
    );
    prop::collection::vec(needle, 1..24)
}

/// The sides of tetrahedra that lie through each other.
pub fn tetrahedra() -> impl Strategy<Value = Vec<[Point; 4]>> {
    prop::collection::vec(prop::array::uniform4(corner(2)), 1..8)
}

/// The faces of tetrahedra.
pub fn sides(tetrahedra: &[[Point; 4]]) -> Vec<[Point; 3]> {
    tetrahedra.iter().flat_map(|corners| TETRAHEDRON.map(|side| side.map(|i| corners[i]))).collect()
}
