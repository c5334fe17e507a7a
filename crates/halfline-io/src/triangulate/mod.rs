//! Polygons to triangles.
//!
//! Every corner of a polygon stays a corner of a triangle, also one that lies on the straight line
//! between its neighbours: a corner that is dropped opens a T-junction towards the polygon next to
//! it, and rays leak through. That is why no crate does this work here: the known ports of earcut
//! drop such corners, and their search for diagonals takes cubic time on a polygon that crosses
//! itself, with no way to stop it.

mod ear_clipping;
mod reflex_grid;

use halfline::geometry::{Vec3, vec3};

use self::ear_clipping::EarClipping;

/// Cuts polygons into triangles and keeps its working memory between them.
///
/// A polygon of n corners becomes n - 2 triangles in the polygon's orientation, or fewer where
/// corners repeat: of a polygon with more than three corners, a triangle with two corners at the
/// same place is left out. Concave and slightly non-planar polygons are cut along inner diagonals.
/// A polygon that crosses itself, has no area or is not finite still becomes triangles over its
/// corners, as a fan where nothing better is found.
#[derive(Debug, Default)]
pub struct Triangulator {
    local: Vec<Vec3>,
    clipping: EarClipping,
}

impl Triangulator {
    /// A triangulator without working memory yet.
    pub fn new() -> Triangulator {
        Triangulator::default()
    }

    /// Hands the triangles of the polygon with the given corners to `emit`, as indices into
    /// `corners`.
    pub fn triangulate(&mut self, corners: &[Vec3], mut emit: impl FnMut([usize; 3])) {
        match corners {
            [] | [_] | [_, _] => return,
            [_, _, _] => return emit([0, 1, 2]),
            _ => {}
        }
        let mut emit_unless_repeated = |t: [usize; 3]| {
            let [a, b, c] = t.map(|i| corners[i]);
            if a != b && b != c && c != a {
                emit(t);
            }
        };
        let scale = scale_to_unit(corners);
        if let &[a, b, c, d] = corners {
            let quad = [Vec3::ZERO, (b - a) * scale, (c - a) * scale, (d - a) * scale];
            return quad_diagonal(quad).into_iter().for_each(emit_unless_repeated);
        }
        self.local.clear();
        self.local.extend(corners.iter().map(|&corner| (corner - corners[0]) * scale));
        match self.clipping.project(newell_normal(&self.local), corners, scale) {
            true => self.clipping.clip(emit_unless_repeated),
            false => (2..corners.len()).for_each(|i| emit_unless_repeated([0, i - 1, i])),
        }
    }
}

/// Cuts the polygon with the given corners into at most `corners.len() - 2` triangles and hands
/// each to `emit` as indices into `corners`, in the polygon's orientation; see [`Triangulator`],
/// which serves many polygons with one working memory.
pub fn triangulate(corners: &[Vec3], emit: impl FnMut([usize; 3])) {
    Triangulator::new().triangulate(corners, emit);
}

/// The power of two that brings the polygon, seen from its first corner, to a size near one, so
/// that products of four lengths neither overflow nor vanish. 1 if the polygon has no such size.
fn scale_to_unit(corners: &[Vec3]) -> f64 {
    let size =
        corners.iter().fold(0.0_f64, |size, &c| size.max((c - corners[0]).abs().max_element()));
    // Lengths between 2^-200 and 2^200 leave their fourth powers normal numbers: no scaling.
    let fourth_power_is_normal = 2.0_f64.powi(-200)..=2.0_f64.powi(200);
    if size == 0.0 || !size.is_finite() || fourth_power_is_normal.contains(&size) {
        return 1.0;
    }
    // The inverse of a huge power of two is subnormal, so the exponent stops short of the range.
    let exponent = (size.log2().floor() as i32).clamp(-1000, 1000);
    2.0_f64.powi(-exponent)
}

/// Cuts a quadrilateral along the diagonal inside it, or, if both are, along the shorter one;
/// corners 0 and 2 win a tie.
fn quad_diagonal([a, b, c, d]: [Vec3; 4]) -> [[usize; 3]; 2] {
    const ALONG_02: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
    const ALONG_13: [[usize; 3]; 2] = [[0, 1, 3], [1, 2, 3]];
    let normal = (c - a).cross(d - b);
    let faces_normal = |p: Vec3, q: Vec3, r: Vec3| (q - p).cross(r - p).dot(normal) > 0.0;
    let inside_02 = faces_normal(a, b, c) && faces_normal(a, c, d);
    let inside_13 = faces_normal(a, b, d) && faces_normal(b, c, d);
    match (inside_02, inside_13) {
        (true, false) => ALONG_02,
        (false, true) => ALONG_13,
        _ => {
            let (length_02, length_13) = (c - a, d - b);
            if length_13.dot(length_13) < length_02.dot(length_02) { ALONG_13 } else { ALONG_02 }
        }
    }
}

/// The sum of the vector products of successive corners (Newell): twice the polygon's area, along
/// its normal.
fn newell_normal(corners: &[Vec3]) -> Vec3 {
    let mut normal = Vec3::ZERO;
    let mut previous = corners[corners.len() - 1];
    for &corner in corners {
        normal += vec3(
            (previous.y - corner.y) * (previous.z + corner.z),
            (previous.z - corner.z) * (previous.x + corner.x),
            (previous.x - corner.x) * (previous.y + corner.y),
        );
        previous = corner;
    }
    normal
}
