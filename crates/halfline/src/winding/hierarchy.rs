//! The solid angle that a boundary adds to the crossings of a ray, summed over a hierarchy of its edges.
//!
//! Martens, Trettner, Bessmeltsev (2026) sum over all boundary edges, or approximate. Here most of the
//! boundary is summed from afar, with a bound: a chain of edges from a to b amounts to the spherical triangle
//! of its chord,
//!
//! ```text
//! sum of angle(-d, ai, ai+1) = angle(-d, a, b) + solid angle of a disc that the chain and the chord bound,
//! ```
//!
//! as long as d does not point into a ball around the chain, for then both sides wind alike around d; and the
//! disc, any disc within the ball, is small, and far from the point a few moments are enough (`multipole.rs`).
//! Closed walks have no chord, and go together in groups. Each node knows from which distance on its moments
//! are good enough.
//!
//! Edges are looked at in the same order by all instruction sets and threads, one point at a time, so no bit
//! depends on them.

use super::multipole::{
    COEFFICIENTS, LARGEST_RATIO, MOST_TRIANGLES, Moments, far_solid_angle, largest_ratio,
};
use crate::geometry::Vec3;
use crate::numeric::{
    AngleProduct, FRAME, FRAME_LENGTH, LARGEST_TERM_ERROR, SeenVertex, TERM_ERROR, edge_sum,
    exact_solid_angle, exponent_of,
};

/// How closely the boundary is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Enough for most points to tell whether they are inside.
    Coarse,
    /// What is promised.
    Fine,
    /// Every edge by itself.
    Exhaustive,
}

/// What all moments together may be wrong in a winding number, by precision.
const BUDGETS: [f64; 2] = [1.0 / 128.0, 5e-10];

/// What all edges by themselves may be wrong in a winding number; else each is computed within [`TERM_ERROR`].
const EDGE_BUDGET: f64 = 4e-10;

/// A whole sphere.
const SPHERE: f64 = 4.0 * std::f64::consts::PI;

/// Edges of a chain that is not divided any more.
const LEAF_EDGES: usize = 12;

/// Room for the roundings of distances, which are compared with no more precision than this.
const ROUNDED_UP: f64 = 1.0 + 1.0 / (1_u64 << 20) as f64;

/// Scaled distances from which nothing is seen from afar: powers of them may overflow.
const FARTHEST: f64 = f64::from_bits((1023 + 100) << 52);

/// Radii, with a scene of about one, whose powers do not underflow.
const LEAST_RADIUS: f64 = f64::from_bits((1023 - 60) << 52);

/// Nodes that wait while a walk goes down: each division halves a chain or a group.
const STACK: usize = 96;

/// A part of the boundary.
#[derive(Clone, Debug)]
struct Node {
    center: Vec3,
    /// Scaled, and rounded up.
    radius: f64,
    /// In the frame's length, squared.
    cone: f64,
    /// From which squared distance on the moments are good enough, by precision; scaled.
    far: [f64; 2],
    /// The vertices, or of a group the first of the first walk and the last of the last.
    first: u32,
    last: u32,
    /// The second half; the first follows its node. Zero for a chain that is not divided.
    second: u32,
    has_chord: bool,
    coefficients: [f64; COEFFICIENTS],
}

/// Net edges, and the nodes over them.
#[derive(Debug)]
pub struct Hierarchy {
    /// Walk after walk, the last vertex of each being its first again.
    vertices: Vec<Vec3>,
    /// Where walks begin, and after the last where it ends.
    splits: Vec<u32>,
    nodes: Vec<Node>,
    /// Brings the boundary to a size of about one: a power of two.
    scale: f64,
}

/// What was found about the boundary seen from a point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Share {
    /// Its share of the winding number.
    pub share: f64,
    /// The exact one differs by at most this.
    pub error: f64,
}

impl Hierarchy {
    /// Over closed walks.
    pub fn new(walks: &[Vec<Vec3>]) -> Hierarchy {
        let all = || walks.iter().flatten();
        let low = all().fold(Vec3::splat(f64::INFINITY), |low, v| low.min(*v));
        let high = all().fold(Vec3::splat(f64::NEG_INFINITY), |high, v| high.max(*v));
        let size = (high * 0.5 - low * 0.5).max_element();
        let exponent = if size > 0.0 { -exponent_of(size.min(f64::MAX)) } else { 0 };
        let scale = f64::from_bits(((1023 + exponent.clamp(-1000, 1000)) as u64) << 52);

        // Bring walks that are near to each other together.
        let mut order: Vec<(usize, Vec3)> =
            walks.iter().map(|walk| center_of(walk)).enumerate().collect();
        sort_by_place(&mut order);
        let mut vertices = Vec::with_capacity(walks.iter().map(Vec::len).sum());
        let mut splits = vec![0];
        for (walk, _) in &order {
            vertices.extend_from_slice(&walks[*walk]);
            splits.push(vertices.len() as u32);
        }
        let mut hierarchy = Hierarchy { vertices, splits, nodes: Vec::new(), scale };
        if !order.is_empty() {
            hierarchy.add_group(0, order.len());
        }
        hierarchy.nodes.shrink_to_fit();
        hierarchy
    }

