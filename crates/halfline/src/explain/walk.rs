//! The textbook's walk, step by step: [`KdTree::ray_tree_intersection`] once more, with the same
//! comparisons in the same order, so that it comes to the same cells and counts.
//!
//! [`KdTree::ray_tree_intersection`]: crate::textbook::KdTree::ray_tree_intersection

use super::cells::{Cells, Content};
use super::verdict::TriangleTest;
use crate::error::Result;
use crate::geometry::{Hit, Ray};
use crate::numeric::{PreparedRay, is_nearer};
use crate::textbook::{Visits, clip_to_box, plane_distance};

/// Which of a cell's parts a half-line passes through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Case {
    /// It leaves the cell before it comes to the plane.
    NearOnly,
    /// It enters the cell behind the plane.
    FarOnly,
    /// It passes, or touches, the plane within the cell.
    Both,
    /// It is parallel to the plane, and below.
    ParallelBelow,
    /// It is parallel to the plane, and above.
    ParallelAbove,
    /// It lies in the plane.
    InPlane,
}

impl Case {
    /// Every case.
    pub const ALL: [Case; 6] = [
        Case::NearOnly,
        Case::FarOnly,
        Case::Both,
        Case::ParallelBelow,
        Case::ParallelAbove,
        Case::InPlane,
    ];

    /// A name of a few words.
    pub const fn name(self) -> &'static str {
        match self {
            Case::NearOnly => "near only",
            Case::FarOnly => "far only",
            Case::Both => "both",
            Case::ParallelBelow => "parallel, below",
            Case::ParallelAbove => "parallel, above",
            Case::InPlane => "in plane",
        }
    }
}

/// A cell to go to, and the part of the half-line that is asked about there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// The cell's number.
    pub cell: usize,
    /// Where that part begins.
    pub t_near: f64,
    /// Where it ends.
    pub t_far: f64,
}

/// A step of the walk.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// The half-line is cut to the root's box.
    Clip {
        /// The part within the box; `None` if it passes by.
        within: Option<[f64; 2]>,
    },
    /// A cell that is split in two.
    Inner {
        /// The cell.
        at: Visit,
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// Where the plane cuts that axis.
        plane: f64,
        /// Where the half-line passes the plane, as computed; `None` if it is parallel.
        t_split: Option<f64>,
        /// Two numbers between which the exact t of the plane lies.
        t_split_bounds: Option<[f64; 2]>,
        /// Which parts of the cell the half-line passes through.
        case: Case,
        /// True if the plane touches an end of the interval, as far as rounding can tell.
        plane_touched: bool,
        /// The child on the side from which the half-line comes; where it is parallel, the one below.
        near: usize,
        /// The child on the far side of the plane.
        far: usize,
        /// Where the half-line goes next.
        enter: Visit,
        /// What is pushed on the stack meanwhile.
        push: Option<Visit>,
    },
    /// A cell whose triangles are all tested.
    Leaf {
        /// The cell.
        at: Visit,
        /// The tests, in the order of the faces.
        tests: Vec<TriangleTest>,
        /// The closest hit in this leaf; it may lie outside of the cell.
        closest: Option<Hit>,
    },
    /// What was pushed last is popped from the stack.
    Pop {
        /// What is popped.
        at: Visit,
        /// The closest hit in the near part.
        closest: Option<Hit>,
        /// False if it is dropped, since that hit lies before the plane.
        is_entered: bool,
    },
    /// The walk is over.
    End {
        /// The closest hit.
        hit: Option<Hit>,
    },
}

/// The walk of a half-line through the textbook's tree.
#[derive(Clone, Debug)]
pub struct Walk {
    /// What happened, in order: the first step cuts the half-line to the box, the last ends the walk.
    pub steps: Vec<Step>,
    /// The closest hit.
    pub hit: Hit,
    /// What it took.
    pub visits: Visits,
}

