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
//! surface-area heuristic finds the least cost.
//!
//! Traverse: [`KdTree::ray_tree_intersection`].
//!
//! Different here from the usual pseudo-code, which is wrong in two places: a hit in the near
//! cell is final only if it lies *before* the splitting plane (a triangle may reach out of its
//! cell), and planes that touch an end of the interval, or hold the ray, have cases of their own.
//! All comparisons with planes allow for rounding, see `PLANE_DISTANCE_ERROR`.

use crate::geometry::{Aabb, Hit, Ray, Vec3};
use crate::mesh::Mesh;
use crate::numeric::{PreparedRay, Touch, complete_hits, is_nearer};

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
    /// Those that are leaves.
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

/// Where to split a cell.
pub trait SplittingRule {
    /// The planes at which `cell`, whose triangles have these `boxes`, may be split, as (axis,
    /// coordinate), the best one first; `by_turns` is the axis whose turn it is.
    fn splitting_planes<'a>(
        &'a self,
        cell: &'a Aabb,
        boxes: &'a [Aabb],
        by_turns: usize,
    ) -> Planes<'a>;
}

/// Planes, as (axis, coordinate); those that nobody asks for are not found.
pub type Planes<'a> = Box<dyn Iterator<Item = (usize, f64)> + 'a>;

/// In the middle of the cell, on each axis by turns.
pub struct Middle;

impl SplittingRule for Middle {
    fn splitting_planes<'a>(
        &'a self,
        cell: &'a Aabb,
        _boxes: &'a [Aabb],
        by_turns: usize,
    ) -> Planes<'a> {
        Box::new(axes_from(by_turns).map(|axis| (axis, cell.center()[axis])))
    }
}

/// So that each side gets half of the triangles, on each axis by turns.
pub struct ObjectMedian;

impl SplittingRule for ObjectMedian {
    fn splitting_planes<'a>(
        &'a self,
        cell: &'a Aabb,
        boxes: &'a [Aabb],
        by_turns: usize,
    ) -> Planes<'a> {
        let median = |axis: usize| {
            // The center of a large triangle may lie outside of the cell.
            let (low, high) = (cell.min[axis], cell.max[axis]);
            let center = |b: &Aabb| b.center()[axis].clamp(low, high);
            let mut centers: Vec<f64> = boxes.iter().map(center).collect();
            let middle = centers.len() / 2;
            *centers.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        Box::new(axes_from(by_turns).map(move |axis| (axis, median(axis))))
    }
}

/// Where the expected cost is least: a ray that meets the cell meets a part of it with a
/// probability proportional to the part's surface area (Goldsmith and Salmon 1987; MacDonald and
/// Booth 1990).
pub struct SurfaceArea {
    /// Cost of a step to a child cell, in units of one triangle test.
    pub traversal_cost: f64,
}

impl SurfaceArea {
    /// The cheapest plane on `axis`, as (cost, coordinate), by a sweep over the boxes' ends.
    fn cheapest_plane(&self, cell: &Aabb, boxes: &[Aabb], axis: usize) -> Option<(f64, f64)> {
        let (low, high) = (cell.min[axis], cell.max[axis]);
        let sorted = |mut ends: Vec<f64>| {
            ends.sort_unstable_by(f64::total_cmp);
            ends
        };
        let starts = sorted(boxes.iter().map(|b| b.min[axis].max(low)).collect());
        let ends = sorted(boxes.iter().map(|b| b.max[axis].min(high)).collect());
        let mut cheapest: Option<(f64, f64)> = None;
        for planes in [&starts, &ends] {
            // How many boxes start at or before the plane, and how many end before it.
            let (mut started, mut ended) = (0, 0);
            for &plane in planes.iter().filter(|&&plane| low < plane && plane < high) {
                started += starts[started..].iter().take_while(|&&start| start <= plane).count();
                ended += ends[ended..].iter().take_while(|&&end| end < plane).count();
                let (below, above) = (started as f64, (ends.len() - ended) as f64);
                let [left, right] = halves(cell, axis, plane);
                let tests = left.surface_area() * below + right.surface_area() * above;
                let cost = self.traversal_cost + tests / cell.surface_area();
                if cheapest.is_none_or(|(least, _)| cost < least) {
                    cheapest = Some((cost, plane));
                }
            }
        }
        cheapest
    }

    /// The cheapest plane on each of the axes, the cheapest of all first; only those that are cheaper
    /// than to leave the cell whole.
    pub fn planes_on(
        &self,
        axes: impl Iterator<Item = usize>,
        cell: &Aabb,
        boxes: &[Aabb],
    ) -> Planes<'static> {
        let cost_of_leaf = boxes.len() as f64;
        let plane_on = |axis| {
            let (cost, plane) = self.cheapest_plane(cell, boxes, axis)?;
            (cost < cost_of_leaf).then_some((cost, axis, plane))
        };
        let mut planes: Vec<_> = axes.filter_map(plane_on).collect();
        planes.sort_by(|a, b| a.0.total_cmp(&b.0));
        Box::new(planes.into_iter().map(|(_, axis, plane)| (axis, plane)))
    }
}

impl SplittingRule for SurfaceArea {
    fn splitting_planes<'a>(
        &'a self,
        cell: &'a Aabb,
        boxes: &'a [Aabb],
        by_turns: usize,
    ) -> Planes<'a> {
        self.planes_on(axes_from(by_turns), cell, boxes)
    }
}

/// All three axes, in turn.
fn axes_from(axis: usize) -> impl Iterator<Item = usize> {
    [axis, next_axis(axis), next_axis(next_axis(axis))].into_iter()
}