    pub fn edge_count(&self) -> usize {
        self.vertices.len() - (self.splits.len() - 1)
    }

    pub fn edges(&self) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        self.splits.windows(2).flat_map(|ends| {
            let walk = &self.vertices[ends[0] as usize..ends[1] as usize];
            walk.windows(2).map(|edge| [edge[0], edge[1]])
        })
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.vertices[..])
            + size_of_val(&self.splits[..])
            + size_of_val(&self.nodes[..])
    }

    /// Adds a node for some walks, and those below it.
    fn add_group(&mut self, first: usize, end: usize) {
        if end - first == 1 {
            let walk = self.splits[first] as usize..self.splits[end] as usize;
            self.add_chain(walk.start, walk.end - 1);
            return;
        }
        let at = self.nodes.len();
        let ends: Vec<[usize; 2]> = self.splits[first..=end]
            .windows(2)
            .map(|ends| [ends[0] as usize, ends[1] as usize - 1])
            .collect();
        let node = self.node(&ends, false);
        self.nodes.push(node);
        let middle = first + (end - first) / 2;
        self.add_group(first, middle);
        self.nodes[at].second = self.nodes.len() as u32;
        self.add_group(middle, end);
    }

    /// Adds a node for a chain, and those below it.
    fn add_chain(&mut self, first: usize, last: usize) {
        let at = self.nodes.len();
        let has_chord = self.vertices[first] != self.vertices[last];
        let node = self.node(&[[first, last]], has_chord);
        self.nodes.push(node);
        if last - first > LEAF_EDGES {
            let middle = first + (last - first) / 2;
            self.add_chain(first, middle);
            self.nodes[at].second = self.nodes.len() as u32;
            self.add_chain(middle, last);
        }
    }

    /// A node for chains.
    fn node(&self, chains: &[[usize; 2]], has_chord: bool) -> Node {
        let (first, last) = (chains[0][0], chains[chains.len() - 1][1]);
        let center = center_of(&self.vertices[first..=last]);
        let from_center = |i: usize| (self.vertices[i] - center) * self.scale;
        let radius = (first..=last).map(|i| from_center(i).length()).fold(0.0, f64::max);
        let radius = radius * ROUNDED_UP;
        let mut node = Node {
            center,
            radius,
            cone: (radius * FRAME_LENGTH).powi(2) * ROUNDED_UP,
            far: [f64::INFINITY; 2],
            first: first as u32,
            last: last as u32,
            second: 0,
            has_chord,
            coefficients: [0.0; COEFFICIENTS],
        };
        let edges: usize = chains.iter().map(|[first, last]| last - first).sum();
        // NaN, of a boundary that overflows, is never far.
        if edges > MOST_TRIANGLES || !(LEAST_RADIUS..FARTHEST).contains(&radius) {
            return node;
        }
        let mut moments = Moments::none();
        let in_ball = |i: usize| from_center(i) * (1.0 / radius);
        for &[first, last] in chains {
            let apex = in_ball(first);
            for i in first + 1..last {
                moments.add([apex, in_ball(i), in_ball(i + 1)]);
            }
        }
        node.coefficients = moments.harmonic();
        let share = edges as f64 / self.edge_count() as f64;
        for (far, budget) in node.far.iter_mut().zip(BUDGETS) {
            let ratio = largest_ratio(moments.area, budget * SPHERE * share);
            *far = (radius / ratio.min(LARGEST_RATIO)).powi(2) * ROUNDED_UP;
        }
        node
    }

    /// The boundary's share of the winding number of a point, which is finite.
    pub fn share(&self, point: Vec3, precision: Precision) -> Share {
        if self.nodes.is_empty() {
            return Share::default();
        }
        let precision = match precision {
            Precision::Coarse => 0,
            Precision::Fine => 1,
            Precision::Exhaustive => return self.share_exhaustively(point),
        };
        let share = self.share_within(point, precision, LARGEST_TERM_ERROR);
        if share.error <= BUDGETS[precision] + EDGE_BUDGET {
            return share;
        }
        self.share_within(point, precision, TERM_ERROR)
    }

    /// The share where edges are computed in doubles that are off by no more than `limit`.
    fn share_within(&self, point: Vec3, precision: usize, limit: f64) -> Share {
        let mut angles = Angles::new(self, point, limit);
        let (mut stack, mut size) = ([0_u32; STACK], 1);
        while size > 0 {
            size -= 1;
            let at = stack[size] as usize;
            let node = &self.nodes[at];
            let from_point = (node.center - point) * self.scale;
            if node.is_far(from_point, precision) {
                angles.sum += far_solid_angle(&node.coefficients, from_point, node.radius);
                if node.has_chord {
                    angles.add_edge(node.first as usize, node.last as usize);
                }
            } else if node.second == 0 {
                for i in node.first as usize..node.last as usize {
                    angles.add_edge(i, i + 1);
                }
            } else {
                (stack[size], stack[size + 1]) = (node.second, at as u32 + 1);
                size += 2;
            }
        }
        angles.finish(BUDGETS[precision])
    }

    fn share_exhaustively(&self, point: Vec3) -> Share {
        let mut angles = Angles::new(self, point, TERM_ERROR);
        for ends in self.splits.windows(2) {
            for i in ends[0] as usize..ends[1] as usize - 1 {
                angles.add_edge(i, i + 1);
            }
        }
        angles.finish(0.0)
    }
}

