//! The last rung: big floats, which are right for all finite coordinates.

use std::cmp::Ordering;

use super::Region;
use crate::geometry::Vec3;
use crate::numeric::exact::{BigFloat, ExactNumber};

/// A vector of exact coordinates.
pub type Vector = [BigFloat; 3];

/// A quotient that is not negative.
pub struct Quotient {
    dividend: BigFloat,
    divisor: BigFloat,
}

impl Quotient {
    /// Which is larger, exactly.
    pub fn compare(&self, other: &Quotient) -> Ordering {
        let left = self.dividend.times(&other.divisor);
        let right = other.dividend.times(&self.divisor);
        left.minus(&right).sign().cmp(&0)
    }
}

/// A triangle and a point.
pub struct Exactly {
    p: Vec3,
    corners: [Vec3; 3],
}

fn difference(a: Vec3, b: Vec3) -> Vector {
    [0, 1, 2].map(|axis| BigFloat::difference(a[axis], b[axis]))
}

fn dot(a: &Vector, b: &Vector) -> BigFloat {
    a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]))
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    let minor = |i: usize, j: usize| a[i].times(&b[j]).minus(&a[j].times(&b[i]));
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

impl Exactly {
    /// Nothing is computed yet.
    pub fn new(p: Vec3, corners: [Vec3; 3]) -> Exactly {
        Exactly { p, corners }
    }

    /// From one corner to another.
    fn side(&self, from: usize, to: usize) -> Vector {
        difference(self.corners[to % 3], self.corners[from % 3])
    }

    /// From a corner to the point.
    fn arm(&self, from: usize) -> Vector {
        difference(self.p, self.corners[from % 3])
    }

    fn normal(&self) -> Vector {
        cross(&self.side(0, 1), &self.side(0, 2))
    }

    /// The part that holds the nearest point.
    pub fn region(&self) -> Region {
        // The sign of how far the point is along the edge from each corner to each other.
        let mut along = [[0; 3]; 3];
        for from in 0..3 {
            let arm = self.arm(from);
            for to in [from + 1, from + 2] {
                along[from][to % 3] = dot(&arm, &self.side(from, to)).sign();
            }
        }
        for corner in 0..3 {
            if along[corner][(corner + 1) % 3] <= 0 && along[corner][(corner + 2) % 3] <= 0 {
                return Region::Corner(corner);
            }
        }
        let normal = self.normal();
        for edge in 0..3 {
            let next = (edge + 1) % 3;
            if along[edge][next] > 0 && along[next][edge] > 0 {
                let inwards = dot(&normal, &cross(&self.side(edge, next), &self.arm(edge)));
                if inwards.sign() <= 0 {
                    return Region::Edge(edge);
                }
            }
        }
        Region::Inside
    }

    /// The square of the distance from a part that holds the nearest point.
    pub fn squared_distance(&self, region: Region) -> Quotient {
        let square = |vector: &Vector| dot(vector, vector);
        match region {
            Region::Corner(corner) => Quotient {
                dividend: square(&self.arm(corner)),
                divisor: BigFloat::from_double(1.0),
            },
            Region::Edge(edge) => {
                let side = self.side(edge, edge + 1);
                Quotient {
                    dividend: square(&cross(&self.arm(edge), &side)),
                    divisor: square(&side),
                }
            }
            Region::Inside => {
                let normal = self.normal();
                let height = dot(&normal, &self.arm(0));
                Quotient { dividend: height.times(&height), divisor: square(&normal) }
            }
        }
    }

    /// For an edge or the inside, the numbers whose squares' sum, by the square of the length of edge or normal, is
    /// the square of the distance. They are small where the point is near, and lose nothing by it.
    pub fn offsets(&self, region: Region) -> Vector {
        match region {
            Region::Corner(corner) => self.arm(corner),
            Region::Edge(edge) => cross(&self.arm(edge), &self.side(edge, edge + 1)),
            Region::Inside => {
                [dot(&self.normal(), &self.arm(0)), BigFloat::default(), BigFloat::default()]
            }
        }
    }

    /// The double nearest to the distance.
    pub fn distance(&self, region: Region) -> f64 {
        let Quotient { dividend, divisor } = self.squared_distance(region);
        dividend.root_of_quotient(&divisor)
    }

    /// The double nearest to a coordinate of the nearest point.
    pub fn coordinate(&self, region: Region, axis: usize) -> f64 {
        let exact = |x: f64| BigFloat::from_double(x);
        match region {
            Region::Corner(corner) => self.corners[corner][axis],
            Region::Edge(edge) => {
                let side = self.side(edge, edge + 1);
                let (along, square) = (dot(&self.arm(edge), &side), dot(&side, &side));
                let start = exact(self.corners[edge][axis]).times(&square);
                start.plus(&along.times(&side[axis])).quotient(&square)
            }
            Region::Inside => {
                let normal = self.normal();
                let (height, square) = (dot(&normal, &self.arm(0)), dot(&normal, &normal));
                let start = exact(self.p[axis]).times(&square);
                start.minus(&height.times(&normal[axis])).quotient(&square)
            }
        }
    }

    /// The double nearest to the weight of a corner.
    pub fn weight(&self, region: Region, of: usize) -> f64 {
        match region {
            Region::Corner(corner) => f64::from(u8::from(corner == of)),
            Region::Edge(edge) => {
                let side = self.side(edge, edge + 1);
                let (along, square) = (dot(&self.arm(edge), &side), dot(&side, &side));
                match of {
                    _ if of == (edge + 1) % 3 => along.quotient(&square),
                    _ if of == edge => square.minus(&along).quotient(&square),
                    _ => 0.0,
                }
            }
            Region::Inside => {
                let normal = self.normal();
                let across = cross(&self.side(of + 1, of + 2), &self.arm(of + 1));
                dot(&normal, &across).quotient(&dot(&normal, &normal))
            }
        }
    }
}