/// x, y, z, x, ...
pub fn next_axis(axis: usize) -> usize {
    (axis + 1) % 3
}

/// True if a cell at this depth with this many triangles should stay whole.
pub fn terminate_construction(termination: &Termination, depth: usize, triangles: usize) -> bool {
    depth >= termination.maximum_depth || triangles <= termination.few_triangles
}

/// The two parts of a cell.
fn halves(cell: &Aabb, axis: usize, plane: f64) -> [Aabb; 2] {
    let mut halves = [*cell; 2];
    halves[0].max[axis] = plane;
    halves[1].min[axis] = plane;
    halves
}

/// The indices of those boxes that reach below and of those that reach above the plane. A box
/// that touches the plane goes to both sides: the cells are closed.
fn move_triangles(triangles: &[u32], boxes: &[Aabb], axis: usize, plane: f64) -> [Vec<u32>; 2] {
    let of = |reaches: &dyn Fn(&Aabb) -> bool| {
        triangles.iter().copied().filter(|&t| reaches(&boxes[t as usize])).collect()
    };
    [of(&|b| b.min[axis] <= plane), of(&|b| b.max[axis] >= plane)]
}

/// A cell, split in two.
pub struct Split {
    /// 0, 1 or 2 for x, y or z.
    pub axis: usize,
    /// Where the plane cuts that axis.
    pub coordinate: f64,
    /// The parts below and above the plane.
    pub cells: [Aabb; 2],
    /// The triangles of each part.
    pub triangles: [Vec<u32>; 2],
}

/// Splits a cell once, where the rule says; `None` if no plane separates its triangles. `boxes` are
/// those of all triangles of the mesh.
pub fn split_cell(
    rule: &dyn SplittingRule,
    boxes: &[Aabb],
    cell: &Aabb,
    triangles: &[u32],
    by_turns: usize,
) -> Option<Split> {
    let boxes_here: Vec<Aabb> = triangles.iter().map(|&t| boxes[t as usize]).collect();
    rule.splitting_planes(cell, &boxes_here, by_turns).find_map(|(axis, plane)| {
        let moved = move_triangles(triangles, boxes, axis, plane);
        let separates = moved.iter().any(|part| part.len() < triangles.len());
        let cells = halves(cell, axis, plane);
        separates.then_some(Split { axis, coordinate: plane, cells, triangles: moved })
    })
}

/// Splits a cell until [`terminate_construction`], each part on the axis next to that of the plane.
pub fn subdivide_cell(
    rule: &dyn SplittingRule,
    termination: &Termination,
    boxes: &[Aabb],
    cell: &Aabb,
    triangles: Vec<u32>,
    depth: usize,
    by_turns: usize,
) -> Node {
    if terminate_construction(termination, depth, triangles.len()) {
        return Node::Leaf { triangles };
    }
    let Some(split) = split_cell(rule, boxes, cell, &triangles, by_turns) else {
        return Node::Leaf { triangles };
    };
    drop(triangles);
    let ([cell_below, cell_above], [below, above]) = (split.cells, split.triangles);
    let subdivide = |cell, triangles| {
        let (deeper, next) = (depth + 1, next_axis(split.axis));
        subdivide_cell(rule, termination, boxes, cell, triangles, deeper, next)
    };
    Node::Inner {
        splitting_axis: split.axis,
        splitting_coordinate: split.coordinate,
        children: Box::new([subdivide(&cell_below, below), subdivide(&cell_above, above)]),
    }
}

/// The boxes of all triangles.
pub fn boxes_of(mesh: &Mesh) -> Vec<Aabb> {
    let box_of = |[a, b, c]: [Vec3; 3]| Aabb::EMPTY.including(a).including(b).including(c);
    (0..mesh.triangle_count() as u32).map(|t| box_of(mesh.corners(t))).collect()
}

/// The triangles with finite corners.
pub fn finite_triangles(mesh: &Mesh) -> Vec<u32> {
    let is_finite = |&t: &u32| mesh.corners(t).into_iter().all(Vec3::is_finite);
    (0..mesh.triangle_count() as u32).filter(is_finite).collect()
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

impl<'mesh> KdTree<'mesh> {
    /// Builds the tree: all triangles into the root, the first split on x.
    ///
    /// Triangles with corners that are not finite are left out: nothing can hit them.
    pub fn init_kd_tree(
        mesh: &'mesh Mesh,
        rule: &dyn SplittingRule,
        termination: &Termination,
    ) -> KdTree<'mesh> {
        let (boxes, triangles) = (boxes_of(mesh), finite_triangles(mesh));
        let bounding_box =
            triangles.iter().fold(Aabb::EMPTY, |all, &t| all.union(&boxes[t as usize]));
        let root = subdivide_cell(rule, termination, &boxes, &bounding_box, triangles, 0, 0);
        KdTree { mesh, bounding_box, root }
    }

    /// The root cell.
    pub fn root(&self) -> &Node {
        &self.root
    }

    /// The box of the root cell.
    pub fn bounding_box(&self) -> &Aabb {
        &self.bounding_box
    }

    /// The closest hit of the half-line; of hits with equal t the one with the lowest face index.
    pub fn ray_tree_intersection(&self, ray: &Ray) -> Hit {
        self.ray_tree_intersection_counted(ray, &mut Visits::default())
    }

    /// The same, adding what it took to `visits`.
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
            // cell; whoever asked knows what to make of it.
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

/// The plural questions, answered from the same tree.
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
