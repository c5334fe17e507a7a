//! Which triangles have a corner at a given place, or hold it: a walk down the tree with a point.
//!
//! Few rays need it, those that touch a surface without crossing it, and few points, those that are asked for in the
//! plane of a triangle along which crossings are counted.

use crate::geometry::Vec3;
use crate::mesh::Mesh;
use crate::numeric::holds_point;
use crate::tree::{Bounds, NodeRef, Tree, panic_corrupt_tree};

/// All triangles of the mesh with a corner at `point`, which is finite, each once.
#[cold]
pub fn triangles_at(tree: &Tree, mesh: &Mesh, point: Vec3) -> Vec<[Vec3; 3]> {
    // Gather the faces of all leaves that may hold the point, and those that no leaf holds.
    let mut faces: Vec<u32> = tree.collinear.with_corner(point).collect();
    faces.extend(faces_around(tree, point).filter(|&face| mesh.corners(face).contains(&point)));

    // Drop the repeats of faces that lie in several leaves.
    faces.sort_unstable();
    faces.dedup();
    faces.into_iter().map(|face| mesh.corners(face)).collect()
}

/// True if `point`, which is finite, lies on a triangle that can be hit.
#[cold]
pub fn is_on_face(tree: &Tree, mesh: &Mesh, point: Vec3) -> bool {
    faces_around(tree, point).any(|face| holds_point(mesh.corners(face), point))
}

/// The faces of all leaves whose boxes may hold a point.
fn faces_around(tree: &Tree, point: Vec3) -> impl Iterator<Item = u32> {
    // A box that holds the point overlaps this one: both are rounded outwards.
    let place = Bounds {
        min: [0, 1, 2].map(|axis| tree.frame.lower(point[axis], axis)),
        max: [0, 1, 2].map(|axis| tree.frame.upper(point[axis], axis)),
    };
    let mut pending = vec![tree.root];
    let mut steps = 0;
    let next_leaf = std::iter::from_fn(move || {
        while let Some(at) = pending.pop() {
            if at == NodeRef::END {
                continue;
            }
            steps += 1;
            if steps > tree.max_steps() {
                panic_corrupt_tree();
            }
            if at.is_leaf() {
                return Some(at.index());
            }
            let node = &tree.nodes[at.index()];
            let children = node.children().enumerate();
            let may_hold = |lane| !node.bounds(lane).intersection(&place).is_empty();
            pending.extend(children.filter(|&(lane, _)| may_hold(lane)).map(|(_, child)| child));
        }
        None
    });
    next_leaf.flat_map(|leaf| tree.faces(leaf))
}
