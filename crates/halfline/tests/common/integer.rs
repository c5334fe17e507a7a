//! The judge in integer arithmetic: for meshes and rays on coarse grids, where vertices, planes and
//! rays coincide, and fast enough for millions of rays. It shares no code with what it judges.

use halfline::{Mesh, Ray, Vec3};

use std::cell::OnceCell;
use std::collections::HashMap;

use super::contact::ExactContact;
use super::soup;

/// A point of the grid. No coordinate exceeds [`LARGEST`], so that nothing below overflows: a
/// difference of two has 21 bits, a determinant of three rows of differences 3 x 21 + 3.
pub type Point = [i128; 3];

/// The largest coordinate of the grid.
pub const LARGEST: i128 = 1 << 20;

/// Triangles on a grid.
#[derive(Clone, Debug)]
pub struct GridMesh {
    pub faces: Vec<[Point; 3]>,
    /// The grid's lines are 2^unit apart.
    pub unit: i32,
}

/// A line on the grid of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct GridLine {
    pub origin: Point,
    /// Times 2^speed.
    pub direction: Point,
    pub speed: i32,
    /// True if a component of zero is a negative one.
    pub has_negative_zeros: bool,
}

/// `x * 2^exponent`.
fn scaled(x: f64, exponent: i32) -> f64 {
    // A single power could be out of range where the product is not.
    x * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2)
}

fn to_vec3(point: Point, exponent: i32) -> Vec3 {
    Vec3::from(point.map(|x| {
        assert!(x.abs() <= LARGEST, "{x} is no coordinate of the grid");
        scaled(x as f64, exponent)
    }))
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl GridMesh {
    /// The mesh in double precision.
    pub fn to_mesh(&self) -> Mesh {
        soup(self.faces.iter().map(|corners| corners.map(|corner| to_vec3(corner, self.unit))))
    }

    /// The line as a ray.
    pub fn to_ray(&self, line: &GridLine) -> Ray {
        let zero = if line.has_negative_zeros { -0.0 } else { 0.0 };
        let direction = to_vec3(line.direction, line.speed).to_array();
        let direction = direction.map(|x| if x == 0.0 { zero } else { x });
        Ray::new(to_vec3(line.origin, self.unit), direction.into())
    }

    /// Every contact of the line, in face order.
    pub fn contacts(&self, line: &GridLine) -> Vec<ExactContact> {
        let border = OnceCell::new();
        let contact = |face: usize| {
            let [t, u, v] = meeting(line, self.faces[face])?;
            let t = scaled(t, self.unit - line.speed);
            let is_crossing = crosses(line, self.faces[face]);
            let on_edges = edges_met(line, self.faces[face]);
            let is_on_border = !on_edges.is_empty()
                && is_on_border(&on_edges, border.get_or_init(|| self.border()));
            Some(ExactContact { face: face as u32, t, u, v, is_crossing, is_on_border })
        };
        (0..self.faces.len()).filter_map(contact).collect()
    }

    /// The edges that an odd number of faces have. Faces with two corners in one place have none.
    fn border(&self) -> Vec<[Point; 2]> {
        let mut faces_of_edge: HashMap<[Point; 2], usize> = HashMap::new();
        for &[a, b, c] in self.faces.iter().filter(|[a, b, c]| a != b && b != c && c != a) {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                *faces_of_edge.entry([p.min(q), p.max(q)]).or_default() += 1;
            }
        }
        faces_of_edge
            .into_iter()
            .filter(|(_, faces)| faces % 2 == 1)
            .map(|(edge, _)| edge)
            .collect()
    }
}

/// The edges of a face that the line meets, which it does meet in one point: none inside of the
/// face, one inside of an edge, two at a corner.
fn edges_met(line: &GridLine, [a, b, c]: [Point; 3]) -> Vec<[Point; 2]> {
    let from_origin = |corner| minus(corner, line.origin);
    [[a, b], [b, c], [c, a]]
        .into_iter()
        .filter(|&[p, q]| dot(line.direction, cross(from_origin(p), from_origin(q))) == 0)
        .collect()
}

/// True if the one edge met is of the border, or the corner that two have in common ends one.
fn is_on_border(met: &[[Point; 2]], border: &[[Point; 2]]) -> bool {
    match *met {
        [[p, q]] => border.contains(&[p.min(q), p.max(q)]),
        [[p, q], other] => {
            let corner = if other.contains(&p) { p } else { q };
            border.iter().any(|edge| edge.contains(&corner))
        }
        _ => false,
    }
}

/// t, u and v, rounded, of the line's meeting with the closed triangle. The weight of a corner is
/// the volume of the tetrahedron over the edge opposite to it, with the direction as fourth edge.
fn meeting(line: &GridLine, corners: [Point; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = corners.map(|corner| minus(corner, line.origin));
    let volumes = [cross(b, c), cross(c, a), cross(a, b)].map(|normal| dot(line.direction, normal));
    let whole: i128 = volumes.iter().sum();
    if whole == 0 || volumes.iter().any(|volume| volume.signum() == -whole.signum()) {
        return None;
    }
    let distance = dot(a, cross(b, c));
    Some([distance, volumes[1], volumes[2]].map(|numerator| nearest_quotient(numerator, whole)))
}

/// True if the line, moved by (e, e^2, e^3), crosses the triangle. On which side of the edge from p
/// to q it passes is a polynomial in e; its first coefficient that is not zero decides.
fn crosses(line: &GridLine, corners: [Point; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| minus(corner, line.origin));
    let sides = [(b, c), (c, a), (a, b)].map(|(p, q)| {
        let [x, y, z] = cross(minus(p, q), line.direction);
        let coefficients = [dot(line.direction, cross(p, q)), x, y, z];
        coefficients.into_iter().map(i128::signum).find(|&sign| sign != 0).unwrap_or(0)
    });
    sides == [1; 3] || sides == [-1; 3]
}

/// The double nearest to `numerator / denominator`, ties to even, by long division; +0 for zero.
pub fn nearest_quotient(numerator: i128, denominator: i128) -> f64 {
    if numerator == 0 {
        return 0.0;
    }
    let (n, d) = (numerator.unsigned_abs(), denominator.unsigned_abs());
    // At least 55 bits: two more than a double has, the last of which tells whether any is left.
    let shift = (55 + n.leading_zeros() as i32 - d.leading_zeros() as i32).max(0);
    let (quotient, rest) = ((n << shift) / d, (n << shift) % d);
    let rounded = scaled((quotient | u128::from(rest > 0)) as f64, -shift);
    if (numerator < 0) == (denominator < 0) { rounded } else { -rounded }
}

/// True if the point lies within the tetrahedron, `None` if it lies in the plane of one of its
/// sides, or there is nothing within.
pub fn is_inside(point: Point, tetrahedron: [Point; 4]) -> Option<bool> {
    let side = |[a, b, c]: [usize; 3]| {
        let [p, q, r] = [a, b, c].map(|i| minus(tetrahedron[i], point));
        dot(p, cross(q, r)).signum()
    };
    let sides = TETRAHEDRON.map(side);
    (!sides.contains(&0)).then(|| sides == [1; 4] || sides == [-1; 4])
}

/// The corners of a tetrahedron's sides, all outwards or all inwards.
pub const TETRAHEDRON: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
