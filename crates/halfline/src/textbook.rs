//! The lecture's kd-tree, to be read from top to bottom.
//!
//! Brute force tests every triangle for every ray. A kd-tree cuts space into cells by planes
//! perpendicular to the axes, until few triangles are left in each, and a ray then visits only
//! the cells that it passes through, from near to far: J. L. Bentley, "Multidimensional Binary
//! Search Trees Used for Associative Searching", CACM 18 (1975); V. Havran, "Heuristic Ray
//! Shooting Algorithms", PhD thesis, Prague 2000, chapter 4 and appendix C.
//!
//! Build, with the lecture's names: [`KdTree::init_kd_tree`] puts all triangles into the root,
//! [`subdivide_cell`] splits a cell and moves its triangles into the two halves, again and again,
//! until [`terminate_construction`] says that it is enough. Where a cell is split is a
//! [`SplittingRule`]: its middle, by turns; the median of its triangles; or where the
//! surface-area heuristic finds the least cost. The three stand in `splitting_rule.rs`.
//!
//! Traverse: [`KdTree::ray_tree_intersection`] goes down the tree along the ray. `all_hits.rs`
//! answers the plural questions.
//!
//! Different here from the usual pseudo-code, which is wrong in two places: a hit in the near
//! cell is final only if it lies *before* the splitting plane (a triangle may reach out of its
//! cell), and planes that touch an end of the interval, or hold the ray, have cases of their own.
//! All comparisons with planes allow for rounding, see `PLANE_DISTANCE_ERROR`.

use crate::geometry::{Aabb, Hit, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{PreparedRay, is_nearer};

mod all_hits;
mod splitting_rule;

pub use splitting_rule::{Middle, ObjectMedian, SplittingRule, SurfaceArea};

/// A kd-tree over the triangles of a mesh.
pub struct KdTree<'mesh> {
    mesh: &'mesh Mesh,
    bounding_box: Aabb,
    root: Node,
}

/// A cell of space.
pub enum Node {
    /// Not split any further.
    Leaf {
        /// The triangles that reach into the cell.
        triangles: Vec<u32>,
    },
    /// Split in two.
    Inner {
        /// 0, 1 or 2 for x, y or z.
        splitting_axis: usize,
        /// Where the plane cuts that axis.
        splitting_coordinate: f64,
        /// The cell below and the cell above the plane.
        children: Box<[Node; 2]>,
    },
}

/// What a half-line has to do with a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Cells that it comes to, leaves included.
    pub nodes: u64,
    /// Leaves that it comes to.
    pub leaves: u64,
    /// Triangles that it is tested against; one that lies in several leaves counts each time.
    pub triangles: u64,
}

/// When to stop splitting.
#[derive(Clone, Copy, Debug)]
pub struct Termination {
    /// A cell this many levels below the root is not split.
    pub maximum_depth: usize,
    /// A cell of at most this many triangles is not split.
    pub few_triangles: usize,
}

impl Termination {
    /// Havran's choice for n triangles: depth 8 + 1.3 log2(n), and at most two triangles.
    pub fn automatic(triangles: usize) -> Termination {
        let levels = 8.0 + 1.3 * (triangles.max(1) as f64).log2();
        Termination { maximum_depth: levels as usize, few_triangles: 2 }
    }
}

/// A cell of a tree under construction.
pub struct Cell {
    /// The box of space that it is.
    pub bounds: Aabb,
    /// The triangles that reach into it.
    pub triangles: Vec<u32>,
    /// How many levels it lies below the root.
    pub depth: usize,
    /// The axis whose turn it is: 0, 1 or 2 for x, y or z.
    pub by_turns: usize,
}

/// A cell, split in two.
pub struct Split {
    /// 0, 1 or 2 for x, y or z.
    pub axis: usize,
    /// Where the plane cuts that axis.
    pub coordinate: f64,
    /// The parts below and above the plane.
    pub parts: [Cell; 2],
}

impl<'mesh> KdTree<'mesh> {
    /// Builds the tree: all triangles into the root, the first split on x.
    pub fn init_kd_tree(
        mesh: &'mesh Mesh,
        rule: &dyn SplittingRule,
        termination: &Termination,
    ) -> KdTree<'mesh> {
        KdTree::init_kd_tree_until(mesh, rule, termination, &|_| false)
    }

    /// Builds the tree, and leaves all cells whole once `stop` says so; see
    /// [`terminate_construction`].
    pub fn init_kd_tree_until(
        mesh: &'mesh Mesh,
        rule: &dyn SplittingRule,
        termination: &Termination,
        stop: &dyn Fn(usize) -> bool,
    ) -> KdTree<'mesh> {
        let boxes = boxes_of(mesh);
        let root = root_cell(mesh, &boxes);
        let bounding_box = root.bounds;
        KdTree { mesh, bounding_box, root: subdivide_cell(root, &boxes, rule, termination, stop) }
    }

    /// The root cell.
    pub fn root(&self) -> &Node {
        &self.root
    }

    /// The box of the root cell.
    pub fn bounding_box(&self) -> &Aabb {
        &self.bounding_box
    }
}

