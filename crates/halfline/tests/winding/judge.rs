//! The winding number by its definition: the sum of the solid angles of all triangles (A. van Oosterom, J. Strackee
//! 1983), in double-double arithmetic. Shares no code with the library, casts no ray and knows no boundary.

use halfline::{Mesh, Vec3};

/// The unevaluated sum of two doubles.
#[derive(Clone, Copy)]
struct Twofold(f64, f64);

fn sum_of(a: f64, b: f64) -> Twofold {
    let sum = a + b;
    let part = sum - a;
    Twofold(sum, (a - (sum - part)) + (b - part))
}

impl Twofold {
    fn plus(self, other: Twofold) -> Twofold {
        let Twofold(high, low) = sum_of(self.0, other.0);
        let Twofold(high_low, low_low) = sum_of(self.1, other.1);
        let Twofold(high, low) = sum_of(high, low + high_low);
        sum_of(high, low + low_low)
    }

    fn minus(self, other: Twofold) -> Twofold {
        self.plus(Twofold(-other.0, -other.1))
    }

    fn times(self, other: Twofold) -> Twofold {
        let product = self.0 * other.0;
        let error = self.0.mul_add(other.0, -product);
        sum_of(product, error + (self.0 * other.1 + self.1 * other.0))
    }

    fn root(self) -> Twofold {
        if self.0 <= 0.0 {
            return Twofold(0.0, 0.0);
        }
        let root = self.0.sqrt();
        let rest = self.minus(Twofold(root, 0.0).times(Twofold(root, 0.0)));
        sum_of(root, rest.0 / (2.0 * root))
    }
}

type Vector = [Twofold; 3];

fn dot(a: &Vector, b: &Vector) -> Twofold {
    a[0].times(b[0]).plus(a[1].times(b[1])).plus(a[2].times(b[2]))
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| a[i].times(b[j]).minus(a[j].times(b[i])))
}

/// The solid angle of a triangle seen from a point that is not on it.
fn solid_angle(point: Vec3, corners: [Vec3; 3], scale: f64) -> f64 {
    if !corners.iter().all(|corner| corner.is_finite()) {
        return 0.0;
    }
    let [a, b, c] = corners.map(|corner| {
        [0, 1, 2].map(|axis| {
            let Twofold(high, low) = sum_of(corner[axis], -point[axis]);
            Twofold(high * scale, low * scale)
        })
    });
    let [la, lb, lc] = [&a, &b, &c].map(|v| dot(v, v).root());
    let above = dot(&a, &cross(&b, &c));
    let below = la
        .times(lb)
        .times(lc)
        .plus(dot(&a, &b).times(lc))
        .plus(dot(&b, &c).times(la))
        .plus(dot(&c, &a).times(lb));
    2.0 * above.0.atan2(below.0)
}

/// The winding number of a point that is off the surface.
pub fn winding_number(mesh: &Mesh, point: Vec3) -> f64 {
    let size = mesh.bounds().max.abs().max(mesh.bounds().min.abs()).max_element();
    let scale = 2.0_f64.powi(-(size.log2().round() as i32));
    let angles =
        (0..mesh.triangle_count() as u32).map(|face| solid_angle(point, mesh.corners(face), scale));
    angles.sum::<f64>() / (4.0 * std::f64::consts::PI)
}