impl Node {
    /// True if the moments are good enough, and d does not point into the ball.
    #[inline(always)]
    fn is_far(&self, from_point: Vec3, precision: usize) -> bool {
        let square = from_point.dot(from_point);
        let [x, y, z] = FRAME.map(|row| row.dot(from_point));
        let is_off_cone = (z < 0.0) | (x * x + y * y > self.cone);
        (square >= self.far[precision]) & (square < FARTHEST) & is_off_cone
    }
}

/// Solid angles, summed up.
struct Angles<'a> {
    hierarchy: &'a Hierarchy,
    point: Vec3,
    /// Of those that are known as angles.
    sum: f64,
    /// Of the others.
    product: AngleProduct,
    error: f64,
    /// With which edges are computed in doubles.
    limit: f64,
    /// The vertex that was seen last: mostly the next edge begins there.
    seen: (usize, SeenVertex),
}

impl<'a> Angles<'a> {
    fn new(hierarchy: &'a Hierarchy, point: Vec3, limit: f64) -> Angles<'a> {
        let seen = (usize::MAX, SeenVertex::new(Vec3::ZERO));
        Angles { hierarchy, point, sum: 0.0, product: AngleProduct::ONE, error: 0.0, limit, seen }
    }

    #[inline(always)]
    fn add_edge(&mut self, first: usize, last: usize) {
        let (vertices, scale) = (&self.hierarchy.vertices, self.hierarchy.scale);
        let (a, b) = (vertices[first], vertices[last]);
        let seen = |vertex: Vec3| SeenVertex::new((vertex - self.point) * scale);
        let from = if self.seen.0 == first { self.seen.1 } else { seen(a) };
        let to = seen(b);
        self.seen = (last, to);
        if let Some((sum, error)) = edge_sum(&from, &to, self.limit) {
            self.product.multiply(sum);
            self.error += error;
        } else {
            self.sum += exact_solid_angle(self.point, a, b);
            self.error += TERM_ERROR;
        }
    }

    fn finish(&self, budget: f64) -> Share {
        let sum = self.sum + self.product.solid_angle();
        Share { share: sum / SPHERE, error: budget + self.error / SPHERE }
    }
}

/// The middle of the box around some vertices.
fn center_of(vertices: &[Vec3]) -> Vec3 {
    let low = vertices.iter().fold(Vec3::splat(f64::INFINITY), |low, v| low.min(*v));
    let high = vertices.iter().fold(Vec3::splat(f64::NEG_INFINITY), |high, v| high.max(*v));
    low * 0.5 + high * 0.5
}

/// Sorts numbered places so that each half of them, and each half of that, is compact.
fn sort_by_place(places: &mut [(usize, Vec3)]) {
    if places.len() < 3 {
        return;
    }
    let low = places.iter().fold(Vec3::splat(f64::INFINITY), |low, p| low.min(p.1));
    let high = places.iter().fold(Vec3::splat(f64::NEG_INFINITY), |high, p| high.max(p.1));
    let axis = (high - low).max_axis();
    let middle = places.len() / 2;
    let along =
        |a: &(usize, Vec3), b: &(usize, Vec3)| a.1[axis].total_cmp(&b.1[axis]).then(a.0.cmp(&b.0));
    places.select_nth_unstable_by(middle, along);
    let (first, second) = places.split_at_mut(middle);
    sort_by_place(first);
    sort_by_place(second);
}