/// The boxes of all triangles of a mesh.
pub fn boxes_of(mesh: &Mesh) -> Vec<Aabb> {
    let box_of = |[a, b, c]: [Vec3; 3]| Aabb::EMPTY.including(a).including(b).including(c);
    (0..mesh.triangle_count() as u32).map(|t| box_of(mesh.corners(t))).collect()
}

/// The cell that holds all triangles, but for those with corners that are not finite: nothing can
/// hit them.
pub fn root_cell(mesh: &Mesh, boxes: &[Aabb]) -> Cell {
    let is_finite = |&t: &u32| mesh.corners(t).into_iter().all(Vec3::is_finite);
    let triangles: Vec<u32> = (0..mesh.triangle_count() as u32).filter(is_finite).collect();
    let bounds = triangles.iter().fold(Aabb::EMPTY, |all, &t| all.union(&boxes[t as usize]));
    Cell { bounds, triangles, depth: 0, by_turns: 0 }
}

/// Splits a cell, and its parts, until [`terminate_construction`]. `boxes` are those of all triangles
/// of the mesh.
pub fn subdivide_cell(
    cell: Cell,
    boxes: &[Aabb],
    rule: &dyn SplittingRule,
    termination: &Termination,
    stop: &dyn Fn(usize) -> bool,
) -> Node {
    if terminate_construction(&cell, termination, stop) {
        return Node::Leaf { triangles: cell.triangles };
    }
    let Some(Split { axis, coordinate, parts }) = split_cell(&cell, boxes, rule) else {
        return Node::Leaf { triangles: cell.triangles };
    };
    drop(cell);
    let children = parts.map(|part| subdivide_cell(part, boxes, rule, termination, stop));
    Node::Inner {
        splitting_axis: axis,
        splitting_coordinate: coordinate,
        children: Box::new(children),
    }
}

/// True if a cell should stay whole: it lies deep, it has few triangles, or `stop` wants the end.
///
/// `stop` is told how many triangles the cell has, before each split, and so can end a construction
/// that takes too long: once it answers true it must go on to do so.
pub fn terminate_construction(
    cell: &Cell,
    termination: &Termination,
    stop: &dyn Fn(usize) -> bool,
) -> bool {
    cell.depth >= termination.maximum_depth
        || cell.triangles.len() <= termination.few_triangles
        || stop(cell.triangles.len())
}

/// Splits a cell once, where the rule says; `None` if no plane separates its triangles. The parts'
/// turn is on the axis next to that of the plane.
pub fn split_cell(cell: &Cell, boxes: &[Aabb], rule: &dyn SplittingRule) -> Option<Split> {
    let boxes_here: Vec<Aabb> = cell.triangles.iter().map(|&t| boxes[t as usize]).collect();
    let planes = rule.splitting_planes(&cell.bounds, &boxes_here, cell.by_turns);
    planes.into_iter().find_map(|(axis, plane)| {
        let [below, above] = move_triangles(&cell.triangles, boxes, axis, plane);
        let separates = below.len().min(above.len()) < cell.triangles.len();
        let (depth, by_turns) = (cell.depth + 1, next_axis(axis));
        let [bounds_below, bounds_above] = halves(&cell.bounds, axis, plane);
        separates.then_some(Split {
            axis,
            coordinate: plane,
            parts: [
                Cell { bounds: bounds_below, triangles: below, depth, by_turns },
                Cell { bounds: bounds_above, triangles: above, depth, by_turns },
            ],
        })
    })
}

/// The indices of those boxes that reach below and of those that reach above the plane. A box
/// that touches the plane goes to both sides: the cells are closed.
fn move_triangles(triangles: &[u32], boxes: &[Aabb], axis: usize, plane: f64) -> [Vec<u32>; 2] {
    let of = |reaches: &dyn Fn(&Aabb) -> bool| {
        triangles.iter().copied().filter(|&t| reaches(&boxes[t as usize])).collect()
    };
    [of(&|b| b.min[axis] <= plane), of(&|b| b.max[axis] >= plane)]
}

/// The axis whose turn is next: x, y, z, x, ...
fn next_axis(axis: usize) -> usize {
    (axis + 1) % 3
}

/// The two parts of a cell.
fn halves(cell: &Aabb, axis: usize, plane: f64) -> [Aabb; 2] {
    let mut halves = [*cell; 2];
    halves[0].max[axis] = plane;
    halves[1].min[axis] = plane;
    halves
}

/// A bound on the relative error of `(plane - origin) / direction`, with room to spare: two
/// roundings make it 2^-52, and the comparison's own rounding is as large again.
const PLANE_DISTANCE_ERROR: f64 = 4.0 * f64::EPSILON;

