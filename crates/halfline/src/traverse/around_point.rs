//! Which triangles have a corner at a given place: a walk down the tree with a point.
//!
//! Few rays need it, those that touch a surface without crossing it.

use crate::geometry::Vec3;
use crate::mesh::Mesh;
use crate::tree::{Bounds, KdTree, Node, NodeKind, give_up};

/// All triangles of the mesh with a corner at `point`, which is finite, each once.
#[cold]
pub fn triangles_at(tree: &KdTree, mesh: &Mesh, point: Vec3) -> Vec<[Vec3; 3]> {
    // A box that holds the point overlaps this one: both are rounded outwards.
    let place = Bounds {
        min: [0, 1, 2].map(|axis| tree.frame.lower(point[axis], axis)),
        max: [0, 1, 2].map(|axis| tree.frame.upper(point[axis], axis)),
    };
    let may_hold = |node: &Node| !node.bounds.intersection(&place).is_empty();

    // Gather the faces of all leaves that may hold the point, and those that no leaf holds.
    let mut faces: Vec<u32> = tree.on_line.with_corner(point).collect();
    let mut pending = vec![tree.root];
    let mut steps = 0;
    while let Some(node) = pending.pop() {
        steps += 1;
        if steps > tree.most_steps() {
            give_up();
        }
        match node.kind() {
            NodeKind::Inner { children, .. } => {
                let pair = tree.children[children as usize].0;
                pending.extend(pair.into_iter().filter(may_hold));
            }
            NodeKind::Leaf { first, count } => {
                let faces_here = tree.faces(first, count).iter().copied();
                faces.extend(faces_here.filter(|&face| mesh.corners(face).contains(&point)));
            }
        }
    }

    // Drop the repeats of faces that lie in several leaves.
    faces.sort_unstable();
    faces.dedup();
    faces.into_iter().map(|face| mesh.corners(face)).collect()
}
