//! Where a camera must stand for the whole model to fill its picture.
//!
//! For a given direction of view the answer is exact, not that of a bounding sphere: in the
//! camera's axes (x right, y up, z forward, e the eye) a vertex p lies left of the picture's
//! right edge if `p.x - e.x <= right * (p.z - e.z)`, that is `p.x - right * p.z <= e.x - right * e.z`,
//! and likewise for the other three edges. So four maxima over all vertices, found in one pass,
//! say all there is to know about the model; the closest eye follows in closed form.

use halfline::geometry::{Aabb, Vec3};
use halfline::mesh::Mesh;

/// The camera's axes: unit vectors at right angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axes {
    pub(crate) right: Vec3,
    pub(crate) up: Vec3,
    pub(crate) forward: Vec3,
}

impl Axes {
    /// Looking along `forward` with `up` upright; `None` if they are parallel or not finite.
    pub(crate) fn looking(forward: Vec3, up: Vec3) -> Option<Axes> {
        // Lengths first brought near one, so that neither squares nor products overflow.
        let forward = unit(forward)?;
        let up = unit(up)?;
        let right = forward.cross(up);
        // Below this sine of the angle between them, the rounding of the two unit vectors could
        // turn `right` by more than a thousandth.
        let smallest_sine = 1000.0 * 4.0 * f64::EPSILON;
        if right.length() <= smallest_sine {
            return None;
        }
        let right = right.normalized();
        Some(Axes { right, up: right.cross(forward).normalized(), forward })
    }

    /// `v` along right, up and forward.
    pub(crate) fn coordinates(&self, v: Vec3) -> [f64; 3] {
        [v.dot(self.right), v.dot(self.up), v.dot(self.forward)]
    }
}

/// `v` with length one; `None` if it is zero or not finite.
pub(crate) fn unit(v: Vec3) -> Option<Vec3> {
    let largest = v.abs().max_element();
    (v.is_finite() && largest > 0.0).then(|| (v / largest).normalized())
}

/// How far the four edges of the picture reach, as slopes against the forward axis for a
/// perspective camera. Positive unless an edge lies on the far side of the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slopes {
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) down: f64,
    pub(crate) up: f64,
}

/// Where to stand, relative to the point given as `center`, in the camera's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stand {
    /// Along right, up and forward.
    pub(crate) eye: [f64; 3],
}

/// Maxima over all vertices, in the camera's axes with the origin at a given centre.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    right: f64,
    left: f64,
    up: f64,
    down: f64,
    nearest: f64,
}

/// The closest eye of a perspective camera that sees all of `mesh` between `slopes`, and at
/// least `clearance` in front of it. `None` if the mesh has no finite vertex.
pub(crate) fn perspective_stand(
    mesh: &Mesh,
    center: Vec3,
    axes: &Axes,
    slopes: Slopes,
    clearance: f64,
) -> Option<Stand> {
    let m = extremes(mesh, center, axes, slopes)?;
    // The right and the left condition added no longer hold e.x: they bound e.z.
    let z_by_width = -(m.right + m.left) / (slopes.right + slopes.left);
    let z_by_height = -(m.up + m.down) / (slopes.up + slopes.down);
    let z = z_by_width.min(z_by_height).min(m.nearest - clearance);
    // In the middle of what room is left: exactly where the width or height decided, and as near
    // as one pass can tell in the other direction.
    let x = 0.5 * ((m.right + slopes.right * z) - (m.left + slopes.left * z));
    let y = 0.5 * ((m.up + slopes.up * z) - (m.down + slopes.down * z));
    Some(Stand { eye: [x, y, z] })
}

/// The box around `mesh` in the camera's axes with the origin at `center`: lowest and highest
/// x, y and z. `None` if the mesh has no finite vertex.
pub(crate) fn box_in_axes(mesh: &Mesh, center: Vec3, axes: &Axes) -> Option<Aabb> {
    let flat = Slopes { left: 0.0, right: 0.0, down: 0.0, up: 0.0 };
    let m = extremes(mesh, center, axes, flat)?;
    let reverse = Axes { right: axes.forward, up: axes.up, forward: axes.right };
    let depth = extremes(mesh, center, &reverse, flat)?;
    Some(Aabb {
        min: Vec3::from([-m.left, -m.down, m.nearest]),
        max: Vec3::from([m.right, m.up, depth.right]),
    })
}

fn extremes(mesh: &Mesh, center: Vec3, axes: &Axes, slopes: Slopes) -> Option<Extremes> {
    const NONE: Extremes = Extremes {
        right: f64::NEG_INFINITY,
        left: f64::NEG_INFINITY,
        up: f64::NEG_INFINITY,
        down: f64::NEG_INFINITY,
        nearest: f64::INFINITY,
    };
    let found = mesh.fold_vertices(
        NONE,
        |m, p| {
            let [x, y, z] = axes.coordinates(p - center);
            Extremes {
                right: m.right.max(x - slopes.right * z),
                left: m.left.max(-x - slopes.left * z),
                up: m.up.max(y - slopes.up * z),
                down: m.down.max(-y - slopes.down * z),
                nearest: m.nearest.min(z),
            }
        },
        |a, b| Extremes {
            right: a.right.max(b.right),
            left: a.left.max(b.left),
            up: a.up.max(b.up),
            down: a.down.max(b.down),
            nearest: a.nearest.min(b.nearest),
        },
    );
    found.nearest.is_finite().then_some(found)
}