/// t at which a ray passes a plane, at least and at most. `direction` is not zero.
///
/// Hits carry the double nearest to their exact t. So a hit beyond the plane has t no less than
/// the lower bound, and a hit before it no more than the upper.
pub fn plane_distance(plane: f64, origin: f64, direction: f64) -> [f64; 2] {
    let t = (plane - origin) / direction;
    // Where t overflows there is nothing to widen, and infinity times a bound would be NaN.
    let error =
        if t.is_finite() { PLANE_DISTANCE_ERROR * t.abs() + f64::MIN_POSITIVE } else { 0.0 };
    [t - error, t + error]
}

impl KdTree<'_> {
    /// The closest hit of the half-line; of hits with equal t the one with the lowest face index.
    pub fn ray_tree_intersection(&self, ray: &Ray) -> Hit {
        self.ray_tree_intersection_counted(ray, &mut Visits::default())
    }

    /// The closest hit, as [`KdTree::ray_tree_intersection`] finds it; what it took is added to
    /// `visits`.
    pub fn ray_tree_intersection_counted(&self, ray: &Ray, visits: &mut Visits) -> Hit {
        let Some(prepared) = PreparedRay::new(ray) else { return Hit::MISS };
        let Some([t_min, t_max]) = clip_to_box(&self.bounding_box, ray) else { return Hit::MISS };
        self.closest_in_cell(&self.root, ray, &prepared, t_min, t_max, visits)
    }

    /// The closest hit of a half-line that passes `node`'s cell between `t_min` and `t_max`.
    fn closest_in_cell(
        &self,
        node: &Node,
        ray: &Ray,
        prepared: &PreparedRay,
        t_min: f64,
        t_max: f64,
        visits: &mut Visits,
    ) -> Hit {
        visits.nodes += 1;
        let (axis, plane, children) = match node {
            // At a leaf, test all triangles and return the closest hit. It may lie outside of the
            // cell: the caller compares it with the plane.
            Node::Leaf { triangles } => {
                let mut closest = Hit::MISS;
                visits.leaves += 1;
                visits.triangles += triangles.len() as u64;
                for &face in triangles {
                    let corners = self.mesh.corners(face);
                    if prepared.meet(corners).is_some() {
                        let hit = prepared.hit(face, corners);
                        if is_nearer(&hit, &closest) {
                            closest = hit;
                        }
                    }
                }
                return closest;
            }
            Node::Inner { splitting_axis, splitting_coordinate, children } => {
                (*splitting_axis, *splitting_coordinate, children)
            }
        };
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        let [below, above] = &**children;

        // A half-line parallel to the plane stays on its side. Inside the plane it may hit
        // triangles of both.
        if direction == 0.0 {
            if origin < plane {
                return self.closest_in_cell(below, ray, prepared, t_min, t_max, visits);
            }
            if origin > plane {
                return self.closest_in_cell(above, ray, prepared, t_min, t_max, visits);
            }
            let hit_below = self.closest_in_cell(below, ray, prepared, t_min, t_max, visits);
            let hit_above = self.closest_in_cell(above, ray, prepared, t_min, t_max, visits);
            return nearer(hit_below, hit_above);
        }

        // Near is the side from which the half-line comes, wherever its origin lies.
        let (near, far) = if direction > 0.0 { (below, above) } else { (above, below) };
        let [split_low, split_high] = plane_distance(plane, origin, direction);

        // It leaves the cell before the plane, or enters it behind the plane: one child is enough.
        if split_low > t_max {
            return self.closest_in_cell(near, ray, prepared, t_min, t_max, visits);
        }
        if split_high < t_min {
            return self.closest_in_cell(far, ray, prepared, t_min, t_max, visits);
        }

        // It passes through both. A hit before the plane is nearer than all beyond it; a hit at or
        // beyond the plane has to stand the comparison with the far child's.
        let hit_near =
            self.closest_in_cell(near, ray, prepared, t_min, split_high.min(t_max), visits);
        if hit_near.t < split_low {
            return hit_near;
        }
        let hit_far = self.closest_in_cell(far, ray, prepared, split_low.max(t_min), t_max, visits);
        nearer(hit_near, hit_far)
    }
}

/// The part of the ray's range that lies in a box; `None` if it passes by.
pub fn clip_to_box(bounds: &Aabb, ray: &Ray) -> Option<[f64; 2]> {
    let [mut t_min, mut t_max] = [ray.t_min, ray.t_max];
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        if direction == 0.0 {
            if !(low <= origin && origin <= high) {
                return None;
            }
            continue;
        }
        let (first, last) = if direction > 0.0 { (low, high) } else { (high, low) };
        t_min = t_min.max(plane_distance(first, origin, direction)[0]);
        t_max = t_max.min(plane_distance(last, origin, direction)[1]);
    }
    (t_min <= t_max).then_some([t_min, t_max])
}

/// The nearer of two hits; see [`is_nearer`].
fn nearer(a: Hit, b: Hit) -> Hit {
    if is_nearer(&b, &a) { b } else { a }
}
