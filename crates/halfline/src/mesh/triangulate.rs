//! Polygons to triangles.

use crate::geometry::Vec3;

/// Cuts the polygon with the given corners into `corners.len() - 2` triangles and hands each to
/// `emit` as indices into `corners`, in the polygon's orientation.
pub fn triangulate(corners: &[Vec3], mut emit: impl FnMut([usize; 3])) {
    for i in 2..corners.len() {
        emit([0, i - 1, i]);
    }
}
