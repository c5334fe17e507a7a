//! The scene graph: which meshes stand where.

use std::path::Path;

use super::document::{Document, Node};
use halfline::error::{Error, Result};
use halfline::geometry::{Transform, vec3};

/// A mesh at its place.
pub(super) struct Instance {
    pub mesh: u32,
    pub transform: Transform,
}

/// The meshes of the default scene, in the order of its nodes, parents before children. Without
/// a default scene those of the first; without any scene those under all root nodes; without any
/// node each mesh once.
pub(super) fn instances(path: &Path, document: &Document) -> Result<Vec<Instance>> {
    let error = |place: String, reason: String| Err(Error::format(path, place, reason));
    let nodes = &document.nodes;
    let scene_index = document.scene.unwrap_or(0);
    let roots = match document.scenes.get(scene_index as usize) {
        Some(scene) => scene.nodes.clone(),
        None if document.scene.is_some() => {
            let reason = format!("the file has {} scenes", document.scenes.len());
            return error(format!("scene {scene_index}"), reason);
        }
        None => roots(document),
    };
    if nodes.is_empty() && roots.is_empty() {
        let all = 0..document.meshes.len() as u32;
        return Ok(all.map(|mesh| Instance { mesh, transform: Transform::IDENTITY }).collect());
    }

    let mut instances = Vec::new();
    let mut visited = vec![false; nodes.len()];
    let mut pending: Vec<(u32, Transform)> =
        roots.iter().rev().map(|&root| (root, Transform::IDENTITY)).collect();
    if pending.is_empty() && document.scenes.is_empty() {
        return error("nodes".to_owned(), "every node is a child: they form a cycle".to_owned());
    }
    while let Some((index, parent)) = pending.pop() {
        let Some(node) = nodes.get(index as usize) else {
            return error(format!("node {index}"), format!("the file has {} nodes", nodes.len()));
        };
        // A tree: so each node is visited once, and the walk ends.
        if std::mem::replace(&mut visited[index as usize], true) {
            let reason = "is reached twice: it has two parents or is its own ancestor";
            return error(format!("node {index}"), reason.to_owned());
        }
        let transform = match local_transform(node) {
            Some(local) if parent == Transform::IDENTITY => local,
            Some(local) => parent.compose(&local),
            None => parent,
        };
        if let Some(mesh) = node.mesh {
            if mesh as usize >= document.meshes.len() {
                let reason = format!("mesh {mesh}, but the file has {}", document.meshes.len());
                return error(format!("node {index}"), reason);
            }
            instances.push(Instance { mesh, transform });
        }
        // Checked here, so that the list cannot outgrow the nodes by naming one many times.
        if pending.len() + node.children.len() > nodes.len() {
            let reason = "its children are reached twice";
            return error(format!("node {index}"), reason.to_owned());
        }
        pending.extend(node.children.iter().rev().map(|&child| (child, transform)));
    }
    Ok(instances)
}

fn roots(document: &Document) -> Vec<u32> {
    let mut is_child = vec![false; document.nodes.len()];
    for &child in document.nodes.iter().flat_map(|node| &node.children) {
        if let Some(is_child) = is_child.get_mut(child as usize) {
            *is_child = true;
        }
    }
    (0..document.nodes.len() as u32).filter(|&node| !is_child[node as usize]).collect()
}

/// The node's own transform; `None` if it says nothing.
fn local_transform(node: &Node) -> Option<Transform> {
    if let Some(m) = &node.matrix {
        // In columns; the last row is 0 0 0 1 by the specification.
        let column = |c: usize| vec3(m[4 * c], m[4 * c + 1], m[4 * c + 2]);
        return Some(Transform {
            columns: [column(0), column(1), column(2)],
            translation: column(3),
        });
    }
    if node.translation.is_none() && node.rotation.is_none() && node.scale.is_none() {
        return None;
    }
    let mut transform = Transform::IDENTITY;
    if let Some(rotation) = &node.rotation {
        transform.columns = rotation_columns(**rotation);
    }
    if let Some(scale) = &node.scale {
        for axis in 0..3 {
            transform.columns[axis] = transform.columns[axis] * scale[axis];
        }
    }
    if let Some(translation) = &node.translation {
        transform.translation = (**translation).into();
    }
    Some(transform)
}

/// The rotation matrix of a quaternion x, y, z, w. Files round it to single precision, so it is
/// brought to unit length again; one without length turns nothing.
fn rotation_columns([x, y, z, w]: [f64; 4]) -> [halfline::geometry::Vec3; 3] {
    let squared = x * x + y * y + z * z + w * w;
    if squared == 0.0 || !squared.is_finite() {
        return Transform::IDENTITY.columns;
    }
    let s = 2.0 / squared;
    [
        vec3(1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)),
        vec3(s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)),
        vec3(s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)),
    ]
}