impl Walk {
    /// Sends a valid ray through the cells.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn through(cells: &mut Cells, ray: &Ray, prepared: &PreparedRay) -> Result<Walk> {
        let root = cells.get(0).bounds;
        let within = clip_to_box(&root, ray);
        let walk =
            Walk { steps: vec![Step::Clip { within }], hit: Hit::MISS, visits: Visits::default() };
        let mut walker = Walker { cells, ray, prepared, walk };
        if let Some([t_near, t_far]) = within {
            walker.walk.hit = walker.visit(Visit { cell: 0, t_near, t_far })?;
        }
        let mut walk = walker.walk;
        walk.steps.push(Step::End { hit: some(walk.hit) });
        Ok(walk)
    }
}

struct Walker<'a, 'mesh> {
    cells: &'a mut Cells<'mesh>,
    ray: &'a Ray,
    prepared: &'a PreparedRay,
    walk: Walk,
}

impl Walker<'_, '_> {
    /// The closest hit in a cell.
    fn visit(&mut self, at: Visit) -> Result<Hit> {
        self.walk.visits.nodes += 1;
        let mesh = self.cells.mesh;
        let (axis, plane, [below, above]) = match &self.cells.visit(at.cell)?.content {
            Content::Inner { axis, plane, children } => (*axis, *plane, *children),
            Content::Leaf { triangles } | Content::Unknown { triangles } => {
                let test = |&face: &u32| TriangleTest::new(mesh, self.ray, self.prepared, face);
                let tests: Vec<TriangleTest> = triangles.iter().map(test).collect();
                return Ok(self.leave(at, tests));
            }
        };
        let (origin, direction) = (self.ray.origin[axis], self.ray.direction[axis]);
        let Visit { t_near, t_far, .. } = at;
        let to = |cell: usize, t_near: f64, t_far: f64| Visit { cell, t_near, t_far };
        let (near, far) = if direction >= 0.0 { (below, above) } else { (above, below) };

        // The cases of the textbook.
        let (case, enter, push);
        let mut bounds = None;
        let mut drop_before = f64::NEG_INFINITY;
        if direction == 0.0 {
            (case, enter, push) = if origin < plane {
                (Case::ParallelBelow, to(below, t_near, t_far), None)
            } else if origin > plane {
                (Case::ParallelAbove, to(above, t_near, t_far), None)
            } else {
                (Case::InPlane, to(below, t_near, t_far), Some(to(above, t_near, t_far)))
            };
        } else {
            let [low, high] = plane_distance(plane, origin, direction);
            bounds = Some([low, high]);
            (case, enter, push) = if low > t_far {
                (Case::NearOnly, to(near, t_near, t_far), None)
            } else if high < t_near {
                (Case::FarOnly, to(far, t_near, t_far), None)
            } else {
                drop_before = low;
                let waiting = to(far, low.max(t_near), t_far);
                (Case::Both, to(near, t_near, high.min(t_far)), Some(waiting))
            };
        }

        let touches = |t: f64| bounds.is_some_and(|[low, high]| low <= t && t <= high);
        self.walk.steps.push(Step::Inner {
            at,
            axis,
            plane,
            t_split: bounds.map(|_| (plane - origin) / direction),
            t_split_bounds: bounds,
            case,
            plane_touched: touches(t_near) || touches(t_far),
            near,
            far,
            enter,
            push,
        });
        let hit = self.visit(enter)?;
        let Some(waiting) = push else { return Ok(hit) };
        let is_entered = hit.t >= drop_before;
        self.walk.steps.push(Step::Pop { at: waiting, closest: some(hit), is_entered });
        if !is_entered {
            return Ok(hit);
        }
        let other = self.visit(waiting)?;
        Ok(if is_nearer(&other, &hit) { other } else { hit })
    }

    /// Ends a visit to a leaf with its closest hit.
    fn leave(&mut self, at: Visit, tests: Vec<TriangleTest>) -> Hit {
        self.walk.visits.leaves += 1;
        self.walk.visits.triangles += tests.len() as u64;
        let mut closest = Hit::MISS;
        for hit in tests.iter().filter_map(TriangleTest::hit) {
            if is_nearer(hit, &closest) {
                closest = *hit;
            }
        }
        self.walk.steps.push(Step::Leaf { at, tests, closest: some(closest) });
        closest
    }
}

fn some(hit: Hit) -> Option<Hit> {
    hit.is_hit().then_some(hit)
}
