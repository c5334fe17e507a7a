//! The plural questions, answered from the textbook's tree.

use super::{KdTree, Node, clip_to_box, plane_distance};
use crate::geometry::{Hit, Ray, Vec3};
use crate::numeric::{PreparedRay, Touch, complete_hits};

impl KdTree<'_> {
    /// True if the half-line hits anything.
    pub fn any(&self, ray: &Ray) -> bool {
        self.ray_tree_intersection(ray).is_hit()
    }

    /// Appends all hits to `hits`, sorted by t and then by face; see [`numeric`](crate::numeric).
    ///
    /// The half-line is sent through the whole tree; a triangle that lies in several cells is
    /// found several times, and counted once.
    pub fn all(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        let first = hits.len();
        let mut touches = Vec::new();
        let Some(prepared) = PreparedRay::new(ray) else { return };
        let Some([t_min, t_max]) = clip_to_box(&self.bounding_box, ray) else { return };
        let mut cells = vec![(&self.root, t_min, t_max)];
        while let Some((node, t_min, t_max)) = cells.pop() {
            match node {
                Node::Leaf { triangles } => {
                    for &face in triangles {
                        let corners = self.mesh.corners(face);
                        let Some(contact) = prepared.meet(corners) else { continue };
                        if contact.is_crossing {
                            hits.push(prepared.hit(face, corners));
                        } else {
                            touches.push(Touch { t: contact.t, face, touched: contact.touched });
                        }
                    }
                }
                Node::Inner { splitting_axis, splitting_coordinate, children } => {
                    let (axis, plane) = (*splitting_axis, *splitting_coordinate);
                    let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
                    let [low, high] = if direction == 0.0 {
                        // Parallel: below only, above only, or both.
                        match origin.partial_cmp(&plane) {
                            Some(std::cmp::Ordering::Less) => [f64::INFINITY; 2],
                            Some(std::cmp::Ordering::Greater) => [f64::NEG_INFINITY; 2],
                            _ => [f64::NEG_INFINITY, f64::INFINITY],
                        }
                    } else {
                        plane_distance(plane, origin, direction)
                    };
                    let [below, above] = &**children;
                    let (near, far) =
                        if direction >= 0.0 { (below, above) } else { (above, below) };
                    if high >= t_min {
                        cells.push((near, t_min, t_max.min(high)));
                    }
                    if low <= t_max {
                        cells.push((far, t_min.max(low), t_max));
                    }
                }
            }
        }
        // At borders, go by all triangles of the mesh: it is rare, and this is to be read.
        let corners_of = |face| self.mesh.corners(face);
        let triangles_at = |point: Vec3| {
            let triangles = (0..self.mesh.triangle_count() as u32).map(corners_of);
            triangles.filter(|corners| corners.contains(&point)).collect()
        };
        complete_hits(&prepared, hits, first, &mut touches, corners_of, triangles_at);
    }
}
